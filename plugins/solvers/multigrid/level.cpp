#include "level.h"

#include <algorithm>
#include <numeric>

namespace multigrid {
namespace {

const Lanes kAll{{1, 1, 1, 0}};

/// ω λ: below 2 by more than what so many power iterations may underestimate λ by.
constexpr double kDampingOfLargest = 1.6;
constexpr int kPowerIterations = 6;

/// 1 or −1, without a pattern that a matrix might have, too.
float random_sign(std::size_t i) {
  std::uint64_t x = (i + 1) * 0x9E3779B97F4A7C15U;
  x ^= x >> 31;
  x *= 0xBF58476D1CE4E5B9U;
  return (x >> 40 & 1) != 0 ? 1.0F : -1.0F;
}

void cut(Sum<Block>& block, const Lanes& row, const Lanes& column) {
  for (int c = 0; c < 3; ++c)
    block[static_cast<std::size_t>(c)] = column[c] * (row * block[static_cast<std::size_t>(c)]);
}
/// One number holds for all three components: a node is held in all of them, or in none.
void cut(Sum<Scalar>& block, const Lanes& row, const Lanes& column) {
  block[0] = column[0] * (row[0] * block[0]);
}

}  // namespace

std::int32_t Pattern::place(Index a, Index b) const {
  const auto first = column.begin() + begin[static_cast<std::size_t>(a)];
  const auto last = column.begin() + begin[static_cast<std::size_t>(a) + 1];
  const auto at = std::lower_bound(first, last, static_cast<std::int32_t>(b));
  return at != last && *at == b ? static_cast<std::int32_t>(at - column.begin()) : -1;
}

template <class Entry>
void Level<Entry>::prepare(Pattern p, std::vector<Mask> masks) {
  pattern = std::move(p);
  held = std::move(masks);
  const auto nodes = static_cast<std::size_t>(pattern.nodes);
  value.assign(pattern.column.size() * Entry::kSize + 1, 0);
  inverse.assign(nodes * Entry::kSize + 1, 0);
  for (LaneVector* v : {&f, &x, &r, &next_}) v->assign(nodes, {});
  diagonal.resize(nodes);
  std::vector<Lanes> factor(nodes, kAll);
  for (const Mask& m : held) factor[static_cast<std::size_t>(m.node)] = m.factor;
  const auto is_held = [](const Lanes& lanes) { return lanes[0] * lanes[1] * lanes[2] == 0; };
  cuts_.clear();
  for (std::size_t a = 0; a < nodes; ++a) {
    diagonal[a] = pattern.place(static_cast<Index>(a), static_cast<Index>(a));
    for (std::int32_t place = pattern.begin[a]; place < pattern.begin[a + 1]; ++place) {
      const Lanes& column =
          factor[static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(place)])];
      if (is_held(factor[a]) || is_held(column)) cuts_.push_back({place, factor[a], column});
    }
  }
}

template <class Entry>
void Level<Entry>::finish() {
  for (const Cut& c : cuts_) {
    float* at = value.data() + static_cast<std::size_t>(c.place) * Entry::kSize;
    Sum<Entry> block{};
    add<Entry>(block, 1, at);
    cut(block, c.row, c.column);
    store(block, at);
  }
  deform::parallel_blocks(pattern.nodes, kRows, [&](Index first, Index size) {
    for (auto a = static_cast<std::size_t>(first); a < static_cast<std::size_t>(first + size);
         ++a) {
      std::array<float, Entry::kSize> block;
      invert(value.data() + static_cast<std::size_t>(diagonal[a]) * Entry::kSize, block);
      std::ranges::copy(block, inverse.begin() + static_cast<std::ptrdiff_t>(a * Entry::kSize));
    }
  });
}

template <class Entry>
double Level<Entry>::product(const LaneVector& a, const LaneVector& b) {
  parts_.resize(static_cast<std::size_t>((pattern.nodes + kRows - 1) / kRows));
  deform::parallel_blocks(pattern.nodes, kRows, [&](Index first, Index size) {
    double sum = 0;
    for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(first + size); ++i)
      sum += dot(a[i], b[i]);
    parts_[static_cast<std::size_t>(first / kRows)] = sum;
  });
  return std::accumulate(parts_.begin(), parts_.end(), 0.0);
}

/// Power iterations x ← D⁻¹A x; the quotient is xᵀA D⁻¹A x / xᵀA x.
template <class Entry>
void Level<Entry>::choose_damping() {
  damping_ = 1;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (int c = 0; c < 3; ++c) x[i].set(c, random_sign(3 * i + static_cast<std::size_t>(c)));
  mask(x);
  double largest = 0;
  for (int k = 0; k < kPowerIterations; ++k) {
    deform::parallel_blocks(pattern.nodes, kRows, [&](Index first, Index size) {
      for (Index a = first; a < first + size; ++a) {
        const auto i = static_cast<std::size_t>(a);
        r[i] = row_times(a, x);
        next_[i] = smoothed(a, r[i]);
      }
    });
    const double below = product(x, r);
    largest = below > 0 ? product(next_, r) / below : 0;
    x.swap(next_);
  }
  damping_ = largest > 0 ? static_cast<float>(kDampingOfLargest / largest) : 0.65F;
}

template <class Entry>
void Level<Entry>::start() {
  deform::parallel_blocks(pattern.nodes, kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      x[static_cast<std::size_t>(a)] = smoothed(a, f[static_cast<std::size_t>(a)]);
  });
}

template <class Entry>
void Level<Entry>::find_residual() {
  deform::parallel_blocks(pattern.nodes, kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      r[static_cast<std::size_t>(a)] = f[static_cast<std::size_t>(a)] - row_times(a, x);
  });
}

template <class Entry>
void Level<Entry>::smooth() {
  deform::parallel_blocks(pattern.nodes, kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a) {
      const auto i = static_cast<std::size_t>(a);
      next_[i] = x[i] + smoothed(a, f[i] - row_times(a, x));
    }
  });
  x.swap(next_);
}

template struct Level<Block>;
template struct Level<Scalar>;

}  // namespace multigrid
