#include "simulation/folder_lock.h"

#include <array>
#include <cerrno>
#include <cstddef>
#include <fcntl.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>

#include "deform/error.h"
#include "deform/log.h"

#include "simulation/machine.h"
#include "simulation/manifest.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, int error) {
  throw Error(ExitCode::internal_error, fmt::format("cannot lock {}: {}", file.string(),
                                                    std::generic_category().message(error)));
}

/// What the holder wrote, as a message can show it whatever stands there.
std::string holder(int descriptor) {
  std::array<char, 200> text{};
  const ssize_t count = ::pread(descriptor, text.data(), text.size(), 0);
  std::string said;
  for (ssize_t i = 0; i < count && text[static_cast<std::size_t>(i)] != '\n'; ++i) {
    const char c = text[static_cast<std::size_t>(i)];
    said += c < ' ' || c > '~' ? '?' : c;
  }
  return said.empty() ? "another process" : said;
}

[[noreturn]] void refuse(const fs::path& file, int descriptor) {
  const std::string who = holder(descriptor);
  ::close(descriptor);
  throw InputError(fmt::format("'{}' is in use by {}: wait for it to end, or name another folder",
                               file.parent_path().string(), who));
}

/// Whether the file of that name is the one that is open: who held it before may have removed it.
bool is_still(const fs::path& file, int descriptor) {
  struct stat named {};
  struct stat held {};
  return ::fstat(descriptor, &held) == 0 && ::lstat(file.c_str(), &named) == 0 &&
         named.st_dev == held.st_dev && named.st_ino == held.st_ino;
}

/// −1 with errno. Of another user's folder the file can be read at best, which is enough to lock
/// it.
int open_lock(const fs::path& file) {
  constexpr int kMode = 0666, kHow = O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | kHow, kMode);
  if (descriptor >= 0 || (errno != EACCES && errno != EROFS)) return descriptor;
  return ::open(file.c_str(), O_RDONLY | kHow);
}

std::string own_text() {
  return fmt::format("process {} on {} since {}\n", ::getpid(), host_name(), utc_now());
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) : file_(fs::absolute(folder) / kLockFile) {
  for (;;) {
    const int descriptor = open_lock(file_);
    if (descriptor < 0) {
      // It is not there, and we cannot make it.
      if (errno == EACCES || errno == EROFS || errno == ENOENT) return;
      fail(file_, errno);
    }
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      if (errno == EWOULDBLOCK) refuse(file_, descriptor);
      ::close(descriptor);
      return;  // no locks here
    }
    if (!is_still(file_, descriptor)) {
      ::close(descriptor);
      continue;
    }
    const std::string text = own_text();
    descriptor_ = descriptor;
    // On a full disk the lock holds without its text.
    if (::ftruncate(descriptor, 0) == 0 && ::pwrite(descriptor, text.data(), text.size(), 0) < 0)
      log::debug(fmt::format("{} says nothing of its holder", file_.string()));
    return;
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  if (is_still(file_, descriptor_)) ::unlink(file_.c_str());
  ::close(descriptor_);
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : file_(std::move(other.file_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

void require_unheld(const fs::path& folder) {
  const fs::path file = folder / kLockFile;
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK) refuse(file, descriptor);
  ::close(descriptor);
}

void require_unheld_within(const fs::path& folder) {
  constexpr auto kOptions = fs::directory_options::skip_permission_denied;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, kOptions, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry.depth() > 0 && entry->path().filename() == kLockFile)
      require_unheld(entry->path().parent_path());
  }
  if (error)
    throw Error(ExitCode::internal_error,
                fmt::format("cannot look into {}: {}", folder.string(), error.message()));
}

}  // namespace deform
