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

  StepTimes times;
  StepReport report;
  long step = 0;                            ///< number of steps that have begun
  const std::atomic<bool>* stop = nullptr;  ///< System::stop_when
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
