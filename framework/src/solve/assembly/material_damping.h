/// Damping of materials (Kelvin–Voigt).
#pragma once

#include <vector>

#include "deform/model/tangent.h"
#include "deform/solve/block_matrix.h"
#include "deform/solve/state.h"
#include "deform/types.h"

#include "solve/assembly/model_terms.h"
#include "solve/assembly/tangent_builder.h"

namespace deform {

/// For a quadratic energy ½ C (T − T⁰)² the damping force is that of the stress θ C Ṫ, with the
/// retardation time θ. Where rates are those of v, it is −D v, D = Σ_t θ_t K_t with the
/// Gauss–Newton tangent of each term: it resists strain rates as the term resists strains, and
/// rigid motions not at all; its power −vᵀDv is never positive. Where they are measured over a step
/// (StepStrains::measure_rates_from), it is θ · rate times the term's own force, strains being
/// those since the step began.
class MaterialDamping {
 public:
  /// Both must live as long.
  MaterialDamping(ModelTerms& terms, TangentBuilder& tangents)
      : terms_(&terms), tangents_(&tangents) {}

  [[nodiscard]] bool is_any() const;
  /// Whether some of it takes the rates of v.
  [[nodiscard]] bool is_any_by_velocity(Strains* strains) const;
  /// All of it at a state whose geometry is `now`, to f (N × 3) [N].
  void add_force(const State& state, const StateGeometry& now, Strains* strains, NodeVectors& f);
  /// The part of it by rates over a step; and whose gradient that is [J].
  void add_step_force(const StateGeometry& now, Strains* strains, NodeVectors& f);
  [[nodiscard]] double step_potential(const StateGeometry& now, Strains* strains);
  /// K += −∂f/∂r of the part over a step, and rate · D of the other.
  void add_tangent(const StateGeometry& now, Strains* strains, Tangent kind, double rate,
                   BlockMatrix& k);

 private:
  /// What each term is multiplied by, of those whose rates are measured over a step or of others.
  [[nodiscard]] std::vector<double> factors(bool over_step, Strains* strains) const;
  [[nodiscard]] Geometries since_begun(std::size_t set, const StateGeometry& now,
                                       Strains* strains) const;
  const BlockMatrix& matrix(const StateGeometry& now, Strains* strains);

  ModelTerms* terms_;
  TangentBuilder* tangents_;
  BlockMatrix matrix_;   // D [N·s/m] …
  NodeVectors at_;       // … at these positions
  long of_strains_ = 0;  // … and with these strains
};

}  // namespace deform
