#include "json/json_file.h"

#include <cstddef>

#include "files/files.h"
#include "json/json_document.h"

namespace deform {
namespace {

/// Values may be put into the deepest place of a scene, which are as deep as one themselves.
constexpr std::size_t kMostLevels = 2 * JsonDocument::kMaxDepth;

bool nests_too_deep(std::string_view text) {
  std::size_t level = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') in_string = !in_string;
    if (in_string) {
      if (c == '\\') ++i;
    } else if (c == '[' || c == '{') {
      if (++level > kMostLevels) return true;
    } else if ((c == ']' || c == '}') && level > 0) {
      --level;
    }
  }
  return false;
}

}  // namespace

Json parse_json(std::string_view text) {
  if (nests_too_deep(text)) return Json::value_t::discarded;
  return Json::parse(text, nullptr, false);
}

Json read_json_object(const std::filesystem::path& file) {
  const auto text = read_file(file);
  Json json = text ? parse_json(*text) : Json();
  return json.is_object() ? json : Json();
}

}  // namespace deform
