#include "deform/model/materials.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deform/error.h"

namespace deform {
namespace {

using testing::HasSubstr;

TEST(SheetMaterials, AreFoundByName) {
  EXPECT_EQ(sheet_material("steel").young, 2.1e11);
  EXPECT_EQ(sheet_material_names().size(), sheet_materials().size());
  try {
    (void)sheet_material("papr");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "there is no material \"papr\"; did you mean \"paper\"?");
  }
}

// What the table says of a sheet must fit together: the isotropic plate lies between the
// directions, and a plate can be no thicker than the sheet.
TEST(SheetMaterials, AgreeWithThemselves) {
  for (const SheetMaterial& m : sheet_materials()) {
    SCOPED_TRACE(m.name);
    EXPECT_GT(m.young, 0);
    EXPECT_GT(m.poisson, 0);
    EXPECT_LT(m.poisson, 0.5);
    EXPECT_LE(m.thickness, m.caliper);
    EXPECT_FALSE(m.source.empty());
    if (!m.directions) continue;
    const double mean = std::sqrt(m.directions->young_1 * m.directions->young_2);
    EXPECT_NEAR(m.young, mean, 0.02 * mean);  // both are rounded to two digits
  }
}

// What the figures were made from, in the units in which they are measured.
TEST(SheetMaterials, HaveTheMeasuredStiffness) {
  const double gf = 9.80665e-3, cm = 1e-2, degree = std::acos(-1.0) / 180;
  const struct {
    const char* name;
    double B, G, emt_1, emt_2, mass;  // KES: gf cm²/cm, gf/(cm deg), 1 at 500 gf/cm; kg/m²
  } cloths[] = {{"wool", 0.10, 0.7, 0.04, 0.07, 0.2}, {"silk", 0.03, 0.35, 0.03, 0.06, 0.065}};
  for (const auto& cloth : cloths) {
    SCOPED_TRACE(cloth.name);
    const SheetMaterial& m = sheet_material(cloth.name);
    const double two_digits = 0.05;
    const auto expect = [&](double found, double expected) {
      EXPECT_NEAR(found, expected, two_digits * expected);
    };
    expect(m.bending_rigidity(), cloth.B * gf * cm);
    expect(m.directions->shear * m.thickness, cloth.G * gf / cm / degree);
    expect(m.directions->young_1 * m.thickness, 500 * gf / cm / cloth.emt_1);
    expect(m.directions->young_2 * m.thickness, 500 * gf / cm / cloth.emt_2);
    expect(m.mass_per_area(), cloth.mass);
  }
  const auto shear = [](const char* name) { return *sheet_material(name).directions; };
  for (const char* name : {"paper", "cardboard"}) {  // Baum et al.
    const SheetDirections d = shear(name);
    EXPECT_NEAR(d.shear, 0.387 * std::sqrt(d.young_1 * d.young_2), 0.01 * d.shear);
  }
}

std::string figure(double value) { return fmt::format("{:.3g}", value); }

std::string row(const SheetMaterial& m) {
  const auto direction = [&](double SheetDirections::*which) {
    return m.directions ? figure(*m.directions.*which) : "";
  };
  return fmt::format("| `{}` | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |", m.name,
                     m.summary, figure(m.young), figure(m.poisson), figure(m.thickness),
                     figure(m.caliper), figure(m.density), direction(&SheetDirections::young_1),
                     direction(&SheetDirections::young_2), direction(&SheetDirections::shear),
                     figure(m.membrane_stiffness()), figure(m.bending_rigidity()));
}

TEST(SheetMaterials, AreTheDocumentedOnes) {
  const auto file = std::filesystem::path(DEFORM_SCENES).parent_path() / "docs/materials.md";
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  for (const SheetMaterial& m : sheet_materials()) {
    EXPECT_THAT(text.str(), HasSubstr(row(m)));
    EXPECT_THAT(text.str(), HasSubstr("- `" + m.name + "`: " + m.source + "."));
  }
}

}  // namespace
}  // namespace deform
