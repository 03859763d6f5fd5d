/// The tag by which a host knows, before it touches anything else, that a plugin was built to fit
/// it.
#pragma once

#include <cstddef>
#include <cstdint>

#include <Eigen/Core>

namespace deform {

/// Raised whenever a public header changes so that older plugins would misbehave.
inline constexpr std::uint32_t kApiNumber = 17;

/// Plain numbers and characters only: readable whatever the plugin was built with.
struct AbiTag {
  std::uint32_t size = sizeof(AbiTag);
  std::uint32_t api = kApiNumber;
  char compiler[32]{};                ///< e.g. "g++ 12"
  char standard_library[32]{};        ///< e.g. "libstdc++ cxx11"
  char flavour[32]{};                 ///< "release", or the sanitizers
  std::uint32_t eigen = 0;            ///< world*10000 + major*100 + minor
  std::uint32_t eigen_max_align = 0;  ///< EIGEN_MAX_ALIGN_BYTES
};

namespace detail {
constexpr void copy_text(char (&to)[32], const char* from) {
  for (std::size_t i = 0; i + 1 < sizeof(to) && from[i] != '\0'; ++i) to[i] = from[i];
}
constexpr void append_number(char (&to)[32], int number) {
  std::size_t end = 0;
  while (to[end] != '\0') ++end;
  if (number >= 10) to[end++] = static_cast<char>('0' + number / 10 % 10);
  to[end] = static_cast<char>('0' + number % 10);
}
}  // namespace detail

/// The tag of the translation unit that calls it.
[[nodiscard]] constexpr AbiTag abi_tag() {
  AbiTag tag;
#if defined(__clang__)
  detail::copy_text(tag.compiler, "clang ");
  detail::append_number(tag.compiler, __clang_major__);
#elif defined(__GNUC__)
  detail::copy_text(tag.compiler, "g++ ");
  detail::append_number(tag.compiler, __GNUC__);
#else
  detail::copy_text(tag.compiler, "unknown");
#endif
#if defined(_GLIBCXX_USE_CXX11_ABI) && _GLIBCXX_USE_CXX11_ABI
  detail::copy_text(tag.standard_library, "libstdc++ cxx11");
#elif defined(_GLIBCXX_RELEASE)
  detail::copy_text(tag.standard_library, "libstdc++ old");
#else
  detail::copy_text(tag.standard_library, "other");
#endif
#if defined(__SANITIZE_ADDRESS__)
  detail::copy_text(tag.flavour, "address sanitizer");
#elif defined(__SANITIZE_THREAD__)
  detail::copy_text(tag.flavour, "thread sanitizer");
#else
  detail::copy_text(tag.flavour, "plain");
#endif
  tag.eigen = EIGEN_WORLD_VERSION * 10000 + EIGEN_MAJOR_VERSION * 100 + EIGEN_MINOR_VERSION;
  tag.eigen_max_align = EIGEN_MAX_ALIGN_BYTES;
  return tag;
}

}  // namespace deform
