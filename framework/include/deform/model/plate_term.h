/// Bending energies that are quadratic in the positions: a constant tangent, and no normal of the
/// present state.
#pragma once

#include "deform/model/quadratic_term.h"

namespace deform {

class Setup;
class Surface;

/// A density w = ½ Σ_ab C_ab X_a·X_b per parameter area [J/m²] of the vectors
/// X_ij = r_ij − Γ^k_ij r_k − B⁰_ij n⁰ [1/m], with Γ, B⁰ and n⁰ of the rest surface; the sum runs
/// over 11, 12, 22, the mixed pair once, and C is as QuadraticTerm's for B.
///
/// X_ij is the second covariant derivative of u = r − r⁰ on the rest surface: a linear plate. Where
/// the rest surface is flat, it is that of r itself, which turns with the surface; and where the
/// surface bends without stretching, that is B_ij n, and w the energy of QuadraticTerm in B
/// (Bergou, Wardetzky, Harmon, Zorin & Grinspun 2006). Unlike B it is smooth where r_1 × r_2
/// vanishes, as where cloth is folded more sharply than its grid resolves.
class DEFORM_API PlateTerm : public JetTerm {
 public:
  /// Whether C_11,12 and C_22,12 are 0 where a1 and a2 are lengths along orthogonal directions, as
  /// those of a material that is isotropic or orthotropic along them: the lagged operator then
  /// couples fewer nodes.
  enum class Twist : std::uint8_t { coupled, separate };
  /// Of a surface whose rest positions are `rest` (N × 3) [m].
  PlateTerm(const Surface& surface, const NodeVectors& rest, Twist twist);
  ~PlateTerm() override;

  /// C at the samples of a block. Const, thread-safe.
  virtual void stiffness(const GeometryBlock& rest, FormStiffness& c) const = 0;

  [[nodiscard]] TermTraits traits() const final;
  [[nodiscard]] std::vector<Derivative> dependence() const final;
  void energy_density(const SampleBlock& block, Values density) const final;
  [[nodiscard]] std::vector<Coupling> couplings() const final;
  void stress(const SampleBlock& block, const Stress& sigma) const final;
  void affine_stress(const SampleBlock& block, const AffineStress& sigma) const final;
  void tangent(const SampleBlock& block, Tangent kind, const JetTangent& h) const final;
  [[nodiscard]] TangentShape tangent_shape(Tangent kind) const final;
  void tangent_factors(const SampleBlock& block, Tangent kind, const TangentFactors& c) const final;

 private:
  bool is_cartesian_;  // G⁰ is 1 and Γ⁰ is 0: X depends on second derivatives alone
  Twist twist_;
};

/// Throws InputError unless the rest surface is a plane (|B⁰_ij| times its size is rounding at all
/// samples), as only there a PlateTerm's energy does not change when the surface turns.
DEFORM_API void require_flat(const Setup& setup);

}  // namespace deform
