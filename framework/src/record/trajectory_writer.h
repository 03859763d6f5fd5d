#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "deform/record/frame.h"

#include "files/files.h"
#include "record/node_fields.h"

namespace deform {

/// Writes trajectory.bin: positions and fields of every recorded state.
class TrajectoryWriter {
 public:
  /// Starts the file, or goes on after the first `keep` bytes of the one that is there. `size`: of
  /// the surface [m]. Throws Error when the file cannot be written.
  TrajectoryWriter(const std::filesystem::path& file, const System& system, double size,
                   std::size_t keep);

  /// Appends a frame, unless this step was the last to be recorded. It is in the file when the call
  /// returns.
  void record(const Frame& frame);
  /// Has all frames put on disk; returns what the file holds. Throws Error when it cannot.
  [[nodiscard]] WrittenFile sync();
  /// Ends the file; returns what it holds. Throws Error when it cannot.
  WrittenFile close();

 private:
  [[nodiscard]] std::string header(const System& system, double size) const;

  NodeFields fields_;
  AppendFile file_;
  std::string frame_;
  long last_ = -1;  // step
};

}  // namespace deform
