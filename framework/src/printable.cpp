#include "deform/printable.h"

#include <array>
#include <cstdint>

#include <fmt/format.h>

namespace deform {
namespace {

struct Range {
  std::uint32_t first, last;
};

/// Beyond C0, DEL and C1: soft hyphen, Arabic letter mark, Mongolian vowel separator, zero-width
/// characters and marks of direction, separators of lines and paragraphs, embeddings and overrides,
/// invisible operators and isolates, byte order mark, annotations, tags.
constexpr std::array<Range, 10> kUnseen{{{0xAD, 0xAD},
                                         {0x61C, 0x61C},
                                         {0x180E, 0x180E},
                                         {0x200B, 0x200F},
                                         {0x2028, 0x202E},
                                         {0x2060, 0x206F},
                                         {0xFEFF, 0xFEFF},
                                         {0xFFF9, 0xFFFB},
                                         {0xE0000, 0xE007F},
                                         {0xD800, 0xDFFF}}};

bool is_safe(std::uint32_t character) {
  if (character < 0x20 || (character >= 0x7F && character < 0xA0)) return false;
  for (const Range& range : kUnseen)
    if (character >= range.first && character <= range.last) return false;
  return true;
}

/// The character that a text begins with, and its bytes; none (0) where they are no UTF-8 (RFC
/// 3629: neither longer than need be, nor beyond U+10FFFF).
struct Decoded {
  std::uint32_t character = 0;
  std::size_t bytes = 0;
};

Decoded decoded(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(text[i]) & 0xFFU; };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < bytes) return {};
  std::uint32_t character = first & (0xFFU >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return {};
    character = character << 6U | (byte(i) & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};
  if (character < kLeast[bytes] || character > 0x10FFFF) return {};
  return {character, bytes};
}

/// As JSON writes it, so that JSON's texts stay the same to who reads them.
std::string escaped(std::uint32_t character) {
  if (character == '\n') return "\\n";
  if (character == '\t') return "\\t";
  if (character == '\r') return "\\r";
  if (character < 0x10000) return fmt::format("\\u{:04x}", character);
  const std::uint32_t beyond = character - 0x10000;  // UTF-16's pair
  return fmt::format("\\u{:04x}\\u{:04x}", 0xD800 + (beyond >> 10U), 0xDC00 + (beyond & 0x3FFU));
}

}  // namespace

std::string printable(std::string_view text) {
  std::string safe;
  safe.reserve(text.size());
  while (!text.empty()) {
    const Decoded next = decoded(text);
    if (next.bytes == 0)
      safe += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    else if (is_safe(next.character))
      safe += text.substr(0, next.bytes);
    else
      safe += escaped(next.character);
    text.remove_prefix(next.bytes == 0 ? 1 : next.bytes);
  }
  return safe;
}

}  // namespace deform
