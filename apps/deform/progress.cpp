#include "progress.h"

#include <cmath>
#include <cstdio>
#include <memory>
#include <unistd.h>

#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "terminal.h"

namespace deform::app {
namespace {

constexpr int kWidth = 24;  // of the bar itself: the line fits 80 columns

/// spdlog's way to stderr, past the bar.
class AboveBar final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit AboveBar(ProgressBar& bar) : bar_(bar) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t text;
    formatter_->format(message, text);
    bar_.write_above(fmt::to_string(text));
  }
  void flush_() override { std::fflush(stderr); }

 private:
  ProgressBar& bar_;
};

}  // namespace

std::string format_duration(double seconds) {
  const auto s = static_cast<long>(std::lround(seconds));
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{}:{:02} min", s / 60, s % 60);
  return fmt::format("{}:{:02}:{:02} h", s / 3600, s / 60 % 60, s % 60);
}

void ProgressBar::begin() {
  visible_ = ::isatty(STDERR_FILENO) == 1;
  start_ = next_ = Clock::now();
}

void ProgressBar::end() {
  const std::lock_guard lock(mutex_);
  erase();
  visible_ = false;
}

void ProgressBar::update(long done, long total) {
  if (!visible_ || total <= 0) return;
  const std::lock_guard lock(mutex_);
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(100);

  const double fraction = static_cast<double>(done) / static_cast<double>(total);
  const double rate =
      static_cast<double>(done) / std::chrono::duration<double>(now - start_).count();
  const int filled = static_cast<int>(fraction * kWidth);
  erase();
  drawn_ = fmt::format("{:3.0f} % [{:#<{}}{:.<{}}] {}/{}  {:.1f} steps/s  {} left",
                       std::floor(100 * fraction), "", filled, "", kWidth - filled, done, total,
                       rate, format_duration(static_cast<double>(total - done) / rate));
  draw();
}

void ProgressLines::operator()(long done, long /*total*/) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  say("progress {}\n", done);
  std::fflush(stdout);
}

void ProgressBar::write_above(const std::string& line) {
  const std::lock_guard lock(mutex_);
  const std::string bar = drawn_;
  erase();
  put_message(line);
  drawn_ = bar;
  draw();
}

void ProgressBar::erase() {
  if (!drawn_.empty()) put_message("\r\x1b[K");
  drawn_.clear();
}

void ProgressBar::draw() {
  if (!drawn_.empty()) put_message(drawn_);
}

void log_above(ProgressBar& bar) {
  auto sink = std::make_shared<AboveBar>(bar);
  sink->set_level(spdlog::level::warn);
  sink->set_pattern("deform: %l: %v");
  auto logger = std::make_shared<spdlog::logger>("deform", std::move(sink));
  logger->set_level(spdlog::level::debug);
  logger->flush_on(spdlog::level::info);  // log.txt must tell how far a crash let it come
  spdlog::set_default_logger(std::move(logger));
}

}  // namespace deform::app
