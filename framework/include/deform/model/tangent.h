/// Tangents: second derivatives of densities of energy with respect to the jet.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "deform/geometry/pairs.h"
#include "deform/types.h"

namespace deform {

/// Which second derivative of a potential a Newton step asks for.
enum class Tangent : std::uint8_t {
  exact,         ///< the Hessian; indefinite where the surface is compressed
  projected,     ///< Gauss–Newton and what else is positive semidefinite at each sample
  gauss_newton,  ///< δG and δB are taken as linear in δr: positive semidefinite, and coarser
  /// The Hessian with the stress that the last Newton step predicted, C (T + δT) at the state
  /// before it, in place of the stress now, which a long step's rotation has spoiled by stretching
  /// the surface; where there is no such step, or a term knows no such stress, the exact one.
  /// Newton's method then takes long steps, and still converges quadratically (the mixed
  /// integration points of Magisano, Leonetti & Garcea 2017).
  mixed,
};

inline constexpr std::array kTangents{Tangent::exact, Tangent::projected, Tangent::gauss_newton,
                                      Tangent::mixed};

/// Whether a tangent was asked to be positive semidefinite.
[[nodiscard]] constexpr bool is_semidefinite(Tangent kind) {
  return kind == Tangent::projected || kind == Tangent::gauss_newton;
}

/// What second derivatives ∂²W/∂(D_m r)∂(D_n r) of a density are at each sample. Where all terms of
/// a sample set agree on one that is more special than `blocks`, a matrix is made of the factors
/// c_mn alone, a ninth of the numbers.
enum class TangentShape : std::uint8_t {
  blocks,    ///< any 3 × 3 blocks
  normal,    ///< c_mn n nᵀ, n being the normal of the state: those of B along its gradient
  identity,  ///< c_mn I: those of energies that are quadratic in r
};

/// The derivatives D_1 … D_22 that make a jet.
inline constexpr int kJet = 5;

/// Hessians of a block's density, one a sample: 3 × 3 blocks ∂²W/∂(D_m r)∂(D_n r) for m ≤ n, of the
/// derivatives that the density depends on; a view, terms add to it.
class JetTangent {
 public:
  /// Place of the block (m, n) among a sample's, counted in the order of the upper triangle; −1
  /// where the density does not depend on one of both.
  using Places = std::array<std::array<std::int16_t, kDerivatives>, kDerivatives>;

  /// `stride`: from a number to the next of the same sample.
  JetTangent(double* data, Index stride, const Places& places, Index size)
      : data_(data), stride_(stride), places_(&places), size_(size) {}

  [[nodiscard]] Index size() const { return size_; }
  /// From an entry of a block to the next, row by row.
  [[nodiscard]] Index stride() const { return stride_; }
  /// Adds to the block (m, n), m ≤ n, at a sample; nothing where the density was said not to depend
  /// on one of them.
  void add(Index sample, Derivative m, Derivative n, const Eigen::Matrix3d& h) const {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (double* const entries = entry(m, n, i, j)) entries[sample] += h(i, j);
  }
  /// Entry (i, j) of the block (m, n), m ≤ n, at all samples (size); null where the density was
  /// said not to depend on one of them.
  [[nodiscard]] double* entry(Derivative m, Derivative n, int i, int j) const {
    const int place =
        (*places_)[static_cast<std::size_t>(slot(m))][static_cast<std::size_t>(slot(n))];
    return place < 0 ? nullptr : data_ + (9 * place + 3 * i + j) * stride_;
  }

 private:
  double* data_;
  Index stride_;
  const Places* places_;
  Index size_;
};

/// The factors c_mn, m ≤ n, of a block's second derivatives of a shape that is not `blocks`, of the
/// derivatives that the density depends on; a view, terms add to it.
class TangentFactors {
 public:
  TangentFactors(double* data, Index stride, const JetTangent::Places& places, Index size)
      : data_(data), stride_(stride), places_(&places), size_(size) {}

  [[nodiscard]] Index size() const { return size_; }
  /// c_mn, m ≤ n, at all samples (size); null where the density was said not to depend on one of
  /// both.
  [[nodiscard]] double* entry(Derivative m, Derivative n) const {
    const int place =
        (*places_)[static_cast<std::size_t>(slot(m))][static_cast<std::size_t>(slot(n))];
    return place < 0 ? nullptr : data_ + place * stride_;
  }

 private:
  double* data_;
  Index stride_;
  const JetTangent::Places* places_;
  Index size_;
};

}  // namespace deform
