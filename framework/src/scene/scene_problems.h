#pragma once

#include <string>
#include <vector>

#include "deform/error.h"

#include "scene/json_document.h"

namespace deform {

/// One thing wrong with a scene, and where its value was written.
struct SceneProblem {
  std::string pointer;  ///< In the scene.
  SourcePosition at;    ///< In the file; unknown if the value is not from there.
  std::string source;   ///< "scene.json:3:7", or "--set /duration".
  std::string rule;     ///< What was found, and what should be.

  bool operator==(const SceneProblem&) const = default;
};

/// Collects what is wrong with a scene. Knows where each value was written: in the file, in one of
/// its variants, or on the command line.
class SceneProblems {
 public:
  explicit SceneProblems(const JsonDocument& document) : document_(document) {}

  /// The value at `pointer` is now that which stands at `source_pointer` of the file.
  void moved(const std::string& pointer, const std::string& source_pointer);
  /// The value at `pointer` is now `source`'s, which is not in the file.
  void moved_from_outside(const std::string& pointer, const std::string& source);

  void add(const std::string& pointer, const std::string& rule);
  /// At the key of an object's member rather than at its value.
  void add_at_key(const std::string& pointer, const std::string& rule);
  /// With something that is neither in the file nor in the scene.
  void add_outside(const std::string& source, const std::string& rule);

  [[nodiscard]] bool empty() const { return problems_.empty(); }
  /// In the order of the file; those without a place there come last.
  [[nodiscard]] std::vector<SceneProblem> sorted() const;

 private:
  struct Origin {
    std::string pointer;         // In the scene.
    std::string source_pointer;  // In the file.
    std::string outside;         // Not empty: not in the file.
  };
  void add(const std::string& pointer, const std::string& rule, bool at_key);

  const JsonDocument& document_;
  std::vector<Origin> origins_;  // Later ones replace parts of earlier ones.
  std::vector<SceneProblem> problems_;
};

/// A problem as programs print it: "FILE:LINE:COLUMN: variant 'x': at POINTER: …"; `variant` may be
/// empty.
Problem to_problem(const SceneProblem& problem, const std::string& variant = "");

/// A problem with the text of the file itself.
SceneProblem to_scene_problem(const JsonProblem& problem, const std::string& file);

}  // namespace deform
