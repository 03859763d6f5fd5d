#include "scene/scene_places.h"

#include <algorithm>

#include "json/json_pointer.h"

namespace deform {

void ScenePlaces::moved(const std::string& pointer, const std::string& source_pointer) {
  origins_.push_back({pointer, source_pointer, ""});
}

void ScenePlaces::moved_from_outside(const std::string& pointer, const std::string& source) {
  origins_.push_back({pointer, "", source});
}

ScenePlace ScenePlaces::of_value(const std::string& pointer) const {
  return of(pointer, &JsonDocument::position);
}

ScenePlace ScenePlaces::of_change(const std::string& pointer) const {
  const auto change = std::find_if(origins_.rbegin(), origins_.rend(),
                                   [&](const Origin& o) { return is_within(o.pointer, pointer); });
  const bool is_one = change != origins_.rend() && !pointer.empty();
  return of_value(is_one ? change->pointer : pointer);
}

ScenePlace ScenePlaces::of_key(const std::string& pointer) const {
  return of(pointer, &JsonDocument::key_position);
}

ScenePlace ScenePlaces::of(const std::string& pointer, Position position) const {
  const auto origin = std::find_if(origins_.rbegin(), origins_.rend(),
                                   [&](const Origin& o) { return is_within(pointer, o.pointer); });
  std::string source = pointer;
  if (origin != origins_.rend()) {
    if (!origin->outside.empty()) return {{}, origin->outside};
    source = origin->source_pointer + pointer.substr(origin->pointer.size());
  }
  SourcePosition at = (document_.*position)(source);
  // What is missing, or was written out from a short form, has the place of what it belongs to.
  while (!at.known() && !source.empty()) {
    source = parent_pointer(source);
    at = document_.position(source);
  }
  return {at, to_string(document_.name(), at)};
}

std::string to_string(const std::string& file, SourcePosition at) {
  if (!at.known()) return file;
  return file + ':' + std::to_string(at.line) + ':' + std::to_string(at.column);
}

}  // namespace deform
