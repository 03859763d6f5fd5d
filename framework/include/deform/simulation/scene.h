/// Scenes: what a JSON file says, checked and complete.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "deform/export.h"
#include "deform/plugin/field.h"
#include "deform/plugin/registry.h"
#include "deform/plugin/setup.h"

namespace deform {

/// A value to put at a JSON pointer before the scene is checked (`--set`); the text is JSON, else a
/// string. A pointer that ends with /- puts it behind the last item of a list.
///
/// Where a variant or a replacement puts another plugin in (/…/plugin), parameters that this one
/// does not have, which were said to the one before, are dropped: see Scene::dropped. Those that a
/// variant or a replacement says itself are refused, unless `may_be_dropped`.
struct Replacement {
  std::string pointer;
  std::string value;
  bool may_be_dropped = false;   ///< as in a grid, where some plugins have the parameter
  std::string source = "--set";  ///< who says so, for messages
};

/// A normal estimator that is evaluated beside an energy term's own, on the same states.
struct ShadowUse {
  std::string name;      ///< the estimator's, unique among the scene's shadows: "gauss_2"
  PluginUse normal;      ///< the estimator
  std::size_t term = 0;  ///< number of the term within the scene's energies
  PluginUse energy;      ///< the term with this estimator in place of its own
};

/// Velocities at first: linear + spin × (r − about).
struct InitialVelocity {
  std::array<Field, 3> linear;  ///< x, y, z [m/s]
  Vec3 spin = Vec3::Zero();     ///< [rad/s]
  std::optional<Vec3> about;    ///< [m]; none: the centre of mass of the initial state
};

/// A file that a scene names: the map of a field, the positions of a shape.
struct SceneFile {
  std::string pointer;         ///< where the scene says it
  std::filesystem::path path;  ///< absolute
};

/// A scene with defaults filled in; every plugin that it names exists and every parameter is in
/// range.
struct DEFORM_API Scene {
  std::filesystem::path file;
  std::string variant = "base";
  std::string title;
  /// Those at the keys of the scene, in the order of the text: one surface, one integrator, one
  /// solver or none (then the matrix' properties choose), any number of other kinds. Plugins in the
  /// parameters of others are there alone.
  PerKind<std::vector<PluginUse>> plugins;
  Material material;
  bool density_is_given = false;      ///< else a sheet that an energy's material names may have one
  double step = 0;                    ///< [s]
  double duration = 0;                ///< [s]
  std::vector<ShadowUse> shadows;     ///< of each estimator, one a term that takes one
  InitialVelocity velocity;           ///< of every free component
  double max_distance = 10;           ///< diverged beyond it, in characteristic lengths
  long checkpoint_every = 0;          ///< steps between checkpoints; 0: not by steps
  double checkpoint_seconds = 30;     ///< time between checkpoints [s]; 0: not by time
  bool frames_written = true;         ///< whether there is a trajectory.bin
  long frames_every = 0;              ///< steps between its frames; 0: see frame_interval
  std::string reference = "base";     ///< of comparisons: a variant's name, or "refined"
  bool base_compared = true;          ///< of comparisons: whether the base is one of the runs
  double tolerance = 0.01;            ///< of comparisons: distance at which variants part, in sizes
  std::vector<std::string> variants;  ///< names in the order of the file; without "base"
  std::vector<Replacement> changes;   ///< made to the base: the variant's, then replacements
  std::vector<std::string> dropped;   ///< pointers of parameters that a plugin put in has not
  std::string completed;              ///< the scene as JSON text with every default written out
  std::vector<SceneFile> files;       ///< that it names, in the order of the text

  /// Where the value at a JSON pointer was written: "FILE:LINE:COLUMN" or "--set POINTER".
  std::function<std::string(const std::string& pointer)> place;
  /// What is wrong with the base or another variant and is of no concern to this one: plugins that
  /// are not there. Each with its place, as problems have it.
  std::vector<Problem> elsewhere;

  [[nodiscard]] const PluginUse& surface() const { return plugins[PluginKind::surface].front(); }
  [[nodiscard]] const PluginUse& integrator() const {
    return plugins[PluginKind::integrator].front();
  }
  [[nodiscard]] long steps() const;           ///< duration / step, rounded
  [[nodiscard]] long frame_interval() const;  ///< steps between frames: about a hundred, if unsaid
  /// A problem that shows only when the scene's parts are made, with its place in front of the
  /// message as the problems of the reader have it.
  [[nodiscard]] Problem located(Problem problem) const;
};

/// Reads and checks a scene. Throws InputError with every problem of the file, each with
/// `FILE:LINE:COLUMN` where it has a place; and then also those that only show when surface,
/// forces and the like are made, as far as nothing else is wrong with them.
[[nodiscard]] DEFORM_API Scene read_scene(const std::filesystem::path& file,
                                          const PluginRegistry& registry,
                                          const std::vector<Replacement>& replacements = {},
                                          const std::string& variant = "base");
/// The same for text, without making anything; relative file names start from `folder`.
[[nodiscard]] DEFORM_API Scene read_scene_text(const std::string& text, const std::string& name,
                                               const std::filesystem::path& folder,
                                               const PluginRegistry& registry,
                                               const std::vector<Replacement>& replacements = {},
                                               const std::string& variant = "base");

/// The base and all variants of a scene, in the order of the file. Throws as read_scene does.
[[nodiscard]] DEFORM_API std::vector<Scene> read_variants(const std::filesystem::path& file,
                                                          const PluginRegistry& registry);

/// JSON Schema (draft 2020-12, as text) of scenes, with the parameters of every plugin that is
/// found; one that does not load is left out, which the log says. It accepts whatever read_scene
/// accepts; what no schema can say (names of nodes, sizes, files, what variants lead to) is left
/// to read_scene and `check`.
[[nodiscard]] DEFORM_API std::string scene_schema(const PluginRegistry& registry);

}  // namespace deform
