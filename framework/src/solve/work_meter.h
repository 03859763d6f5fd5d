/// What all parts of a System share while they work: whether to go on, and what it took.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <string>

#include "deform/error.h"
#include "deform/solve/step_report.h"

namespace deform {

struct WorkMeter {
  /// Which matrix a linear solver was chosen for; the first that has one is what a run names.
  enum class Matrix : std::size_t { lagged, newton, mass, jacobian, count };

  StepReport report;
  long step = 0;  ///< number of steps that have begun
  /// As soon as it is true, whatever evaluates, factorises or solves throws Error with
  /// ExitCode::interrupted: an integrator's step ends there, whatever the integrator. What a step
  /// has made until then is to be thrown away. Null: nothing stops them.
  const std::atomic<bool>* stop = nullptr;
  std::array<std::string, static_cast<std::size_t>(Matrix::count)> choices;

  /// Throws Error where the step is to be given up.
  void require_going_on() const {
    if (stop != nullptr && stop->load(std::memory_order_relaxed))
      throw Error(ExitCode::interrupted, "interrupted");
  }
  void choose(Matrix matrix, const std::string& solver) {
    std::string& choice = choices[static_cast<std::size_t>(matrix)];
    if (choice != solver) choice = solver;
  }
};

}  // namespace deform
