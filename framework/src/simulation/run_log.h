/// log.txt of a run.
#pragma once

#include <filesystem>
#include <memory>

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

  /// Ends the file. Throws Error naming it and the cause when not all was written.
  void close();

 private:
  class Sink;
  void leave();

  std::shared_ptr<Sink> sink_;
};

}  // namespace deform
