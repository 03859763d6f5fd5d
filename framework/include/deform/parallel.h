/// Loops over blocks in parallel. What a block computes must not depend on any other block of the
/// loop, so that results have the same bits at any number of threads. A plugin that includes this
/// links TBB::tbb.
#pragma once

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "deform/types.h"

namespace deform {

/// Calls body(first, size) for consecutive blocks of at most `block` of 0 … count−1.
template <class Body>
void parallel_blocks(Index count, Index block, const Body& body) {
  const Index blocks = (count + block - 1) / block;
  tbb::parallel_for(tbb::blocked_range<Index>(0, blocks),
                    [&](const tbb::blocked_range<Index>& range) {
                      for (Index b = range.begin(); b != range.end(); ++b) {
                        const Index first = b * block;
                        body(first, std::min(block, count - first));
                      }
                    });
}

}  // namespace deform
