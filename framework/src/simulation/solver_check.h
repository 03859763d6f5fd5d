/// Whether the linear solver that a scene names takes the matrices of its integrator.
#pragma once

#include "deform/plugin/registry.h"
#include "deform/simulation/scene.h"
#include "deform/solve/integrator.h"

#include "solve/matrix/solver_queue.h"

namespace deform {

/// Throws InputError at /solver, naming the solver, the matrix and the solvers that take it, when
/// `make_solvers` gives none that does; the matrix is that of `integrator` (Integrator::solves).
void require_solver(const Scene& scene, const PluginRegistry& registry, const System& system,
                    const Named<Integrator>& integrator, const MakeSolvers& make_solvers);

}  // namespace deform
