#include "report/base64.h"

#include <algorithm>
#include <bit>

#include <openssl/evp.h>

#include "deform/error.h"

namespace deform {

static_assert(std::endian::native == std::endian::little, "reports are little-endian");

namespace {

/// OpenSSL counts in int; a multiple of three, so that the parts need no padding.
constexpr std::size_t kMostBytes = 3 << 20;

}  // namespace

void Base64Writer::append_bytes(std::span<const std::byte> bytes) {
  if (left_count_ > 0) {
    while (left_count_ < 3 && !bytes.empty()) {
      left_[left_count_++] = bytes.front();
      bytes = bytes.subspan(1);
    }
    if (left_count_ < 3) return;
    encode(left_.data(), 3);
    left_count_ = 0;
  }
  const std::size_t whole = bytes.size() / 3 * 3;
  for (std::size_t at = 0; at < whole; at += kMostBytes)
    encode(bytes.data() + at, std::min(kMostBytes, whole - at));
  std::ranges::copy(bytes.subspan(whole), left_.begin());
  left_count_ = bytes.size() - whole;
}

void Base64Writer::finish() {
  if (left_count_ > 0) encode(left_.data(), left_count_);
  left_count_ = 0;
}

void Base64Writer::encode(const std::byte* bytes, std::size_t count) {
  const std::size_t before = text_.size();
  // It ends what it writes with a zero, which has its place after the text's last character.
  text_.resize(before + (count + 2) / 3 * 4);
  ::EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text_.data() + before),
                    reinterpret_cast<const unsigned char*>(bytes), static_cast<int>(count));
}

std::string decode_base64(std::string_view text) {
  if (text.size() % 4 != 0) throw InputError("a base64 text has a length that none can have");
  std::string bytes(text.size() / 4 * 3, '\0');
  const int size = ::EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                                     reinterpret_cast<const unsigned char*>(text.data()),
                                     static_cast<int>(text.size()));
  if (size < 0) throw InputError("a base64 text has a character that none can have");
  const auto padding = static_cast<std::size_t>(std::ranges::count(text, '='));
  bytes.resize(static_cast<std::size_t>(size) - padding);
  return bytes;
}

}  // namespace deform
