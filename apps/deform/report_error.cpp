#include "report_error.h"

#include <cerrno>
#include <cstdio>
#include <exception>
#include <system_error>

#include <fmt/format.h>

#include "deform/error.h"

#include "terminal.h"

namespace deform::app {

int report_current_error() {
  try {
    throw;
  } catch (const InputError& e) {
    for (const Problem& problem : e.problems()) {
      complain("{}", problem.message);
    }
    return static_cast<int>(e.code());
  } catch (const Error& e) {
    complain("{}", e.what());
    return static_cast<int>(e.code());
  } catch (const std::system_error& e) {  // nothing is wrong with the program: a full disk, say
    complain("{}", e.what());
    return static_cast<int>(ExitCode::internal_error);
  } catch (const std::exception& e) {
    complain("internal error: {}", e.what());
    return static_cast<int>(ExitCode::internal_error);
  }
}

int finish_output(int code) {
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0) return code;
  // An earlier write may have failed, of which the reason is no longer known.
  complain("cannot write to standard output{}",
           flushed ? "" : ": " + std::generic_category().message(errno));
  return code == static_cast<int>(ExitCode::done) ? static_cast<int>(ExitCode::internal_error)
                                                  : code;
}

}  // namespace deform::app
