/// Normal estimators: what stands for n in the bending force β_ij n of (19).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "deform/geometry/geometry.h"
#include "deform/plugin/descriptor.h"
#include "deform/types.h"

namespace deform {

/// A normal as an affine form of the jet, n_ij ≈ p r_ij + s_1 r_1 + s_2 r_2 + c, for the samples of
/// a block. All zero at first: an estimator writes what is not.
struct AffineNormal {
  std::array<double, kBlock> p{};                 ///< [m]
  std::array<std::array<double, kBlock>, 2> s{};  ///< s_1, s_2 [1]
  std::array<std::array<double, kBlock>, 3> c{};  ///< x, y, z [1]

  /// The estimate at the block's sample i on a jet.
  [[nodiscard]] Vec3 at(Index i, const GeometryBlock& jets, Pair ij) const {
    const auto k = static_cast<std::size_t>(i);
    return p[k] * jets.r(ij)[i] + s[0][k] * jets.r(Derivative::d1)[i] +
           s[1][k] * jets.r(Derivative::d2)[i] + Vec3(c[0][k], c[1][k], c[2][k]);
  }
};

/// What of the present jet an estimate depends on.
enum class Dependence : std::uint8_t {
  none,               ///< p = s = 0: a constant of the step
  second_derivative,  ///< s = 0
  jet,
};

/// Estimates the unit normal that multiplies β_ij, with coefficients from the lagged (previous)
/// state.
///
/// Contract: const and thread-safe; writes samples 0 … lagged.size()−1 of `normal` from `lagged`
/// alone; where r_ij is not computable the estimate may be anything finite (β_ij is 0 there).
class DEFORM_API NormalEstimator : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::normal;
  ~NormalEstimator() override;

  virtual void estimate(const GeometryBlock& lagged, Pair ij, AffineNormal& normal) const = 0;

  /// What the framework may rely on (it then leaves the other coefficients out of its matrices).
  [[nodiscard]] virtual Dependence dependence() const { return Dependence::jet; }

  /// Names of the cases that the estimator distinguishes, e.g. the delta rule's; none by default.
  [[nodiscard]] virtual std::vector<std::string> branches() const;
  /// The case of each sample (index into branches()); called only when there are some.
  virtual void branch(const GeometryBlock& lagged, Pair ij, std::span<std::uint8_t> out) const;
};

}  // namespace deform
