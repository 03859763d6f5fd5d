#include "scalar_system.h"

namespace multigrid {
namespace {

/// The pattern among all nodes; those without an unknown have no entry but their diagonal's.
Pattern pattern_of(const deform::SparseMatrix& a, std::span<const std::int32_t> nodes,
                   Index total) {
  std::vector<std::int32_t> unknown(static_cast<std::size_t>(total), -1);
  for (std::size_t q = 0; q < nodes.size(); ++q)
    unknown[static_cast<std::size_t>(nodes[q])] = static_cast<std::int32_t>(q);
  Pattern pattern;
  pattern.nodes = total;
  for (std::size_t node = 0; node < unknown.size(); ++node) {
    if (const std::int32_t q = unknown[node]; q < 0) {
      pattern.column.push_back(static_cast<std::int32_t>(node));
    } else {
      for (auto p = a.row_begin[static_cast<std::size_t>(q)];
           p < a.row_begin[static_cast<std::size_t>(q) + 1]; ++p)
        pattern.column.push_back(
            nodes[static_cast<std::size_t>(a.column[static_cast<std::size_t>(p)])]);
    }
    pattern.begin.push_back(static_cast<std::int32_t>(pattern.column.size()));
  }
  return pattern;
}

std::vector<Mask> masks_of(std::span<const std::int32_t> nodes, Index total) {
  std::vector<bool> is_free(static_cast<std::size_t>(total), false);
  for (const std::int32_t node : nodes) is_free[static_cast<std::size_t>(node)] = true;
  std::vector<Mask> masks;
  for (std::size_t a = 0; a < is_free.size(); ++a)
    if (!is_free[a]) masks.push_back({static_cast<std::int32_t>(a), {}});
  return masks;
}

}  // namespace

ScalarSystem::ScalarSystem(const deform::SparseMatrix& pattern, std::span<const std::int32_t> nodes,
                           Index total, const std::vector<deform::Prolongation>& coarsening)
    : node_(nodes.begin(), nodes.end()) {
  cycle_.emplace(pattern_of(pattern, nodes, total), masks_of(nodes, total), coarsening,
                 Finest::smoothed);
  // Unknowns are numbered as their nodes are, so that rows keep the order of their entries.
  const Level<Scalar>& level = cycle_->finest();
  for (Index q = 0; q < pattern.size; ++q) {
    const Index node = node_[static_cast<std::size_t>(q)];
    const std::int32_t begin = pattern.row_begin[static_cast<std::size_t>(q)],
                       size = pattern.row_begin[static_cast<std::size_t>(q) + 1] - begin;
    for (std::int32_t k = 0; k < size; ++k)
      place_.push_back(
          level.quads.place(node, level.pattern.begin[static_cast<std::size_t>(node)] + k));
  }
  value_.assign(level.quads.places() + kOverrun, 0);
  b_.assign(total);
  x_.assign(total);
}

void ScalarSystem::factor(const deform::SparseMatrix& a) {
  Level<Scalar>& level = cycle_->finest();
  deform::parallel_blocks(a.size, kRows, [&](Index first, Index size) {
    for (auto p = static_cast<std::size_t>(a.row_begin[static_cast<std::size_t>(first)]);
         p < static_cast<std::size_t>(a.row_begin[static_cast<std::size_t>(first + size)]); ++p) {
      const auto place = static_cast<std::size_t>(place_[p]);
      value_[place] = a.value[p];
      level.value[place] = static_cast<float>(a.value[p]);
    }
  });
  cycle_->renew(true);
}

std::string ScalarSystem::improve(const Eigen::Ref<const Eigen::MatrixXd>& b, double tolerance,
                                  int most, Eigen::Ref<Eigen::MatrixXd> x) {
  iterations_ = 0;
  const double largest = b.size() == 0 ? 0 : b.cwiseAbs().maxCoeff();
  if (largest == 0) {
    x.setZero();
    return "";
  }
  const auto each_number = [&](const auto& visit) {
    deform::parallel_blocks(b.rows(), kRows, [&](Index first, Index size) {
      for (Index c = 0; c < b.cols(); ++c)
        for (Index q = first; q < first + size; ++q)
          visit(q, c, Index{node_[static_cast<std::size_t>(q)]});
    });
  };
  each_number([&](Index q, Index c, Index node) {
    b_(node, c) = b(q, c) / largest;
    x_(node, c) = x(q, c) / largest;
  });
  Level<Scalar>& level = cycle_->finest();
  const Ending end = gradients_.solve(
      [&](const NodeLanes<double>& y, Index first, Index size, NodeLanes<double>& out) {
        multiply_scalars(level.quads.view(), value_.data(), y.data(), first, first + size,
                         out.data());
      },
      [&](const NodeLanes<double>& r, NodeLanes<double>& z) { precondition(r, z); }, b_, x_,
      tolerance, most, x.isZero(0) ? From::zero : From::guess);
  iterations_ = end.iterations;
  if (end.is_indefinite) return "not positive definite";
  if (!end.has_converged)
    return std::to_string(end.iterations) + " iterations do not reduce the residual enough";
  each_number([&](Index q, Index c, Index node) { x(q, c) = largest * x_(node, c); });
  return "";
}

/// One cycle, in single precision.
void ScalarSystem::precondition(const NodeLanes<double>& r, NodeLanes<double>& z) {
  Level<Scalar>& level = cycle_->finest();
  z.resize(r.quads());
  const auto each = [&](const auto& convert_some) {
    deform::parallel_blocks(r.quads(), kQuads,
                            [&](Index first, Index size) { convert_some(first, first + size); });
  };
  each([&](Index first, Index end) { convert(r.data(), first, end, level.f.data()); });
  cycle_->run();
  each([&](Index first, Index end) { convert(level.x.data(), first, end, z.data()); });
}

}  // namespace multigrid
