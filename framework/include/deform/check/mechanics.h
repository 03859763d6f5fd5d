/// The mathematics that an energy term is checked by.
#pragma once

#include <cstddef>

#include "deform/export.h"
#include "deform/solve/system.h"

namespace deform {

/// A state with a smooth and a small random disturbance of the positions `rest` (N × 3), its
/// relative size about `strain`; the same for the same arguments.
[[nodiscard]] DEFORM_API State disturbed(const NodeVectors& rest, double strain);
/// The same of a System's rest state; its scalar unknowns are disturbed, too.
[[nodiscard]] DEFORM_API State disturbed(const System& system, double strain);

/// |f + ∇E| / |f| of one term: its force against fourth-order differences of its energy.
[[nodiscard]] DEFORM_API double gradient_error(const System& system, std::size_t term, State state);
/// How much of that may be the error of the differences, of those that a force without `stress` is
/// made by, and rounding: estimated, relative to |f|.
[[nodiscard]] DEFORM_API double gradient_resolution(const System& system, std::size_t term,
                                                    State state);

/// |f − (c − K r)| / |f| of one term's lagged operator, at the state that it is lagged at.
[[nodiscard]] DEFORM_API double lagged_error(const System& system, std::size_t term,
                                             const State& state);

/// |Σ f| / Σ |f| and |Σ r×f| / Σ |r||f| about the centroid; 0 where there is no force.
struct Momenta {
  double force = 0, torque = 0;
};
[[nodiscard]] DEFORM_API Momenta momenta(const NodeVectors& force, const NodeVectors& r);

/// |K x + ∂f/∂r x| / |K x| of the exact tangent and a random x: against fourth-order differences of
/// the whole force.
[[nodiscard]] DEFORM_API double tangent_error(const System& system, State state);
/// How much of that may be the error of the differences, of those that a tangent without `tangent`
/// or `stress` is made by, and rounding: estimated, relative to |K x|.
[[nodiscard]] DEFORM_API double tangent_resolution(const System& system, State state);
/// −(smallest eigenvalue) / (largest) of a tangent. Dense: for small surfaces.
[[nodiscard]] DEFORM_API double tangent_indefiniteness(const System& system, const State& state,
                                                       Tangent kind);

/// |K − Kᵀ| / |K|.
[[nodiscard]] DEFORM_API double asymmetry(const SparseMatrix& k);

/// −(smallest eigenvalue) / (largest) of the symmetric part: at most rounding where K is
/// semidefinite. Dense: for small matrices.
[[nodiscard]] DEFORM_API double indefiniteness(const SparseMatrix& k);

}  // namespace deform
