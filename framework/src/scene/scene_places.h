#pragma once

#include <string>
#include <vector>

#include "json/json_document.h"

namespace deform {

/// Where a value of a scene was written.
struct ScenePlace {
  SourcePosition at;   ///< In the file; unknown if the value is not from there.
  std::string source;  ///< "scene.json:3:7", or "--set /duration".
};

/// Knows where each value of a scene was written: in the file, in one of its variants, or on the
/// command line.
class ScenePlaces {
 public:
  /// The document must live as long.
  explicit ScenePlaces(const JsonDocument& document) : document_(document) {}

  /// The value at `pointer` is now that which stands at `source_pointer` of the file.
  void moved(const std::string& pointer, const std::string& source_pointer);
  /// The value at `pointer` is now `source`'s, which is not in the file.
  void moved_from_outside(const std::string& pointer, const std::string& source);

  /// The place of the value at a pointer into the scene; of what is not written anywhere, that of
  /// what it belongs to.
  [[nodiscard]] ScenePlace of_value(const std::string& pointer) const;
  /// The place of what makes a value what it is now: the last change within it, where there is one.
  [[nodiscard]] ScenePlace of_change(const std::string& pointer) const;
  /// The place of the key of an object's member.
  [[nodiscard]] ScenePlace of_key(const std::string& pointer) const;

 private:
  struct Origin {
    std::string pointer;         // In the scene.
    std::string source_pointer;  // In the file.
    std::string outside;         // Not empty: not in the file.
  };
  using Position = SourcePosition (JsonDocument::*)(std::string_view) const;
  [[nodiscard]] ScenePlace of(const std::string& pointer, Position position) const;

  const JsonDocument& document_;
  std::vector<Origin> origins_;  // Later ones replace parts of earlier ones.
};

/// "scene.json:3:7", or the file alone.
std::string to_string(const std::string& file, SourcePosition at);

}  // namespace deform
