/// What the machine can do: bandwidth of a triad, and arithmetic peaks.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <numeric>
#include <vector>

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include "deform/kernel.h"
#include "deform/parallel.h"

namespace {
using deform::Index;

constexpr Index kNumbers = Index{1} << 24;  // far more than any cache holds
constexpr Index kTask = Index{1} << 16;

DEFORM_KERNEL void triad_of(Index size, const double* __restrict b, const double* __restrict c,
                            double* __restrict a) {
  for (Index i = 0; i < size; ++i) a[i] = b[i] + 3 * c[i];
}

/// a = b + 3 c; a line that is written is read first, which counts as 32 bytes a number.
/// range(0): threads.
void triad(benchmark::State& bench) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(bench.range(0)));
  std::vector<double> a(kNumbers), b(kNumbers, 1.0), c(kNumbers, 2.0);
  for (auto _ : bench)
    deform::parallel_blocks(kNumbers, kTask, [&](Index first, Index size) {
      triad_of(size, b.data() + first, c.data() + first, a.data() + first);
    });
  benchmark::DoNotOptimize(a.data());
  bench.counters["bytes"] = 32.0 * kNumbers;
}
BENCHMARK(triad)->ArgName("threads")->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

using Numbers [[gnu::vector_size(64)]] = double;
constexpr int kChains = 12;  // as many as it takes to hide latencies
constexpr long kRounds = 100000;

/// x ← x a + b in independent chains, multiplied and added as kernels do: not fused.
DEFORM_KERNEL double multiply_and_add(double start) {
  Numbers x[kChains];
  for (int k = 0; k < kChains; ++k) x[k] = Numbers{} + (start + k);
  const Numbers a = Numbers{} + 0.999999, b = Numbers{} + 1e-6;
  for (long i = 0; i < kRounds; ++i)
    for (int k = 0; k < kChains; ++k) x[k] = x[k] * a + b;
  Numbers sum{};
  for (const Numbers& of_chain : x) sum += of_chain;
  return sum[0];
}

/// range(0): threads.
void arithmetic(benchmark::State& bench) {
  const auto threads = static_cast<Index>(bench.range(0));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  std::vector<double> sums(static_cast<std::size_t>(threads));
  for (auto _ : bench)
    deform::parallel_blocks(threads, 1, [&](Index t, Index /*one*/) {
      sums[static_cast<std::size_t>(t)] = multiply_and_add(static_cast<double>(t));
    });
  benchmark::DoNotOptimize(sums.data());
  bench.counters["flops"] = static_cast<double>(threads) * 2.0 * 8 * kChains * kRounds;
}
BENCHMARK(arithmetic)
    ->ArgName("threads")
    ->Arg(1)
    ->Arg(2)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
