/// Plugins come in here as anything, and leave as what their kind promises. So this file, alone in
/// this folder, sees all interfaces.
#include "host/interface_check.h"

#include <utility>

#include "deform/error.h"
#include "deform/model/collider.h"
#include "deform/model/constraint.h"
#include "deform/model/energy_term.h"
#include "deform/model/force_field.h"
#include "deform/model/normal_estimator.h"
#include "deform/record/output.h"
#include "deform/record/probe.h"
#include "deform/solve/integrator.h"
#include "deform/solve/linear_solver.h"
#include "deform/surface/shape.h"
#include "deform/surface/surface.h"

#include "host/guarded_parts.h"
#include "surface/surface_check.h"

namespace deform {
namespace {

#define DEFORM_AGREES(name, plural, Interface) \
  static_assert(Interface::kKind == PluginKind::name, "the interface names another kind");
DEFORM_PLUGIN_KINDS(DEFORM_AGREES)
#undef DEFORM_AGREES

/// Most objects are guarded by those who call them.
template <class Interface>
std::shared_ptr<Plugin> guarded_part(std::shared_ptr<Interface> object,
                                     const std::string& /*origin*/) {
  return object;
}
std::shared_ptr<Plugin> guarded_part(std::shared_ptr<Shape> shape, const std::string& origin) {
  return std::make_shared<GuardedShape>(origin, std::move(shape));
}
std::shared_ptr<Plugin> guarded_part(std::shared_ptr<NormalEstimator> normal,
                                     const std::string& origin) {
  return std::make_shared<GuardedNormal>(origin, std::move(normal));
}
std::shared_ptr<Plugin> guarded_part(std::shared_ptr<Surface> surface, const std::string& origin) {
  check_surface(*surface, origin);
  return surface;
}

using Check = std::shared_ptr<Plugin> (*)(std::shared_ptr<Plugin>, const std::string& origin);

template <class Interface>
std::shared_ptr<Plugin> checked(std::shared_ptr<Plugin> object, const std::string& origin) {
  auto part = std::dynamic_pointer_cast<Interface>(std::move(object));
  if (!part) {
    throw PluginFailure(origin + " made an object that is no " +
                        std::string(name_of(Interface::kKind)) + " plugin");
  }
  return guarded_part(std::move(part), origin);
}

constexpr auto kChecks = per_kind<Check>([]<class Interface>() { return checked<Interface>; });

}  // namespace

std::shared_ptr<Plugin> through_interface(std::shared_ptr<Plugin> object, PluginKind kind,
                                          const std::string& origin) {
  return kChecks[kind](std::move(object), origin);
}

}  // namespace deform
