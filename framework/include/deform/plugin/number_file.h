/// Text files with rows of numbers, as spreadsheets and scripts write them.
#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "deform/export.h"

namespace deform {

/// Reads rows of numbers separated by blanks, tabs or commas; empty lines, and what follows # on a
/// line, do not count.
class DEFORM_API NumberFile {
 public:
  /// Throws InputError when it is not a regular file that can be read. A line of more than
  /// `longest_line` bytes is an error: what has no line breaks is no such file, and may be too
  /// large for the memory; so is a file of more than 1 GiB.
  explicit NumberFile(std::filesystem::path path, std::size_t longest_line = 4096);

  /// The next row, at least one number; nothing at the end. Throws InputError that begins with
  /// place() for what is no finite number, with the path where reading fails.
  [[nodiscard]] std::optional<std::vector<double>> next();
  /// File and line of the row that was read last, for messages: "rest.txt:3: ".
  [[nodiscard]] std::string place() const;

 private:
  [[nodiscard]] bool read_line(std::string& line);

  std::filesystem::path path_;
  std::size_t longest_line_;
  std::ifstream file_;
  std::size_t bytes_ = 0;  // read so far
  long line_ = 0;          // number of the line that was read last
};

}  // namespace deform
