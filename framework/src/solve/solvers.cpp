#include "deform/solve/integrator.h"
#include "deform/solve/linear_solver.h"

namespace deform {

Integrator::~Integrator() = default;
LinearSolver::~LinearSolver() = default;
BlockSolver::~BlockSolver() = default;

}  // namespace deform
