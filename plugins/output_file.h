/// Files that appear whole or not at all, and the names of a sequence of them.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace deform::outputs {

/// A file that is written under a temporary name and takes its own, replacing an older one, in
/// commit(): a reader, or an interrupted run, never sees half of it. Without commit() nothing is
/// left behind. Every function throws Error, naming the file and the system's reason, when it
/// fails.
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }
  void commit();

 private:
  std::filesystem::path path_;
  std::filesystem::path temporary_;
  std::FILE* file_;
};

/// Makes the folder of a run's frames and those above it. In one that is resumed, takes out the
/// frames of the step at which it goes on and of later ones: those that come again are written
/// again, those that were the last of a shorter run are not. Throws Error.
void make_folder(const std::filesystem::path& folder, std::optional<long> resumed_at);

/// "stem_000123.extension".
[[nodiscard]] std::string numbered_name(const std::string& stem, long step,
                                        const std::string& extension);

/// Appends the shortest text that reads back as the same number, whatever the locale.
void append_number(std::string& text, double value);
void append_number(std::string& text, long value);

}  // namespace deform::outputs
