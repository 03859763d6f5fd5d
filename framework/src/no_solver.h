#pragma once

#include <string>

#include "deform/error.h"

namespace deform {

/// None of the linear solvers that the scene allows takes a matrix: no failure of the plugin that
/// asked for the solution.
class NoSolver : public InputError {
 public:
  explicit NoSolver(const std::string& message) : InputError({{"/solver", message}}) {}
};

}  // namespace deform
