/// Loops over blocks in parallel. What a block computes must not depend on any other block of the
/// loop, so that results have the same bits at any number of threads. A plugin that includes this
/// links TBB::tbb.
#pragma once

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "deform/types.h"

#if defined(__SANITIZE_THREAD__)
extern "C" void __tsan_acquire(void* address);
extern "C" void __tsan_release(void* address);
#endif

namespace deform {

/// The order in time that a parallel loop brings with it, said to the thread sanitizer, which does
/// not see it: oneTBB, a library of the system, is compiled without. What was done before the loop
/// comes before each of its tasks, and each of these before what is done after the loop; two tasks
/// have no order, so that races between them are found. Does nothing in other builds.
class ForkAndJoin {
 public:
  ForkAndJoin() { release(fork_); }
  ~ForkAndJoin() { acquire(join_); }
  ForkAndJoin(const ForkAndJoin&) = delete;
  ForkAndJoin& operator=(const ForkAndJoin&) = delete;

  /// Lives as long as a task runs.
  class Task {
   public:
    explicit Task(ForkAndJoin& loop) : loop_(loop) { acquire(loop_.fork_); }
    ~Task() { release(loop_.join_); }
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;

   private:
    ForkAndJoin& loop_;
  };

 private:
#if defined(__SANITIZE_THREAD__)
  static void acquire(char& moment) { __tsan_acquire(&moment); }
  static void release(char& moment) { __tsan_release(&moment); }
#else
  static void acquire(char& /*moment*/) {}
  static void release(char& /*moment*/) {}
#endif
  char fork_ = 0, join_ = 0;  // their addresses name the two moments
};

/// Calls body(first, size) for consecutive blocks of at most `block` of 0 … count−1.
template <class Body>
void parallel_blocks(Index count, Index block, const Body& body) {
  const Index blocks = (count + block - 1) / block;
  ForkAndJoin order;
  tbb::parallel_for(tbb::blocked_range<Index>(0, blocks),
                    [&](const tbb::blocked_range<Index>& range) {
                      const ForkAndJoin::Task task(order);
                      for (Index b = range.begin(); b != range.end(); ++b) {
                        const Index first = b * block;
                        body(first, std::min(block, count - first));
                      }
                    });
}

}  // namespace deform
