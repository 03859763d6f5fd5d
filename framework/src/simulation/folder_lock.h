/// Who works in a folder has it alone.
#pragma once

#include <filesystem>
#include <string>

namespace deform {

/// The file of a folder that is held; its text says by whom.
inline constexpr const char* kLockFile = ".deform-lock";

/// Holds a folder for as long as it lives: no other process that asks gets it. The operating system
/// keeps the lock (flock), so that of a process which was killed nothing is left but the file's
/// text. Where the folder cannot be written to, or its file system knows no locks, nothing is held.
class FolderLock {
 public:
  /// The folder is there. Throws InputError, which names the process, its host and since when, when
  /// another one holds it; Error when the file cannot be made.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

/// Throws InputError as the lock would where somebody holds the folder now; changes nothing, and
/// knows nothing of a folder that is not there.
void require_unheld(const std::filesystem::path& folder);

/// The same of all folders below this one: what is moved or removed with it must be nobody's work.
/// Throws Error when one cannot look into them; those of others, which cannot be read, do not
/// count.
void require_unheld_within(const std::filesystem::path& folder);

}  // namespace deform
