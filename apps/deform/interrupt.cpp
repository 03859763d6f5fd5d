#include "interrupt.h"

#include <csignal>
#include <cstdint>
#include <ctime>
#include <unistd.h>

#include "deform/plugin/process_end.h"

namespace deform::app {
namespace {

/// One request may come as several signals: `timeout` sends one to the process and one to its
/// group.
constexpr std::int64_t kOneRequest = 300'000'000;  // ns

std::atomic<bool> interrupted = false, ends_at_once = false;
std::atomic<std::int64_t> first_signal = 0;  // when it came [ns]; 0: not yet
static_assert(std::atomic<bool>::is_always_lock_free &&
                  std::atomic<std::int64_t>::is_always_lock_free,
              "a signal handler must not lock");

std::int64_t now() {
  timespec time{};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

void on_signal(int /*number*/) {
  const std::int64_t time = now();
  std::int64_t first = 0;
  const bool is_first = first_signal.compare_exchange_strong(first, time);
  interrupted = true;
  if (!ends_at_once && (is_first || time - first < kOneRequest)) return;
  expect_process_end();  // whatever plugin is at work
  ::_exit(130);
}

/// What is ignored stays so: nohup, or a shell's background job.
bool is_ignored(int signal) {
  struct sigaction action {};
  return ::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

}  // namespace

void prepare_signals() {
  // A file that may not grow any more is one that cannot be written, and says so.
  std::signal(SIGXFSZ, SIG_IGN);
  // Who ignores it never learns how a child ended.
  std::signal(SIGCHLD, SIG_DFL);
}

const std::atomic<bool>& watch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})  // the last: the terminal was closed
    if (!is_ignored(signal)) ::sigaction(signal, &action, nullptr);
  // Whoever read what is said may be gone: no reason to end a run.
  std::signal(SIGPIPE, SIG_IGN);
  return interrupted;
}

bool end_when_interrupted() {
  ends_at_once = true;
  return !interrupted;
}

}  // namespace deform::app
