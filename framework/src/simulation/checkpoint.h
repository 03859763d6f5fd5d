/// Checkpoints: all that a run needs to go on to the same bits.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "deform/plugin/plugin.h"
#include "deform/simulation/scene.h"

#include "files/files.h"

namespace deform {

/// A run between a step and its recording: what was recorded of earlier steps is part of it, the
/// figures and frames of this step are not. So nothing depends on whether it is recorded because it
/// was the last one when the checkpoint was written, or because it is due.
struct Checkpoint {
  std::string scene;               ///< identity_of() the run's scene and its files
  long step = 0;                   ///< steps done
  std::vector<WrittenFile> files;  ///< of the run directory, as earlier steps left them
  Memory memory;                   ///< of the simulation, the probes and the outputs

  /// The file of that name; null where there is none.
  [[nodiscard]] const WrittenFile* file(const std::string& name) const;
};

/// The content of a checkpoint file. Little-endian: a line of text, format version (4 bytes),
/// identity (64), step (8), number of files (8); of each file the lengths of its name (8) and of
/// its hash (8: 64 or 0), its bytes (8), name, hash; number of entries (8); of each entry the
/// lengths of its name (8) and of its list (8), the name, the list of doubles; the SHA-256 of all
/// that, in hexadecimal digits (64).
[[nodiscard]] std::string encoded(const Checkpoint& checkpoint);
/// `file` is for messages. Throws InputError, naming it and the reason, for anything that
/// encoded() of this version does not write; allocates no more than `content` takes.
[[nodiscard]] Checkpoint decode_checkpoint(std::string_view content, const std::string& file);
/// Appends the checksum.
[[nodiscard]] std::string sealed(std::string content);

/// The file in a run directory.
[[nodiscard]] std::filesystem::path checkpoint_file(const std::filesystem::path& folder);
/// Replaces a run's checkpoint, all at once. Throws Error naming the file and the cause; the one
/// before is then still there.
void write_checkpoint(const std::filesystem::path& folder, const Checkpoint& checkpoint);
/// Nothing where there is none. Throws InputError for one that cannot be used, Error for one that
/// cannot be read.
[[nodiscard]] std::optional<Checkpoint> read_checkpoint(const std::filesystem::path& folder);

/// When a scene wants its checkpoints.
class CheckpointSchedule {
 public:
  explicit CheckpointSchedule(const Scene& scene);
  /// Whether one is due after so many steps.
  [[nodiscard]] bool due(long step) const;
  /// To be called when one was written.
  void restart() { last_ = Clock::now(); }

 private:
  using Clock = std::chrono::steady_clock;
  long every_;
  double seconds_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace deform
