/// Parameters that the framework itself reads for every plugin of a kind, beside the plugin's own.
#pragma once

#include <cstdint>

#include "deform/plugin/declaration.h"

namespace deform {

/// Of an interface's kind. None, unless it is said here.
template <class Interface>
struct CommonParameters {
  static void declare(Declaration<CommonParameters>& /*declaration*/) {}
};

template <>
struct CommonParameters<EnergyTerm> {
  double retardation = 0;
  static void declare(Declaration<CommonParameters>& d) {
    d("retardation", &CommonParameters::retardation, "s",
      "damping of the material (Kelvin–Voigt): strain rates times this are resisted as strains are")
        .at_least(0);
  }
};

template <>
struct CommonParameters<Collider> {
  double friction = 0.3, thickness = 0, restitution = 0;
  std::vector<double> times;
  std::vector<Vec3> displacements, rotations;
  Vec3 pivot = Vec3::Zero();
  static void declare(Declaration<CommonParameters>& d) {
    d("friction", &CommonParameters::friction, "", "Coulomb's coefficient; 0: none").at_least(0);
    d("thickness", &CommonParameters::thickness, "m", "distance that nodes keep from the body")
        .at_least(0);
    d("restitution", &CommonParameters::restitution, "",
      "part of the speed of approach that an impact gives back (Newton's law); 0: none")
        .at_least(0)
        .at_most(1);
    d("times", &CommonParameters::times, "s",
      "when the body is displaced and turned as the lists say, ascending; linear between, constant "
      "before and after; empty: it stays");
    d("displacements", &CommonParameters::displacements, "m", "of the body, one for each time");
    d("rotations", &CommonParameters::rotations, "rad",
      "of the body about its pivot, one for each time: axis times angle");
    d("pivot", &CommonParameters::pivot, "m", "place that rotations leave, moved by displacements");
  }
};

template <>
struct CommonParameters<Integrator> {
  double step = 0;
  static void declare(Declaration<CommonParameters>& d) {
    d("step", &CommonParameters::step, "s", "time from one state to the next").required().above(0);
  }
};

/// Of what records a run.
struct RecorderParameters {
  std::int64_t every = 1;
  template <class Parameters>
  static void declare(Declaration<Parameters>& d) {
    d("every", &RecorderParameters::every, "steps", "how often it is due").at_least(1);
  }
};
template <>
struct CommonParameters<Output> : RecorderParameters {};
template <>
struct CommonParameters<Probe> : RecorderParameters {};

/// Those that a scene gives to a plugin of the interface's kind.
template <class Interface>
[[nodiscard]] CommonParameters<Interface> common_parameters(const PluginUse& use) {
  CommonParameters<Interface> parameters;
  if (use.parameters == nullptr) return parameters;
  Declaration<CommonParameters<Interface>> declaration(parameters, *use.parameters);
  CommonParameters<Interface>::declare(declaration);
  return parameters;
}

}  // namespace deform
