#include "deform/log.h"

#include <memory>
#include <mutex>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "deform/printable.h"

namespace deform::log {
namespace {

constexpr const char* kName = "deform";

/// spdlog's default logger, which a program may have replaced by its own. The one that spdlog
/// starts with writes to stdout, where results go: it gives way to one of ours on stderr.
spdlog::logger& logger() {
  static std::once_flag once;
  std::call_once(once, [] {
    const auto current = spdlog::default_logger();
    if (current != nullptr && !current->name().empty()) return;
    auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
    auto ours = std::make_shared<spdlog::logger>(kName, std::move(sink));
    if (current != nullptr) ours->set_level(current->level());
    spdlog::set_default_logger(std::move(ours));
  });
  return *spdlog::default_logger_raw();
}

// One line a message, whatever is in it. As a string view it is written as it is: braces in it are
// no format.
void write(spdlog::level::level_enum level, const std::string& message) {
  if (logger().should_log(level)) logger().log(level, spdlog::string_view_t(printable(message)));
}

}  // namespace

void debug(const std::string& message) { write(spdlog::level::debug, message); }
void info(const std::string& message) { write(spdlog::level::info, message); }
void warn(const std::string& message) { write(spdlog::level::warn, message); }

}  // namespace deform::log
