#include "deform/plugin/registry.h"

#include "plugin/fields_of.h"

namespace deform {
namespace {

struct IntegratorCommon {
  double step = 0;
  static void declare(Declaration<IntegratorCommon>& d) {
    d("step", &IntegratorCommon::step, "s", "time from one state to the next").required().above(0);
  }
};

struct EnergyCommon {
  double retardation = 0;
  static void declare(Declaration<EnergyCommon>& d) {
    d("retardation", &EnergyCommon::retardation, "s",
      "damping of the material (Kelvin–Voigt): strain rates times this are resisted as strains are")
        .at_least(0);
  }
};

struct ColliderCommon {
  double friction = 0.3, thickness = 0;
  static void declare(Declaration<ColliderCommon>& d) {
    d("friction", &ColliderCommon::friction, "", "Coulomb's coefficient; 0: none").at_least(0);
    d("thickness", &ColliderCommon::thickness, "m", "distance that nodes keep from the body")
        .at_least(0);
  }
};

struct RecorderCommon {
  std::int64_t every = 1;
  static void declare(Declaration<RecorderCommon>& d) {
    d("every", &RecorderCommon::every, "steps", "how often it is due").at_least(1);
  }
};

}  // namespace

const ParameterFields& common_fields(PluginKind kind) {
  static const ParameterFields none;
  static const ParameterFields energy = fields_of<EnergyCommon>();
  static const ParameterFields integrator = fields_of<IntegratorCommon>();
  static const ParameterFields recorder = fields_of<RecorderCommon>();
  static const ParameterFields collider = fields_of<ColliderCommon>();
  switch (kind) {
    case PluginKind::energy:
      return energy;
    case PluginKind::collider:
      return collider;
    case PluginKind::integrator:
      return integrator;
    case PluginKind::output:
    case PluginKind::probe:
      return recorder;
    default:
      return none;
  }
}

}  // namespace deform
