#include <filesystem>
#include <fstream>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "deform/surface/shape.h"

#include "support/builtin.h"

namespace deform {
namespace {

using std::numbers::pi;
using test::make_builtin;
using test::parameters;

const Vec2 kSize(1.0, 0.6);

Vec3 position(const Shape& shape, const Vec2& a, const Vec2& size = kSize) {
  Eigen::MatrixX2d one(1, 2);
  one.row(0) = a;
  return shape.positions(one, size).row(0);
}

// Derivatives by central differences of step h: errors are h² (1e-8) and, of the second ones,
// 1e-16/h² (1e-8).
struct Jet {
  Vec3 r_1, r_2, r_11, r_12, r_22;
  [[nodiscard]] Vec3 n() const { return r_1.cross(r_2).normalized(); }
};
Jet jet(const Shape& shape, const Vec2& a) {
  const double h = 1e-4;
  const auto r = [&](int i, int j) { return position(shape, a + h * Vec2(i, j)); };
  return {(r(1, 0) - r(-1, 0)) / (2 * h), (r(0, 1) - r(0, -1)) / (2 * h),
          (r(1, 0) - 2 * r(0, 0) + r(-1, 0)) / (h * h),
          (r(1, 1) - r(1, -1) - r(-1, 1) + r(-1, -1)) / (4 * h * h),
          (r(0, 1) - 2 * r(0, 0) + r(0, -1)) / (h * h)};
}
constexpr double kTolerance = 1e-6;
const std::vector<Vec2> kPlaces{{0.5, 0.3}, {0.1, 0.05}, {0.93, 0.2}, {0.3, 0.55}};

TEST(Shapes, FlatIsTheParameterPlane) {
  EXPECT_EQ(position(*make_builtin<Shape>("flat"), {0.3, 0.2}), Vec3(0.3, 0.2, 0));
  const auto shape = make_builtin<Shape>("flat", parameters({{"origin", Vec3(1, 2, 3)}}));
  EXPECT_EQ(position(*shape, {0.25, 0.5}), Vec3(1.25, 2.5, 3));
}

class Arc : public testing::TestWithParam<std::tuple<std::int64_t, std::int64_t>> {};

TEST_P(Arc, IsIsometricAndHasItsCurvature) {
  const auto [along, side] = GetParam();
  const double R = 0.4;
  const auto shape =
      make_builtin<Shape>("arc", parameters({{"radius", R}, {"along", along}, {"side", side}}));
  for (const Vec2& a : kPlaces) {
    const Jet j = jet(*shape, a);
    EXPECT_NEAR(j.r_1.squaredNorm(), 1, kTolerance);
    EXPECT_NEAR(j.r_1.dot(j.r_2), 0, kTolerance);
    EXPECT_NEAR(j.r_2.squaredNorm(), 1, kTolerance);
    const double B = -static_cast<double>(side) / R;
    EXPECT_NEAR(j.n().dot(j.r_11), along == 1 ? B : 0, kTolerance);
    EXPECT_NEAR(j.n().dot(j.r_12), 0, kTolerance);
    EXPECT_NEAR(j.n().dot(j.r_22), along == 2 ? B : 0, kTolerance);
  }
}
INSTANTIATE_TEST_SUITE_P(Shapes, Arc,
                         testing::Combine(testing::Values(1, 2), testing::Values(1, -1)));

TEST(Shapes, ArcStandsOnItsBase) {
  const double R = 0.5;
  const auto arc = [&](const char* base) {
    return make_builtin<Shape>("arc", parameters({{"radius", R}, {"base", std::string(base)}}));
  };
  const Vec2 end(0, 0.2), middle(0.5, 0.2);
  EXPECT_NEAR(position(*arc("ends"), end).z(), 0, 1e-15);
  EXPECT_NEAR(position(*arc("ends"), middle).z(), R * (1 - std::cos(1.0)), 1e-15);  // L/2R = 1
  EXPECT_NEAR(position(*arc("apex"), middle).z(), 0, 1e-15);
  EXPECT_NEAR(position(*arc("axis"), middle).z(), R, 1e-15);
  EXPECT_LT((position(*arc("apex"), middle) - Vec3(0.5, 0.2, 0)).norm(), 1e-15);
}

TEST(Shapes, ArcMayBeAWholeCircleButNotMore) {
  const auto tube = make_builtin<Shape>("arc", parameters({{"radius", 0.15915494309}}));
  EXPECT_LT((position(*tube, {0, 0.1}) - position(*tube, {1, 0.1})).norm(), 1e-9);
  const auto tight = make_builtin<Shape>("arc", parameters({{"radius", 0.159}}));
  EXPECT_THROW((void)position(*tight, {0, 0}), InputError);
  EXPECT_THROW((void)make_builtin<Shape>("arc", parameters({{"side", std::int64_t{0}}})),
               InputError);
}

TEST(Shapes, SpherePatchIsUmbilic) {
  const double R = 0.7;
  const auto shape = make_builtin<Shape>(
      "sphere_patch", parameters({{"radius", R}, {"base", std::string("centre")}}));
  for (const Vec2& a : kPlaces) {
    EXPECT_NEAR((position(*shape, a) - Vec3(0.5, 0.3, 0)).norm(), R, 1e-15);
    const Jet j = jet(*shape, a);
    const double v = (a.y() - 0.3) / R;
    EXPECT_NEAR(j.r_1.norm(), std::cos(v), kTolerance);
    EXPECT_NEAR(j.r_2.norm(), 1, kTolerance);
    EXPECT_NEAR(j.n().dot(j.r_11), -j.r_1.squaredNorm() / R, kTolerance);  // B = −G/R
    EXPECT_NEAR(j.n().dot(j.r_12), 0, kTolerance);
    EXPECT_NEAR(j.n().dot(j.r_22), -1 / R, kTolerance);
  }
}

TEST(Shapes, SpherePatchStandsOnItsBase) {
  const auto patch = [](const char* base, double radius) {
    return make_builtin<Shape>("sphere_patch",
                               parameters({{"radius", radius}, {"base", std::string(base)}}));
  };
  for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 0.6), Vec2(1, 0.6)})
    EXPECT_NEAR(position(*patch("corners", 0.7), corner).z(), 0, 1e-15);
  EXPECT_LT((position(*patch("apex", 0.7), {0.5, 0.3}) - Vec3(0.5, 0.3, 0)).norm(), 1e-15);
  EXPECT_THROW((void)position(*patch("apex", 0.6 / pi), {0, 0}), InputError);  // reaches the poles
  EXPECT_THROW((void)position(*patch("apex", 0.159), {0, 0}, {1, 0.1}), InputError);
}

TEST(Shapes, HemisphereIsUmbilic) {
  const double R = 0.7, hole = 18 * pi / 180;
  const auto shape = make_builtin<Shape>("hemisphere", parameters({{"radius", R}}));
  for (const Vec2& a : kPlaces) {
    EXPECT_NEAR(position(*shape, a).norm(), R, 1e-15);
    const Jet j = jet(*shape, a);
    const double v = (pi / 2 - hole) * a.y() / kSize.y();
    EXPECT_NEAR(j.r_1.norm(), 2 * pi * R * std::cos(v), 40 * kTolerance);  // third derivative (2π)³
    EXPECT_NEAR(j.r_2.norm(), (pi / 2 - hole) * R / kSize.y(), 10 * kTolerance);
    EXPECT_NEAR(j.n().dot(j.r_11), -j.r_1.squaredNorm() / R, 1e-4);  // B = −G/R: n points outwards
    EXPECT_NEAR(j.n().dot(j.r_22), -j.r_2.squaredNorm() / R, 1e-5);
  }
  EXPECT_NEAR(position(*shape, {0.3, 0.6}).z(), R * std::cos(hole), 1e-15);
  EXPECT_NEAR(position(*shape, {0.3, 0}).z(), 0, 1e-15);
  EXPECT_LT((position(*shape, {0, 0.2}) - position(*shape, {1, 0.2})).norm(), 1e-15);
}

TEST(Shapes, HemisphereMayBeASector) {
  const auto quarter = make_builtin<Shape>(
      "hemisphere", parameters({{"radius", 10.0}, {"sector", 90.0}, {"origin", Vec3(1, 2, 3)}}));
  EXPECT_LT((position(*quarter, {0, 0}) - Vec3(11, 2, 3)).norm(), 1e-14);
  EXPECT_LT((position(*quarter, {1, 0}) - Vec3(1, 12, 3)).norm(), 1e-14);
}

TEST(Shapes, TorusClosesAndHasItsCurvature) {
  const double R = 1, t = 0.25;
  const auto shape = make_builtin<Shape>("torus", parameters({{"radius", R}, {"tube", t}}));
  EXPECT_LT((position(*shape, {0, 0.1}) - position(*shape, {1, 0.1})).norm(), 1e-15);
  EXPECT_LT((position(*shape, {0.2, 0}) - position(*shape, {0.2, 0.6})).norm(), 1e-15);
  EXPECT_EQ(position(*shape, {0, 0}), Vec3(R + t, 0, 0));
  EXPECT_NEAR(position(*shape, {0, 0.15}).z(), t, 1e-15);
  for (const Vec2& a : kPlaces) {
    const Jet j = jet(*shape, a);
    const double v = 2 * pi * a.y() / kSize.y();
    EXPECT_NEAR(j.n().dot(j.r_22) / j.r_2.squaredNorm(), -1 / t, 1e-5);
    EXPECT_NEAR(j.n().dot(j.r_11) / j.r_1.squaredNorm(), -std::cos(v) / (R + t * std::cos(v)),
                1e-5);
  }
  EXPECT_THROW((void)make_builtin<Shape>("torus", parameters({{"radius", 1.0}, {"tube", 1.0}})),
               InputError);
}

TEST(Shapes, HelicoidIsMinimal) {
  const double height = 0.5;
  const auto shape = make_builtin<Shape>(
      "helicoid", parameters({{"inner", -0.5}, {"height", height}, {"turns", 0.75}}));
  const double c = height / (1.5 * pi);  // height a radian
  for (const Vec2& a : kPlaces) {
    const Jet j = jet(*shape, a);
    const double rho = a.x() - 0.5, G_22 = j.r_2.squaredNorm();
    EXPECT_NEAR(j.r_1.norm(), 1, kTolerance);
    EXPECT_NEAR(j.r_1.dot(j.r_2), 0, kTolerance);
    EXPECT_NEAR(G_22, (rho * rho + c * c) * std::pow(1.5 * pi / kSize.y(), 2), 1e-4);
    const double H = j.n().dot(j.r_11) + j.n().dot(j.r_22) / G_22;
    const double K = -std::pow(j.n().dot(j.r_12), 2) / G_22;
    EXPECT_NEAR(H, 0, kTolerance);
    EXPECT_NEAR(K, -c * c / std::pow(rho * rho + c * c, 2), 1e-4);
    EXPECT_GE(j.n().z() * rho, 0);  // up where a1 leads away from the axis
  }
  EXPECT_LT((position(*shape, {0.5, 0.6}) - Vec3(0, 0, height)).norm(), 1e-15);
}

TEST(Shapes, FormulaIsWhatItSays) {
  const auto shape =
      make_builtin<Shape>("formula", parameters({{"x", std::string("a1")},
                                                 {"y", std::string("k*cos(a2)")},
                                                 {"z", std::string("0.1*sin(2*pi*a1/L1) + L2")},
                                                 {"constants", NamedNumbers{{"k", 3}}}}));
  for (const Vec2& a : kPlaces) {
    const Vec3 expected(a.x(), 3 * std::cos(a.y()), 0.1 * std::sin(2 * pi * a.x()) + 0.6);
    EXPECT_LT((position(*shape, a) - expected).norm(), 1e-15);
  }
  EXPECT_EQ(position(*make_builtin<Shape>("formula"), {0.3, 0.2}), Vec3(0.3, 0.2, 0));
}

TEST(Shapes, FormulaSaysWhatIsWrong) {
  const auto complaint = [](const std::string& z) {
    try {
      (void)position(*make_builtin<Shape>("formula", parameters({{"z", z}})), {0, 0.2});
    } catch (const InputError& error) {
      return error.problems()[0].pointer + ": " + error.problems()[0].message;
    }
    return std::string();
  };
  EXPECT_EQ(complaint("sin(a3)"),
            "/z: found \"sin(a3)\", expected a formula of a1, a2, L1, L2: there is no \"a3\"; did "
            "you mean \"a1\"?");
  EXPECT_EQ(complaint("a2/a1"),
            ": z = a2/a1 is inf at a1 = 0, a2 = 0.2: a position must be finite");
}

class FileShape : public testing::Test {
 public:
  FileShape()
      : folder(std::filesystem::temp_directory_path() /
               ("deform_shapes_test_" +
                std::to_string(::testing::UnitTest::GetInstance()->random_seed()) + "_" +
                testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::create_directories(folder);
  }
  ~FileShape() override { std::filesystem::remove_all(folder); }

  [[nodiscard]] NodeVectors read(const std::string& text, Index nodes) const {
    std::ofstream(folder / "nodes.txt", std::ios::binary) << text;
    deform::Setup setup = test::bare_setup();
    setup.with_folder(folder);
    const auto shape = make_builtin<Shape>(
        "file", parameters({{"path", std::filesystem::path("nodes.txt")}}), setup);
    return shape->positions(Eigen::MatrixX2d::Zero(nodes, 2), kSize);
  }
  [[nodiscard]] std::string error_of(const std::string& text, Index nodes) const {
    try {
      (void)read(text, nodes);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder;
};

TEST_F(FileShape, ReadsRows) {
  NodeVectors expected(3, 3);
  expected << 1, 2, 3, -1e-3, 0.5, 4, 7, 8, 9;
  EXPECT_EQ(read("# x y z\n1 2 3\n\n -1e-3,\t0.5, 4 # second\r\n7,8,9", 3), expected);
}

TEST_F(FileShape, SaysWhereItIsWrong) {
  const std::string file = (folder / "nodes.txt").string();
  for (const auto& [text, where] : std::vector<std::pair<std::string, std::string>>{
           {"1 2 3\n#\n4 5\n", ":3: has 2 numbers"},
           {"1 2 3 4\n", ":1: has 4 numbers"},
           {"1 2 3\n1 2x 3\n", ":2: '2x' is not"},
           {"1 2 nan\n", ":1: 'nan' is not"},
           {"1 2 inf\n", ":1: 'inf' is not"},
           {"1 2 3\n", ": has 1 positions, but the surface has 2"}})
    EXPECT_NE(error_of(text, 2).find(file + where), std::string::npos) << error_of(text, 2);
}

TEST_F(FileShape, NamesAMissingFile) {
  const auto make = [this](const std::filesystem::path& path) {
    (void)make_builtin<Shape>("file", parameters({{"path", path}}), test::bare_setup());
  };
  EXPECT_THROW(make(folder / "missing.txt"), InputError);
  EXPECT_THROW(make(folder), InputError);
}

}  // namespace
}  // namespace deform
