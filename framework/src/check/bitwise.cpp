#include "check/bitwise.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <exception>
#include <thread>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace deform {
namespace {

constexpr double kSentinel = 0x1.badbadbadp-7;  // no figure that a plugin would give
constexpr int kThreads = 4;
constexpr int kRepetitions = 8;

/// The same evaluation on several threads at once, several times.
bool same_when_concurrent(const Evaluate& evaluate, const Evaluated& expected) {
  std::vector<std::thread> threads;
  std::vector<char> same(kThreads, 1);
  std::vector<std::exception_ptr> thrown(kThreads);
  for (std::size_t t = 0; t < kThreads; ++t)
    threads.emplace_back([&, t] {
      try {
        const Index block = t % 2 == 0 ? kBlock : kBlock / 3;
        for (int i = 0; i < kRepetitions; ++i)
          if (!same_bits(evaluate(block, 0).numbers, expected.numbers)) same[t] = 0;
      } catch (...) {
        thrown[t] = std::current_exception();
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::exception_ptr& exception : thrown)
    if (exception) std::rethrow_exception(exception);
  return std::ranges::all_of(same, [](char s) { return s == 1; });
}

/// Largest difference between x and (x + prefill) − prefill, relative to both.
double addition_error(std::span<const double> alone, std::span<const double> added,
                      double prefill) {
  double worst = 0;
  for (std::size_t i = 0; i < alone.size(); ++i)
    worst = std::max(
        worst, std::abs(added[i] - prefill - alone[i]) / (std::abs(alone[i]) + std::abs(prefill)));
  return worst;
}

}  // namespace

GuardedRoom::GuardedRoom(Index size, double prefill)
    : size_(static_cast<std::size_t>(size)), numbers_(size_ + 2 * kMargin, kSentinel) {
  std::ranges::fill(values(), prefill);
}

bool GuardedRoom::margins_intact() const {
  const auto is_sentinel = [](double x) { return x == kSentinel; };
  return std::all_of(numbers_.begin(), numbers_.begin() + kMargin, is_sentinel) &&
         std::all_of(numbers_.end() - kMargin, numbers_.end(), is_sentinel);
}

bool all_finite(std::span<const double> numbers) {
  return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
}

bool same_bits(std::span<const double> a, std::span<const double> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

std::string what_is_not_finite(std::span<const double> numbers, const NameOfNumber& name) {
  const auto found = std::ranges::find_if_not(numbers, [](double x) { return std::isfinite(x); });
  if (found == numbers.end()) return "";
  return fmt::format("{} is {}", name(static_cast<std::size_t>(found - numbers.begin())), *found);
}

void check_evaluation(Checks& checks, const Evaluate& evaluate, bool adds,
                      const NameOfNumber& name) {
  const Evaluated once = evaluate(kBlock, 0);
  const auto differing = [&](const Evaluated& other) {
    const auto at = std::ranges::mismatch(once.numbers, other.numbers, [](double a, double b) {
                      return same_bits({&a, 1}, {&b, 1});
                    }).in1;
    if (at == once.numbers.end()) return std::string();
    return ": " + name(static_cast<std::size_t>(at - once.numbers.begin()));
  };
  checks.holds("gives finite numbers", all_finite(once.numbers),
               what_is_not_finite(once.numbers, name));
  checks.holds(kWritesWithin, once.margins_intact, "numbers beside the block's were written");
  const Evaluated again = evaluate(kBlock, 0);
  checks.holds("same bits when asked again", same_bits(again.numbers, once.numbers),
               "the second answer differs from the first" + differing(again));
  for (const Index block : {Index{1}, Index{13}}) {
    const Evaluated cut = evaluate(block, 0);
    checks.holds(
        "same bits in blocks of other sizes", same_bits(cut.numbers, once.numbers),
        fmt::format("blocks of {} differ from blocks of {}{}", block, kBlock, differing(cut)));
    checks.holds(kWritesWithin, cut.margins_intact,
                 "numbers beside a block's of " + std::to_string(block) + " were written");
  }
  checks.holds("same bits on several threads at once", same_when_concurrent(evaluate, once),
               "answers differ: something is shared");
  if (adds) {
    constexpr double prefill = 3.25;
    checks.below("adds to what is there",
                 addition_error(once.numbers, evaluate(kBlock, prefill).numbers, prefill), 1e-12);
  }
}

bool same_on_threads(const std::function<std::vector<double>()>& f) {
  // Threads are wanted that take turns, where the machine has fewer.
  const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism, kThreads);
  const auto in_arena = [&f](int threads) {
    std::vector<double> result;
    tbb::task_arena arena(threads);
    arena.execute([&] { result = f(); });
    return result;
  };
  return same_bits(in_arena(1), in_arena(kThreads));
}

}  // namespace deform
