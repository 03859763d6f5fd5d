/// Tables on a terminal.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace deform::app {

/// Characters of a UTF-8 text.
[[nodiscard]] std::size_t width_of(const std::string& text);

/// Prints columns side by side, each as wide as its widest text (UTF-8, a column a character), the
/// last one wrapped on a terminal; the first row is the heading. Columns that are empty in all
/// other rows are left out.
void print_table(const std::vector<std::vector<std::string>>& rows);

/// Prints a text behind its front; what does not fit into a terminal, or into `width` columns, goes
/// on below, indented as far as the front is wide.
void print_wrapped(const std::string& front, const std::string& text,
                   std::size_t width = std::numeric_limits<std::size_t>::max());

}  // namespace deform::app
