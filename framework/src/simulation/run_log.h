/// log.txt of a run.
#pragma once

#include <filesystem>
#include <memory>

namespace spdlog::sinks {
class sink;
}

namespace deform {

/// Copies what is logged to a file as long as it lives. Make and destroy it while no other thread
/// logs.
class RunLog {
 public:
  /// Starts the file, or adds to the one that is there. Throws Error when it cannot.
  RunLog(const std::filesystem::path& file, bool add);
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

 private:
  std::shared_ptr<spdlog::sinks::sink> sink_;
};

}  // namespace deform
