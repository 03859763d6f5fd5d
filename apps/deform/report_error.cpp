#include "report_error.h"

#include <cstdio>
#include <exception>

#include <fmt/format.h>

#include "deform/error.h"

namespace deform::app {

int report_current_error() {
  try {
    throw;
  } catch (const InputError& e) {
    for (const Problem& problem : e.problems()) {
      fmt::print(stderr, "deform: {}\n", problem.message);
    }
    return static_cast<int>(e.code());
  } catch (const Error& e) {
    fmt::print(stderr, "deform: {}\n", e.what());
    return static_cast<int>(e.code());
  } catch (const std::exception& e) {
    fmt::print(stderr, "deform: internal error: {}\n", e.what());
    return static_cast<int>(ExitCode::internal_error);
  }
}

}  // namespace deform::app
