/// What a plugin's constructor is given to look at.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "deform/error.h"
#include "deform/export.h"
#include "deform/plugin/plugin.h"
#include "deform/plugin/values.h"
#include "deform/types.h"

namespace deform {

class Surface;
class Geometry;
class SampleSet;

/// What mass, damping and loads per area and length are of.
enum class AreaOf : std::uint8_t {
  rest,       ///< the rest surface
  parameters  ///< the rectangle of a1 and a2, as in (16)
};

/// Mass and damping per area as in (16), and Rayleigh's damping.
struct Material {
  double density = 0.1;             ///< mu [kg/m²]
  double damping = 0.0;             ///< gamma [N·s/m³]
  double rayleigh_mass = 0.0;       ///< damping force as a multiple of mass · velocity [1/s]
  double rayleigh_stiffness = 0.0;  ///< and of stiffness · velocity [s], for all energies
  AreaOf mass = AreaOf::rest;
};

/// (N) Areas of a surface's nodes that a material's mass goes by [m²].
[[nodiscard]] DEFORM_API NodeValues areas_of_mass(const Surface& surface, const Material& material);

/// The world at the time when a plugin object is made. Surfaces and shapes are made before there is
/// a surface: they get a Setup without one.
class DEFORM_API Setup {
 public:
  /// Makes an object of the use's kind, as PluginRegistry::create does; never null.
  using Factory = std::function<std::shared_ptr<Plugin>(const PluginUse&, const Setup&)>;

  explicit Setup(Factory factory) : factory_(std::move(factory)) {}

  /// Throws Error when there is none yet (in the constructor of a surface or shape).
  [[nodiscard]] const Surface& surface() const;
  /// (N × 3) rest positions of this simulation [m] (mirrored in a mirrored run: not the surface's
  /// own).
  [[nodiscard]] const NodeVectors& rest() const;
  [[nodiscard]] const Material& material() const { return material_; }
  /// (N) area that each node stands for [m²], of the rest surface or of the parameters as the
  /// scene's material says: what masses and loads per area go by. To be copied: it lasts while the
  /// plugin is made.
  [[nodiscard]] const NodeValues& areas() const;
  /// Relative file names in a scene start from its folder.
  [[nodiscard]] std::filesystem::path resolve(const std::filesystem::path& file) const;

  /// Makes a plugin that a parameter names, e.g. setup.create<NormalEstimator>(parameters.normal).
  template <class Interface>
  [[nodiscard]] std::shared_ptr<Interface> create(const PluginUse& use) const {
    require_kind(use, Interface::kKind);
    return std::static_pointer_cast<Interface>(create_any(use));
  }

  /// The selected nodes, ascending, each once. Throws InputError when there are none.
  [[nodiscard]] std::vector<Index> select(const NodeSelection& where) const;

  /// All must outlive the Setup.
  Setup& with_surface(const Surface& surface, const NodeVectors& rest, const NodeValues& areas);
  Setup& with_material(const Material& material);
  Setup& with_folder(std::filesystem::path folder);

 private:
  [[nodiscard]] std::shared_ptr<Plugin> create_any(const PluginUse& use) const;

  Factory factory_;
  const Surface* surface_ = nullptr;
  const NodeVectors* rest_ = nullptr;
  const NodeValues* areas_ = nullptr;
  Material material_;
  std::filesystem::path folder_;
};

}  // namespace deform
