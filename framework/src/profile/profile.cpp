#include "profile/profile.h"

#include <algorithm>

#include <fmt/format.h>

#include "json/json.h"

namespace deform {
namespace {

constexpr std::size_t kDepth = 64;  // of nesting, before the stack grows
constexpr std::size_t kNameWidth = 44;

double milliseconds(std::chrono::nanoseconds time) {
  return 1e-6 * static_cast<double>(time.count());
}

/// To the nanosecond, so that spans nest in the file as they did in the run.
std::string microseconds(std::chrono::nanoseconds time) {
  return fmt::format("{}.{:03}", time.count() / 1000, time.count() % 1000);
}

}  // namespace

constinit thread_local Profile* Profile::active_ = nullptr;

Profile::Profile(std::size_t events) : parts_(1), most_events_(std::max<std::size_t>(events, 1)) {
  open_.reserve(kDepth);
  events_.reserve(most_events_);
}

std::size_t Profile::part_within(std::size_t parent, std::string_view name) {
  for (const std::size_t part : parts_[parent].parts)
    if (parts_[part].name == name) return part;
  parts_.emplace_back().name = name;
  parts_[parent].parts.push_back(parts_.size() - 1);
  return parts_.size() - 1;
}

void Profile::enter(std::string_view part) {
  const std::size_t number = part_within(open_.empty() ? 0 : open_.back().part, part);
  open_.push_back({number, Clock::now()});
}

void Profile::leave() {
  const Clock::time_point now = Clock::now();
  const Open span = open_.back();
  open_.pop_back();
  Part& part = parts_[span.part];
  ++part.calls;
  part.total += now - span.start;
  part.step += now - std::max(span.start, step_begun_);
  const Event event{span.part, span.start - begun_, now - span.start};
  if (events_.size() < most_events_)
    events_.push_back(event);
  else
    events_[event_count_ % most_events_] = event;
  ++event_count_;
}

void Profile::end_step() {
  const Clock::time_point now = Clock::now();
  for (const Open& span : open_) parts_[span.part].step += now - std::max(span.start, step_begun_);
  for (Part& part : parts_) {
    part.recent[steps_ % kRecent] = part.step;
    part.step = Nanoseconds{0};
  }
  ++steps_;
  step_begun_ = now;
}

Profile::Nanoseconds Profile::median(const Part& part) const {
  const std::size_t count = std::min(steps_, kRecent);
  if (count == 0) return Nanoseconds{0};
  std::array<Nanoseconds, kRecent> sorted = part.recent;
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
  return (sorted[(count - 1) / 2] + sorted[count / 2]) / 2;
}

void Profile::add_rows(const std::vector<std::size_t>& parts, std::size_t depth, Nanoseconds all,
                       std::string& text) const {
  std::vector<std::size_t> sorted = parts;
  std::ranges::stable_sort(
      sorted, [this](std::size_t a, std::size_t b) { return parts_[a].total > parts_[b].total; });
  for (const std::size_t number : sorted) {
    const Part& part = parts_[number];
    Nanoseconds self = part.total;
    for (const std::size_t within : part.parts) self -= parts_[within].total;
    text += fmt::format(
        "{:<{}} {:>9} {:>12.3f} {:>6.1f} % {:>12.3f} {:>12.4f} {:>12.4f}\n",
        std::string(2 * depth, ' ') + part.name, kNameWidth, part.calls, milliseconds(part.total),
        100 * milliseconds(part.total) / std::max(milliseconds(all), 1e-6), milliseconds(self),
        milliseconds(median(part)),
        milliseconds(part.total) / static_cast<double>(std::max<std::size_t>(steps_, 1)));
    add_rows(part.parts, depth + 1, all, text);
  }
}

std::string Profile::table() const {
  std::string text =
      fmt::format("{:<{}} {:>9} {:>12} {:>8} {:>12} {:>12} {:>12}\n", "part", kNameWidth, "calls",
                  "total ms", "share", "self ms", "median/step", "mean/step");
  Nanoseconds all{0};
  for (const std::size_t part : parts_.front().parts) all += parts_[part].total;
  add_rows(parts_.front().parts, 0, all, text);
  text += fmt::format("{} steps; medians are of the last {}\n", steps_, std::min(steps_, kRecent));
  if (event_count_ > events_.size())
    text += fmt::format("the trace holds the last {} spans; {} before them were dropped\n",
                        events_.size(), event_count_ - events_.size());
  return text;
}

std::string Profile::trace() const {
  std::vector<std::string> names;
  for (const Part& part : parts_)
    names.push_back(Json(part.name).dump(-1, ' ', false, Json::error_handler_t::replace));
  std::string text = fmt::format(
      "{{\"displayTimeUnit\":\"ms\",\"otherData\":{{\"dropped_spans\":{}}},\"traceEvents\":[\n"
      R"({{"name":"process_name","ph":"M","pid":1,"tid":1,"args":{{"name":"deform"}}}},)"
      "\n"
      R"({{"name":"thread_name","ph":"M","pid":1,"tid":1,"args":{{"name":"simulation"}}}})",
      event_count_ - events_.size());
  for (const Event& event : events_)
    text += fmt::format(",\n{{\"name\":{},\"ph\":\"X\",\"ts\":{},\"dur\":{},\"pid\":1,\"tid\":1}}",
                        names[event.part], microseconds(event.start), microseconds(event.duration));
  return text + "\n]}\n";
}

}  // namespace deform
