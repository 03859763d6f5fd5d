/// Sample sets: where G and B are evaluated, and the difference operators that map nodes to jets
/// there.
#pragma once

#include <algorithm>
#include <array>
#include <bitset>
#include <memory>
#include <optional>
#include <vector>

#include "deform/export.h"
#include "deform/geometry/pairs.h"
#include "deform/types.h"

namespace deform {

/// What a surface's sample sets are for; one set may serve both.
enum class SampleRole : std::uint8_t { membrane, bending };

/// One sample as a Surface describes it.
struct SampleStencil {
  struct Entry {
    Index node = 0;
    /// Coefficients of the node in D_0, D_1, D_2 [1/m], D_11, D_12, D_22 [1/m²].
    std::array<double, kDerivatives> d{};
  };
  struct FrameEntry {
    Index node = 0;
    std::array<double, 2> d{};  ///< coefficients of the node in the frame's two tangents
  };

  double weight = 0;              ///< A_s, parameter area that the sample stands for [m²]
  Vec2 parameter = Vec2::Zero();  ///< (a1, a2) [m]
  std::vector<Entry> entries;     ///< each node once, in a fixed order
  std::bitset<kDerivatives>
      computable;  ///< which of the operators exist here; the others have zero rows
  std::vector<FrameEntry>
      frame;  ///< empty: the normal is that of D_1 r, D_2 r; else of these tangents
};

/// Optional capability of a set whose samples are the nodes: differences of a field given at the
/// samples, D_i^- and D_ij^- of the paper, as the expanded form (22) needs. Rows where the
/// difference cannot be formed are zero.
class DEFORM_API FieldDifferences {
 public:
  struct Term {
    Index sample = 0;
    double coefficient = 0;
  };
  /// For each of d1 … d22 and each sample, the row of the operator.
  using Rows = std::array<std::vector<std::vector<Term>>, kDerivatives>;

  FieldDifferences() = default;
  explicit FieldDifferences(const Rows& rows);

  /// out[s] = (D^- field)(first + s); `field` is the whole field (m).
  void apply(Derivative op, ConstValues field, Index first, Values out) const;
  /// The row of sample s.
  [[nodiscard]] std::span<const Term> row(Derivative op, Index s) const;
  /// True when there is a row of d1 … d22 for each of m samples, and no row names another.
  [[nodiscard]] bool fits(Index m) const;

 private:
  struct Operator {
    std::vector<Index> begin;
    std::vector<Term> terms;
  };
  std::array<Operator, kDerivatives> operators_;
};

/// The operators of all samples of a set, compactly: samples with the same coefficients share them.
class DEFORM_API SampleSet {
 public:
  class Builder;

  /// What one sample sees: its nodes and, a node, the six coefficients.
  struct Stencil {
    std::span<const std::int32_t> nodes;
    const std::array<double, kDerivatives>* d;  ///< one row a node
  };
  struct Frame {
    Index sample;
    std::vector<SampleStencil::FrameEntry> entries;
  };

  [[nodiscard]] Index size() const { return static_cast<Index>(weights_.size()); }
  [[nodiscard]] Index nodes() const { return nodes_; }
  /// How far apart arrays of one number a sample are kept that are read together: not size(), for
  /// arrays that lie a power of two apart share the same few lines of a cache.
  [[nodiscard]] Index stride() const { return (size() + 7) / 8 * 8 + 8; }
  /// (m) A_s [m²].
  [[nodiscard]] ConstValues weights() const { return weights_; }
  [[nodiscard]] const std::vector<Vec2>& parameters() const { return parameters_; }
  [[nodiscard]] bool computable(Derivative d, Index s) const {
    return computable_[static_cast<std::size_t>(s)].test(static_cast<std::size_t>(slot(d)));
  }
  [[nodiscard]] Stencil stencil(Index s) const {
    const auto i = static_cast<std::size_t>(s);
    const auto begin = static_cast<std::size_t>(begin_[i]);
    const auto end = static_cast<std::size_t>(begin_[i + 1]);
    return {{nodes_of_.data() + begin, end - begin}, pool_.data() + pool_begin_[i]};
  }
  /// Calls visit(first, size) for parts of first … first+size−1, ascending: samples with the same
  /// coefficients, whose nodes are those of the part's first, counted on by one from each to the
  /// next.
  template <class Visit>
  void visit_runs(Index first, Index size, const Visit& visit) const {
    for (Index s = first; s < first + size;) {
      const Index end = std::min<Index>(run_end_[static_cast<std::size_t>(s)], first + size);
      visit(s, end - s);
      s = end;
    }
  }
  /// The end of the run that a sample is in.
  [[nodiscard]] Index run_end(Index s) const { return run_end_[static_cast<std::size_t>(s)]; }
  /// Samples whose normal is taken from other tangents than D_1 r and D_2 r, in ascending order.
  [[nodiscard]] const std::vector<Frame>& frames() const { return frames_; }
  /// True when sample s is node s for every s (D_0 is the identity).
  [[nodiscard]] bool samples_are_nodes() const { return samples_are_nodes_; }
  /// Null where the set cannot difference a field of samples.
  [[nodiscard]] const FieldDifferences* field_differences() const {
    return field_differences_ ? &*field_differences_ : nullptr;
  }
  /// D v at every sample (m × 3), for v given at the nodes.
  [[nodiscard]] NodeVectors apply(Derivative d, const NodeVectors& v) const;

 private:
  Index nodes_ = 0;
  bool samples_are_nodes_ = false;
  std::vector<double> weights_;
  std::vector<Vec2> parameters_;
  std::vector<std::bitset<kDerivatives>> computable_;
  std::vector<Index> begin_{0};
  std::vector<std::int32_t> nodes_of_;
  std::vector<std::size_t> pool_begin_;
  std::vector<std::int32_t> run_end_;
  std::vector<std::array<double, kDerivatives>> pool_;
  std::vector<Frame> frames_;
  std::optional<FieldDifferences> field_differences_;
};

/// Takes samples one by one; sharing of equal coefficients happens here.
class DEFORM_API SampleSet::Builder {
 public:
  explicit Builder(Index nodes);
  ~Builder();
  void add(const SampleStencil& sample);
  void set_field_differences(FieldDifferences differences);
  [[nodiscard]] SampleSet build();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace deform
