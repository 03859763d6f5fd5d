#include "scalar_system.h"

#include <algorithm>
#include <cmath>

namespace multigrid {
namespace {

/// Of the residual's norm in the preconditioner, what single precision reduces it to at a time: far
/// above what it has rounded until then.
constexpr double kPart = 1e-4;
/// Part of |b| and of |A| |x| that their difference may be, for its rounding.
constexpr double kRounding = 1e-15;

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
  largest_diagonal_ = 0;
  for (const std::int32_t node : node_) {
    const auto place = static_cast<std::size_t>(level.diagonal[static_cast<std::size_t>(node)]);
    largest_diagonal_ = std::max(largest_diagonal_, value_[place]);
  }
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
  // In single precision numbers should be neither tiny nor huge.
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
  std::string reason = improve_nodes(tolerance, most);
  if (reason.empty())
    each_number([&](Index q, Index c, Index node) { x(q, c) = largest * x_(node, c); });
  return reason;
}

/// The residual is found anew as often as single precision has to reduce it.
std::string ScalarSystem::improve_nodes(double tolerance, int most) {
  Goal goal{.part = std::max(tolerance, kPart)};
  while (iterations_ < most) {
    if (find_residual_is_rounding()) return "";
    const bool is_first = iterations_ == 0;
    const Ending end = correct(goal, most - iterations_);
    iterations_ += end.iterations;
    if (end.is_indefinite) return "not positive definite";
    if (is_first) goal = {.part = kPart, .absolute = tolerance * tolerance * end.first};
    if (end.has_converged && (end.last <= goal.absolute || end.iterations == 0)) return "";
  }
  return std::to_string(iterations_) + " iterations do not reduce the residual enough";
}

/// The residual becomes the finest level's right-hand side.
bool ScalarSystem::find_residual_is_rounding() {
  Level<Scalar>& level = cycle_->finest();
  deform::parallel_blocks(x_.quads(), kQuads, [&](Index first, Index size) {
    find_residual(level.quads.view(), value_.data(), x_.data(), b_.data(), first, first + size,
                  level.f.data());
  });
  const double rounding = kRounding * (norm(b_) + largest_diagonal_ * norm(x_));
  return level.product(level.f, level.f) <= rounding * rounding;
}

Ending ScalarSystem::correct(Goal goal, int most) {
  Level<Scalar>& level = cycle_->finest();
  return gradients_.solve(
      [&](const LaneVector& y, Index first, Index size, LaneVector& out) {
        multiply_scalars(level.quads.view(), value_.data(), y.data(), first, first + size,
                         out.data());
      },
      [&] { return cycle_->run(); }, level.f, level.x, x_, goal, most);
}

double ScalarSystem::norm(const NodeLanes<double>& y) {
  return std::sqrt(sums_(y.quads(), [&](Index first, Index size) {
    return dot(y.data(), y.data(), first, first + size);
  }));
}

}  // namespace multigrid
