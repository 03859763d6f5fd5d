/// Mass, damping and loads go by the area of the rest surface, whatever its parameters are.
#include <cmath>
#include <numbers>
#include <string>

#include "deform/solve/newton_matrix.h"

#include "model/support/simulate.h"

namespace deform {
namespace {

using std::numbers::pi;
using test::simulation_from_text;

std::string scene(const std::string& surface, const std::string& rest,
                  const std::string& material = R"({"density": 2})") {
  return R"({"surface": {"plugin": "grid", )" + surface + R"(, "rest": )" + rest +
         R"(}, "material": )" + material +
         R"(, "forces": [{"plugin": "gravity", "acceleration": [0, 0, -1]}],
             "integrator": {"plugin": "symplectic_euler", "step": 1}, "duration": 1})";
}

double weight(const std::string& surface, const std::string& rest) {
  Simulation s = simulation_from_text(scene(surface, rest));
  return -s.system().terms().external_force(s.state()).col(2).sum();
}

struct Case {
  std::string name, surface, rest;
  double area;  // [m²]
};

/// To 0.1 %, with few nodes around a circle.
TEST(RestArea, WeightIsThatOfTheRestSurface) {
  const std::string square = R"("nodes": [17, 13], "size": [1, 1])",
                    long_way = R"("nodes": [17, 33], "size": [2, 0.5])";
  const double latitude = 72 * pi / 180;
  const std::vector<Case> cases{
      {"torus", R"("nodes": [33, 33], "size": [1, 1], "periodic": true)",
       R"({"plugin": "torus", "radius": 1, "tube": 0.3})", 4 * pi * pi * 0.3},
      {"thick torus, few nodes", R"("nodes": [11, 11], "size": [1, 1], "periodic": true)",
       R"({"plugin": "torus", "radius": 1, "tube": 0.9})", 4 * pi * pi * 0.9},
      {"hemisphere", R"("nodes": [33, 9], "size": [1, 1], "periodic": [true, false])",
       R"({"plugin": "hemisphere", "radius": 2, "hole": 18})", 4 * 2 * pi * std::sin(latitude)},
      {"sector of it", square, R"({"plugin": "hemisphere", "radius": 2, "hole": 18, "sector": 90})",
       4 * 0.5 * pi * std::sin(latitude)},
      {"sphere patch", square, R"({"plugin": "sphere_patch", "radius": 0.6})",
       2 * 0.6 * std::sin(0.5 / 0.6)},
      {"slope", square, R"s({"plugin": "formula", "z": "a1"})s", std::sqrt(2)},
      {"uneven, flat", square,
       R"s({"plugin": "formula", "x": "a1+0.1*sin(2*pi*a1)", "y": "a2*(1+a2)"})s", 2},
      {"cylinder, uneven", long_way,
       R"s({"plugin": "formula", "x": "sin(a1+a1^2/4)", "y": "3*a2", "z": "cos(a1+a1^2/4)"})s",
       3 * 1.5},
      {"flat", long_way, R"({"plugin": "flat"})", 1}};
  for (const Case& c : cases)
    for (const char* differences :
         {R"(, "differences": "symmetric")", R"(, "differences": "forward", "border": "paper")"})
      EXPECT_NEAR(weight(c.surface + differences, c.rest) / (2 * c.area), 1, 1e-3) << c.name;
}

/// Creases along lines of nodes, and heights that have nothing to do with each other: the area is
/// that of the facets, which polynomials across them would miss by percents.
TEST(RestArea, CreasedSurfacesHaveTheAreaOfTheirFacets) {
  for (const char* nodes : {"[5, 5]", "[9, 9]", "[17, 17]"}) {
    const std::string square = R"("size": [1, 1], "nodes": )" + std::string(nodes);
    const double gable = weight(square, R"s({"plugin": "formula", "z": "abs(a1-0.5)"})s");
    EXPECT_NEAR(gable / (2 * std::sqrt(2)), 1, 1e-12) << nodes;
    const double bent = weight(square, R"s({"plugin": "formula", "z": "4*max(0, a1-0.5)"})s");
    EXPECT_NEAR(bent / (1 + std::sqrt(17)), 1, 1e-12) << nodes;
  }
  // Heights of ±0.02 m in turn, as far apart as nodes are.
  const double rough =
      weight(R"("size": [1, 1], "nodes": [26, 26])",
             R"s({"plugin": "formula", "z": "0.02*cos(25*pi*a1)*cos(25*pi*a2)"})s");
  double facets = 0;  // bilinear, by the rule of Gauss
  for (const double p : {0.5 - std::sqrt(0.75) / 3, 0.5 + std::sqrt(0.75) / 3})
    for (const double q : {0.5 - std::sqrt(0.75) / 3, 0.5 + std::sqrt(0.75) / 3})
      facets += 0.25 * Vec3(1, 0, (1 - 2 * q)).cross(Vec3(0, 1, (1 - 2 * p))).norm();
  EXPECT_NEAR(rough / (2 * facets), 1, 1e-9);
}

/// Where a1 and a2 are lengths nothing is multiplied, wherever the sheet lies.
TEST(RestArea, FlatSheetsHaveExactlyTheirParametersArea) {
  for (const char* rest :
       {R"({"plugin": "flat"})", R"s({"plugin": "formula", "x": "a1+1024", "z": "7"})s",
        R"s({"plugin": "formula", "x": "0.6*a1", "y": "a2", "z": "0.8*a1"})s"})
    for (const char* weights : {"area", "equal"}) {
      const std::string surface =
          std::string(R"("nodes": [31, 17], "size": [0.7, 0.3], "differences": "forward",
                         "weights": ")") +
          weights + '"';
      Simulation s =
          simulation_from_text(scene(surface, rest, R"({"density": 0.3, "damping": 2})"));
      const NodeValues& areas = s.system().surface().areas();
      EXPECT_EQ(s.system().areas(), areas) << rest;
      EXPECT_EQ(s.system().mass(), NodeValues(0.3 * areas)) << rest;
      EXPECT_EQ(s.system().damping(), NodeValues(2 * areas)) << rest;
    }
}

/// (16) of the paper counts mass and damping by parameter area.
TEST(RestArea, ParametersAreAChoice) {
  Simulation s = simulation_from_text(
      scene(R"("nodes": [9, 9], "size": [1, 1], "periodic": true)",
            R"({"plugin": "torus", "radius": 1, "tube": 0.3})",
            R"({"density": 2, "damping": 3, "rayleigh_mass": 0.5, "mass": "parameters"})"));
  EXPECT_NEAR(s.system().mass().sum(), 2, 1e-12);
  EXPECT_NEAR(s.system().damping().sum(), 4, 1e-12);
  try {
    (void)simulation_from_text(
        scene(R"("nodes": [9, 9])", R"({"plugin": "flat"})", R"({"mass": "parameter"})"));
    FAIL() << "it took another name";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(R"(did you mean "parameters"?)"), std::string::npos)
        << error.what();
  }
}

TEST(RestArea, NoAreaIsNoMass) {
  try {
    (void)simulation_from_text(
        scene(R"("nodes": [5, 5])", R"s({"plugin": "formula", "y": "0*a2"})s"));
    FAIL() << "a line has no mass";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no area around node"), std::string::npos)
        << error.what();
  }
}

/// A viscous stream at rest: total drag 2 N·s/m³ · 1 m/s · √2 m² cos 45° normal to a slope.
TEST(RestArea, DragAndEdgeLoadsGoByTheRestSurfaceToo) {
  const auto force_of = [](const std::string& load, const std::string& rest) {
    Simulation s = simulation_from_text(
        scene(R"("nodes": [9, 9], "size": [1, 1])", rest),
        {{.pointer = "/forces", .value = '[' + load + ']'},
         {.pointer = "/energies", .value = R"([{"plugin": "stretching", "eta": 0}])"}});
    return Vec3(s.system().terms().external_force(s.state()).colwise().sum());
  };
  const Vec3 drag =
      force_of(R"({"plugin": "viscous_fluid", "viscosity": 2, "velocity": [0, 0, 1]})",
               R"s({"plugin": "formula", "z": "a1"})s");
  EXPECT_LT((drag - 2 * std::sqrt(2) * std::sqrt(0.5) * Vec3(-1, 0, 1) / std::sqrt(2)).norm(),
            1e-9);
  const Vec3 pull =
      force_of(R"({"plugin": "edge_load", "force": [1, 0, 0], "where": {"boundary": "right"}})",
               R"s({"plugin": "formula", "y": "0.3*sin(a2*pi)", "z": "0.3*cos(a2*pi)"})s");
  EXPECT_NEAR(pull.x(), 0.3 * pi, 1e-3 * 0.3 * pi);
}

/// The lowest frequency of a supported plate, 2π² √(D/μ)/L², knows no parameters.
TEST(RestArea, FrequencyDoesNotDependOnParameters) {
  for (const char* energy :
       {R"({"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 1e-2})",
        R"({"plugin": "thin_plate", "xi": 0.09157509157509157, "poisson": 0.3})"}) {
    const auto frequency = [&](const std::string& rest) {
      Simulation s =
          simulation_from_text(scene(R"("nodes": [33, 33], "size": [1, 1])", rest),
                               {{.pointer = "/energies", .value = '[' + std::string(energy) + ']'},
                                {.pointer = "/constraints",
                                 .value = R"([{"plugin": "pin", "where": {"boundary": "all"}}])"}});
      NewtonMatrix tangent(s.system());
      tangent.evaluate(s.state());
      return std::sqrt(tangent.stability().lowest);
    };
    const double expected = 2 * pi * pi * std::sqrt(0.09157509157509157 / 2);
    EXPECT_NEAR(frequency(R"({"plugin": "flat"})") / expected, 1, 0.005) << energy;
    EXPECT_NEAR(
        frequency(
            R"s({"plugin": "formula", "x": "a1+0.04*sin(2*pi*a1)", "y": "a2*(0.8+0.2*a2)"})s") /
            expected,
        1, 0.01)
        << energy;
  }
}

/// A sheet that is named weighs what it weighs, unless the scene says otherwise.
TEST(RestArea, NamedMaterialsHaveTheirMass) {
  const auto mass = [](const std::string& energies, const std::string& material = "{}") {
    Simulation s = simulation_from_text(
        scene(R"("nodes": [5, 5], "size": [1, 2])", R"({"plugin": "flat"})", material),
        {{.pointer = "/energies", .value = '[' + energies + ']'}});
    return s.system().mass().sum() / 2;
  };
  const std::string steel = R"({"plugin": "koiter", "material": "steel")";
  EXPECT_NEAR(mass(steel + '}'), 7850 * 5e-4, 1e-9);
  EXPECT_NEAR(mass(steel + R"(, "thickness": 2e-3})"), 7850 * 2e-3, 1e-9);
  EXPECT_NEAR(mass(R"({"plugin": "koiter_orthotropic", "material": "wool"})"), 0.2, 1e-3);
  EXPECT_NEAR(mass(steel + '}', R"({"density": 0.7})"), 0.7, 1e-12);
  EXPECT_NEAR(mass(R"({"plugin": "koiter", "young": 1, "poisson": 0, "thickness": 1})"), 0.1,
              1e-12);
  EXPECT_NEAR(mass(steel + "}, " + steel + '}'), 7850 * 5e-4, 1e-9);
  EXPECT_THROW((void)mass(steel + R"(}, {"plugin": "koiter_orthotropic", "material": "paper"})"),
               InputError);
}

/// What the scene did not say is not said by the complete scene either, so that it means the same.
TEST(RestArea, CompletedScenesMeanTheSameMass) {
  const auto complete = [](const std::string& text) {
    return read_scene_text(text, "test scene", ".", *test::built_in()).completed;
  };
  const std::string text =
      R"({"surface": {"plugin": "grid", "nodes": [5, 5]},
          "energies": [{"plugin": "koiter", "material": "steel"}],
          "integrator": {"plugin": "static", "step": 1}, "duration": 1})";
  const std::string completed = complete(text);
  EXPECT_EQ(completed.find("young"), std::string::npos) << completed;
  EXPECT_EQ(completed.find("density"), std::string::npos) << completed;
  EXPECT_EQ(complete(completed), completed);
  EXPECT_EQ(simulation_from_text(completed).system().mass(),
            simulation_from_text(text).system().mass());
}

}  // namespace
}  // namespace deform
