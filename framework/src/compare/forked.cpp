#include "compare/forked.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>

#include "deform/error.h"

#include "json/json.h"
#include "plugin/process_end.h"

namespace deform {
namespace {

bool has_one_thread() {
  std::error_code error;
  const std::filesystem::directory_iterator threads("/proc/self/task", error);
  return !error && std::distance(begin(threads), end(threads)) == 1;
}

/// A file in memory that a child writes and its parent reads; −1 where there is none to be had.
class Scratch {
 public:
  Scratch() : file_(::memfd_create("deform", MFD_CLOEXEC)) {}
  ~Scratch() {
    if (file_ >= 0) ::close(file_);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  [[nodiscard]] int file() const { return file_; }
  [[nodiscard]] bool write(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t written = ::write(file_, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
  }
  [[nodiscard]] std::string read() const {
    std::string text;
    std::array<char, 4096> block{};
    for (ssize_t got = 0;
         (got = ::pread(file_, block.data(), block.size(), static_cast<off_t>(text.size()))) > 0;)
      text.append(block.data(), static_cast<std::size_t>(got));
    return text;
  }

 private:
  int file_;
};

/// What `make` returned or threw.
std::string outcome_of(const std::function<std::string()>& make) {
  Json outcome;
  try {
    outcome["text"] = make();
  } catch (const InputError& e) {
    outcome["problems"] = Json::array();
    for (const Problem& problem : e.problems())
      outcome["problems"].push_back({problem.pointer, problem.message});
  } catch (const Error& e) {
    outcome["code"] = static_cast<int>(e.code());
    outcome["message"] = e.what();
  } catch (const std::exception& e) {
    outcome["code"] = static_cast<int>(ExitCode::internal_error);
    outcome["message"] = e.what();
  }
  return outcome.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// The same here.
std::string take(const Json& outcome) {
  if (outcome.contains("text")) return outcome["text"].get<std::string>();
  if (outcome.contains("problems")) {
    std::vector<Problem> problems;
    for (const Json& problem : outcome["problems"])
      problems.push_back({problem[0].get<std::string>(), problem[1].get<std::string>()});
    throw InputError(std::move(problems));
  }
  const auto code = static_cast<ExitCode>(outcome["code"].get<int>());
  const auto message = outcome["message"].get<std::string>();
  if (code == ExitCode::plugin_failed) throw PluginFailure(message);
  throw Error(code, message);
}

[[noreturn]] void be_child(pid_t parent, const std::function<std::string()>& make,
                           const Scratch& result, const Scratch& said) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) exit_at_once(1);  // it ended before it could be watched
  // Ctrl-C goes to the whole group: the parent ends this one.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_IGN);
  ::dup2(said.file(), STDERR_FILENO);
  watch_this_process();
  ::_exit(result.write(outcome_of(make)) ? 0 : 1);
}

/// Waits for a child's end; returns its status. Throws Error when interrupted.
int wait_for(pid_t child, const std::atomic<bool>* interrupted) {
  constexpr std::chrono::milliseconds kLongestPause{20};
  std::chrono::milliseconds pause{1};
  int status = 0;
  const auto is_interrupted = [=] { return interrupted != nullptr && interrupted->load(); };
  for (;;) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended < 0 && errno != EINTR) {
      throw Error(ExitCode::internal_error, "cannot wait for the process that makes plugins: " +
                                                std::generic_category().message(errno));
    }
    const bool stops = is_interrupted();
    if (stops && ended != child) {
      ::kill(child, SIGKILL);
      (void)::waitpid(child, &status, 0);
    }
    if (stops) throw Error(ExitCode::interrupted, "interrupted before the first run");
    if (ended == child) return status;
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, kLongestPause);
  }
}

std::string how_it_ended(int status, std::string said) {
  while (!said.empty() && said.back() == '\n') said.pop_back();
  constexpr std::string_view kProgram = "deform: ";
  if (const std::size_t last = said.rfind('\n'); last != std::string::npos) said.erase(0, last + 1);
  if (said.starts_with(kProgram)) return said.substr(kProgram.size());
  return "the process that made its plugins ended: " +
         (WIFSIGNALED(status) ? fmt::format("it was killed by signal {} ({})", WTERMSIG(status),
                                            ::strsignal(WTERMSIG(status)))
                              : fmt::format("with code {}", WEXITSTATUS(status)));
}

}  // namespace

std::string in_child(const std::function<std::string()>& make,
                     const std::atomic<bool>* interrupted) {
  const Scratch result, said;
  const bool can_fork = has_one_thread() && result.file() >= 0 && said.file() >= 0;
  const pid_t parent = ::getpid();
  const pid_t child = can_fork ? ::fork() : -1;
  if (child < 0) return make();
  if (child == 0) be_child(parent, make, result, said);
  const int status = wait_for(child, interrupted);
  // Complete or nothing: a plugin that leaves the process leaves no outcome.
  const Json outcome = Json::parse(result.read(), nullptr, false);
  if (WIFEXITED(status) && outcome.is_object()) return take(outcome);
  throw PluginFailure(how_it_ended(status, said.read()));
}

}  // namespace deform
