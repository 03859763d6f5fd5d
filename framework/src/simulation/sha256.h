/// SHA-256 of files.
#pragma once

#include <filesystem>
#include <string>

namespace deform {

/// 64 lower-case hexadecimal digits. Throws Error when the file cannot be read.
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace deform
