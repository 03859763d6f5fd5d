/// Where the time of a run goes: nested spans, summed up by part and kept one by one for a trace.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <deque>
#include <string>
#include <string_view>
#include <vector>

namespace deform {

/// Records the spans of one thread: those of the thread on which it is active (see
/// Profile::Active). Allocates nothing for a part that it has seen within the same parts before.
class Profile {
 public:
  static constexpr std::size_t kEvents = std::size_t{1} << 18;
  /// `events`: spans that are kept for the trace; of more, the oldest go.
  explicit Profile(std::size_t events = kEvents);

  /// Makes a profile the one that spans of this thread are recorded by while it lives; null: none.
  class Active {
   public:
    explicit Active(Profile* profile) : before_(active_) { active_ = profile; }
    ~Active() { active_ = before_; }
    Active(const Active&) = delete;
    Active& operator=(const Active&) = delete;

   private:
    Profile* before_;
  };
  [[nodiscard]] static Profile* active() { return active_; }

  /// Begins a part of the innermost one that has not ended; ends the innermost one.
  void enter(std::string_view part);
  void leave();
  /// Ends a step of the run, which medians and means are of.
  void end_step();

  /// The parts as a tree, the longest first: calls, total [ms], share of all, time in none of its
  /// parts [ms], median and mean a step [ms].
  [[nodiscard]] std::string table() const;
  /// Chrome's trace event format, JSON object form: complete events with times in µs.
  [[nodiscard]] std::string trace() const;

 private:
  using Clock = std::chrono::steady_clock;
  using Nanoseconds = std::chrono::nanoseconds;
  /// Medians are of so many last steps.
  static constexpr std::size_t kRecent = 1024;

  struct Part {
    std::string name;
    std::vector<std::size_t> parts;  // numbers of those within it
    long calls = 0;
    Nanoseconds total{0};
    Nanoseconds step{0};                           // of the step that has not ended
    std::array<Nanoseconds, kRecent> recent = {};  // step by step, a ring
  };
  struct Open {
    std::size_t part;
    Clock::time_point start;
  };
  struct Event {
    std::size_t part;
    Nanoseconds start, duration;  // since the profile was made
  };

  [[nodiscard]] std::size_t part_within(std::size_t parent, std::string_view name);
  [[nodiscard]] Nanoseconds median(const Part& part) const;
  void add_rows(const std::vector<std::size_t>& parts, std::size_t depth, Nanoseconds all,
                std::string& text) const;

  static constinit thread_local Profile* active_;

  Clock::time_point begun_ = Clock::now(), step_begun_ = begun_;
  std::deque<Part> parts_;  // the first contains all others
  std::vector<Open> open_;
  std::vector<Event> events_;  // a ring once it is full
  std::size_t most_events_, event_count_ = 0;
  std::size_t steps_ = 0;
};

/// A scope that the active profile, if there is one, records as a part.
class Span {
 public:
  explicit Span(std::string_view part) : profile_(Profile::active()) {
    if (profile_ != nullptr) profile_->enter(part);
  }
  ~Span() {
    if (profile_ != nullptr) profile_->leave();
  }
  Span(const Span&) = delete;
  Span& operator=(const Span&) = delete;

 private:
  Profile* profile_;
};

}  // namespace deform
