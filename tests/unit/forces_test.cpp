#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "deform/model/force_field.h"

#include "support/builtin.h"
#include "support/fake_surface.h"

namespace deform {
namespace {

using test::make_builtin;
using test::nodes_numbered;
using test::parameters;

// Half a second up a ramp of one second, so that a forgotten profile shows.
constexpr double kTime = 0.5;
const TimeProfile kRamp{TimeProfile::Form::ramp, {{0, 0}, {1, 1}}};
constexpr double kFactor = 0.5;

class Forces : public testing::Test {
 public:
  Forces() : setup(test::bare_setup()) {
    setup.with_surface(surface, surface.rest(), surface.areas());
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (auto* field : {&r, &v, &normal})
      *field = NodeVectors::NullaryExpr(surface.nodes(), 3, [&] { return uniform(generator); });
    normal.rowwise().normalize();
    mass = surface.areas() * 3;
  }

  [[nodiscard]] static Values values_of(NodeValues& values) {
    return {values.data(), static_cast<std::size_t>(values.size())};
  }
  [[nodiscard]] NodeBlock block(Index first, Index size) const {
    NodeBlock nodes;
    nodes.first = first, nodes.size = size, nodes.time = kTime;
    nodes.r = rows_from(r, first), nodes.v = rows_from(v, first);
    nodes.normal = rows_from(normal, first);
    nodes.area = {surface.areas().data() + first, static_cast<std::size_t>(size)};
    nodes.mass = {mass.data() + first, static_cast<std::size_t>(size)};
    return nodes;
  }
  [[nodiscard]] NodeVectors force_of(const ForceField& field, Index block_size = kBlock) const {
    NodeVectors force = NodeVectors::Zero(surface.nodes(), 3);
    for (Index first = 0; first < surface.nodes(); first += block_size)
      field.add_force(block(first, std::min(block_size, surface.nodes() - first)),
                      rows_from(force, first));
    return force;
  }
  [[nodiscard]] double potential_of(const ForceField& field) const {
    NodeValues energy = NodeValues::Zero(surface.nodes());
    field.add_potential(block(0, surface.nodes()), values_of(energy));
    return energy.sum();
  }

  // Central differences of quantities of order one, with steps of 1e-5: their error is about 1e-10.
  void expect_force_is_minus_gradient(const ForceField& field) {
    ASSERT_TRUE(field.traits().potential);
    const NodeVectors force = force_of(field);
    const double h = 1e-5;
    for (Index i = 0; i < r.size(); ++i) {
      const double x = r.data()[i];
      r.data()[i] = x + h;
      const double above = potential_of(field);
      r.data()[i] = x - h;
      const double below = potential_of(field);
      r.data()[i] = x;
      EXPECT_NEAR(force.data()[i], -(above - below) / (2 * h), 1e-8) << "coordinate " << i;
    }
  }
  void expect_blocks_do_not_matter(const ForceField& field) const {
    EXPECT_EQ(force_of(field), force_of(field, 5));
  }

  test::FakeSurface surface{4, 3};
  deform::Setup setup;
  NodeVectors r, v, normal;
  NodeValues mass;
};

TEST_F(Forces, GravityIsMassTimesAcceleration) {
  const auto field = make_builtin<ForceField>("gravity", parameters({{"time", kRamp}}), setup);
  const NodeVectors force = force_of(*field);
  EXPECT_LT((force.col(2) + kFactor * 9.81 * mass).norm(), 1e-14);
  EXPECT_EQ(force.leftCols(2).norm(), 0);
  expect_force_is_minus_gradient(*field);
  expect_blocks_do_not_matter(*field);
}

TEST_F(Forces, PointLoadIsSharedByArea) {
  const Vec3 total(1, -2, 3);
  const auto field = make_builtin<ForceField>(
      "point_load",
      parameters({{"force", total}, {"where", nodes_numbered({0, 5, 6})}, {"time", kRamp}}), setup);
  const NodeVectors force = force_of(*field);
  EXPECT_LT((force.colwise().sum().transpose() - kFactor * total).norm(), 1e-14);
  EXPECT_LT((force.row(5) - 4 * force.row(0)).norm(), 1e-14);  // inside and in a corner
  for (const Index node : {1, 2, 3, 4, 7, 8, 9, 10, 11}) EXPECT_EQ(force.row(node).norm(), 0);
  expect_force_is_minus_gradient(*field);
  expect_blocks_do_not_matter(*field);
}

TEST_F(Forces, LoadsRefuseASelectionOfNoNode) {
  for (const char* name : {"point_load", "spring"})
    EXPECT_THROW((void)make_builtin<ForceField>(name, {}, setup), InputError) << name;
}

TEST_F(Forces, ViscousFluidPushesAlongTheNormal) {
  const Vec3 stream(0.3, 0.2, -0.9);
  const auto field = make_builtin<ForceField>(
      "viscous_fluid", parameters({{"viscosity", 2.5}, {"velocity", stream}, {"time", kRamp}}),
      setup);
  EXPECT_TRUE(field->traits().normals);
  const NodeVectors force = force_of(*field);
  for (Index a = 0; a < surface.nodes(); ++a) {
    const Vec3 n = normal.row(a), relative = kFactor * stream - v.row(a).transpose();
    EXPECT_LT((force.row(a).transpose() - 2.5 * surface.areas()[a] * n.dot(relative) * n).norm(),
              1e-15);
  }
  expect_blocks_do_not_matter(*field);
  normal *= -1;
  EXPECT_EQ(force_of(*field), force);
}

TEST_F(Forces, ViscousFluidAtRestOnlyBrakes) {
  const auto field = make_builtin<ForceField>("viscous_fluid", {}, setup);
  const NodeVectors force = force_of(*field);
  for (Index a = 0; a < surface.nodes(); ++a) EXPECT_LE(force.row(a).dot(v.row(a)), 0);
  v.setZero();
  EXPECT_EQ(force_of(*field).norm(), 0);
}

TEST_F(Forces, SpringWithoutLengthHasAnIsotropicTangent) {
  const Vec3 anchor(0.5, 0.4, 2);
  const auto field = make_builtin<ForceField>("spring",
                                              parameters({{"anchor", anchor},
                                                          {"stiffness", 3.0},
                                                          {"where", nodes_numbered({0, 5, 6})},
                                                          {"time", kRamp}}),
                                              setup);
  ASSERT_TRUE(field->traits().isotropic_tangent);
  expect_force_is_minus_gradient(*field);
  expect_blocks_do_not_matter(*field);
  NodeValues stiffness = NodeValues::Zero(surface.nodes()), damping = stiffness;
  field->add_tangent(block(0, surface.nodes()), values_of(stiffness), values_of(damping));
  EXPECT_NEAR(stiffness.sum(), kFactor * 3, 1e-14);
  EXPECT_EQ(damping.norm(), 0);
  const NodeVectors force = force_of(*field);
  for (Index a = 0; a < surface.nodes(); ++a)
    EXPECT_LT((force.row(a).transpose() - stiffness[a] * (anchor - r.row(a).transpose())).norm(),
              1e-14);
}

TEST_F(Forces, SpringWithLengthPullsAndPushes) {
  const Vec3 anchor(0, 0, 1);
  const auto field = make_builtin<ForceField>("spring",
                                              parameters({{"anchor", anchor},
                                                          {"rest_length", 0.5},
                                                          {"where", nodes_numbered({0, 1, 5})},
                                                          {"time", kRamp}}),
                                              setup);
  EXPECT_FALSE(field->traits().isotropic_tangent);
  r.row(0) << 0, 0, 0.3;  // further than 0.5
  r.row(1) << 0, 0, 0.8;  // nearer
  expect_force_is_minus_gradient(*field);
  EXPECT_GT(force_of(*field)(0, 2), 0);
  EXPECT_LT(force_of(*field)(1, 2), 0);
  r.row(0) = anchor;  // no direction
  EXPECT_EQ(force_of(*field).row(0).norm(), 0);
}

}  // namespace
}  // namespace deform
