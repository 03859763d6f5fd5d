#include "text/nearest_name.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace deform {
namespace {

/// A longer text is no mistyped name, and not worth quadratic time.
constexpr std::size_t kMaxLength = 256;
constexpr std::size_t kMaxListed = 12;

char to_lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

/// Optimal string alignment: Damerau-Levenshtein in which no part is edited twice.
std::size_t distance(std::string_view a, std::string_view b) {
  const auto same = [&](std::size_t i, std::size_t j) { return to_lower(a[i]) == to_lower(b[j]); };
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before_last, last);
    std::swap(last, row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (same(i - 1, j - 1) ? 0U : 1U);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && same(i - 1, j - 2) && same(i - 2, j - 1)) {
        row[j] = std::min(row[j], before_last[j - 2] + 1);
      }
    }
  }
  return row[b.size()];
}

}  // namespace

std::optional<std::string> nearest_name(std::string_view wrong,
                                        std::span<const std::string> valid) {
  if (wrong.size() > kMaxLength) return std::nullopt;
  std::size_t limit = std::max<std::size_t>(2, wrong.size() / 3);
  std::optional<std::string> nearest;
  for (const std::string& name : valid) {
    if (name.size() > kMaxLength) continue;
    const std::size_t edits = distance(wrong, name);
    // Among very short names all are within two edits: one that replaces everything is not near.
    const bool is_near = edits <= limit && edits < std::max(wrong.size(), name.size());
    if (!is_near || (nearest && edits == limit)) continue;
    nearest = name;
    limit = edits;
  }
  return nearest;
}

std::string did_you_mean(std::string_view wrong, std::span<const std::string> valid) {
  if (const auto name = nearest_name(wrong, valid)) return "; did you mean \"" + *name + "\"?";
  if (valid.empty() || valid.size() > kMaxListed) return "";
  std::string list;
  for (const std::string& name : valid) list += (list.empty() ? "\"" : ", \"") + name + "\"";
  return (valid.size() == 1 ? "; valid is " : "; valid are ") + list;
}

}  // namespace deform
