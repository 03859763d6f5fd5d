/// The folder that a run or a comparison is recorded in, while it is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "simulation/folder_lock.h"

namespace deform {

/// What is to become of what a folder holds.
enum class FolderUse : std::uint8_t {
  made,      ///< it must not be there
  replaced,  ///< --force: the old run stays until drop_old
  resumed,   ///< --resume: as `replaced` where there is nothing to go on from
};

/// Holds the folder, and an old run that is being replaced.
class HeldFolder {
 public:
  /// Holds it if it is there, and undoes what a process that was killed has left half done. Throws
  /// InputError when another process holds it, or as check_run_directory does; whether it can be
  /// resumed in is for the caller to find out, who looks after that.
  HeldFolder(const std::filesystem::path& folder, FolderUse use);

  /// Makes the folder if it is not there, and holds it: another process may have made it meanwhile.
  void take();
  /// The same; then it holds nothing. What it held is set aside, or removed where that is worth
  /// nothing.
  void begin_anew(bool is_worth_keeping = true);
  /// The new run has taken its first step.
  void drop_old();
  /// It never will: puts the old run back. Returns whether there was one.
  bool give_old_back();
  [[nodiscard]] bool has_old() const { return has_old_; }

 private:
  std::filesystem::path folder_;
  FolderUse use_;
  std::optional<FolderLock> lock_;
  bool has_old_ = false;
};

}  // namespace deform
