/// What is left behind when a process ends within a plugin; see deform/plugin/process_end.h.
#pragma once

#include <filesystem>
#include <string>

namespace deform {

/// While it lives, and watch_process_end() was called: what a file is replaced by when the process
/// ends within a plugin. All is made in advance, as a signal handler can allocate nothing. One at a
/// time.
class LastNote {
 public:
  /// `before` and `after` stand around the reason, which is put between JSON's quotes.
  LastNote(const std::filesystem::path& file, std::string before, std::string after);
  ~LastNote();
  LastNote(const LastNote&) = delete;
  LastNote& operator=(const LastNote&) = delete;

  /// Writes it; async-signal-safe. `reason` is made safe for JSON.
  void write(const char* reason) const noexcept;

 private:
  std::string file_, temporary_, before_, after_;
};

/// For a child that was forked to call plugins: from now on its end is watched as its parent's was.
void watch_this_process();
/// What _exit does.
[[noreturn]] void exit_at_once(int code) noexcept;

/// Gives this thread the stack that a handler needs where the thread's own has no room left.
void prepare_thread_for_crashes();

}  // namespace deform
