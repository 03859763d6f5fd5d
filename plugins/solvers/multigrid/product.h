/// Products y = A x with symmetric matrices that lie in strips.
#pragma once

#include <algorithm>
#include <vector>

#include <deform/parallel.h>

#include "entries.h"
#include "field.h"
#include "strips.h"

namespace multigrid {

/// What the rows of a chunk give to columns behind it waits until all chunks are done, and is then
/// added in their order: the same bits at any number of threads. Sums are in the precision of Sum.
template <class Sum>
class Product {
 public:
  Product() = default;
  explicit Product(const Strips& strips) : strips_(&strips) {
    for (const Strips::Chunk& chunk : strips.chunks())
      behind_.emplace_back(static_cast<std::size_t>(3 * (chunk.reach - chunk.end)));
  }

  /// y = A x; then(chunk, first, size) for the rows of each chunk when their y is there. `Entry`:
  /// what an entry's numbers are.
  template <class Entry, class Value, class X, class Y, class Then>
  void multiply(const Value* value, const Field<X>& x, Field<Y>& y, const Then& then) {
    const auto chunks = static_cast<Index>(strips_->chunks().size());
    deform::parallel_blocks(chunks, 1, [&](Index c, Index /*one*/) {
      multiply_chunk<Entry>(static_cast<std::size_t>(c), value, x, y);
    });
    deform::parallel_blocks(chunks, 1, [&](Index c, Index /*one*/) {
      const Strips::Chunk& chunk = strips_->chunks()[static_cast<std::size_t>(c)];
      add_from_before(static_cast<std::size_t>(c), y);
      then(static_cast<std::size_t>(c), chunk.row, chunk.end - chunk.row);
    });
  }

 private:
  template <class Entry, class Value, class X, class Y>
  void multiply_chunk(std::size_t c, const Value* value, const Field<X>& x, Field<Y>& y) {
    const Strips::Chunk& chunk = strips_->chunks()[c];
    const Index own = chunk.end - chunk.row, stride = chunk.reach - chunk.row + kLanes;
    // Kept by each thread from call to call: no allocation once it is large enough.
    thread_local std::vector<Sum> sums;
    sums.assign(static_cast<std::size_t>(6 * stride), 0);
    Sum *const upper = sums.data(), *const lower = upper + 3 * stride;
    for (std::size_t s = chunk.strip; s < chunk.strip_end; ++s) {
      const Strips::Strip& strip = strips_->strips()[s];
      const Index at = strip.row - chunk.row;
      const StripValues<Value> a{value + Entry::kNumbers * strip.begin, strip.lanes,
                                 strips_->distances(strip).data(), strip.entries};
      Entry::multiply(a, Components<const X>{x.data(0) + strip.row, x.stride()},
                      Components<Sum>{upper + at, stride}, Components<Sum>{lower + at, stride});
    }
    for (Index k = 0; k < 3; ++k) {
      add_halves(own, upper + k * stride, lower + k * stride, y.data(k) + chunk.row);
      std::copy_n(lower + k * stride + own, chunk.reach - chunk.end,
                  behind_[c].data() + k * (chunk.reach - chunk.end));
    }
  }

  template <class Y>
  void add_from_before(std::size_t c, Field<Y>& y) const {
    const std::vector<Strips::Chunk>& chunks = strips_->chunks();
    const Strips::Chunk& to = chunks[c];
    for (std::size_t b = 0; b < c; ++b) {
      const Strips::Chunk& from = chunks[b];
      const Index first = std::max(from.end, to.row), end = std::min(from.reach, to.end);
      for (Index k = 0; k < 3 && first < end; ++k)
        add_part(end - first, behind_[b].data() + k * (from.reach - from.end) + first - from.end,
                 y.data(k) + first);
    }
  }

  const Strips* strips_ = nullptr;
  std::vector<std::vector<Sum>> behind_;  // of each chunk, (3 × what it reaches beyond)
};

}  // namespace multigrid
