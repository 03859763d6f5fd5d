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

/// Rows that one task takes.
constexpr Index kRows = 4096;

/// Calls visit(p, column) for the entries of the upper half in a row, `column` being a node. As
/// unknowns are numbered as their nodes are, these are ascending.
template <class Visit>
void each_upper_entry(const deform::SparseMatrix& a, std::span<const std::int32_t> nodes,
                      std::size_t row, const Visit& visit) {
  for (auto p = static_cast<std::size_t>(a.row_begin[row]);
       p < static_cast<std::size_t>(a.row_begin[row + 1]); ++p)
    if (static_cast<std::size_t>(a.column[p]) >= row)
      visit(p, nodes[static_cast<std::size_t>(a.column[p])]);
}

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
      each_upper_entry(a, nodes, static_cast<std::size_t>(q),
                       [&](std::size_t /*p*/, std::int32_t b) { pattern.column.push_back(b); });
    }
    pattern.begin.push_back(static_cast<std::int32_t>(pattern.column.size()));
  }
  return pattern;
}

std::vector<Held> nodes_held(std::span<const std::int32_t> nodes, Index total) {
  std::vector<bool> is_free(static_cast<std::size_t>(total), false);
  for (const std::int32_t node : nodes) is_free[static_cast<std::size_t>(node)] = true;
  std::vector<Held> held;
  for (std::size_t a = 0; a < is_free.size(); ++a)
    if (!is_free[a]) held.push_back({static_cast<std::int32_t>(a), 7});
  return held;
}

}  // namespace

ScalarSystem::ScalarSystem(const deform::SparseMatrix& pattern, std::span<const std::int32_t> nodes,
                           Index total, const std::vector<deform::Prolongation>& coarsening)
    : node_(nodes.begin(), nodes.end()) {
  cycle_.emplace(pattern_of(pattern, nodes, total), nodes_held(nodes, total), coarsening,
                 Finest::smoothed);
  const Level<Scalar>& level = cycle_->finest();
  for (std::size_t q = 0; q < node_.size(); ++q) {
    row_begin_.push_back(entries_.size());
    each_upper_entry(pattern, node_, q, [&](std::size_t p, std::int32_t b) {
      entries_.push_back({static_cast<std::int32_t>(p),
                          level.strips.place(node_[q], b - node_[q], Scalar::kNumbers).first});
    });
  }
  row_begin_.push_back(entries_.size());
  value_.assign(level.strips.size(Scalar::kNumbers), 0);
  product_ = Product<double>(level.strips);
  sums_.resize(level.strips.chunks().size());
  for (Field<double>* v : {&b_, &x_, &product_of_x_}) level.assign(*v);
  gradients_.assign(total, b_.stride());
}

void ScalarSystem::factor(const deform::SparseMatrix& a) {
  Level<Scalar>& level = cycle_->finest();
  deform::parallel_blocks(a.size, kRows, [&](Index first, Index size) {
    for (std::size_t e = row_begin_[static_cast<std::size_t>(first)];
         e < row_begin_[static_cast<std::size_t>(first + size)]; ++e) {
      const double value = a.value[static_cast<std::size_t>(entries_[e].from)];
      const auto place = static_cast<std::size_t>(entries_[e].to);
      value_[place] = value;
      level.value[place] = static_cast<float>(value);
    }
  });
  largest_diagonal_ = 0;
  for (std::size_t q = 0; q < node_.size(); ++q)
    largest_diagonal_ =
        std::max(largest_diagonal_, value_[static_cast<std::size_t>(entries_[row_begin_[q]].to)]);
  cycle_->renew_finest();
  cycle_->renew_coarse();
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
  product_.multiply<Scalar>(
      value_.data(), x_, product_of_x_, [&](std::size_t /*c*/, Index first, Index size) {
        for (Index k = 0; k < 3; ++k)
          subtract_from(size, b_.data(k) + first, product_of_x_.data(k) + first,
                        level.f.data(k) + first);
      });
  const double rounding = kRounding * (norm(b_) + largest_diagonal_ * norm(x_));
  return level.product(level.f, level.f) <= rounding * rounding;
}

Ending ScalarSystem::correct(Goal goal, int most) {
  Level<Scalar>& level = cycle_->finest();
  return gradients_.solve(
      [&](const Field<float>& y, Field<float>& out) {
        product_.multiply<Scalar>(
            value_.data(), y, out,
            [&](std::size_t c, Index first, Index size) { sums_[c] = dot(y, out, first, size); });
        return sums_.total();
      },
      [&] { return cycle_->run(); }, level.f, level.x, x_, goal, most);
}

double ScalarSystem::norm(const Field<double>& y) {
  const std::vector<Strips::Chunk>& chunks = cycle_->finest().strips.chunks();
  for (std::size_t c = 0; c < chunks.size(); ++c)
    sums_[c] = dot(y, y, chunks[c].row, chunks[c].end - chunks[c].row);
  return std::sqrt(sums_.total());
}

}  // namespace multigrid
