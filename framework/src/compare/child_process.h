#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace deform {

/// How a process ended.
struct ChildExit {
  int code = 0;      ///< what it returned
  int signal = 0;    ///< what killed it, or 0
  std::string said;  ///< its last lines on stdout and stderr that were not taken
};

/// Runs a program and waits for it. `take(line)` is given each line that it prints, and returns
/// whether that one was meant for it. When `interrupted` becomes true the process gets a SIGTERM;
/// should this one end, however it does, it gets a SIGKILL. Throws Error when it cannot be started.
[[nodiscard]] ChildExit run_child(const std::string& program,
                                  const std::vector<std::string>& arguments,
                                  const std::function<bool(const std::string& line)>& take,
                                  const std::atomic<bool>* interrupted);

}  // namespace deform
