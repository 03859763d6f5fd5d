#include "compare/child_process.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <fcntl.h>
#include <mutex>
#include <thread>
#include <unistd.h>

#include <boost/process/args.hpp>
#include <boost/process/child.hpp>
#include <boost/process/exe.hpp>
#include <boost/process/extend.hpp>
#include <boost/process/io.hpp>
#include <boost/process/pipe.hpp>
#include <boost/process/posix.hpp>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>

#include "deform/error.h"

namespace deform {
namespace {

namespace bp = boost::process;

/// Of what a process says without being asked: enough for an error and what led to it.
constexpr std::size_t kMostSaid = 4000;

/// A killed parent takes its children along: two processes must never write one run directory. A
/// Ctrl-C is for the parent alone, which passes it on.
struct DiesWithParent : bp::extend::handler {
  template <class Executor>
  void on_exec_setup(Executor& /*executor*/) const {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  }
};

/// Passes an interruption on to a process while it runs.
class Watch {
 public:
  Watch(const std::atomic<bool>* interrupted, pid_t process) {
    if (interrupted != nullptr) {
      thread_ = std::thread([this, interrupted, process] { wait(*interrupted, process); });
    }
  }
  ~Watch() {
    {
      const std::lock_guard lock(mutex_);
      ended_ = true;
    }
    end_.notify_one();
    if (thread_.joinable()) thread_.join();
  }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

 private:
  void wait(const std::atomic<bool>& interrupted, pid_t process) {
    std::unique_lock lock(mutex_);
    while (!end_.wait_for(lock, std::chrono::milliseconds(50), [this] { return ended_; })) {
      if (!interrupted.load()) continue;
      ::kill(process, SIGTERM);  // once: a second one would end it without a checkpoint
      return;
    }
  }

  std::mutex mutex_;
  std::condition_variable end_;
  bool ended_ = false;
  std::thread thread_;
};

/// No process may inherit the pipe of another one, whose end would not show then.
bp::child start(const std::string& program, const std::vector<std::string>& arguments,
                bp::ipstream& output, std::error_code& error) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  for (const int end : {output.pipe().native_source(), output.pipe().native_sink()})
    ::fcntl(end, F_SETFD, FD_CLOEXEC);
  return bp::child(bp::exe = program, bp::args = arguments,
                   bp::std_in<bp::null, (bp::std_out & bp::std_err)> output, DiesWithParent(),
                   error);
}

}  // namespace

ChildExit run_child(const std::string& program, const std::vector<std::string>& arguments,
                    const std::function<bool(const std::string& line)>& take,
                    const std::atomic<bool>* interrupted) {
  ChildExit result;
  std::error_code error;
  bp::ipstream output;
  bp::child child = start(program, arguments, output, error);
  if (error)
    throw Error(ExitCode::internal_error,
                fmt::format("cannot start {}: {}", program, error.message()));
  {
    const Watch watch(interrupted, child.id());
    for (std::string line; std::getline(output, line);) {
      if (take(line)) continue;
      result.said += line + '\n';
      if (result.said.size() > kMostSaid) result.said.erase(0, result.said.find('\n') + 1);
    }
    child.wait(error);
  }
  const int status = child.native_exit_code();
  if (WIFSIGNALED(status)) {
    result.signal = WTERMSIG(status);
  } else {
    result.code = WEXITSTATUS(status);
  }
  return result;
}

}  // namespace deform
