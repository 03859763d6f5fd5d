#include "cycle.h"

#include <algorithm>

namespace multigrid {
namespace {

/// Levels of so few nodes are solved directly; where there is no such level, by so many steps.
constexpr Index kDirect = 30;
constexpr int kStepsOnCoarsest = 20;

/// A coarse node is held as the fine one that it is.
std::vector<Mask> coarse_masks(const std::vector<Mask>& fine, const Galerkin& to) {
  std::vector<Mask> masks;
  for (const Mask& m : fine)
    if (const std::int32_t c = to.same(m.node); c >= 0) masks.push_back({c, m.factor});
  std::ranges::sort(masks, {}, &Mask::node);
  return masks;
}

}  // namespace

template <class Entry>
Cycle<Entry>::Cycle(Pattern finest, std::vector<Mask> held,
                    const std::vector<deform::Prolongation>& coarsening, Finest treatment)
    : levels_(1), treatment_(treatment) {
  levels_.front().prepare(std::move(finest), std::move(held));
  for (const deform::Prolongation& p : coarsening) {
    if (levels_.back().pattern.nodes <= kDirect) break;
    between_.emplace_back(levels_.back().pattern, levels_.back().quads, p);
    Level<Entry> next;
    next.prepare(between_.back().coarse(), coarse_masks(levels_.back().held, between_.back()));
    levels_.push_back(std::move(next));
  }
}

template <class Entry>
void Cycle<Entry>::renew(bool coarse_levels) {
  levels_.front().finish();
  if (!coarse_levels) return;
  if constexpr (std::same_as<Entry, Scalar>) levels_.front().choose_damping_by_rows();
  for (std::size_t l = 1; l < levels_.size(); ++l) {
    between_[l - 1].multiply(levels_[l - 1], levels_[l]);
    levels_[l].finish();
    levels_[l].choose_damping();
  }
  factor_coarsest();
}

template <class Entry>
void Cycle<Entry>::factor_coarsest() {
  const Level<Entry>& level = levels_.back();
  const Index n = level.pattern.nodes;
  if (n > kDirect) return;
  constexpr Index kComponents = Entry::kColumns;
  Eigen::MatrixXd& a = coarsest_;
  a.setZero(kComponents * n, kComponents * n);
  for (Index row = 0; row < n; ++row)
    for (auto p = level.pattern.begin[static_cast<std::size_t>(row)];
         p < level.pattern.begin[static_cast<std::size_t>(row) + 1]; ++p) {
      const float* value = level.value.data() + Entry::start(level.quads.place(row, p));
      const Index column = level.pattern.column[static_cast<std::size_t>(p)];
      for (Index i = 0; i < kComponents; ++i)
        for (Index j = 0; j < kComponents; ++j)
          a(kComponents * row + i, kComponents * column + j) =
              static_cast<double>(value[Index{Entry::kStride} * j + i]);
    }
  for (Index i = 0; i < a.rows(); ++i)
    if (!(a(i, i) > 0)) a.row(i).setZero(), a.col(i).setZero(), a(i, i) = 1;  // held
  for (Index i = 0; i < a.rows(); ++i)
    for (Index j = 0; j < i; ++j) a(i, j) = a(j, i) = 0.5 * (a(i, j) + a(j, i));
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
  constexpr Index kComponents = Entry::kColumns;
  for (int c = 0; c < 3; c += static_cast<int>(kComponents)) {
    for (Index a = 0; a < level.pattern.nodes; ++a)
      for (Index i = 0; i < kComponents; ++i) f_[kComponents * a + i] = level.f(a, c + i);
    x_.noalias() = inverse_ * f_;
    for (Index a = 0; a < level.pattern.nodes; ++a)
      for (Index i = 0; i < kComponents; ++i) level.x(a, c + i) = x_[kComponents * a + i];
  }
}

/// x += P x_coarse; or, `from_zero`, x = ω D⁻¹ f + P x_coarse.
template <class Entry>
void Cycle<Entry>::correct(std::size_t l, const LaneVector& x_coarse, bool from_zero) {
  Level<Entry>& level = levels_[l];
  const Galerkin& to = between_[l];
  deform::parallel_blocks(level.pattern.nodes, kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      level.x.set(a, (from_zero ? level.smoothed(a, level.f.node(a)) : level.x.node(a)) +
                         to.prolonged(a, x_coarse));
  });
  level.mask(level.x);
}

template <class Entry>
void Cycle<Entry>::run_from(std::size_t l) {
  if (l + 1 == levels_.size()) return solve_coarsest();
  correct_from_coarser(l);
  levels_[l].smooth();
}

/// A cycle but for its last step on this level.
template <class Entry>
void Cycle<Entry>::correct_from_coarser(std::size_t l) {
  Level<Entry>& level = levels_[l];
  Level<Entry>& next = levels_[l + 1];
  const bool is_additive = l == 0 && treatment_ == Finest::additive;
  if (!is_additive) {
    level.start();
    level.find_residual();
  }
  between_[l].restrict_to(is_additive ? level.f : level.r, next.f);
  next.mask(next.f);
  run_from(l + 1);
  correct(l, next.x, is_additive);
}

template <class Entry>
double Cycle<Entry>::run() {
  Level<Entry>& level = finest();
  if (levels_.size() == 1) {
    solve_coarsest();
    return level.product(level.f, level.x);
  }
  correct_from_coarser(0);
  if (treatment_ == Finest::smoothed) return level.smooth_and_multiply();
  return level.product(level.f, level.x);
}

template class Cycle<Block>;
template class Cycle<Scalar>;

}  // namespace multigrid
