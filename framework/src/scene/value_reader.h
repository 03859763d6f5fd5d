#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "deform/plugin/registry.h"
#include "deform/simulation/scene.h"

#include "scene/plain_reader.h"

namespace deform {

/// Reads objects of a scene by the rules of their fields. Notes every problem and goes on; writes
/// the defaults of what is missing into the JSON, behind what is there.
class ValueReader {
 public:
  /// Relative file names start from `folder`, an absolute path; they become absolute, in the JSON
  /// too.
  ValueReader(const PluginRegistry& registry, std::filesystem::path folder, SceneProblems& problems)
      : registry_(registry), folder_(std::move(folder)), problems_(problems), plain_(problems) {}

  /// A plugin, given by an object or by its name alone, which becomes an object.
  PluginUse plugin(Json& json, PluginKind kind, const std::string& pointer);
  /// All members of an object; `owner` is what messages say has them ("material").
  ParameterValues members(Json& object, const ParameterFields& fields, const std::string& pointer,
                          const std::string& owner);
  /// One member of an object, which stands at `pointer`.
  void member(Json& object, const ParameterField& field, const std::string& pointer,
              ParameterValues& values);
  /// The files that were named so far.
  [[nodiscard]] const std::vector<SceneFile>& files() const { return files_; }

 private:
  std::optional<ParameterValue> value(Json& json, const ValuePlace& place);
  void note_maps(const Json& json, const std::string& pointer);
  void missing_member(Json& object, const ParameterField& field, const std::string& pointer,
                      ParameterValues& values);
  ParameterValues plugin_members(Json& object, const LoadedPlugin& plugin,
                                 const std::string& pointer);

  template <class T>
  std::optional<T> read(Json& json, const ValuePlace& place, const T& by_default) {
    return plain_.read(json, place, by_default);
  }
  std::optional<TimeProfile> read(Json& json, const ValuePlace& place, const TimeProfile&);
  std::optional<NodeSelection> read(Json& json, const ValuePlace& place, const NodeSelection&);
  std::optional<PluginUse> read(Json& json, const ValuePlace& place, const PluginUse& by_default);
  std::optional<std::filesystem::path> read(Json& json, const ValuePlace& place,
                                            const std::filesystem::path& by_default);
  std::optional<Field> read(Json& json, const ValuePlace& place, const Field&);
  std::optional<PairWeightsField> read(Json& json, const ValuePlace& place,
                                       const PairWeightsField&);

  const PluginRegistry& registry_;
  std::filesystem::path folder_;
  SceneProblems& problems_;
  PlainReader plain_;
  bool resolves_files_ = true;
  std::vector<SceneFile> files_;
};

}  // namespace deform
