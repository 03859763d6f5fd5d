/// What the program says: results on stdout, anything else on stderr.
#pragma once

#include <string>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include "deform/printable.h"

namespace deform::app {

/// Texts among the arguments of a format are printable; titles, paths and plugins' words come from
/// anywhere.
template <class T>
[[nodiscard]] auto made_printable(const T& value) {
  if constexpr (std::is_convertible_v<const T&, std::string_view>)
    return printable(value);
  else
    return value;
}

template <class... Args>
[[nodiscard]] std::string formatted(fmt::string_view format, const Args&... args) {
  const auto format_all = [format](const auto&... safe) {
    return fmt::vformat(format, fmt::make_format_args(safe...));
  };
  return format_all(made_printable(args)...);
}

/// Text that is printable already to stdout. What cannot be written is told by finish_output.
void put_result(std::string_view text);
/// … to stderr. What cannot be written is lost: there is no better place to say so.
void put_message(std::string_view text);
/// Several lines, made printable one by one, to stdout.
void put_lines(std::string_view text);

/// As fmt::print.
template <class... Args>
void say(fmt::format_string<const Args&...> format, const Args&... args) {
  put_result(formatted(format, args...));
}

/// A line "deform: …" on stderr.
template <class... Args>
void complain(fmt::format_string<const Args&...> format, const Args&... args) {
  put_message("deform: " + formatted(format, args...) + '\n');
}

/// For a program's first lines: where stdin, stdout or stderr is closed, no file that is opened
/// later takes its place, and what is said does not get into it.
void occupy_standard_streams();

}  // namespace deform::app
