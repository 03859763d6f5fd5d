/// Files that are whole or absent, whatever happens while they are written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "files/sha256.h"

namespace deform {

/// Replaces `file` by one with this content, all at once: readers see the old file or the new one,
/// and so does who looks after a crash. A link of that name is replaced, not followed. Throws Error
/// naming the file and the cause; the old file is then still there.
void write_atomically(const std::filesystem::path& file, std::string_view content);

/// The content of a regular file; nothing where there is no file, nor can be one of that name.
/// Throws InputError where there is something else, or more than memory holds, and Error when it
/// cannot be read; both name the file and the cause.
[[nodiscard]] std::optional<std::string> read_file(const std::filesystem::path& file);

/// A file of a run as it was at some time.
struct WrittenFile {
  std::string name;         ///< within the run directory
  std::uint64_t bytes = 0;  ///< then; one that grows is longer later
  std::string sha256;       ///< of these bytes; empty where nobody has looked at them
};

/// "", or why a folder does not hold a file with what was written to it: it is not there, no
/// regular file, too short, or its beginning is another. Throws Error when it cannot be read.
[[nodiscard]] std::string missing_from(const std::filesystem::path& folder,
                                       const WrittenFile& written);

/// A file that grows by whole records.
class AppendFile {
 public:
  /// Makes the file anew, or goes on after the first `keep` bytes of the one that is there and cuts
  /// off what follows them. Follows no link. Throws Error naming the file and the cause when it
  /// cannot, or the file is shorter.
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
  /// Ends it: nothing is appended any more. Throws Error naming the file and the cause: some file
  /// systems report a failed write only here.
  void close();
  /// Bytes.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Its name, size and hash.
  [[nodiscard]] WrittenFile written() const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
  std::size_t size_;
  Sha256 hash_;
};

}  // namespace deform
