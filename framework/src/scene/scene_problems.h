#pragma once

#include <string>
#include <vector>

#include "deform/error.h"

#include "scene/scene_places.h"

namespace deform {

/// One thing wrong with a scene, and where its value was written.
struct SceneProblem {
  std::string pointer;          ///< In the scene.
  SourcePosition at;            ///< In the file; unknown if the value is not from there.
  std::string source;           ///< "scene.json:3:7", or "--set /duration".
  std::string rule;             ///< What was found, and what should be.
  bool plugin_missing = false;  ///< A plugin cannot be loaded: it is not there, or does not fit.

  bool operator==(const SceneProblem&) const = default;
};

/// Collects what is wrong with a scene, each with its place.
class SceneProblems {
 public:
  /// More than a user reads at a time. Further ones are only counted: each is located by a search
  /// through the file, and there may be as many as the file has values.
  static constexpr std::size_t kMost = 100;

  explicit SceneProblems(const JsonDocument& document) : document_(document), places_(document) {}

  void add(const std::string& pointer, const std::string& rule);
  /// That a plugin cannot be loaded.
  void add_missing_plugin(const std::string& pointer, const std::string& rule);
  /// At the key of an object's member rather than at its value.
  void add_at_key(const std::string& pointer, const std::string& rule);
  /// The same for a member that should not be there; unknown_keys() knows it then.
  void add_unknown_key(const std::string& pointer, const std::string& rule);
  /// With something that is neither in the file nor in the scene.
  void add_outside(const std::string& source, const std::string& rule);

  [[nodiscard]] bool empty() const { return problems_.empty(); }
  /// Whether there may be problems with a value or something in it.
  [[nodiscard]] bool any_within(const std::string& pointer) const;
  /// In the order of the file; those without a place there come last, and then how many more there
  /// are.
  [[nodiscard]] std::vector<SceneProblem> sorted() const;

  [[nodiscard]] const std::vector<std::string>& unknown_keys() const { return unknown_keys_; }
  [[nodiscard]] ScenePlaces& places() { return places_; }

  /// Whether there are enough: then a problem need not be put into words, and is counted by this.
  [[nodiscard]] bool takes_no_more();

 private:
  const JsonDocument& document_;
  ScenePlaces places_;
  std::vector<SceneProblem> problems_;
  std::vector<std::string> unknown_keys_;
  std::size_t unlisted_ = 0;
};

/// A problem as programs print it: "FILE:LINE:COLUMN: variant 'x': at POINTER: …"; `variant` may be
/// empty.
Problem to_problem(const SceneProblem& problem, const std::string& variant = "");

/// A problem with the text of the file itself.
SceneProblem to_scene_problem(const JsonProblem& problem, const std::string& file);

}  // namespace deform
