#include "block_system.h"

#include <algorithm>
#include <cmath>

namespace multigrid {
namespace {

/// Rows that one task takes.
constexpr Index kRows = 4096;
/// The largest eigenvalue of D⁻¹A, about: that of membranes.
constexpr double kLargest = 2.5;
/// The diagonal's norm sees little of smooth errors, which a cycle's sees: it asks for so much
/// more.
constexpr double kStricter = 0.1;
/// So many iterations with the diagonal cost less than cycles and their coarse matrices …
constexpr double kWorthIt = 90;
/// … and are given up for these after so many.
constexpr int kMostByDiagonal = 150;
/// Of the nine numbers of a symmetric block, row by row: which of its six each is; and of the six,
/// which of the nine they are first.
constexpr Index kOfNine[9] = {0, 1, 2, 1, 3, 4, 2, 4, 5}, kOfSix[6] = {0, 1, 2, 4, 5, 8};

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
      diagonal_(pattern.nodes, 6) {
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
  for (Index q = 0; q < 6; ++q)
    for (Index k = 0; k < size; ++k) diagonal_(row + k, q) = from[kOfSix[q] * rows.lanes + k];
  const std::span<const std::int32_t> columns = pattern_.columns(row);
  put_blocks({from, rows.lanes, size, columns.data(), static_cast<Index>(columns.size()),
              static_cast<std::int32_t>(row)},
             level.strips.distances(strip).data(), strip.lanes,
             level.value.data() + 9 * strip.begin + row - strip.row);
}

void BlockSystem::factor(const deform::NodeValues& d, const deform::NodeBlocks& blocks,
                         bool renew) {
  Level<Block>& level = cycle_->finest();
  deform::parallel_blocks(
      static_cast<Index>(level.strips.chunks().size()), 1, [&](Index i, Index /*one*/) {
        const Strips::Chunk& chunk = level.strips.chunks()[static_cast<std::size_t>(i)];
        for (std::size_t s = chunk.strip; s < chunk.strip_end; ++s) {
          const Strips::Strip& strip = level.strips.strips()[s];
          for (Index q = 0; q < 9; ++q) {
            const Index six = kOfNine[q];
            float* to = level.value.data() + 9 * strip.begin + q * strip.lanes;
            for (Index r = strip.row; r < strip.row + strip.size; ++r) {
              const double of_contact = blocks.rows() > 0 ? blocks(r, six) : 0;
              const double of_nodes = q % 4 == 0 ? d[r] : 0;
              *to++ = static_cast<float>(diagonal_(r, six) + of_contact + of_nodes);
            }
          }
        }
      });
  cycle_->renew_finest();
  measure_inertia(d);
  wants_new_ = wants_new_ || renew;
  is_current_ = false;
}

/// Mean over nodes of the part that d has in the matrix's diagonal.
void BlockSystem::measure_inertia(const deform::NodeValues& d) {
  double sum = 0;
  for (Index a = 0; a < d.size(); ++a) {
    const double trace = diagonal_(a, 0) + diagonal_(a, 3) + diagonal_(a, 5);
    sum += 3 * d[a] / (trace + 3 * d[a]);
  }
  inertia_ = d.size() > 0 ? sum / static_cast<double>(d.size()) : 0;
}

/// An estimate for conjugate gradients with D for a preconditioner: as K is not negative, no
/// eigenvalue of D⁻¹(K + diag(d)) is below the least d/D, for which the mean stands.
double BlockSystem::iterations_by_diagonal(double tolerance) const {
  return inertia_ > 0 ? 0.5 * std::sqrt(kLargest / inertia_) * std::log(2 / tolerance)
                      : deform::kInfinity;
}

Ending BlockSystem::iterate(double tolerance, int most, bool with_cycle) {
  Level<Block>& level = cycle_->finest();
  level.f = b_;
  x_.set_zero();
  const Ending end = gradients_.solve(
      [&](const Field<float>& y, Field<float>& out) { return level.multiply(y, out); },
      [&] { return with_cycle ? cycle_->run() : cycle_->step(); }, level.f, level.x, x_,
      {.part = tolerance}, most);
  iterations_ += end.iterations;
  return end;
}

/// With coarse levels of an earlier matrix while these will do.
Ending BlockSystem::solve_by_cycles(double tolerance) {
  if (!wants_new_ && !is_current_) {
    const Ending end = iterate(tolerance, limits_.patience, true);
    if (end.has_converged) return end;
  }
  if (!is_current_) cycle_->renew_coarse();
  is_current_ = true;
  wants_new_ = false;
  return iterate(tolerance, limits_.iterations, true);
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
  Ending end;
  if (iterations_by_diagonal(kStricter * tolerance) <= kWorthIt)
    end = iterate(kStricter * tolerance, kMostByDiagonal, false);
  if (!end.has_converged && !end.is_indefinite) end = solve_by_cycles(tolerance);
  if (end.is_indefinite) {
    wants_new_ = true;  // nothing of such a matrix helps the next
    is_current_ = false;
    return deform::Outcome::indefinite;
  }
  if (!end.has_converged) return deform::Outcome::unfinished;
  each_component([&](Index first, Index size, Index c) {
    for (Index a = first; a < first + size; ++a) x(a, c) = largest * static_cast<double>(x_(a, c));
  });
  return deform::Outcome::solved;
}

}  // namespace multigrid
