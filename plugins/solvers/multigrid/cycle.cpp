#include "cycle.h"

#include <algorithm>

namespace multigrid {
namespace {

/// Levels of so few nodes are solved directly; where there is no such level, by so many steps.
constexpr Index kDirect = 30;
constexpr int kStepsOnCoarsest = 20;

/// A coarse node is held as the fine one that it is.
std::vector<Held> coarse_nodes_held(const std::vector<Held>& fine, const Galerkin& to) {
  std::vector<Held> held;
  for (const Held& h : fine)
    if (const std::int32_t c = to.same(h.node); c >= 0) held.push_back({c, h.components});
  std::ranges::sort(held, {}, &Held::node);
  return held;
}

}  // namespace

template <class Entry>
Cycle<Entry>::Cycle(const Pattern& finest, std::vector<Held> held,
                    const std::vector<deform::Prolongation>& coarsening, Finest treatment)
    : levels_(1), treatment_(treatment) {
  levels_.front().prepare(finest, std::move(held));
  Pattern pattern = finest;
  for (const deform::Prolongation& p : coarsening) {
    Level<Entry>& fine = levels_.back();
    if (fine.nodes() <= kDirect) break;
    Galerkin& to = between_.emplace_back(pattern, p);
    pattern = to.coarse();
    Level<Entry>& coarse = levels_.emplace_back();
    coarse.prepare(pattern, coarse_nodes_held(fine.held, to));
    to.bind(fine.strips, coarse.strips, Entry::kNumbers);
  }
  if (!between_.empty()) sums_.resize(between_.front().interpolation().tasks().size());
}

template <class Entry>
void Cycle<Entry>::renew_finest() {
  levels_.front().finish();
}

template <class Entry>
void Cycle<Entry>::renew_coarse() {
  if constexpr (std::same_as<Entry, Scalar>) levels_.front().choose_damping_by_rows();
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    between_[l - 1].template multiply<Entry>(levels_[l - 1].value, levels_[l].value);
    levels_[l].finish();
    levels_[l].choose_damping();
  }
  factor_coarsest();
}

template <class Entry>
void Cycle<Entry>::factor_coarsest() {
  const Level<Entry>& level = levels_.back();
  const Index n = level.nodes();
  if (n > kDirect) return;
  constexpr Index kComponents = Entry::kComponents;
  Eigen::MatrixXd& a = coarsest_;
  a.setZero(kComponents * n, kComponents * n);
  for (Index row = 0; row < n; ++row)
    for (const std::int32_t distance : level.strips.distances(level.strips.strip_of(row))) {
      if (row + distance >= n) break;
      const Place at = level.strips.place(row, distance, Entry::kNumbers);
      for (Index i = 0; i < kComponents; ++i)
        for (Index j = 0; j < kComponents; ++j) {
          const Index number = at.first + (kComponents * i + j) * at.stride;
          const Index p = kComponents * row + i, q = kComponents * (row + distance) + j;
          a(p, q) = a(q, p) = static_cast<double>(level.value[static_cast<std::size_t>(number)]);
        }
    }
  for (Index i = 0; i < a.rows(); ++i)
    if (!(a(i, i) > 0)) a.row(i).setZero(), a.col(i).setZero(), a(i, i) = 1;  // held
  factor_.compute(a);
  exact_inverse_.setIdentity(a.rows(), a.cols());
  factor_.solveInPlace(exact_inverse_);
  inverse_ = exact_inverse_.template cast<float>();
  f_.resize(inverse_.rows());
  x_.resize(inverse_.rows());
}

template <class Entry>
void Cycle<Entry>::solve_coarsest() {
  Level<Entry>& level = levels_.back();
  if (inverse_.size() == 0) {
    level.start();
    for (int k = 0; k < kStepsOnCoarsest; ++k) level.smooth();
    return;
  }
  constexpr Index kComponents = Entry::kComponents;
  for (Index c = 0; c < 3; c += kComponents) {
    for (Index a = 0; a < level.nodes(); ++a)
      for (Index i = 0; i < kComponents; ++i) f_[kComponents * a + i] = level.f(a, c + i);
    x_.noalias() = inverse_ * f_;
    for (Index a = 0; a < level.nodes(); ++a)
      for (Index i = 0; i < kComponents; ++i) level.x(a, c + i) = x_[kComponents * a + i];
  }
}

template <class Entry>
void Cycle<Entry>::run_from(std::size_t l) {
  if (l + 1 == levels_.size()) return solve_coarsest();
  correct_from_coarser(l);
  levels_[l].smooth();
}

/// A cycle but for its last step on this level: x += P x₁ of the next, or, where it is additive,
/// x = ω D⁻¹ f + P x₁.
template <class Entry>
void Cycle<Entry>::correct_from_coarser(std::size_t l) {
  Level<Entry>& level = levels_[l];
  Level<Entry>& next = levels_[l + 1];
  const Galerkin& to = between_[l];
  const bool is_additive = l == 0 && treatment_ == Finest::additive;
  if (!is_additive) {
    level.start();
    level.find_residual();
  }
  to.restrict_to(is_additive ? level.f : level.r, next.f);
  next.mask(next.f);
  run_from(l + 1);
  const std::vector<Runs::Task>& tasks = to.interpolation().tasks();
  deform::parallel_blocks(static_cast<Index>(tasks.size()), 1, [&](Index t, Index /*one*/) {
    const Runs::Task& task = tasks[static_cast<std::size_t>(t)];
    if (is_additive) level.start(task.row, task.size);
    to.interpolation().multiply(task, next.x, level.x, true);
    // Held components of f are 0.
    if (is_additive)
      sums_[static_cast<std::size_t>(t)] = dot(level.f, level.x, task.row, task.size);
  });
  level.mask(level.x);
}

template <class Entry>
double Cycle<Entry>::run() {
  Level<Entry>& level = finest();
  if (levels_.size() == 1) {
    solve_coarsest();
    return level.product(level.f, level.x);
  }
  correct_from_coarser(0);
  return treatment_ == Finest::smoothed ? level.smooth_and_multiply() : sums_.total();
}

template <class Entry>
double Cycle<Entry>::step() {
  Level<Entry>& level = finest();
  level.start();
  return level.product(level.f, level.x);
}

template class Cycle<Block>;
template class Cycle<Scalar>;

}  // namespace multigrid
