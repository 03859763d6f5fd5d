/// SHA-256.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace deform {

/// 64 lower-case hexadecimal digits. Throws Error when the file cannot be read.
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& file);

/// The same for bytes in memory.
[[nodiscard]] std::string sha256_of(std::string_view bytes);

}  // namespace deform
