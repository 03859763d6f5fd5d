#include "deform/solve/mass_matrix.h"

#include <optional>
#include <string>
#include <vector>

#include "not_finite.h"
#include "solve/matrix/tangent_solver.h"
#include "solve/system_parts.h"

namespace deform {

struct MassMatrix::Impl {
  void factor();

  SystemParts* parts;
  BlockMatrix pattern;                  // of the diagonal
  std::optional<TangentSolver> solver;  // where ties make more of it; made when first needed
};

MassMatrix::MassMatrix(SystemParts& parts) : impl_(std::make_unique<Impl>()) {
  impl_->parts = &parts;
}
MassMatrix::~MassMatrix() = default;

void MassMatrix::Impl::factor() {
  const Index nodes = parts->model.mass.size();
  pattern.nodes = nodes;
  for (Index a = 0; a < nodes; ++a) {
    pattern.column.push_back(static_cast<std::int32_t>(a));
    pattern.row_begin.push_back(static_cast<std::int32_t>(a + 1));
  }
  pattern.value.assign(9 * static_cast<std::size_t>(nodes), 0.0);
  solver.emplace(parts->constraints.map(), pattern, std::vector<Freedom>{}, parts->solvers,
                 [this]() -> const BlockMatrix& { return pattern; });
  const std::string reason = solver->factor(parts->model.mass);
  parts->meter.choose(WorkMeter::Matrix::mass, solver->choice());
  if (!reason.empty())
    throw Error(ExitCode::diverged, "the matrix of masses cannot be factorised: " + reason);
}

void MassMatrix::accelerate(const NodeVectors& f, NodeVectors& acceleration) const {
  require_finite(f, "the force to accelerate by", "the integrator", "");
  const ReductionMap& map = impl_->parts->constraints.map();
  if (map.ties().empty()) {
    acceleration = f;
    map.transpose(acceleration);
    for (int c = 0; c < 3; ++c) acceleration.col(c).array() /= impl_->parts->model.mass.array();
    return;
  }
  if (!impl_->solver) impl_->factor();
  const std::string reason = impl_->solver->solve(f, acceleration);
  if (!reason.empty())
    throw Error(ExitCode::diverged, "the matrix of masses cannot be solved with: " + reason);
}

}  // namespace deform
