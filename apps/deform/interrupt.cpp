#include "interrupt.h"

#include <csignal>
#include <unistd.h>

#include "deform/plugin/process_end.h"

namespace deform::app {
namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler must not lock");

void on_signal(int /*number*/) {
  if (!interrupted.exchange(true)) return;
  expect_process_end();  // whatever plugin is at work
  ::_exit(130);
}

}  // namespace

const std::atomic<bool>& watch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGHUP, &action, nullptr);  // the terminal was closed
  // A file that may not grow any more is one that cannot be written, and says so.
  std::signal(SIGXFSZ, SIG_IGN);
  // Whoever read what is said may be gone: no reason to end a run.
  std::signal(SIGPIPE, SIG_IGN);
  return interrupted;
}

}  // namespace deform::app
