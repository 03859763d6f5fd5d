#include "block_system.h"

#include <algorithm>
#include <cmath>

namespace multigrid {
namespace {

/// Rows that one task takes.
constexpr Index kRows = 4096;

std::vector<Held> nodes_held(const std::vector<std::uint8_t>& components) {
  std::vector<Held> held;
  for (std::size_t a = 0; a < components.size(); ++a)
    if (components[a] != 0) held.push_back({static_cast<std::int32_t>(a), components[a]});
  return held;
}

}  // namespace

BlockSystem::BlockSystem(const deform::BlockMatrix& pattern, const std::vector<std::uint8_t>& held,
                         const std::vector<deform::Prolongation>& coarsening, Limits limits)
    : limits_(limits),
      pattern_{pattern.nodes, pattern.row_begin, pattern.column},
      diagonal_(pattern.nodes, 3) {
  cycle_.emplace(pattern_, nodes_held(held), coarsening, Finest::additive);
  cycle_->finest().assign(b_);
  cycle_->finest().assign(x_);
  gradients_.assign(pattern.nodes, b_.stride());
}

void BlockSystem::put(const deform::BlockRows& rows) {
  const Strips& strips = cycle_->finest().strips;
  for (Index k = 0; k < rows.size;) {
    const Strips::Strip& strip = strips.strip_of(rows.row + k);
    const Index size = std::min(rows.size - k, strip.row + strip.size - rows.row - k);
    put_in_strip(rows, k, size);
    k += size;
  }
}

/// `size` of the rows, from one on, which lie in one strip.
void BlockSystem::put_in_strip(const deform::BlockRows& rows, Index skipped, Index size) {
  Level<Block>& level = cycle_->finest();
  const Index row = rows.row + skipped;
  const Strips::Strip& strip = level.strips.strip_of(row);
  const double* from = rows.value + skipped;
  for (int c = 0; c < 3; ++c)
    for (Index k = 0; k < size; ++k) diagonal_(row + k, c) = from[4 * c * rows.lanes + k];
  const std::span<const std::int32_t> columns = pattern_.columns(row);
  put_blocks({from, rows.lanes, size, columns.data(), static_cast<Index>(columns.size()),
              static_cast<std::int32_t>(row)},
             level.strips.distances(strip).data(), strip.lanes,
             level.value.data() + 9 * strip.begin + row - strip.row);
}

void BlockSystem::factor(const deform::NodeValues& d, bool renew) {
  Level<Block>& level = cycle_->finest();
  deform::parallel_blocks(
      static_cast<Index>(level.strips.chunks().size()), 1, [&](Index i, Index /*one*/) {
        const Strips::Chunk& chunk = level.strips.chunks()[static_cast<std::size_t>(i)];
        for (std::size_t s = chunk.strip; s < chunk.strip_end; ++s) {
          const Strips::Strip& strip = level.strips.strips()[s];
          for (Index c = 0; c < 3; ++c) {
            float* const to = level.value.data() + 9 * strip.begin + 4 * c * strip.lanes;
            for (Index k = 0; k < strip.size; ++k)
              to[k] = static_cast<float>(diagonal_(strip.row + k, c) + d[strip.row + k]);
          }
        }
      });
  is_old_ = is_made_ && !renew;
  is_made_ = true;
  cycle_->renew(!is_old_);
}

Ending BlockSystem::iterate(double tolerance, int most) {
  Level<Block>& level = cycle_->finest();
  level.f = b_;
  x_.set_zero();
  const Ending end = gradients_.solve(
      [&](const Field<float>& y, Field<float>& out) { return level.multiply(y, out); },
      [&] { return cycle_->run(); }, level.f, level.x, x_, {.part = tolerance}, most);
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
  const auto each_component = [&](const auto& visit) {
    deform::parallel_blocks(b.rows(), kRows, [&](Index first, Index size) {
      for (Index c = 0; c < 3; ++c) visit(first, size, c);
    });
  };
  each_component([&](Index first, Index size, Index c) {
    for (Index a = first; a < first + size; ++a) b_(a, c) = static_cast<float>(b(a, c) / largest);
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
  each_component([&](Index first, Index size, Index c) {
    for (Index a = first; a < first + size; ++a) x(a, c) = largest * static_cast<double>(x_(a, c));
  });
  return deform::Outcome::solved;
}

}  // namespace multigrid
