#include "scene/scene_rules.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "deform/plugin/setup.h"
#include "deform/simulation/scene.h"

#include "plugin/fields_of.h"
#include "scene/velocity_reader.h"

namespace deform {
namespace {

using Form = SceneSection::Form;

struct Title {
  std::string title;
  static void declare(Declaration<Title>& d) {
    d("title", &Title::title, "", "what the scene is, in a line");
  }
};

struct Duration {
  double duration = 0;
  static void declare(Declaration<Duration>& d) {
    d("duration", &Duration::duration, "s", "simulated time, at least one step")
        .required()
        .above(0);
  }
};

struct VelocityRules {
  Vec3 linear = Vec3::Zero(), spin = Vec3::Zero(), about = Vec3::Zero();
  static void declare(Declaration<VelocityRules>& d) {
    d(kLinear, &VelocityRules::linear, "m/s",
      "components of every free node's velocity at first, numbers or formulas of a1 and a2 [m]");
    d(kSpin, &VelocityRules::spin, "rad/s", "adds spin × (r − about)");
    d(kAbout, &VelocityRules::about, "m",
      "a point of the axis; the centre of mass of the initial state when absent");
  }
};

struct MaterialRules {
  std::string mass = kRest;
  double density = Material{}.density;
  double damping = Material{}.damping;
  double rayleigh_mass = Material{}.rayleigh_mass;
  double rayleigh_stiffness = Material{}.rayleigh_stiffness;
  static void declare(Declaration<MaterialRules>& d) {
    d("density", &MaterialRules::density, "kg/m²",
      "mu of (16), mass per area; when absent that of the sheet that an energy's 'material' names, "
      "if any does")
        .above(0);
    d("mass", &MaterialRules::mass, "",
      "the area that mass, damping and loads go by: rest, that of the rest surface; or parameters, "
      "that of a1 and a2, as in (16)")
        .one_of({kRest, kParameters});
    d("damping", &MaterialRules::damping, "N·s/m³", "gamma of (16), damping per area").at_least(0);
    d("rayleigh_mass", &MaterialRules::rayleigh_mass, "1/s",
      "damping force as a multiple of mass times velocity")
        .at_least(0);
    d("rayleigh_stiffness", &MaterialRules::rayleigh_stiffness, "s",
      "damping force as a multiple of stiffness times velocity: added to the retardation of every "
      "energy that has a potential")
        .at_least(0);
  }
};

struct Limits {
  double distance = Scene{}.max_distance;
  static void declare(Declaration<Limits>& d) {
    d("distance", &Limits::distance, "characteristic lengths",
      "a node farther than this from the rest state's centre means divergence")
        .above(0);
  }
};

struct CheckpointRules {
  std::int64_t every = Scene{}.checkpoint_every;
  double seconds = Scene{}.checkpoint_seconds;
  static void declare(Declaration<CheckpointRules>& d) {
    d("every", &CheckpointRules::every, "steps", "a checkpoint whenever so many are done; 0: never")
        .at_least(0);
    d("seconds", &CheckpointRules::seconds, "s",
      "a checkpoint whenever so much time went by; 0: never")
        .at_least(0);
  }
};

struct FrameRules {
  bool write = Scene{}.frames_written;
  std::int64_t every = Scene{}.frames_every;
  static void declare(Declaration<FrameRules>& d) {
    d("write", &FrameRules::write, "",
      "whether states are recorded for the report and for comparisons, in trajectory.bin");
    d("every", &FrameRules::every, "steps",
      "a frame whenever so many are done; 0: about a hundred a run")
        .at_least(0);
  }
};

struct ComparisonRules {
  std::string reference = Scene{}.reference;
  double tolerance = Scene{}.tolerance;
  bool base = Scene{}.base_compared;
  static void declare(Declaration<ComparisonRules>& d) {
    d("reference", &ComparisonRules::reference, "",
      "the variant that the others are measured against, or refined: the scene on a grid twice as "
      "fine with a quarter of the step");
    d("tolerance", &ComparisonRules::tolerance, "characteristic lengths",
      "the distance from the reference at which a variant parts from it")
        .above(0);
    d("base", &ComparisonRules::base, "",
      "whether the unchanged scene is a run, too, where there are variants");
  }
};

template <class Rules>
const ParameterFields& declared() {
  static const ParameterFields fields = fields_of<Rules>();
  return fields;
}

template <class Rules>
constexpr SceneSection value(std::string_view name) {
  return {.name = name, .form = Form::value, .fields = declared<Rules>};
}

template <class Rules>
constexpr SceneSection object(std::string_view name) {
  return {.name = name, .form = Form::object, .fields = declared<Rules>};
}

template <class Rules>
constexpr SceneSection object_of_comparison(std::string_view name) {
  return {.name = name, .form = Form::object, .fields = declared<Rules>, .of_run = false};
}

constexpr SceneSection one(PluginKind kind) {
  return {.name = name_of(kind), .form = Form::plugin, .kind = kind, .required = true};
}

constexpr SceneSection at_most_one(PluginKind kind) {
  return {.name = name_of(kind), .form = Form::plugin, .kind = kind};
}

constexpr SceneSection any_number(PluginKind kind) {
  return {.name = plural_of(kind), .form = Form::plugins, .kind = kind};
}

constexpr std::array kSections{
    SceneSection{.name = "$schema", .form = Form::note},
    value<Title>("title"),
    one(PluginKind::surface),
    object<MaterialRules>("material"),
    any_number(PluginKind::energy),
    any_number(PluginKind::force),
    any_number(PluginKind::constraint),
    any_number(PluginKind::collider),
    SceneSection{.name = "velocity", .form = Form::velocity, .fields = declared<VelocityRules>},
    one(PluginKind::integrator),
    value<Duration>("duration"),
    at_most_one(PluginKind::solver),
    object<Limits>("limits"),
    object<CheckpointRules>("checkpoint"),
    object<FrameRules>("frames"),
    any_number(PluginKind::output),
    any_number(PluginKind::probe),
    SceneSection{.name = "shadow", .form = Form::shadows, .kind = PluginKind::normal},
    object_of_comparison<ComparisonRules>("comparison"),
    SceneSection{.name = "variants", .form = Form::variants},
};

/// Kinds of which only parameters of other plugins name any.
constexpr std::array kNestedKinds{PluginKind::shape, PluginKind::normal};

constexpr auto names_parts_of(PluginKind kind) {
  return [kind](const SceneSection& s) { return s.names_parts() && s.kind == kind; };
}

static_assert(std::ranges::all_of(kPluginKinds,
                                  [](PluginKind kind) {
                                    return std::ranges::count_if(kSections, names_parts_of(kind)) +
                                               std::ranges::count(kNestedKinds, kind) ==
                                           1;
                                  }),
              "plugins of a kind stand at one key of the scene, or in parameters alone");

}  // namespace

std::span<const SceneSection> scene_sections() { return kSections; }

const SceneSection* section_of(PluginKind kind) {
  const auto found = std::ranges::find_if(kSections, names_parts_of(kind));
  return found == kSections.end() ? nullptr : &*found;
}

}  // namespace deform
