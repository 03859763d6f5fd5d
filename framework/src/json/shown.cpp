#include "json/shown.h"

#include <cstddef>

namespace deform {
namespace {

constexpr std::size_t kMostShown = 60;  // [bytes]

/// Appends JSON text until there is more than is shown: a value may be as large as the file.
void append_shown(const Json& json, std::string& text) {
  if (json.is_structured()) {
    text += json.is_object() ? '{' : '[';
    for (auto item = json.begin(); item != json.end() && text.size() <= kMostShown; ++item) {
      if (item != json.begin()) text += ',';
      if (json.is_object()) {
        append_shown(Json(item.key()), text);
        text += ':';
      }
      append_shown(*item, text);
    }
    text += json.is_object() ? '}' : ']';
    return;
  }
  const bool is_long = json.is_string() && json.get_ref<const std::string&>().size() > kMostShown;
  const Json start =
      is_long ? Json(json.get_ref<const std::string&>().substr(0, kMostShown)) : Json();
  text += (is_long ? start : json).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string shown(const Json& json) {
  std::string text;
  append_shown(json, text);
  if (text.size() <= kMostShown) return text;
  std::size_t end = kMostShown;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "...";
}

}  // namespace deform
