/// Files that are whole or absent, whatever happens while they are written.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace deform {

/// Replaces `file` by one with this content, all at once: readers see the old file or the new one,
/// and so does who looks after a crash. Throws Error naming the file and the cause; the old file is
/// then still there.
void write_atomically(const std::filesystem::path& file, std::string_view content);

/// The content of a regular file; nothing where there is no file. Throws Error naming the file and
/// the cause when it cannot be read.
[[nodiscard]] std::optional<std::string> read_file(const std::filesystem::path& file);

/// A file that grows by whole records.
class AppendFile {
 public:
  /// Makes the file anew, or goes on after the first `keep` bytes of the one that is there and cuts
  /// off what follows them. Throws Error naming the file and the cause when it cannot, or the file
  /// is shorter.
  explicit AppendFile(std::filesystem::path file, std::size_t keep = 0);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Hands a record to the operating system. Throws Error naming the file and the cause; the file
  /// then ends with the record before.
  void append(std::string_view record);
  /// Has the operating system put it all on disk: what was appended survives a power cut. Throws
  /// Error naming the file and the cause.
  void sync();
  /// Bytes.
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::filesystem::path file_;
  int descriptor_;
  std::size_t size_;
};

}  // namespace deform
