#include "files/files.h"

#include <cerrno>
#include <fcntl.h>
#include <limits>
#include <new>
#include <stdexcept>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>
#include <sys/stat.h>

#include "deform/error.h"

namespace deform {
namespace {

[[noreturn]] void fail(const char* doing, const std::filesystem::path& file, int error) {
  throw Error(ExitCode::internal_error, fmt::format("cannot {} {}: {}", doing, file.string(),
                                                    std::generic_category().message(error)));
}

/// Owns a file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return number_; }
  [[nodiscard]] int release() { return std::exchange(number_, -1); }
  /// 0, or the error: some file systems report a failed write only here.
  [[nodiscard]] int close() { return ::close(std::exchange(number_, -1)) == 0 ? 0 : errno; }

 private:
  int number_;
};

/// 0, or the error.
int write_all(int descriptor, std::string_view content) {
  while (!content.empty()) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    content.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

/// Where it is more than the machine has [bytes], nothing is read.
std::uint64_t memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0
             ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(size)
             : std::numeric_limits<std::uint64_t>::max();
}

/// Room for a file's bytes.
std::string room_for(const std::filesystem::path& file, off_t bytes) {
  try {
    if (std::cmp_less_equal(bytes, memory()))
      return std::string(static_cast<std::size_t>(bytes), '\0');
  } catch (const std::bad_alloc&) {  // said below
  } catch (const std::length_error&) {
  }
  throw InputError(
      fmt::format("cannot read {}: there is no room for its {} bytes", file.string(), bytes));
}

/// Shortens a file and goes to its end; 0, or −1 with errno.
int cut_to(int descriptor, std::size_t size) {
  const auto end = static_cast<off_t>(size);
  return ::ftruncate(descriptor, end) == 0 && ::lseek(descriptor, end, SEEK_SET) == end ? 0 : -1;
}

/// Makes a rename in the folder survive a power cut; where a file system cannot do that, so be it.
void sync_folder(const std::filesystem::path& folder) {
  const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.get() >= 0) (void)::fsync(descriptor.get());
}

/// A new file in place of what has its name; −1 with errno. What somebody links elsewhere is not
/// written to: the link goes.
int make_file(const std::filesystem::path& file) {
  if (::unlink(file.c_str()) != 0 && errno != ENOENT) return -1;
  return ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
}

/// 0, or the error.
int write_and_sync(const std::filesystem::path& file, std::string_view content) {
  Descriptor descriptor(make_file(file));
  if (descriptor.get() < 0) return errno;
  if (const int error = write_all(descriptor.get(), content); error != 0) return error;
  if (::fsync(descriptor.get()) != 0) return errno;
  return descriptor.close();
}

}  // namespace

void write_atomically(const std::filesystem::path& file, std::string_view content) {
  std::filesystem::path temporary = file;
  temporary += ".part";
  int error = write_and_sync(temporary, content);
  if (error == 0 && ::rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    fail("write", file, error);
  }
  sync_folder(std::filesystem::absolute(file).parent_path());
}

std::optional<std::string> read_file(const std::filesystem::path& file) {
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (descriptor.get() < 0) {
    if (errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG) return std::nullopt;
    fail("read", file, errno);
  }
  struct stat status {};
  if (::fstat(descriptor.get(), &status) != 0) fail("read", file, errno);
  if (!S_ISREG(status.st_mode))
    throw InputError(fmt::format("cannot read {}: it is not a regular file", file.string()));
  std::string content = room_for(file, status.st_size);
  std::size_t size = 0;
  while (size < content.size()) {
    const ssize_t count = ::read(descriptor.get(), content.data() + size, content.size() - size);
    if (count < 0 && errno != EINTR) fail("read", file, errno);
    if (count == 0) break;  // somebody cuts it short
    if (count > 0) size += static_cast<std::size_t>(count);
  }
  content.resize(size);
  return content;
}

std::string missing_from(const std::filesystem::path& folder, const WrittenFile& written) {
  namespace fs = std::filesystem;
  const fs::path file = folder / written.name;
  std::error_code error;
  for (fs::path above = fs::path(written.name).parent_path(); !above.empty();
       above = above.parent_path()) {
    if (fs::is_symlink(fs::symlink_status(folder / above, error)))
      return fmt::format("{} is a link, out of the run directory", (folder / above).string());
  }
  const auto status = std::filesystem::symlink_status(file, error);
  if (status.type() == std::filesystem::file_type::not_found)
    return fmt::format("{} is not there", file.string());
  if (!is_regular_file(status)) return fmt::format("{} is not a regular file", file.string());
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (error) return fmt::format("{} cannot be read: {}", file.string(), error.message());
  if (bytes < written.bytes) {
    return fmt::format("{} has {} bytes only, of {} that were written", file.string(), bytes,
                       written.bytes);
  }
  if (written.sha256.empty()) return "";
  Sha256 hash;
  (void)add_file(hash, file, written.bytes);
  if (hash.digits() == written.sha256) return "";
  return fmt::format("the {} bytes of {} are not those that were written", written.bytes,
                     file.string());
}

AppendFile::AppendFile(std::filesystem::path file, std::size_t keep)
    : file_(std::move(file)), size_(keep) {
  Descriptor opened(keep == 0 ? make_file(file_)
                              : ::open(file_.c_str(), O_WRONLY | O_NOFOLLOW | O_CLOEXEC));
  if (opened.get() < 0) fail(keep == 0 ? "make" : "go on with", file_, errno);
  const off_t end = ::lseek(opened.get(), 0, SEEK_END);
  int error = end < 0 ? errno : std::cmp_less(end, keep) ? EINVAL : 0;
  if (error == 0 && cut_to(opened.get(), keep) != 0) error = errno;
  if (error != 0) fail("go on with", file_, error);
  if (keep > 0) (void)add_file(hash_, file_, keep);
  descriptor_ = opened.release();
}

AppendFile::~AppendFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void AppendFile::append(std::string_view record) {
  if (const int error = write_all(descriptor_, record); error != 0) {
    // Half a record would make the whole file unreadable to some.
    (void)cut_to(descriptor_, size_);
    fail("write", file_, error);
  }
  size_ += record.size();
  hash_.add(record);
}

void AppendFile::sync() {
  if (::fsync(descriptor_) != 0) fail("write", file_, errno);
}

void AppendFile::close() {
  if (::close(std::exchange(descriptor_, -1)) != 0) fail("write", file_, errno);
}

WrittenFile AppendFile::written() const {
  return {file_.filename().string(), size_, hash_.digits()};
}

}  // namespace deform
