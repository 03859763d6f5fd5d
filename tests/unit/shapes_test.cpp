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
