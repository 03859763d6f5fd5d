/// Sheets of common materials, with typical figures from the literature.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "deform/export.h"

namespace deform {

/// What a woven or rolled sheet has along its two directions: machine and cross direction of paper,
/// warp and weft of cloth. Moduli belong to the material's `thickness`.
struct SheetDirections {
  double young_1 = 0;  ///< machine direction, or warp [Pa]
  double young_2 = 0;  ///< cross direction, or weft [Pa]
  double shear = 0;    ///< in the sheet's plane [Pa]
};

/// A sheet as the homogeneous, isotropic plate that stretches and bends alike: young · thickness is
/// its membrane stiffness, young · thickness³/(12 (1 − poisson²)) its bending rigidity. Threads of
/// cloth slide on each other: it bends as a much thinner plate, and `thickness` is that plate's.
struct SheetMaterial {
  std::string name;     ///< what scenes call it
  std::string summary;  ///< which sheet is meant
  double young = 0;     ///< [Pa]
  double poisson = 0;
  double thickness = 0;  ///< of the plate that bends alike [m]
  double caliper = 0;    ///< what a gauge measures [m]
  double density = 0;    ///< mass per measured volume [kg/m³]
  std::optional<SheetDirections> directions;
  std::string source;

  [[nodiscard]] double mass_per_area() const { return density * caliper; }  ///< [kg/m²]
  /// Of a sheet of the same make whose plate is of another thickness [m], in proportion [kg/m²].
  [[nodiscard]] double mass_per_area(double of_thickness) const {
    return mass_per_area() * (of_thickness / thickness);
  }
  [[nodiscard]] double membrane_stiffness() const { return young * thickness; }  ///< [N/m]
  [[nodiscard]] double bending_rigidity() const {                                ///< [N·m]
    return young * thickness * thickness * thickness / (12 * (1 - poisson * poisson));
  }
};

[[nodiscard]] DEFORM_API const std::vector<SheetMaterial>& sheet_materials();
/// Their names, for a parameter's one_of().
[[nodiscard]] DEFORM_API std::vector<std::string> sheet_material_names();
/// Throws InputError, with the nearest name, when there is none of this name.
[[nodiscard]] DEFORM_API const SheetMaterial& sheet_material(const std::string& name);

}  // namespace deform
