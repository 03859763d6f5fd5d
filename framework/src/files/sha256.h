/// SHA-256.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

namespace deform {

/// The hash of bytes that come one after another. Throws Error where OpenSSL has no SHA-256.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void add(std::string_view bytes);
  /// Of the bytes so far: 64 lower-case hexadecimal digits.
  [[nodiscard]] std::string digits() const;

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

inline constexpr std::uintmax_t kWholeFile = std::numeric_limits<std::uintmax_t>::max();

/// Adds the first `most` bytes of a file, all where it has fewer; returns how many. Throws Error
/// when the file cannot be read.
std::uintmax_t add_file(Sha256& hash, const std::filesystem::path& file,
                        std::uintmax_t most = kWholeFile);

/// 64 lower-case hexadecimal digits. Throws Error when the file cannot be read.
[[nodiscard]] std::string sha256_of_file(const std::filesystem::path& file);

/// The same for bytes in memory.
[[nodiscard]] std::string sha256_of(std::string_view bytes);

}  // namespace deform
