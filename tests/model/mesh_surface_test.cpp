/// Surface "mesh": its derivatives against known surfaces, its forces against finite differences
/// and against the grid, and what it says of files that are no surface.
#include <cmath>

#include "deform/check/mechanics.h"
#include "deform/error.h"

#include "model/support/mesh_file.h"
#include "model/support/simulate.h"

namespace deform {
namespace {

using test::MeshFolder;
using test::MeshText;
using test::simulation_from_text;

constexpr const char* kKoiter =
    R"({"plugin": "koiter", "young": 50, "poisson": 0.3, "thickness": 0.05})";

Simulation sheet(const std::string& path, const std::string& energies, const std::string& more = "",
                 const std::string& keys = "") {
  return simulation_from_text(
      R"({"surface": {"plugin": "mesh", "path": ")" + path + "\"" + more +
      R"(}, "material": {"density": 0.1}, "energies": [)" + energies +
      R"(], "integrator": {"plugin": "backward_euler", "step": 0.01}, "duration": 0.01)" + keys +
      "}");
}

/// Mean and Gaussian curvature of the rest surface at a node.
struct Curvature {
  double H, K;
};
Curvature curvature(const GeometryBlock& g, std::size_t s) {
  const double G_11 = g.G(Pair::p11)[s], G_12 = g.G(Pair::p12)[s], G_22 = g.G(Pair::p22)[s];
  const double B_11 = g.B(Pair::p11)[s], B_12 = g.B(Pair::p12)[s], B_22 = g.B(Pair::p22)[s];
  const double det = G_11 * G_22 - G_12 * G_12;
  return {(B_11 * G_22 - 2 * B_12 * G_12 + B_22 * G_11) / (2 * det),
          (B_11 * B_22 - B_12 * B_12) / det};
}

/// Largest and mean errors of H over nodes, and of K.
struct Errors {
  double largest_H = 0, mean_H = 0, largest_K = 0;
};
/// `exact`: at a place.
Errors errors(const MeshText& mesh, const std::function<Curvature(const Vec3&)>& exact) {
  const MeshFolder folder;
  Simulation s = sheet(folder.write("a.obj", mesh.obj()), kKoiter);
  const SampleSet& samples = s.system().surface().samples(SampleRole::bending);
  const NodeVectors& r = s.system().rest();
  const auto geometry = s.system().terms().geometry(r, samples);
  Errors e;
  for (Index a = 0; a < r.rows(); ++a) {
    const Curvature found = curvature(geometry->all(), static_cast<std::size_t>(a)),
                    is = exact(r.row(a));
    e.largest_H = std::max(e.largest_H, std::abs(std::abs(found.H) - std::abs(is.H)));
    e.mean_H += std::abs(std::abs(found.H) - std::abs(is.H)) / static_cast<double>(r.rows());
    e.largest_K = std::max(e.largest_K, std::abs(found.K - is.K));
  }
  return e;
}

double order(double coarse, double fine) { return std::log2(coarse / fine); }

/// H = 1/(2R), K = 0, at borders, too.
TEST(Mesh, HasTheCurvatureOfACylinder) {
  const auto cylinder = [](std::size_t n, double jitter) {
    return errors(
        test::patch([](double u,
                       double v) { return Vec3(0.5 * std::sin(2 * u), v, 0.5 * std::cos(2 * u)); },
                    {1.2, 1}, n, n, jitter),
        [](const Vec3&) {
          return Curvature{1, 0};
        });
  };
  const Errors coarse = cylinder(12, 0), fine = cylinder(24, 0);
  EXPECT_GT(order(coarse.mean_H, fine.mean_H), 1.7);
  EXPECT_GT(order(coarse.largest_H, fine.largest_H), 0.9);
  EXPECT_LT(fine.largest_H, 0.05);  // at the border
  const Errors jittered = cylinder(24, 0.2), finer = cylinder(48, 0.2);
  EXPECT_GT(order(jittered.mean_H, finer.mean_H), 0.9);
  EXPECT_LT(finer.largest_H, 0.1);
}

/// A closed surface, which no two parameters cover.
TEST(Mesh, HasTheCurvatureOfAClosedSphere) {
  const auto sphere = [](int k) {
    return errors(test::sphere(k), [](const Vec3&) { return Curvature{1, 1}; });
  };
  const Errors coarse = sphere(3), fine = sphere(4);
  EXPECT_GT(order(coarse.mean_H, fine.mean_H), 1.7);
  EXPECT_GT(order(coarse.largest_K, fine.largest_K), 0.9);
  EXPECT_LT(fine.largest_H, 1e-2);
}

/// z = x y: H = −x y/W³, K = −1/W⁴, W² = 1 + x² + y².
TEST(Mesh, HasTheCurvatureOfASaddle) {
  const auto saddle = [](std::size_t n) {
    return errors(test::patch([](double u, double v) { return Vec3(u, v, u * v); }, {1, 1}, n, n),
                  [](const Vec3& r) {
                    const double W = std::sqrt(1 + r.x() * r.x() + r.y() * r.y());
                    return Curvature{-r.x() * r.y() / (W * W * W), -1 / (W * W * W * W)};
                  });
  };
  const Errors coarse = saddle(12), fine = saddle(24);
  EXPECT_GT(order(coarse.mean_H, fine.mean_H), 1.5);
  EXPECT_GT(order(coarse.largest_K, fine.largest_K), 0.9);
}

TEST(Mesh, KnowsNoEnergyAtRest) {
  const MeshFolder folder;
  Simulation s = sheet(folder.write("a.obj", test::sphere(2).obj()), kKoiter);
  EXPECT_EQ(s.system().evaluator().potential(s.state()), 0);
  EXPECT_LT(s.system().evaluator().force(s.state()).norm(), 1e-15);
}

/// Exact derivatives on samples that each have a chart of their own.
TEST(Mesh, ForcesAndTangentsAreDerivatives) {
  const MeshFolder folder;
  const std::string file = folder.write("a.obj", test::sphere(2).obj());
  for (const std::string& energy :
       {std::string(kKoiter), std::string(R"({"plugin": "stretching", "eta": 2})"),
        std::string(R"({"plugin": "bending_variational", "xi": 1e-2})")}) {
    Simulation s = sheet(file, energy);
    const State state = disturbed(s.system().rest(), 0.05);
    for (std::size_t term = 0; term < s.system().energies().size(); ++term)
      EXPECT_LT(gradient_error(s.system(), term, state), 1e-7) << energy;
    EXPECT_LT(tangent_error(s.system(), state), 1e-8) << energy;
  }
}

/// A sheet that hangs from one side, as a grid and as a mesh of its nodes: they come closer as both
/// are refined.
TEST(Mesh, ComesCloseToTheGrid) {
  const auto difference = [](std::size_t n) {
    const MeshFolder folder;
    const auto flat = [](double u, double v) { return Vec3(u, v, 0); };
    const std::string surface_of_mesh =
        R"({"plugin": "mesh", "path": ")" +
        folder.write("a.obj", test::patch(flat, {1, 1}, n, n).obj()) + "\"}";
    const std::string surface_of_grid =
        fmt::format(R"({{"plugin": "grid", "nodes": [{0}, {0}], "size": [1, 1]}})", n + 1);
    const auto hung = [&](const std::string& surface) {
      Simulation s = simulation_from_text(R"({"surface": )" + surface +
                                          R"(, "material": {"density": 0.1}, "energies": [
             {"plugin": "koiter", "young": 1e4, "poisson": 0.3, "thickness": 0.01}],
             "forces": ["gravity"], "constraints": [{"plugin": "pin",
             "where": {"space": [[-0.01, -1, -1], [0.01, 2, 1]]}}],
             "integrator": {"plugin": "backward_euler", "step": 0.02, "tolerance": 1e-8},
             "duration": 0.2})");
      while (s.steps() < s.scene().steps()) s.step();
      return s.state().r;
    };
    const NodeVectors mesh = hung(surface_of_mesh), grid = hung(surface_of_grid);
    return (mesh - grid).rowwise().norm().maxCoeff() /
           (grid - Simulation(simulation_from_text(
                                  R"({"surface": )" + surface_of_grid +
                                  R"(, "energies": [{"plugin": "stretching"}], "integrator":
                                  {"plugin": "semi_implicit", "step": 0.01}, "duration": 0.01})"))
                       .state()
                       .r)
               .rowwise()
               .norm()
               .maxCoeff();
  };
  const double coarse = difference(8), fine = difference(16);
  EXPECT_LT(fine, 0.02);
  EXPECT_GT(order(coarse, fine), 0.8);
}

/// What was refused; "" if nothing was.
std::string refused(const std::string& path, const std::string& more = "",
                    const std::string& energies = kKoiter, const std::string& keys = "") {
  try {
    (void)sheet(path, energies, more, keys);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

struct Bad {
  const char* name;
  const char* text;
  const char* says;
  bool can_be_mended;
};
void PrintTo(const Bad& tested, std::ostream* out) { *out << tested.name; }

class BadMesh : public testing::TestWithParam<Bad> {};

TEST_P(BadMesh, IsNamedAndRefusedOrMended) {
  const MeshFolder folder;
  const std::string file = folder.write("a.obj", GetParam().text);
  const std::string why = refused(file);
  EXPECT_NE(why.find(GetParam().says), std::string::npos) << why;
  EXPECT_EQ(refused(file, R"(, "repair": true)").empty(), GetParam().can_be_mended);
}

// Seven vertices about a hexagon's centre, so that second derivatives are there.
#define HEXAGON                                                                          \
  "v 0 0 0\nv 1 0 0\nv 0.5 0.9 0\nv -0.5 0.9 0\nv -1 0 0\nv -0.5 -0.9 0\nv 0.5 -0.9 0\n" \
  "f 1 2 3\nf 1 3 4\nf 1 4 5\nf 1 5 6\nf 1 6 7\n"

INSTANTIATE_TEST_SUITE_P(
    All, BadMesh,
    testing::Values(
        Bad{"Flipped", HEXAGON "f 1 2 7\n", "polygons that run the other way round", true},
        Bad{"Unused", HEXAGON "f 1 7 2\nv 5 5 5\n", "vertices that no polygon has: 7", true},
        Bad{"Doubled", HEXAGON "v 0 0 0\nf 8 7 2\n", "vertices at the place of an earlier one: 7",
            true},
        Bad{"SameFace", HEXAGON "f 1 7 2\nf 7 2 1\n", "polygons that lie upon others", true},
        Bad{"NoArea", HEXAGON "f 1 7 2\nf 5 1 2\n", "polygons without area: 6", true},
        Bad{"TwiceNamed", HEXAGON "f 1 7 2\nf 2 2 3\n", "polygons that name a vertex twice: 6",
            true},
        Bad{"Fins", HEXAGON "f 1 7 2\nv 0 0 1\nf 1 2 8\n", "more than two polygons", false},
        Bad{"Point", HEXAGON "f 1 7 2\nv 2 1 0\nv 2 -1 0\nf 2 9 8\n", "in a point", false},
        Bad{"Nothing", "v 0 0 0\n", "no polygons", false},
        Bad{"TooFew", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "do not determine second derivatives",
            false},
        Bad{"NotFinite", HEXAGON "f 1 7 2\nv 0 0 nan\n", "line 14", false},
        Bad{"Comma", HEXAGON "f 1 7 2\nv 0,5 0 0\n", "line 14", false},
        Bad{"NoIndex", HEXAGON "f 1 7 2.5\n", "line 13", false}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST(Mesh, RefusesAMoebiusStrip) {
  MeshText strip;
  constexpr std::size_t kCells = 24;
  for (std::size_t i = 0; i < kCells; ++i)
    for (const double w : {-0.2, 0.0, 0.2}) {
      const double t = 2 * M_PI * static_cast<double>(i) / kCells;
      const double rho = 1 + w * std::cos(t / 2);
      strip.vertices.emplace_back(rho * std::cos(t), rho * std::sin(t), w * std::sin(t / 2));
    }
  for (std::size_t i = 0; i < kCells; ++i)
    for (std::size_t k = 0; k < 2; ++k) {
      const bool is_last = i + 1 == kCells;
      const auto next = [&](std::size_t j) { return is_last ? 2 - j : 3 * (i + 1) + j; };
      const std::size_t a = 3 * i + k, b = a + 1;
      strip.triangles.push_back({a, next(k), next(k + 1)});
      strip.triangles.push_back({a, next(k + 1), b});
    }
  const MeshFolder folder;
  const std::string why = refused(folder.write("a.obj", strip.obj()), R"(, "repair": true)");
  EXPECT_NE(why.find("one side only"), std::string::npos) << why;
}

TEST(Mesh, SaysWhatNeedsParameters) {
  const MeshFolder folder;
  const std::string file = folder.write("a.off", test::sphere(2).off());
  const auto expect = [&](const std::string& why, const char* says) {
    EXPECT_NE(why.find(says), std::string::npos) << why;
  };
  expect(refused(file, "", kKoiter,
                 R"(, "constraints": [{"plugin": "pin", "where": {"box": [[0, 0], [1, 1]]}}])"),
         "selects by parameters");
  expect(refused(file, "",
                 R"json({"plugin": "koiter", "young": {"formula": "50*(1+a1)"}, "poisson": 0.3,
                         "thickness": 0.05})json"),
         "needs parameters");
  expect(refused(file, "", R"({"plugin": "stretching", "eta": [[1, 2], [2, 1]]})"),
         "needs parameters");
  expect(refused(file, R"(, "initial": {"plugin": "arc", "radius": 1})"), "parameters");
  EXPECT_EQ(refused(file), "");
}

TEST(Mesh, IsReadFromEveryFormat) {
  const MeshFolder folder;
  const MeshText ball = test::sphere(2);
  double area = 0;
  for (const auto& [a, b, c] : ball.triangles)
    area += 0.5 *
            (ball.vertices[b] - ball.vertices[a]).cross(ball.vertices[c] - ball.vertices[a]).norm();
  std::string stl = "solid ball\n";
  for (const auto& t : ball.triangles) {
    stl += "facet normal 0 0 0\nouter loop\n";
    for (const std::size_t a : t)
      stl += fmt::format("vertex {} {} {}\n", ball.vertices[a].x(), ball.vertices[a].y(),
                         ball.vertices[a].z());
    stl += "endloop\nendfacet\n";
  }
  stl += "endsolid ball\n";
  std::string ply = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty "
      "double z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      ball.vertices.size(), ball.triangles.size());
  for (const Vec3& v : ball.vertices) ply += fmt::format("{} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& t : ball.triangles) ply += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  for (const auto& [name, text] : {std::pair{"a.obj", ball.obj()}, std::pair{"a.off", ball.off()},
                                   std::pair{"a.stl", stl}, std::pair{"a.ply", ply}}) {
    Simulation s = sheet(folder.write(name, text), kKoiter,
                         R"(, "scale": 2, "rotation": [0, 0, 1.5707963267948966],
                            "translation": [0, 0, 3])");
    EXPECT_EQ(s.system().nodes(), static_cast<Index>(ball.vertices.size())) << name;
    EXPECT_NEAR(s.system().areas().sum(), 4 * area, 1e-5) << name;
    EXPECT_NEAR(s.system().rest().col(2).maxCoeff(), 5, 1e-6) << name;
  }
  EXPECT_NE(refused(folder.write("a.txt", "")).find("expected a mesh"), std::string::npos);
  EXPECT_NE(refused("/nowhere.obj").find("no such file"), std::string::npos);
}

}  // namespace
}  // namespace deform
