#include "simulation/run_log.h"

#include <algorithm>
#include <mutex>
#include <string>
#include <system_error>

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include "deform/error.h"
#include "deform/log.h"

#include "files/files.h"

namespace deform {
namespace {

/// What is there of a file that is added to; a link is not, and is replaced.
std::size_t size_of(const std::filesystem::path& file) {
  std::error_code error;
  const bool is_file = is_regular_file(std::filesystem::symlink_status(file, error));
  const std::uintmax_t size = is_file ? std::filesystem::file_size(file, error) : 0;
  return error ? 0 : static_cast<std::size_t>(size);
}

}  // namespace

/// Writes line by line; the first that cannot be written is the last.
class RunLog::Sink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  Sink(const std::filesystem::path& file, std::size_t keep) : file_(file, keep) {}

  /// Ends the file; throws the first error there was.
  void close() {
    if (!failure_.empty()) throw Error(ExitCode::internal_error, failure_);
    file_.close();
  }

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (!failure_.empty()) return;
    spdlog::memory_buf_t text;
    formatter_->format(message, text);
    try {
      file_.append({text.data(), text.size()});
    } catch (const Error& e) {  // a logger must not throw: see close()
      failure_ = e.what();
    }
  }
  void flush_() override {}

  AppendFile file_;
  std::string failure_;
};

RunLog::RunLog(const std::filesystem::path& file, bool add)
    : sink_(std::make_shared<Sink>(file, add ? size_of(file) : 0)) {
  sink_->set_pattern("%Y-%m-%d %H:%M:%S.%e %l: %v");
  log::debug("log.txt begins");  // has the default logger settled before the sink joins it
  spdlog::default_logger()->sinks().push_back(sink_);
}

RunLog::~RunLog() { leave(); }

void RunLog::leave() {
  auto& sinks = spdlog::default_logger()->sinks();
  sinks.erase(std::remove(sinks.begin(), sinks.end(), sink_), sinks.end());
}

void RunLog::close() {
  leave();
  sink_->close();
}

}  // namespace deform
