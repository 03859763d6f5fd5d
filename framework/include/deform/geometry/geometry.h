/// Differential geometry of one state at the samples of one set.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "deform/export.h"
#include "deform/geometry/pairs.h"
#include "deform/types.h"

namespace deform {

class SampleSet;

/// The geometry at the samples first … first+size−1 of a set; a view, valid as long as its
/// Geometry.
///
/// Lengths are metres, parameters a1, a2 are metres too (rest arc length for a flat sheet), so that
/// r_i [1], r_ij [1/m], G [1], B [1/m], Γ [1/m], d [1/m]. Where a set cannot compute a derivative,
/// it is 0, and so is all that needs it.
class GeometryBlock {
 public:
  GeometryBlock(const double* data, Index stride, Index first, Index size,
                bool has_mean_strains = false)
      : data_(data + first),
        stride_(stride),
        first_(first),
        size_(size),
        has_mean_strains_(has_mean_strains) {}

  [[nodiscard]] Index size() const { return size_; }
  /// Number of the block's first sample within its set (to index arrays of one's own).
  [[nodiscard]] Index first() const { return first_; }

  /// r_1, r_2, r_11, r_12 or r_22 (not d0).
  [[nodiscard]] ConstVectors r(Derivative d) const { return vectors(3 * (slot(d) - 1)); }
  [[nodiscard]] ConstVectors r(Pair ij) const { return r(second(ij)); }
  /// Unit normal r_1×r_2/|r_1×r_2| (6), along the set's frame (SampleSet::frame).
  [[nodiscard]] ConstVectors n() const { return vectors(kNormal); }
  /// Metric G_ij = r_i·r_j (3).
  [[nodiscard]] ConstValues G(Pair ij) const { return values(kMetric + slot(ij)); }
  /// Curvature tensor B_ij = n·r_ij (6).
  [[nodiscard]] ConstValues B(Pair ij) const { return values(kCurvature + slot(ij)); }
  /// Reciprocal metric G^ij (13).
  [[nodiscard]] ConstValues reciprocal(Pair ij) const { return values(kReciprocal + slot(ij)); }
  /// Christoffel symbol Γ^k_ij (15), k = 1 or 2.
  [[nodiscard]] ConstValues gamma(int k, Pair ij) const {
    return values(kChristoffel + 3 * (k - 1) + slot(ij));
  }
  /// Weingarten coefficient d_ij (8), ∂n/∂a_j = d_1j r_1 + d_2j r_2 (7); i, j = 1 or 2.
  [[nodiscard]] ConstValues d(int i, int j) const {
    return values(kWeingarten + 2 * (i - 1) + (j - 1));
  }
  /// Whether G and B are means of two states' (Geometry::make_mean), not those of the jet here.
  [[nodiscard]] bool has_mean_strains() const { return has_mean_strains_; }
  /// Area element |r_1×r_2| = √(G_11 G_22 − G_12²) [1].
  [[nodiscard]] ConstValues area_element() const { return values(kAreaElement); }

  // Places of the fields in a Geometry's storage, in arrays of one number a sample.
  static constexpr int kNormal = 15, kMetric = 18, kCurvature = 21, kReciprocal = 24,
                       kChristoffel = 27, kWeingarten = 33, kAreaElement = 37, kFields = 38;

 private:
  [[nodiscard]] ConstValues values(int field) const {
    return {data_ + field * stride_, static_cast<std::size_t>(size_)};
  }
  [[nodiscard]] ConstVectors vectors(int field) const {
    const double* x = data_ + field * stride_;
    return {x, x + stride_, x + 2 * stride_};
  }

  const double* data_;
  Index stride_;
  Index first_;
  Index size_;
  bool has_mean_strains_;
};

/// The geometry of one state at every sample of one set: computed once, shared by all that need it.
class DEFORM_API Geometry {
 public:
  Geometry() = default;
  explicit Geometry(const SampleSet& samples);

  /// What is computed of a state.
  enum class Detail : std::uint8_t {
    none,
    metric,  ///< r_1, r_2, G
    first,   ///< what follows from r_1 and r_2: these, n, G, G^ij, the area element
    second,  ///< everything
  };

  /// Evaluates (3), (6), (8), (13), (15) at positions r (N × 3) [m], in parallel, with the same
  /// bits at any number of threads. What is left out is not a number.
  void compute(const SampleSet& samples, const NodeVectors& r, Detail detail = Detail::second);
  /// The same in pieces, where somebody reads each while it is in cache: `begin`, then `compute`
  /// for all samples, first … first+size−1 at a time. Thread-safe for different samples.
  void begin(Detail detail);
  void compute(const SampleSet& samples, const NodeVectors& r, Index first, Index size);
  /// Computes what was left out, if anything was, at the same positions r (N × 3) [m].
  void complete(const SampleSet& samples, const NodeVectors& r);

  /// Makes this (1 − s) · this + s · other, field by field, of the same set: a G and a B that no
  /// surface need have.
  void blend(double s, const Geometry& other);

  /// Makes this the geometry of a step from r to r⁺ with which forces conserve energy and momenta:
  /// jets at the middle r̄ = (r + r⁺)/2, whose geometry is `middle`, and
  ///   G = (G(r) + G(r⁺))/2, B = (B(r) + B(r⁺))/2, n = (n(r) + n(r⁺))/2, not of length 1,
  ///   Γ by r̄_ij = Γ^k_ij r̄_k + b_ij n.
  /// With these, for any step, without remainder,
  ///   ΔG_ij = r̄_i·Δr_j + r̄_j·Δr_i,  ΔB_ij = n·(Δr_ij − Γ^k_ij Δr_k),
  /// which read as δG and δB of one state: G is quadratic in r, and for B it follows from
  /// n·r_k = 0 and |n| = 1 at both ends, hence Δn·r̄_k = −n̄·Δr_k and Δn·n̄ = 0. A stress of the
  /// mean G and B then does the work of the energy's change, and has no moment (Simo & Tarnow 1992,
  /// where the strain is quadratic; the normal by the same argument). All of the same set; `from`
  /// and `to` of at least the middle's detail.
  void make_mean(const Geometry& middle, const Geometry& from, const Geometry& to);
  /// Makes G and B their means with another state's of the same set; the rest stays.
  void average_forms(const Geometry& other);
  [[nodiscard]] bool has_mean_strains() const { return has_mean_strains_; }

  [[nodiscard]] Index size() const { return size_; }
  [[nodiscard]] GeometryBlock block(Index first, Index size) const {
    return {data_.data(), stride_, first, size, has_mean_strains_};
  }
  [[nodiscard]] GeometryBlock all() const { return block(0, size_); }

 private:
  void leave_out(Detail beyond);

  Index size_ = 0, stride_ = 0;
  std::vector<double> data_;  // (kFields × stride)
  Detail detail_ = Detail::none;
  bool has_mean_strains_ = false;
};

}  // namespace deform
