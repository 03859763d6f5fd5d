#include "deform/solve/integrator.h"
#include "deform/solve/linear_solver.h"

namespace deform {

Integrator::~Integrator() = default;
LinearSolver::~LinearSolver() = default;
BlockSolver::~BlockSolver() = default;

void LinearSolver::improve(const Eigen::Ref<const Eigen::MatrixXd>& b, double /*tolerance*/,
                           Eigen::Ref<Eigen::MatrixXd> x) {
  solve(b, x);
}

}  // namespace deform
