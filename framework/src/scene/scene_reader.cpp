#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "deform/simulation/scene.h"

#include "json/json_document.h"
#include "json/json_pointer.h"
#include "json/shown.h"
#include "scene/scene_json_reader.h"
#include "scene/scene_rules.h"
#include "simulation/run_parts.h"
#include "text/nearest_name.h"

namespace deform {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBase = "base";
constexpr const char* kVariantsKey = "variants";
constexpr const char* kVariants = "/variants";

/// What reading all variants may cost: bytes of the file, once for every variant and every change
/// that it makes. Far beyond what anybody writes, and still a matter of seconds.
constexpr double kMostWork = 2.5e8;

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
  if (!is_utf8(text)) return std::nullopt;
  return Json(text);
}

bool is_of_missing_plugin(const SceneProblem& problem) { return problem.plugin_missing; }

/// A scene's document and all that can be made of it: the base, its variants, and one of these with
/// replacements.
class SceneDocument {
 public:
  /// `makes_parts`: looks for the problems that show only then, if there are others.
  SceneDocument(JsonDocument document, fs::path file, const PluginRegistry& registry,
                bool makes_parts)
      : shared_document_(std::make_shared<const JsonDocument>(std::move(document))),
        document_(*shared_document_),
        file_(std::move(file)),
        folder_(fs::absolute(file_).parent_path()),
        registry_(registry),
        makes_parts_(makes_parts) {}

  Scene read(const std::vector<Replacement>& replacements, const std::string& wanted) {
    prepare();
    check_name(wanted);
    as_it_stands_ = replacements.empty() ? wanted : "";
    Scene scene;
    check_all([&](Reading& reading) {
      if (reading.scene.variant != wanted) return;
      scene = replacements.empty() ? std::move(reading.scene)
                                   : replaced(replacements, wanted, reading.problems);
    });
    if (makes_parts_) look_at_parts(wanted, replacements);
    throw_found();
    scene.elsewhere = std::move(elsewhere_);
    return scene;
  }

  std::vector<Scene> read_all() {
    prepare();
    std::vector<Scene> scenes;
    check_all([&scenes](Reading& reading) { scenes.push_back(std::move(reading.scene)); });
    if (makes_parts_) look_at_parts(kBase, {});
    throw_found();
    return scenes;
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

  /// Where there are problems, looks also for those that only show when the parts of the scene are
  /// made: all are to be said at once.
  void look_at_parts(const std::string& wanted, const std::vector<Replacement>& replacements) {
    if (found_.empty()) return;
    std::set<std::string> known;  // what the variants share is said once
    const auto look = [&](const std::string& variant, const std::vector<Replacement>& with) {
      if (found_.size() >= SceneProblems::kMost) return;
      const Scene scene = read_one(variant, with).scene;
      for (const Problem& problem : problems_of_sound_parts(scene, registry_)) {
        const std::string told = scene.place(problem.pointer) + problem.message;
        if (known.insert(told).second) found_.push_back(scene.located(problem));
      }
    };
    look(kBase, {});
    for (const auto& [name, changes] : variants_) look(name, {});
    if (!replacements.empty()) look(wanted, replacements);
  }

  void note(const std::vector<SceneProblem>& problems, const std::string& variant,
            const std::vector<SceneProblem>& known) {
    for (const SceneProblem& problem : problems) {
      if (std::find(known.begin(), known.end(), problem) != known.end()) continue;
      found_.push_back(to_problem(problem, variant == kBase ? "" : variant));
    }
  }

  /// The same of a reading of the file as it stands. Plugins must be there for what is wanted
  /// alone; returns the problems that are problems whatever is wanted.
  std::vector<SceneProblem> note_as_it_stands(const std::vector<SceneProblem>& problems,
                                              const std::string& variant,
                                              const std::vector<SceneProblem>& known) {
    if (!as_it_stands_) {
      note(problems, variant, known);
      return problems;
    }
    std::vector<SceneProblem> lasting = problems;
    std::erase_if(lasting, is_of_missing_plugin);
    if (*as_it_stands_ == variant) {
      note(problems, variant, known);
      return lasting;
    }
    note(lasting, variant, known);
    for (const SceneProblem& problem : problems) {
      if (!problem.plugin_missing || std::ranges::find(missing_, problem) != missing_.end())
        continue;
      missing_.push_back(problem);
      elsewhere_.push_back(to_problem(problem, variant == kBase ? "" : variant));
    }
    return lasting;
  }

  /// Throws unless the text is JSON, and not too much of it; then knows the variants.
  void prepare() {
    for (const JsonProblem& problem : document_.problems()) {
      found_.push_back(to_problem(to_scene_problem(problem, document_.name())));
    }
    throw_found();
    base_ = document_.root();
    if (base_.is_object()) base_.erase(kVariantsKey);
    find_variants();
    check_work();
  }

  void check_work() {
    double readings = 1;
    for (const auto& [name, changes] : variants_) {
      readings += 1 + static_cast<double>(changes.size());
    }
    const double work = readings * static_cast<double>(document_.bytes());
    if (work <= kMostWork && variants_.size() <= kMostVariants) return;
    SceneProblems problems(document_);
    problems.add(kVariants, "found " + std::to_string(variants_.size()) +
                                " variants of a scene of " + std::to_string(document_.bytes()) +
                                " bytes, which are too many: split the scene");
    note(problems.sorted(), kBase, {});
    throw_found();
  }

  void find_variants() {
    const Json& root = document_.root();
    if (!root.is_object() || !root.contains(kVariantsKey)) return;
    const Json& variants = root[kVariantsKey];
    SceneProblems problems(document_);
    if (!variants.is_object()) {
      problems.add(kVariants, "found " + shown(variants) + ", expected an object of variants");
    } else {
      for (const auto& variant : variants.items()) find_variant(variant, problems);
    }
    note(problems.sorted(), kBase, {});
  }

  template <class Item>
  void find_variant(const Item& variant, SceneProblems& problems) {
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

  /// Reads the base and every variant as the file has them. What is wrong with the base is not said
  /// again for the others.
  void check_all(const std::function<void(Reading&)>& take) {
    Reading base = read_one(kBase, {});
    const std::vector<SceneProblem> known = note_as_it_stands(base.problems, kBase, {});
    take(base);
    for (const auto& [name, changes] : variants_) {
      if (found_.size() >= SceneProblems::kMost) break;  // enough to read, and to repair
      Reading variant = read_one(name, {});
      (void)note_as_it_stands(variant.problems, name, known);
      take(variant);
    }
  }

  /// The wanted variant with replacements.
  Scene replaced(const std::vector<Replacement>& replacements, const std::string& wanted,
                 std::vector<SceneProblem> known) {
    const std::vector<SceneProblem> of_base = read_one(kBase, {}).problems;
    known.insert(known.end(), of_base.begin(), of_base.end());
    std::erase_if(known, is_of_missing_plugin);
    Reading reading = read_one(wanted, replacements);
    note(reading.problems, wanted, known);
    return std::move(reading.scene);
  }

  Reading read_one(const std::string& variant, const std::vector<Replacement>& replacements) {
    Json json = base_;
    SceneProblems problems(document_);
    for (const auto& [name, changes] : variants_) {
      if (name == variant) apply_variant(json, name, changes, problems);
    }
    for (const Replacement& replacement : replacements) {
      apply_replacement(json, replacement, problems);
    }
    std::vector<Replacement> changes = changes_of(variant);
    changes.insert(changes.end(), replacements.begin(), replacements.end());
    std::vector<std::string> dropped = drop_parameters(json, changes);
    Reading reading{read_scene_json(json, registry_, folder_, problems), problems.sorted()};
    Scene& scene = reading.scene;
    scene.changes = std::move(changes);
    scene.dropped = std::move(dropped);
    scene.file = file_;
    scene.variant = variant;
    for (const auto& named : variants_) scene.variants.push_back(named.first);
    scene.place = [document = shared_document_, places = problems.places()](
                      const std::string& pointer) { return places.of_change(pointer).source; };
    return reading;
  }

  void apply_variant(Json& json, const std::string& name, const Json& changes,
                     SceneProblems& problems) {
    const std::string pointer = child_pointer(kVariants, name);
    for (const auto& change : changes.items()) {
      const std::string source = child_pointer(pointer, change.key());
      const std::string why = apply(json, change.key(), change.value());
      if (why.empty()) {
        problems.places().moved(pointer_of_put(json, change.key()), source);
      } else {
        problems.add_at_key(source, why);
      }
    }
  }

  void apply_replacement(Json& json, const Replacement& replacement, SceneProblems& problems) {
    const auto value = replacement_value(replacement.value);
    const std::string why =
        !value ? "the value is not UTF-8" : apply(json, replacement.pointer, *value);
    if (why.empty()) {
      const std::string pointer = pointer_of_put(json, replacement.pointer);
      problems.places().moved_from_outside(pointer, replacement.source + ' ' + pointer);
    } else {
      problems.add_outside(replacement.source + ' ' + replacement.pointer, why);
    }
  }

  /// Removes the members that are unknown to a plugin which a change put in, and returns their
  /// pointers; those that a change says itself stay, to be refused. A reading that is thrown away
  /// tells which these are.
  std::vector<std::string> drop_parameters(Json& json, const std::vector<Replacement>& changes) {
    std::vector<std::string> owners, said, dropped;
    for (const Replacement& change : changes) {
      if (change.pointer.ends_with("/plugin")) owners.push_back(parent_pointer(change.pointer));
      if (!change.may_be_dropped) said.push_back(change.pointer);
    }
    if (owners.empty()) return dropped;
    SceneProblems ignored(document_);
    Json copy = json;
    (void)read_scene_json(copy, registry_, folder_, ignored);
    for (const std::string& unknown : ignored.unknown_keys()) {
      if (std::ranges::find(owners, parent_pointer(unknown)) == owners.end()) continue;
      if (std::ranges::any_of(said, [&](const std::string& s) { return is_within(s, unknown); }))
        continue;
      json[Json::json_pointer(parent_pointer(unknown))].erase(pointer_steps(unknown)->back());
      dropped.push_back(unknown);
    }
    return dropped;
  }

  [[nodiscard]] std::vector<Replacement> changes_of(const std::string& variant) const {
    std::vector<Replacement> all;
    for (const auto& [name, changes] : variants_) {
      if (name != variant) continue;
      for (const auto& change : changes.items()) {
        all.push_back({change.key(), change.value().dump(), false, "variant"});
      }
    }
    return all;
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

  std::shared_ptr<const JsonDocument> shared_document_;  // scenes keep it, for their messages
  const JsonDocument& document_;
  fs::path file_;
  fs::path folder_;
  const PluginRegistry& registry_;
  bool makes_parts_;
  Json base_;  // without variants
  std::vector<std::pair<std::string, Json>> variants_;
  /// The variant that is wanted without replacements, "" where there are some; none: all are.
  std::optional<std::string> as_it_stands_;
  std::vector<Problem> found_, elsewhere_;
  std::vector<SceneProblem> missing_;  // what elsewhere_ says
};

}  // namespace

long Scene::steps() const { return std::lround(duration / step); }

long Scene::frame_interval() const {
  constexpr long kFrames = 100;
  return frames_every > 0 ? frames_every : std::max(1L, (steps() + kFrames - 1) / kFrames);
}

Problem Scene::located(Problem problem) const {
  std::string front = (place ? place(problem.pointer) : file.string()) + ": ";
  if (variant != kBase) front += "variant \"" + variant + "\": ";
  if (!problem.message.starts_with(front)) problem.message = front + problem.message;
  return problem;
}

Scene read_scene(const fs::path& file, const PluginRegistry& registry,
                 const std::vector<Replacement>& replacements, const std::string& variant) {
  return SceneDocument(JsonDocument::read(file), file, registry, true).read(replacements, variant);
}

Scene read_scene_text(const std::string& text, const std::string& name, const fs::path& folder,
                      const PluginRegistry& registry, const std::vector<Replacement>& replacements,
                      const std::string& variant) {
  const fs::path file = folder / fs::path(name).filename();
  return SceneDocument(JsonDocument::parse(text, name), file, registry, false)
      .read(replacements, variant);
}

std::vector<Scene> read_variants(const fs::path& file, const PluginRegistry& registry) {
  return SceneDocument(JsonDocument::read(file), file, registry, true).read_all();
}

}  // namespace deform
