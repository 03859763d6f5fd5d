/// Forces on faces, pressure and wind: closed forms, and the same sums written down another way.
#include <algorithm>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "deform/model/force_field.h"

#include "support/builtin.h"
#include "support/fake_surface.h"
#include "support/polygon_surface.h"

namespace deform {
namespace {

using test::FakeSurface;
using test::hemisphere;
using test::make_builtin;
using test::parameters;
using test::PolygonSurface;
using test::torus;

// Half a second up a ramp of one second, so that a forgotten profile shows.
constexpr double kTime = 0.5;
const TimeProfile kRamp{TimeProfile::Form::ramp, {{0, 0}, {1, 1}}};
constexpr double kFactor = 0.5;

NodeVectors random_vectors(Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return NodeVectors::NullaryExpr(n, 3, [&] { return uniform(random); });
}

/// A force field on a surface in some state.
struct Loaded {
  Loaded(const Surface& surface_, const std::string& name, const ParameterValues& values)
      : surface(surface_), r(surface.rest()), v(NodeVectors::Zero(r.rows(), 3)) {
    auto setup = test::bare_setup();
    setup.with_surface(surface, surface.rest(), surface.areas());
    field = make_builtin<ForceField>(name, values, setup);
  }

  [[nodiscard]] NodeBlock block(Index first, Index size) const {
    NodeBlock b;
    b.first = first, b.size = size, b.time = kTime;
    b.r = rows_from(r, first), b.v = rows_from(v, first);
    b.all_r = rows_from(r, 0), b.all_v = rows_from(v, 0);
    return b;
  }
  [[nodiscard]] NodeVectors force(Index block_size = kBlock) const {
    NodeVectors f = NodeVectors::Zero(r.rows(), 3);
    for (Index first = 0; first < r.rows(); first += block_size)
      field->add_force(block(first, std::min(block_size, r.rows() - first)), rows_from(f, first));
    return f;
  }
  [[nodiscard]] double potential() const {
    NodeValues energy = NodeValues::Zero(r.rows());
    field->add_potential(block(0, r.rows()),
                         {energy.data(), static_cast<std::size_t>(energy.size())});
    return energy.sum();
  }
  [[nodiscard]] NodeValues damping() const {
    NodeValues stiffness = NodeValues::Zero(r.rows()), damping = stiffness;
    const auto size = static_cast<std::size_t>(r.rows());
    field->add_tangent(block(0, r.rows()), {stiffness.data(), size}, {damping.data(), size});
    EXPECT_EQ(stiffness.norm(), 0);
    return damping;
  }

  const Surface& surface;
  NodeVectors r, v;
  std::shared_ptr<ForceField> field;
};

Vec3 total(const NodeVectors& f) { return f.colwise().sum().transpose(); }
Vec3 torque(const NodeVectors& r, const NodeVectors& f, const Vec3& about) {
  Vec3 sum = Vec3::Zero();
  for (Index a = 0; a < r.rows(); ++a)
    sum += (r.row(a).transpose() - about).cross(Vec3(f.row(a).transpose()));
  return sum;
}

/// Calls f(nodes of the polygon) for each face.
template <class F>
void for_each_face(const Surface& surface, const F& f) {
  const Faces& faces = surface.faces();
  for (std::size_t i = 0; i + 1 < faces.begin.size(); ++i)
    f(std::vector<Index>(faces.nodes.begin() + faces.begin[i],
                         faces.nodes.begin() + faces.begin[i + 1]));
}

/// Six times the signed volume between triangles and the origin.
double six_volumes(const Vec3& a, const Vec3& b, const Vec3& c) { return a.dot(b.cross(c)); }

/// The volume below the surface: its polygons cut into triangles about the mean of their corners.
double volume(const Surface& surface, const NodeVectors& r) {
  double six = 0;
  for_each_face(surface, [&](const std::vector<Index>& face) {
    Vec3 m = Vec3::Zero();
    for (const Index a : face) m += r.row(a).transpose() / static_cast<double>(face.size());
    for (std::size_t c = 0; c < face.size(); ++c)
      six += six_volumes(m, r.row(face[c]), r.row(face[(c + 1) % face.size()]));
  });
  return six / 6;
}

Loaded pressure_on(const Surface& surface, double pressure) {
  return {surface, "pressure", parameters({{"pressure", pressure}, {"time", kRamp}})};
}

TEST(Pressure, PushesAPlaneAlongItsNormal) {
  const FakeSurface plane(5, 4);
  const Loaded load = pressure_on(plane, 3);
  const NodeVectors f = load.force();
  // A corner's quarter of each face is its node's parameter area.
  EXPECT_LT((f.col(2) - kFactor * 3 * plane.areas()).norm(), 1e-15);
  EXPECT_EQ(f.leftCols(2).norm(), 0);
  EXPECT_FALSE(load.field->traits().potential);
}

TEST(Pressure, OnAHemisphereIsThatOnItsOpening) {
  for (const int around : {3, 8}) {
    const PolygonSurface dome = hemisphere(4, around, false);
    const NodeVectors f = pressure_on(dome, 3).force();
    const double opening = 0.5 * around * std::sin(2 * std::numbers::pi / around);
    EXPECT_LT((total(f) - kFactor * 3 * opening * Vec3::UnitZ()).norm(), 1e-14);
    // The opening's centre is the origin, where the pressure on it would act.
    const Vec3 about(2, -1, 0.7);
    EXPECT_LT((torque(dome.rest(), f, about) - (-about).cross(total(f))).norm(), 2e-14);
  }
}

TEST(Pressure, ClosedSurfacesAreNeitherPushedNorTurned) {
  for (const PolygonSurface& closed : {torus(12, 7), hemisphere(3, 7, true)}) {
    Loaded load = pressure_on(closed, 3);
    load.r += 0.1 * random_vectors(load.r.rows(), 1);
    load.r.rowwise() += Eigen::RowVector3d(5, -3, 2);
    const NodeVectors f = load.force();
    EXPECT_GT(f.rowwise().norm().minCoeff(), 1e-3);
    EXPECT_LT(total(f).norm(), 1e-13);
    EXPECT_LT(torque(load.r, f, Vec3::Zero()).norm(), 1e-12);
  }
}

// Central differences of quantities of order one, with steps of 1e-5: their error is about 1e-10;
// V is of third degree, and of first in each coordinate.
TEST(Pressure, IsTheGradientOfTheVolume) {
  for (const PolygonSurface& closed : {torus(9, 5), hemisphere(3, 7, true)}) {
    Loaded load = pressure_on(closed, 3);
    ASSERT_TRUE(load.field->traits().potential);
    load.r += 0.1 * random_vectors(load.r.rows(), 2);
    EXPECT_NEAR(load.potential(), -kFactor * 3 * volume(closed, load.r), 1e-13);
    const NodeVectors f = load.force();
    const double h = 1e-5;
    for (Index i = 0; i < load.r.size(); ++i) {
      const double x = load.r.data()[i];
      load.r.data()[i] = x + h;
      const double above = volume(closed, load.r);
      load.r.data()[i] = x - h;
      const double below = volume(closed, load.r);
      load.r.data()[i] = x;
      EXPECT_NEAR(f.data()[i], kFactor * 3 * (above - below) / (2 * h), 1e-9) << "coordinate " << i;
    }
  }
}

/// Inner nodes of an open surface have closed faces around them: there, too, it is the gradient.
TEST(Pressure, IsTheGradientOfTheVolumeInsideOfABorder) {
  const FakeSurface sheet(4, 4);
  Loaded load = pressure_on(sheet, 3);
  load.r += random_vectors(load.r.rows(), 3);
  const NodeVectors f = load.force();
  for (const Index a : {5, 6, 9, 10})
    for (const int c : {0, 1, 2}) {
      NodeVectors above = load.r, below = load.r;
      above(a, c) += 1, below(a, c) -= 1;  // of first degree in each coordinate
      EXPECT_NEAR(f(a, c), kFactor * 3 * (volume(sheet, above) - volume(sheet, below)) / 2, 1e-12);
    }
}

/// Another way to write it for quadrilaterals: the mean over both diagonals, a triangle at a time.
TEST(Pressure, AgreesWithTrianglesOfBothDiagonals) {
  const FakeSurface sheet(5, 4);
  const PolygonSurface ring = torus(12, 7);
  for (const Surface* surface : std::initializer_list<const Surface*>{&sheet, &ring}) {
    Loaded load = pressure_on(*surface, 3);
    load.r += random_vectors(load.r.rows(), 4);
    NodeVectors expected = NodeVectors::Zero(load.r.rows(), 3);
    const auto add = [&](Index a, Index b, Index c) {
      const Vec3 ab = load.r.row(b) - load.r.row(a), ac = load.r.row(c) - load.r.row(a);
      for (const Index node : {a, b, c})
        expected.row(node) += kFactor * 3 * 0.5 * ab.cross(ac).transpose() / 6;
    };
    for_each_face(*surface, [&](const std::vector<Index>& q) {
      add(q[0], q[1], q[2]), add(q[0], q[2], q[3]);
      add(q[0], q[1], q[3]), add(q[1], q[2], q[3]);
    });
    EXPECT_LT((load.force() - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST(Pressure, BlocksDoNotMatter) {
  const PolygonSurface closed = torus(12, 7);
  const Loaded load = pressure_on(closed, 3);
  EXPECT_EQ(load.force(), load.force(5));
  EXPECT_EQ(load.force(), load.force(1));
}

const Vec3 kAir(4, -3, 2);
constexpr double kDensity = 1.3, kDrag = 0.9, kFriction = 0.2;

Loaded wind_on(const Surface& surface) {
  return {surface, "wind",
          parameters({{"velocity", kAir},
                      {"air_density", kDensity},
                      {"drag", kDrag},
                      {"friction", kFriction},
                      {"time", kRamp}})};
}

TEST(Wind, OnAPlaneAtAnAngle) {
  const FakeSurface plane(5, 4);  // 1 m × 0.75 m
  for (const double angle : {0.0, 0.3, 1.0, std::numbers::pi / 2}) {
    Loaded load(plane, "wind",
                parameters({{"velocity", Vec3(5, 0, 0)}, {"drag", 1.1}, {"friction", 0.3}}));
    const double s = std::sin(angle), c = std::cos(angle);
    for (Index a = 0; a < load.r.rows(); ++a)  // turned about y, (x, 0, 0) to (x cos, 0, −x sin)
      load.r.row(a) << c * plane.rest()(a, 0), plane.rest()(a, 1), -s * plane.rest()(a, 0);
    load.v.col(0).setConstant(2);
    const Vec3 n(s, 0, c), t(c, 0, -s);  // the air comes at 3 m/s
    const Vec3 expected = 0.5 * 1.2 * 9 * 0.75 * (1.1 * s * s * n + 0.3 * c * c * t);
    EXPECT_LT((total(load.force()) - expected).norm(), 1e-14) << angle;
    EXPECT_NEAR(load.damping().sum(), 1.2 * 3 * 0.75 * std::max(1.1 * s, 0.3 * c), 1e-14);
  }
}

TEST(Wind, IsSharedEquallyByTheCorners) {
  NodeVectors r(4, 3);
  r << 0, 0, 0, 1, 0, 0, 1, 1, 0, -3, 1, 0;
  const PolygonSurface quadrilateral(r, {{0, 1, 2, 3}});
  const NodeVectors f = wind_on(quadrilateral).force();
  for (const Index a : {1, 2, 3}) EXPECT_EQ(f.row(a), f.row(0));
  EXPECT_GT(f.row(0).norm(), 0);
}

/// Face by face, each adding to its nodes, on triangles, quadrilaterals and a heptagon.
TEST(Wind, AgreesWithALoopOverFaces) {
  for (const PolygonSurface& surface : {torus(12, 7), hemisphere(3, 7, true)}) {
    Loaded load = wind_on(surface);
    load.r += 0.1 * random_vectors(load.r.rows(), 5);
    load.v = 3 * random_vectors(load.r.rows(), 6);
    NodeVectors expected = NodeVectors::Zero(load.r.rows(), 3);
    for_each_face(surface, [&](const std::vector<Index>& face) {
      const auto k = static_cast<double>(face.size());
      Vec3 area = Vec3::Zero(), u = kFactor * kAir;
      for (std::size_t c = 0; c < face.size(); ++c) {
        const Vec3 here = load.r.row(face[c]), next = load.r.row(face[(c + 1) % face.size()]);
        area += 0.5 * here.cross(next);
        u -= load.v.row(face[c]).transpose() / k;
      }
      const Vec3 n = area.normalized(), u_t = n.cross(u).cross(n);
      const Vec3 f = 0.5 * kDensity * area.norm() *
                     (kDrag * std::abs(u.dot(n)) * u.dot(n) * n + kFriction * u_t.norm() * u_t);
      for (const Index a : face) expected.row(a) += f.transpose() / k;
    });
    EXPECT_LT((load.force() - expected).norm(), 1e-12 * expected.norm());
    EXPECT_EQ(load.force(), load.force(5));
  }
}

TEST(Wind, DoesNotKnowTheSidesOfAFace) {
  NodeVectors r(4, 3);
  r << 0, 0, 0, 1, 0, 0.2, 1, 1, 0, 0, 1, 0.1;
  const PolygonSurface above(r, {{0, 1, 2, 3}}), below(r, {{3, 2, 1, 0}});
  EXPECT_LT((wind_on(above).force() - wind_on(below).force()).norm(), 1e-15);
}

TEST(Wind, StillAirOnlyBrakes) {
  const PolygonSurface surface = hemisphere(3, 7, false);
  Loaded load(surface, "wind", {});
  EXPECT_EQ(load.force().norm(), 0);
  const auto power = [&] { return load.force().cwiseProduct(load.v).sum(); };
  for (unsigned seed = 0; seed < 20; ++seed) {
    const NodeVectors flight = random_vectors(2, seed);  // rigid: translation and rotation
    for (Index a = 0; a < load.r.rows(); ++a)
      load.v.row(a) = flight.row(0) + Vec3(flight.row(1)).cross(Vec3(load.r.row(a))).transpose();
    EXPECT_LT(power(), 0);
    load.v = random_vectors(load.r.rows(), 100 + seed);
    EXPECT_LT(power(), 0);
  }
}

/// A rank-one part of the derivative for each face, which the bound must hold from above: tight
/// where a flat sheet meets the wind squarely.
TEST(Wind, DampingBoundsTheDerivative) {
  const FakeSurface sheet(5, 4);
  Loaded load = wind_on(sheet);
  const auto drag_along = [&](const NodeVectors& w) {  // −w·(∂f/∂v) w
    const NodeVectors v = load.v;
    const double h = 1e-5;
    load.v = v - h * w;
    const NodeVectors above = load.force();
    load.v = v + h * w;
    const NodeVectors below = load.force();
    load.v = v;
    return (above - below).cwiseProduct(w).sum() / (2 * h);
  };
  NodeVectors square = NodeVectors::Zero(load.r.rows(), 3);
  square.col(2).setOnes();
  EXPECT_NEAR(drag_along(square), load.damping().sum(), 1e-8);
  for (unsigned seed = 0; seed < 20; ++seed) {
    load.r = sheet.rest() + 0.3 * random_vectors(load.r.rows(), seed);
    load.v = 5 * random_vectors(load.r.rows(), 100 + seed);
    const NodeVectors w = random_vectors(load.r.rows(), 200 + seed);
    EXPECT_LE(drag_along(w), load.damping().dot(w.rowwise().squaredNorm()));
  }
}

TEST(Wind, AFaceWithoutAreaFeelsNothing) {
  const FakeSurface sheet(3, 3);
  Loaded load = wind_on(sheet);
  load.r.setZero();
  EXPECT_EQ(load.force().norm(), 0);
  EXPECT_EQ(load.damping().norm(), 0);
}

}  // namespace
}  // namespace deform
