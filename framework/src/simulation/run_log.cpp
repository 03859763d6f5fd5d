#include "simulation/run_log.h"

#include <algorithm>

#include <fmt/format.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>

#include "deform/error.h"
#include "deform/log.h"

namespace deform {

RunLog::RunLog(const std::filesystem::path& file, bool add) {
  try {
    sink_ = std::make_shared<spdlog::sinks::basic_file_sink_mt>(file.string(), !add);
  } catch (const spdlog::spdlog_ex& e) {
    throw Error(ExitCode::internal_error, e.what());  // it names the file and the cause
  }
  sink_->set_pattern("%Y-%m-%d %H:%M:%S.%e %l: %v");
  log::debug("log.txt begins");  // has the default logger settled before the sink joins it
  spdlog::default_logger()->sinks().push_back(sink_);
}

RunLog::~RunLog() {
  sink_->flush();
  auto& sinks = spdlog::default_logger()->sinks();
  sinks.erase(std::remove(sinks.begin(), sinks.end(), sink_), sinks.end());
}

}  // namespace deform
