#include "plugin/process_end.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <string_view>
#include <ucontext.h>
#include <unistd.h>
#include <utility>

#include <sys/syscall.h>
#include <sys/types.h>
#include <tbb/task_scheduler_observer.h>

#include "deform/error.h"
#include "deform/plugin/process_end.h"

#include "plugin/plugin_call.h"

namespace deform {
namespace {

std::atomic<const LastNote*> note = nullptr;
std::atomic<bool> is_expected = false;
/// Whose end is watched: a plugin's own children end as they like.
std::atomic<pid_t> watched = 0;
/// Of the thread that began to watch, which waits for the others: what they do, they do for it.
const PluginCall* const* main_call = nullptr;

/// A text of limited length, of whatever a handler may use.
class Text {
 public:
  void add(std::string_view text) noexcept {
    for (const char c : text) {
      if (size_ + 1 == characters_.size()) return;
      // Names of files may hold what terminals take for orders, or what is no text in JSON.
      characters_[size_++] = c < ' ' || c > '~' ? '?' : c;
    }
  }
  [[nodiscard]] const char* c_str() const noexcept { return characters_.data(); }
  [[nodiscard]] std::string_view view() const noexcept { return {characters_.data(), size_}; }

 private:
  std::array<char, 8192> characters_{};
  std::size_t size_ = 0;
};

bool write_all(int file, std::string_view text) noexcept {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

[[noreturn]] void leave(int code) noexcept {
  for (;;) ::syscall(SYS_exit_group, code);
}

/// Says who ended the process, and ends it. Async-signal-safe.
[[noreturn]] void end_process(const char* cause) noexcept {
  const PluginCall* call = PluginCall::innermost();
  if (call == nullptr && main_call != nullptr) call = *main_call;
  static Text text;  // handlers have small stacks
  if (call != nullptr) {
    text.add("plugin ");
    text.add(call->origin());
    text.add(" failed while ");
    text.add(call->doing());
    text.add(": ");
    text.add(cause);
  } else {
    text.add("internal error: ");
    text.add(cause);
  }
  (void)(write_all(STDERR_FILENO, "deform: ") && write_all(STDERR_FILENO, text.view()) &&
         write_all(STDERR_FILENO, "\n"));
  const LastNote* const left = note.exchange(nullptr);
  if (call != nullptr && left != nullptr && ::getpid() == watched) left->write(text.c_str());
  leave(static_cast<int>(call != nullptr ? ExitCode::plugin_failed : ExitCode::internal_error));
}

/// One thread tells the end; others that come meanwhile wait for it.
void wait_if_it_ends_already() noexcept {
  static std::atomic_flag ends = ATOMIC_FLAG_INIT;
  if (ends.test_and_set())
    for (;;) ::pause();
}

/// Whether an address that could not be used is where the stack had to grow.
bool is_near_stack(const siginfo_t& info, const void* context) noexcept {
#if defined(__x86_64__)
  const auto stack = static_cast<std::uintptr_t>(
      static_cast<const ucontext_t*>(context)->uc_mcontext.gregs[REG_RSP]);
#elif defined(__aarch64__)
  const auto stack =
      static_cast<std::uintptr_t>(static_cast<const ucontext_t*>(context)->uc_mcontext.sp);
#else
  const std::uintptr_t stack = 0;
  (void)context;
#endif
  constexpr std::uintptr_t kNear = std::uintptr_t{1} << 16U;
  const auto address = reinterpret_cast<std::uintptr_t>(info.si_addr);
  return address + kNear > stack && address < stack + kNear;
}

void on_crash(int signal, siginfo_t* info, void* context) {
  if (::getpid() != watched) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);  // comes when this returns
    return;
  }
  wait_if_it_ends_already();
  switch (signal) {
    case SIGSEGV:
      end_process(is_near_stack(*info, context) ? "it crashed (stack overflow)"
                                                : "it crashed (segmentation fault)");
    case SIGABRT:
      end_process("it called abort()");
    case SIGFPE:
      end_process("it crashed (arithmetic exception)");
    case SIGILL:
      end_process("it crashed (illegal instruction)");
    default:
      end_process("it crashed (bus error)");
  }
}

void on_exit() {
  if (is_expected || ::getpid() != watched) return;
  wait_if_it_ends_already();
  end_process("it called exit()");
}

/// Workers come and go.
class PreparesWorkers final : public tbb::task_scheduler_observer {
 public:
  PreparesWorkers() { observe(true); }
  void on_scheduler_entry(bool /*is_worker*/) override { prepare_thread_for_crashes(); }
};

/// A thread's other stack, as long as the thread lives.
class OtherStack {
 public:
  OtherStack() : memory_(std::make_unique<char[]>(kSize)) {
    stack_t stack{};
    stack.ss_sp = memory_.get();
    stack.ss_size = kSize;
    ::sigaltstack(&stack, nullptr);
  }
  ~OtherStack() {
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    ::sigaltstack(&none, nullptr);
  }
  OtherStack(const OtherStack&) = delete;
  OtherStack& operator=(const OtherStack&) = delete;

 private:
  static constexpr std::size_t kSize = std::size_t{1} << 16U;
  std::unique_ptr<char[]> memory_;
};

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kHandlesSignals = false;
#else
constexpr bool kHandlesSignals = true;
#endif

bool watches = false;

}  // namespace

constinit thread_local const PluginCall* PluginCall::innermost_ = nullptr;

void prepare_thread_for_crashes() {
  if (!watches || !kHandlesSignals) return;
  static thread_local const OtherStack stack;
}

void watch_this_process() {
  if (!watches) return;
  main_call = PluginCall::place();
  watched = ::getpid();
}

void watch_process_end() {
  if (std::exchange(watches, true)) return;
  watch_this_process();
  std::atexit(on_exit);
  std::at_quick_exit(on_exit);
  if (!kHandlesSignals) return;
  prepare_thread_for_crashes();
  static PreparesWorkers workers;
  struct sigaction action {};
  action.sa_sigaction = on_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT})
    ::sigaction(signal, &action, nullptr);
}

void expect_process_end() noexcept { is_expected = true; }

/// The framework's library comes before the C library where plugins' names are looked up, so that
/// their calls of _exit come here; those of the C library itself do not.
void exit_at_once(int code) noexcept {
  const bool is_a_plugins = PluginCall::innermost() != nullptr && ::getpid() == watched;
  if (is_a_plugins && !is_expected) {
    wait_if_it_ends_already();
    end_process("it called _exit()");
  }
  leave(code);
}

LastNote::LastNote(const std::filesystem::path& file, std::string before, std::string after)
    : file_(file.string()),
      temporary_(file_ + ".part"),
      before_(std::move(before)),
      after_(std::move(after)) {
  note = this;
}

LastNote::~LastNote() {
  const LastNote* expected = this;
  note.compare_exchange_strong(expected, nullptr);
}

void LastNote::write(const char* reason) const noexcept {
  const int out =
      ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (out < 0) return;
  bool is_written = write_all(out, before_) && write_all(out, "\"");
  for (std::string_view rest(reason); !rest.empty() && is_written; rest.remove_prefix(1)) {
    const bool needs_escape = rest.front() == '"' || rest.front() == '\\';
    is_written = (!needs_escape || write_all(out, "\\")) && write_all(out, rest.substr(0, 1));
  }
  is_written = is_written && write_all(out, "\"") && write_all(out, after_);
  is_written = ::close(out) == 0 && is_written;
  if (!is_written || ::rename(temporary_.c_str(), file_.c_str()) != 0) ::unlink(temporary_.c_str());
}

}  // namespace deform

// NOLINTBEGIN(bugprone-reserved-identifier, cert-dcl37-c, cert-dcl51-cpp)
extern "C" {
// The library's declarations say that they do not return.
__attribute__((visibility("default"))) void _exit(int code) { deform::exit_at_once(code); }
__attribute__((visibility("default"))) void _Exit(int code) noexcept { deform::exit_at_once(code); }
}
// NOLINTEND(bugprone-reserved-identifier, cert-dcl37-c, cert-dcl51-cpp)
