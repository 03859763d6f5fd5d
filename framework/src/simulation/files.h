/// Files that are whole or absent, whatever happens while they are written.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace deform {

/// Replaces `file` by one with this content, all at once: readers see the old file or the new one,
/// and so does who looks after a crash. Throws Error naming the file and the cause; the old file is
/// then still there.
void write_atomically(const std::filesystem::path& file, std::string_view content);

/// A new file that grows by whole records.
class AppendFile {
 public:
  /// Throws Error when the file cannot be made.
  explicit AppendFile(std::filesystem::path file);
  ~AppendFile();
  AppendFile(const AppendFile&) = delete;
  AppendFile& operator=(const AppendFile&) = delete;

  /// Hands a record to the operating system. Throws Error naming the file and the cause; the file
  /// then ends with the record before.
  void append(std::string_view record);

 private:
  std::filesystem::path file_;
  int descriptor_;
  long size_ = 0;
};

}  // namespace deform
