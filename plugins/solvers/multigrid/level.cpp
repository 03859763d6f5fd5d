#include "level.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace multigrid {
namespace {

/// ω λ for a bound of λ.
constexpr double kDampingOfBound = 1.75;
/// ω λ: below 2 by more than what so many power iterations may underestimate λ by.
constexpr double kDampingOfLargest = 1.6;
constexpr int kPowerIterations = 5;

/// 1 or −1, without a pattern that a matrix might have, too.
float random_sign(std::size_t i) {
  std::uint64_t x = (i + 1) * 0x9E3779B97F4A7C15U;
  x ^= x >> 31;
  x *= 0xBF58476D1CE4E5B9U;
  return (x >> 40 & 1) != 0 ? 1.0F : -1.0F;
}

}  // namespace

template <class Entry>
void Level<Entry>::prepare(const Pattern& pattern, std::vector<Held> nodes_held) {
  strips = Strips(pattern);
  product_ = Product<float>(strips);
  held = std::move(nodes_held);
  value.assign(strips.size(Entry::kNumbers), 0);
  inverse_.assign(static_cast<std::size_t>(Entry::kInverse * pattern.nodes), 0);
  for (Field<float>* v : {&f, &x, &r}) v->assign(pattern.nodes, strips.reach());
  sums_.resize(strips.chunks().size());
  find_cuts();
}

/// Of a held node a: the numbers of entries (a, b) in its components' rows, of (b, a) in their
/// columns.
template <class Entry>
void Level<Entry>::find_cuts() {
  cuts_.clear();
  std::vector<std::uint8_t> components(static_cast<std::size_t>(nodes()), 0);
  for (const Held& h : held) components[static_cast<std::size_t>(h.node)] = h.components;
  for (Index a = 0; a < nodes(); ++a)
    for (const std::int32_t distance : strips.distances(strips.strip_of(a))) {
      if (a + distance >= nodes()) break;  // what rows lack may lie beyond
      const std::uint8_t row = components[static_cast<std::size_t>(a)],
                         column = components[static_cast<std::size_t>(a + distance)];
      if (row == 0 && column == 0) continue;
      const Place at = strips.place(a, distance, Entry::kNumbers);
      for (Index i = 0; i < Entry::kComponents; ++i)
        for (Index j = 0; j < Entry::kComponents; ++j)
          if ((row >> i & 1) != 0 || (column >> j & 1) != 0)
            cuts_.push_back(at.first + (Entry::kComponents * i + j) * at.stride);
    }
}

template <class Entry>
void Level<Entry>::finish() {
  for (const std::int64_t at : cuts_) value[static_cast<std::size_t>(at)] = 0;
  deform::parallel_blocks(
      static_cast<Index>(strips.chunks().size()), 1, [&](Index c, Index /*one*/) {
        const Strips::Chunk& chunk = strips.chunks()[static_cast<std::size_t>(c)];
        for (std::size_t s = chunk.strip; s < chunk.strip_end; ++s) {
          const Strips::Strip& strip = strips.strips()[s];
          Entry::invert(strip.size, value.data() + Entry::kNumbers * strip.begin, strip.lanes,
                        inverse_.data() + strip.row, nodes());
        }
      });
}

template <class Entry>
double Level<Entry>::multiply(const Field<float>& y, Field<float>& out) {
  product_.template multiply<Entry>(
      value.data(), y, out,
      [&](std::size_t c, Index first, Index size) { sums_[c] = dot(y, out, first, size); });
  return sums_.total();
}

template <class Entry>
double Level<Entry>::product(const Field<float>& a, const Field<float>& b) {
  deform::parallel_blocks(static_cast<Index>(strips.chunks().size()), 1,
                          [&](Index i, Index /*one*/) {
                            const auto c = static_cast<std::size_t>(i);
                            const Strips::Chunk& chunk = strips.chunks()[c];
                            sums_[c] = dot(a, b, chunk.row, chunk.end - chunk.row);
                          });
  return sums_.total();
}

template <class Entry>
void Level<Entry>::mask(Field<float>& y) const {
  for (const Held& h : held)
    for (Index c = 0; c < 3; ++c)
      if ((h.components >> c & 1) != 0) y(h.node, c) = 0;
}

/// Power iterations x ← D⁻¹A x from a vector of some components; the quotient is
/// xᵀA D⁻¹A x / xᵀA x.
template <class Entry>
double Level<Entry>::largest_eigenvalue(Index first, Index end) {
  x.set_zero();
  for (Index c = first; c < end; ++c)
    for (Index a = 0; a < nodes(); ++a) x(a, c) = random_sign(static_cast<std::size_t>(3 * a + c));
  mask(x);
  double largest = 0;
  for (int k = 0; k < kPowerIterations; ++k) {
    const double below = multiply(x, r);
    Entry::smooth(0, nodes(), 1, inverse(), r.read(), x.write(), false);
    largest = below > 0 ? product(x, r) / below : 0;
  }
  return largest;
}

/// Of vectors in the plane and normal to it: what is mirrored at z = 0 has the same ω then, and
/// its solutions are mirror images.
template <class Entry>
void Level<Entry>::choose_damping() {
  const double largest = std::max(largest_eigenvalue(0, 2), largest_eigenvalue(2, 3));
  damping_ = largest > 0 ? static_cast<float>(kDampingOfLargest / largest) : 0.65F;
}

template <class Entry>
void Level<Entry>::choose_damping_by_rows() requires std::same_as<Entry, Scalar> {
  // Both parts of a row's sum, in fields that the next cycle overwrites.
  r.set_zero();
  for (const Strips::Strip& strip : strips.strips())
    add_magnitudes(
        {value.data() + strip.begin, strip.lanes, strips.distances(strip).data(), strip.entries},
        r.data(0) + strip.row, r.data(1) + strip.row);
  float bound = 0;
  for (Index a = 0; a < nodes(); ++a)
    bound = std::max(bound, (r(a, 0) + r(a, 1)) * std::abs(inverse_[static_cast<std::size_t>(a)]));
  r.set_zero();
  damping_ = bound > 0 ? static_cast<float>(kDampingOfBound) / bound : 0.65F;
}

template <class Entry>
void Level<Entry>::start(Index first, Index size) {
  Entry::smooth(first, size, damping_, inverse(), f.read(), x.write(), false);
}

template <class Entry>
void Level<Entry>::find_residual() {
  product_.template multiply<Entry>(value.data(), x, r,
                                    [&](std::size_t /*c*/, Index first, Index size) {
                                      for (Index k = 0; k < 3; ++k)
                                        subtract_from(size, f.data(k) + first, r.data(k) + first);
                                    });
}

/// x += ω D⁻¹ (f − A x), A x being in r.
template <class Entry>
void Level<Entry>::add_correction(Index first, Index size) {
  for (Index k = 0; k < 3; ++k) subtract_from(size, f.data(k) + first, r.data(k) + first);
  Entry::smooth(first, size, damping_, inverse(), r.read(), x.write(), true);
}

template <class Entry>
void Level<Entry>::smooth() {
  product_.template multiply<Entry>(
      value.data(), x, r,
      [&](std::size_t /*c*/, Index first, Index size) { add_correction(first, size); });
}

template <class Entry>
double Level<Entry>::smooth_and_multiply() {
  product_.template multiply<Entry>(value.data(), x, r,
                                    [&](std::size_t c, Index first, Index size) {
                                      add_correction(first, size);
                                      sums_[c] = dot(f, x, first, size);
                                    });
  return sums_.total();
}

template class Level<Block>;
template class Level<Scalar>;

}  // namespace multigrid
