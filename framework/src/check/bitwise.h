/// Evaluations that must have the same bits however they are cut into blocks and spread over
/// threads, and that must write where they are told and nowhere else.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "deform/types.h"

#include "check/checks.h"

namespace deform {

/// Room for the numbers of one block, between margins that nobody may write to.
class GuardedRoom {
 public:
  GuardedRoom(Index size, double prefill);
  [[nodiscard]] Values values() { return {numbers_.data() + kMargin, size_}; }
  [[nodiscard]] double* data() { return numbers_.data() + kMargin; }
  [[nodiscard]] bool margins_intact() const;

 private:
  static constexpr std::size_t kMargin = 16;
  std::size_t size_;
  std::vector<double> numbers_;
};

/// All numbers of one evaluation, block after block.
struct Evaluated {
  std::vector<double> numbers;
  bool margins_intact = true;
};

/// Evaluates everything in blocks of at most `block`, adding to rooms that hold `prefill`; must be
/// callable from several threads at once.
using Evaluate = std::function<Evaluated(Index block, double prefill)>;

/// The check that a plugin fails which may have damaged the memory of the process: what comes after
/// it says nothing, and may crash.
inline constexpr const char* kWritesWithin = "writes nothing beyond a block";

/// Says what the number i of an evaluation is: "p of pair 12 at sample 3".
using NameOfNumber = std::function<std::string(std::size_t i)>;

/// Checks that results do not depend on blocks, threads or earlier calls, that nothing is written
/// beyond a block, that everything is finite and, where `adds`, that it is added to what was there.
void check_evaluation(Checks& checks, const Evaluate& evaluate, bool adds,
                      const NameOfNumber& name);

[[nodiscard]] bool same_bits(std::span<const double> a, std::span<const double> b);
[[nodiscard]] bool all_finite(std::span<const double> numbers);
/// "force, y at node 7 is nan" of the first that is not finite; empty where all are.
[[nodiscard]] std::string what_is_not_finite(std::span<const double> numbers,
                                             const NameOfNumber& name);

/// Calls f on one thread, then on as many as there are, and tells whether the results have the same
/// bits. For what the framework itself spreads over threads.
[[nodiscard]] bool same_on_threads(const std::function<std::vector<double>()>& f);

}  // namespace deform
