#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "deform/simulation/scene.h"

#include "scene/json_document.h"
#include "scene/json_pointer.h"
#include "scene/nearest_name.h"
#include "scene/scene_json_reader.h"
#include "scene/value_json.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBase = "base";
constexpr const char* kVariants = "/variants";

/// Names of variants become names of folders and columns.
bool is_variant_name(const std::string& name) {
  const auto is_allowed = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           std::string_view("_-+=.").find(c) != std::string_view::npos;
  };
  return !name.empty() && name.front() != '.' && name.front() != '-' && name != kBase &&
         std::all_of(name.begin(), name.end(), is_allowed);
}

/// The value that the text of a replacement says: JSON, else a string. Nothing if it is not UTF-8.
std::optional<Json> replacement_value(const std::string& text) {
  const JsonDocument document = JsonDocument::parse(text, "");
  if (document.problems().empty()) return document.root();
  try {
    (void)Json(text).dump();
  } catch (const Json::type_error&) {
    return std::nullopt;
  }
  return Json(text);
}

/// A scene's document and all that can be made of it: the base, its variants, and one of these with
/// replacements.
class SceneDocument {
 public:
  SceneDocument(const JsonDocument& document, fs::path folder, const PluginRegistry& registry)
      : document_(document), folder_(std::move(folder)), registry_(registry) {}

  Scene read(const std::vector<Replacement>& replacements, const std::string& wanted) {
    for (const JsonProblem& problem : document_.problems()) {
      found_.push_back(to_problem(to_scene_problem(problem, document_.name())));
    }
    throw_found();
    read_variants();
    check_name(wanted);
    Scene scene = check_all(replacements, wanted);
    throw_found();
    for (const auto& [name, changes] : variants_) scene.variants.push_back(name);
    return scene;
  }

 private:
  /// One thing to be made of the document.
  struct Reading {
    Scene scene;
    std::vector<SceneProblem> problems;
  };

  void throw_found() {
    if (!found_.empty()) throw InputError(found_);
  }

  void note(const std::vector<SceneProblem>& problems, const std::string& variant,
            const std::vector<SceneProblem>& known) {
    for (const SceneProblem& problem : problems) {
      if (std::find(known.begin(), known.end(), problem) != known.end()) continue;
      found_.push_back(to_problem(problem, variant == kBase ? "" : variant));
    }
  }

  void read_variants() {
    const Json& root = document_.root();
    if (!root.is_object() || !root.contains("variants")) return;
    const Json& variants = root["variants"];
    SceneProblems problems(document_);
    if (!variants.is_object()) {
      problems.add(kVariants, "found " + shown(variants) + ", expected an object of variants");
    } else {
      for (const auto& variant : variants.items()) read_variant(variant, problems);
    }
    note(problems.sorted(), kBase, {});
  }

  template <class Item>
  void read_variant(const Item& variant, SceneProblems& problems) {
    const std::string pointer = child_pointer(kVariants, variant.key());
    if (!is_variant_name(variant.key())) {
      problems.add_at_key(pointer, "found " + shown(variant.key()) +
                                       ", expected a name of letters, digits and _-+=. that is "
                                       "not \"base\" and begins with none of - and .");
    } else if (!variant.value().is_object()) {
      problems.add(pointer, "found " + shown(variant.value()) +
                                ", expected an object of JSON pointers and values");
    } else {
      variants_.emplace_back(variant.key(), variant.value());
    }
  }

  void check_name(const std::string& wanted) {
    std::vector<std::string> names{kBase};
    for (const auto& [name, changes] : variants_) names.push_back(name);
    if (std::find(names.begin(), names.end(), wanted) != names.end()) return;
    found_.push_back({kVariants, document_.name() + ": there is no variant \"" + wanted + '"' +
                                     did_you_mean(wanted, names)});
  }

  /// Checks the base and every variant as the file has them, and the wanted one with its
  /// replacements, which is returned. What is wrong with the base is not said again for the others.
  Scene check_all(const std::vector<Replacement>& replacements, const std::string& wanted) {
    const Reading base = read_one(kBase, {});
    note(base.problems, kBase, {});
    Reading of_wanted = base;
    for (const auto& [name, changes] : variants_) {
      Reading variant = read_one(name, {});
      note(variant.problems, name, base.problems);
      if (name == wanted) of_wanted = std::move(variant);
    }
    if (replacements.empty()) return of_wanted.scene;
    Reading replaced = read_one(wanted, replacements);
    std::vector<SceneProblem> known = base.problems;
    known.insert(known.end(), of_wanted.problems.begin(), of_wanted.problems.end());
    note(replaced.problems, wanted, known);
    return replaced.scene;
  }

  Reading read_one(const std::string& variant, const std::vector<Replacement>& replacements) {
    Json json = document_.root();
    SceneProblems problems(document_);
    for (const auto& [name, changes] : variants_) {
      if (name == variant) apply_variant(json, name, changes, problems);
    }
    for (const Replacement& replacement : replacements) {
      apply_replacement(json, replacement, problems);
    }
    Reading reading{read_scene_json(json, registry_, folder_, problems), {}};
    reading.problems = problems.sorted();
    return reading;
  }

  void apply_variant(Json& json, const std::string& name, const Json& changes,
                     SceneProblems& problems) {
    const std::string pointer = child_pointer(kVariants, name);
    for (const auto& change : changes.items()) {
      const std::string source = child_pointer(pointer, change.key());
      const std::string why = apply(json, change.key(), change.value());
      if (why.empty()) {
        problems.moved(change.key(), source);
      } else {
        problems.add_at_key(source, why);
      }
    }
  }

  void apply_replacement(Json& json, const Replacement& replacement, SceneProblems& problems) {
    const std::string source = "--set " + replacement.pointer;
    const auto value = replacement_value(replacement.value);
    const std::string why =
        !value ? "the value is not UTF-8" : apply(json, replacement.pointer, *value);
    if (why.empty()) {
      problems.moved_from_outside(replacement.pointer, source);
    } else {
      problems.add_outside(source, why);
    }
  }

  std::string apply(Json& json, const std::string& pointer, const Json& value) {
    if (is_within(pointer, kVariants)) return "variants cannot be replaced";
    return replace_at(json, pointer, value, [&] {
      Json completed = json;
      SceneProblems ignored(document_);
      (void)read_scene_json(completed, registry_, folder_, ignored);
      return completed;
    });
  }

  const JsonDocument& document_;
  fs::path folder_;
  const PluginRegistry& registry_;
  std::vector<std::pair<std::string, Json>> variants_;
  std::vector<Problem> found_;
};

Scene read_document(const JsonDocument& document, const fs::path& file,
                    const PluginRegistry& registry, const std::vector<Replacement>& replacements,
                    const std::string& variant) {
  const fs::path folder = fs::absolute(file).parent_path();
  Scene scene = SceneDocument(document, folder, registry).read(replacements, variant);
  scene.file = file;
  return scene;
}

}  // namespace

long Scene::steps() const { return std::lround(duration / step); }

Scene read_scene(const fs::path& file, const PluginRegistry& registry,
                 const std::vector<Replacement>& replacements, const std::string& variant) {
  return read_document(JsonDocument::read(file), file, registry, replacements, variant);
}

Scene read_scene_text(const std::string& text, const std::string& name, const fs::path& folder,
                      const PluginRegistry& registry, const std::vector<Replacement>& replacements,
                      const std::string& variant) {
  const fs::path file = folder / fs::path(name).filename();
  return read_document(JsonDocument::parse(text, name), file, registry, replacements, variant);
}

}  // namespace deform
