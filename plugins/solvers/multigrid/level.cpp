#include "level.h"

#include <algorithm>

namespace multigrid {
namespace {

const Lanes kAll{{1, 1, 1, 0}};

/// ω λ for a bound of λ.
constexpr double kDampingOfBound = 1.75;
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

/// The entry at a place.
template <class Entry>
Sum<Entry> entry_at(const std::vector<float>& value, std::int32_t place) {
  Sum<Entry> entry{};
  add<Entry>(entry, 1, value.data() + Entry::start(place));
  return entry;
}

}  // namespace

template <class Entry>
void Level<Entry>::prepare(Pattern p, std::vector<Mask> masks) {
  pattern = std::move(p);
  quads = Quads(pattern);
  held = std::move(masks);
  const auto nodes = static_cast<std::size_t>(pattern.nodes);
  value.assign(quads.places() * Entry::kSize + kOverrun, 0);
  inverse.assign(padded(pattern.nodes) * Entry::kSize + kOverrun, 0);
  for (LaneVector* v : {&f, &x, &r, &next_}) v->assign(pattern.nodes);
  diagonal.resize(nodes);
  std::vector<Lanes> factor(nodes, kAll);
  for (const Mask& m : held) factor[static_cast<std::size_t>(m.node)] = m.factor;
  const auto is_held = [](const Lanes& lanes) { return lanes[0] * lanes[1] * lanes[2] == 0; };
  cuts_.clear();
  for (std::size_t a = 0; a < nodes; ++a) {
    const auto row = static_cast<Index>(a);
    diagonal[a] = place(row, row);
    for (std::int32_t k = pattern.begin[a]; k < pattern.begin[a + 1]; ++k) {
      const Lanes& column =
          factor[static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(k)])];
      if (is_held(factor[a]) || is_held(column))
        cuts_.push_back({quads.place(row, k), factor[a], column});
    }
  }
}

template <class Entry>
std::int32_t Level<Entry>::place(Index a, Index b) const {
  const auto begin = pattern.column.begin();
  const auto at = std::lower_bound(begin + pattern.begin[static_cast<std::size_t>(a)],
                                   begin + pattern.begin[static_cast<std::size_t>(a) + 1],
                                   static_cast<std::int32_t>(b));
  return quads.place(a, static_cast<std::int32_t>(at - begin));
}

template <class Entry>
void Level<Entry>::finish() {
  for (const Cut& c : cuts_) {
    Sum<Entry> block = entry_at<Entry>(value, c.place);
    cut(block, c.row, c.column);
    store(block, value.data() + Entry::start(c.place));
  }
  deform::parallel_blocks(pattern.nodes, kRows, [&](Index first, Index size) {
    for (Index a = first; a < first + size; ++a)
      store(inverse_of(entry_at<Entry>(value, diagonal[static_cast<std::size_t>(a)])),
            inverse.data() + Entry::start(static_cast<std::int32_t>(a)));
  });
}

template <class Entry>
double Level<Entry>::product(const LaneVector& a, const LaneVector& b) {
  return sums_(a.quads(), [&](Index first, Index size) {
    return dot(a.data(), b.data(), first, first + size);
  });
}

/// Power iterations x ← D⁻¹A x; the quotient is xᵀA D⁻¹A x / xᵀA x.
template <class Entry>
void Level<Entry>::choose_damping() {
  for (Index a = 0; a < pattern.nodes; ++a)
    for (int c = 0; c < 3; ++c) x(a, c) = random_sign(static_cast<std::size_t>(3 * a + c));
  mask(x);
  double largest = 0;
  for (int k = 0; k < kPowerIterations; ++k) {
    deform::parallel_blocks(x.quads(), kQuads, [&](Index first, Index size) {
      multiply(x, first, size, r);
      Entry::smooth({inverse.data(), r.data(), 1}, first, first + size, next_.data());
    });
    const double below = product(x, r);
    largest = below > 0 ? product(next_, r) / below : 0;
    x.swap(next_);
  }
  damping_ = largest > 0 ? static_cast<float>(kDampingOfLargest / largest) : 0.65F;
}

template <class Entry>
void Level<Entry>::choose_damping_by_rows() requires std::same_as<Entry, Scalar> {
  const auto quad_bound = [&](std::size_t q) {
    Lanes sum;
    const Quads::View rows = quads.view();
    for (std::int32_t e = rows.begin[q]; e < rows.begin[q + 1]; ++e)
      sum += magnitude(Lanes::load(value.data() + 4 * static_cast<std::size_t>(e)));
    const Lanes bound = sum * magnitude(Lanes::load(inverse.data() + 4 * q));
    return std::max(std::max(bound[0], bound[1]), std::max(bound[2], bound[3]));
  };
  largest_.resize(static_cast<std::size_t>(x.quads()));
  deform::parallel_blocks(x.quads(), kQuads, [&](Index first, Index size) {
    for (auto q = static_cast<std::size_t>(first); q < static_cast<std::size_t>(first + size); ++q)
      largest_[q] = quad_bound(q);
  });
  const float bound = std::ranges::max(largest_);
  damping_ = bound > 0 ? static_cast<float>(kDampingOfBound) / bound : 0.65F;
}

template <class Entry>
void Level<Entry>::start() {
  deform::parallel_blocks(x.quads(), kQuads, [&](Index first, Index size) {
    Entry::smooth({inverse.data(), f.data(), damping_}, first, first + size, x.data());
  });
}

template <class Entry>
void Level<Entry>::find_residual() {
  deform::parallel_blocks(x.quads(), kQuads, [&](Index first, Index size) {
    multiply(x, first, size, r);
    // f − 1 · A x
    scale_and_add(-1, f.data(), first, first + size, r.data());
  });
}

template <class Entry>
void Level<Entry>::smooth_some(Index first, Index size) {
  multiply(x, first, size, r);
  Entry::smooth({inverse.data(), f.data(), damping_, x.data(), r.data()}, first, first + size,
                next_.data());
}

template <class Entry>
void Level<Entry>::smooth() {
  deform::parallel_blocks(x.quads(), kQuads,
                          [&](Index first, Index size) { smooth_some(first, size); });
  x.swap(next_);
}

template <class Entry>
double Level<Entry>::smooth_and_multiply() {
  const double sum = sums_(x.quads(), [&](Index first, Index size) {
    smooth_some(first, size);
    return dot(f.data(), next_.data(), first, first + size);
  });
  x.swap(next_);
  return sum;
}

template struct Level<Block>;
template struct Level<Scalar>;

}  // namespace multigrid
