#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace deform {

/// Appends base64 (standard alphabet, padded, no line breaks) to a text, of bytes that come in
/// parts: what a report holds is larger than it need ever be at one time.
class Base64Writer {
 public:
  explicit Base64Writer(std::string& text) : text_(text) {}

  /// The bytes of the numbers, in the order of this machine: little-endian.
  template <class T>
  void append(std::span<const T> numbers) {
    append_bytes(std::as_bytes(numbers));
  }
  /// Writes what is left over, and the padding; nothing may be appended after it.
  void finish();

 private:
  void append_bytes(std::span<const std::byte> bytes);
  void encode(const std::byte* bytes, std::size_t count);

  std::string& text_;
  std::array<std::byte, 3> left_{};  // bytes that do not make a group of three yet
  std::size_t left_count_ = 0;
};

/// The bytes of a base64 text; throws InputError when it is not one.
[[nodiscard]] std::string decode_base64(std::string_view text);

}  // namespace deform
