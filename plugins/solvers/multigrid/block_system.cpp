#include "block_system.h"

#include <algorithm>
#include <cmath>

namespace multigrid {
namespace {

/// Both triangles of a symmetric pattern of which `half` is the upper one.
Pattern both_triangles(const deform::BlockMatrix& half) {
  const auto nodes = static_cast<std::size_t>(half.nodes);
  std::vector<std::int32_t> size(nodes, 0);
  for (std::size_t a = 0; a < nodes; ++a)
    for (auto p = half.row_begin[a]; p < half.row_begin[a + 1]; ++p) {
      const auto b = static_cast<std::size_t>(half.column[static_cast<std::size_t>(p)]);
      ++size[a];
      if (b != a) ++size[b];
    }
  Pattern full;
  full.nodes = half.nodes;
  for (const std::int32_t s : size) full.begin.push_back(full.begin.back() + s);
  full.column.resize(static_cast<std::size_t>(full.begin.back()));
  std::vector<std::int32_t> next(full.begin.begin(), full.begin.end() - 1);
  // Rows come in ascending order, so the columns below the diagonal do, and come first.
  for (std::size_t a = 0; a < nodes; ++a)
    for (auto p = half.row_begin[a] + 1; p < half.row_begin[a + 1]; ++p) {
      const auto b = static_cast<std::size_t>(half.column[static_cast<std::size_t>(p)]);
      full.column[static_cast<std::size_t>(next[b]++)] = static_cast<std::int32_t>(a);
    }
  for (std::size_t a = 0; a < nodes; ++a)
    for (auto p = half.row_begin[a]; p < half.row_begin[a + 1]; ++p)
      full.column[static_cast<std::size_t>(next[a]++)] = half.column[static_cast<std::size_t>(p)];
  return full;
}

std::vector<Mask> masks_of(const std::vector<std::uint8_t>& held) {
  std::vector<Mask> masks;
  for (std::size_t a = 0; a < held.size(); ++a) {
    if (held[a] == 0) continue;
    Mask mask{static_cast<std::int32_t>(a), {}};
    for (int c = 0; c < 3; ++c) mask.factor.set(c, (held[a] >> c & 1) != 0 ? 0.0F : 1.0F);
    masks.push_back(mask);
  }
  return masks;
}

}  // namespace

BlockSystem::BlockSystem(const deform::BlockMatrix& pattern, const std::vector<std::uint8_t>& held,
                         const std::vector<deform::Prolongation>& coarsening, Limits limits)
    : limits_(limits) {
  cycle_.emplace(both_triangles(pattern), masks_of(held), coarsening, Finest::additive);
  const Level<Block>& full = cycle_->finest();
  for (Index a = 0; a < pattern.nodes; ++a)
    for (auto p = pattern.row_begin[static_cast<std::size_t>(a)];
         p < pattern.row_begin[static_cast<std::size_t>(a) + 1]; ++p) {
      const Index b = pattern.column[static_cast<std::size_t>(p)];
      upper_.push_back(full.place(a, b));
      lower_.push_back(full.place(b, a));
    }
  b_.assign(pattern.nodes);
}

void BlockSystem::factor(const deform::BlockMatrix& a, const deform::NodeValues& d, bool renew) {
  Level<Block>& level = cycle_->finest();
  deform::parallel_blocks(a.nodes, kRows, [&](Index first, Index size) {
    for (Index row = first; row < first + size; ++row) {
      const auto begin = static_cast<std::size_t>(a.row_begin[static_cast<std::size_t>(row)]);
      const Index blocks = a.row_begin[static_cast<std::size_t>(row) + 1] -
                           a.row_begin[static_cast<std::size_t>(row)];
      const double* from = a.value.data() + 9 * begin;
      write_blocks(from, upper_.data() + begin, lower_.data() + begin, blocks, level.value.data());
      // The diagonal block, which comes first, is its own mirror image.
      float* diagonal = level.value.data() + Block::start(upper_[begin]);
      for (int c = 0; c < 3; ++c)
        diagonal[(Block::kStride + 1) * c] = static_cast<float>(from[4 * c] + d[row]);
    }
  });
  is_old_ = is_made_ && !renew;
  is_made_ = true;
  cycle_->renew(!is_old_);
}

Ending BlockSystem::iterate(double tolerance, int most) {
  Level<Block>& level = cycle_->finest();
  level.f = b_;
  x_.set_zero(b_.quads());
  const Ending end = gradients_.solve([&](const LaneVector& y, Index first, Index size,
                                          LaneVector& out) { level.multiply(y, first, size, out); },
                                      [&] { return cycle_->run(); }, level.f, level.x, x_,
                                      {.part = tolerance}, most);
  iterations_ += end.iterations;
  return end;
}

deform::Outcome BlockSystem::solve(const deform::NodeVectors& b, double tolerance,
                                   deform::NodeVectors& x) {
  // In single precision numbers should be neither tiny nor huge.
  const double largest = b.cwiseAbs().maxCoeff();
  x.resize(b.rows(), 3);
  iterations_ = 0;
  if (largest == 0) {
    x.setZero();
    return deform::Outcome::solved;
  }
  deform::parallel_blocks(b.rows(), kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      for (int c = 0; c < 3; ++c) b_(a, c) = static_cast<float>(b(a, c) / largest);
  });
  cycle_->finest().mask(b_);
  Ending end = iterate(tolerance, is_old_ ? limits_.patience : limits_.iterations);
  if (!end.has_converged && is_old_) {
    cycle_->renew(true);
    is_old_ = false;
    end = iterate(tolerance, limits_.iterations);
  }
  if (end.is_indefinite) {
    is_made_ = false;  // nothing of such a matrix helps the next
    return deform::Outcome::indefinite;
  }
  if (!end.has_converged) return deform::Outcome::unfinished;
  deform::parallel_blocks(b.rows(), kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      for (int c = 0; c < 3; ++c) x(a, c) = largest * static_cast<double>(x_(a, c));
  });
  return deform::Outcome::solved;
}

}  // namespace multigrid
