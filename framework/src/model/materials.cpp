#include "deform/model/materials.h"

#include <algorithm>

#include "deform/error.h"

#include "text/nearest_name.h"

namespace deform {
namespace {

// Paper: ISO 534 and 536 say how thickness and mass are measured, ISO 1924-2 how Young's modulus
// is; in-plane shear is 0.387 √(E_1 E_2) for all sorts (Baum et al.), from which follows the
// isotropic Poisson's ratio 1/(2 · 0.387) − 1 = 0.29 that has the same shear; the isotropic E is
// √(E_1 E_2).
//
// Cloth: from the figures of Kawabata's evaluation system (KES), with E_i thickness = 490 N/m (500
// gf/cm) / EMT_i, and the thickness for which the plate has the measured bending rigidity.
// Wool: EMT 4 % and 7 %, B 0.10 gf cm²/cm (9.8e-6 N·m), G 0.7 gf/(cm deg) (39 N/m).
// Silk: EMT 3 % and 6 %, B 0.03 gf cm²/cm (2.9e-6 N·m), G 0.35 gf/(cm deg) (20 N/m).
// Isotropic: E = √(E_1 E_2). Cloth has no Poisson's ratio worth the name: 0.2 is a habit.
const char* const kKawabata =
    "typical of such cloth in KES, see S. Kawabata, The Standardization and Analysis of "
    "Hand Evaluation, 2nd ed., Textile Machinery Society of Japan, Osaka 1980";

std::vector<SheetMaterial> make_materials() {
  return {
      {.name = "paper",
       .summary = "copy paper, 80 g/m²",
       .young = 3.5e9,
       .poisson = 0.29,
       .thickness = 1e-4,
       .caliper = 1e-4,
       .density = 800,
       .directions = SheetDirections{5.0e9, 2.5e9, 1.37e9},
       .source =
           "typical of office paper, see K. Niskanen (ed.), Paper Physics, Fapet 1998; shear: "
           "G. A. Baum, D. C. Brennan, C. C. Habeger, Orthotropic elastic constants of "
           "paper, Tappi 64 (1981) 97-101"},
      {.name = "cardboard",
       .summary = "solid paperboard, 375 g/m²",
       .young = 3.3e9,
       .poisson = 0.29,
       .thickness = 5e-4,
       .caliper = 5e-4,
       .density = 750,
       .directions = SheetDirections{5.6e9, 2.0e9, 1.3e9},
       .source =
           "typical of boxboard, see Q. S. Xia, M. C. Boyce, D. M. Parks, A constitutive model "
           "for the anisotropic elastic-plastic deformation of paper and paperboard, Int. J. "
           "Solids Struct. 39 (2002) 4053-4071"},
      {.name = "wool",
       .summary = "woven suiting, 200 g/m²",
       .young = 8.4e7,
       .poisson = 0.2,
       .thickness = 1.1e-4,
       .caliper = 6e-4,
       .density = 333,
       .directions = SheetDirections{1.1e8, 6.4e7, 3.5e5},
       .source = kKawabata},
      {.name = "silk",
       .summary = "plain woven dress cloth, 65 g/m²",
       .young = 2.1e8,
       .poisson = 0.2,
       .thickness = 5.4e-5,
       .caliper = 2e-4,
       .density = 325,
       .directions = SheetDirections{3.0e8, 1.5e8, 3.7e5},
       .source = kKawabata},
      {.name = "rubber",
       .summary = "natural rubber without filler, at small strains",
       .young = 1.2e6,
       .poisson = 0.49,
       .thickness = 1e-3,
       .caliper = 1e-3,
       .density = 930,
       .directions = std::nullopt,
       .source = "shear modulus 0.4 MPa, E = 3 G: L. R. G. Treloar, The Physics of Rubber "
                 "Elasticity, 3rd ed., Clarendon Press, Oxford 1975"},
      {.name = "steel",
       .summary = "structural steel, thin sheet",
       .young = 2.1e11,
       .poisson = 0.3,
       .thickness = 5e-4,
       .caliper = 5e-4,
       .density = 7850,
       .directions = std::nullopt,
       .source = "EN 1993-1-1, 3.2.6; density: EN 1991-1-1, annex A"},
  };
}

}  // namespace

const std::vector<SheetMaterial>& sheet_materials() {
  static const std::vector<SheetMaterial> materials = make_materials();
  return materials;
}

std::vector<std::string> sheet_material_names() {
  std::vector<std::string> names;
  for (const SheetMaterial& material : sheet_materials()) names.push_back(material.name);
  return names;
}

const SheetMaterial& sheet_material(const std::string& name) {
  const auto& all = sheet_materials();
  const auto found = std::ranges::find(all, name, &SheetMaterial::name);
  if (found == all.end())
    throw InputError("there is no material \"" + name + '"' +
                     did_you_mean(name, sheet_material_names()));
  return *found;
}

}  // namespace deform
