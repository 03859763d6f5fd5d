/// Parts of a mirrored model against parts that were made for the reflected world, and their
/// derivatives against differences.
#include "model/mirrored_parts.h"

#include <algorithm>
#include <array>
#include <memory>
#include <ostream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "deform/surface/shape.h"
#include "deform/surface/surface.h"

#include "support/builtin.h"
#include "support/fake_surface.h"

namespace deform {
namespace {

using test::make_builtin;
using test::nodes_numbered;
using test::parameters;

constexpr double kTime = 0.5;
/// Of numbers of order one, added up in another order.
constexpr double kRounding = 1e-13;
/// Central differences over this are good to about 1e-10, of quantities of order one.
constexpr double kStep = 1e-5, kDifference = 1e-8;

NodeVectors reflected(NodeVectors v) {
  v.col(2) *= -1;
  return v;
}

NodeVectors random_vectors(Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return NodeVectors::NullaryExpr(n, 3, [&] { return uniform(random); });
}

/// Nodes that move, with normals of their own.
struct Motion {
  explicit Motion(Index nodes)
      : r(random_vectors(nodes, 1)), v(random_vectors(nodes, 2)), n(random_vectors(nodes, 3)) {
    n.rowwise().normalize();
  }
  [[nodiscard]] Motion moved(const NodeVectors& dr, const NodeVectors& dv) const {
    Motion there = *this;
    there.r += dr, there.v += dv;
    return there;
  }
  /// The same in the reflected world, in which normals are turned round, too.
  [[nodiscard]] Motion mirror_image() const {
    Motion image = *this;
    image.r = reflected(r), image.v = reflected(v), image.n = -reflected(n);
    return image;
  }
  NodeVectors r, v, n;
};

/// A field of the scene's world and the one that its mirror image is known to be.
struct FieldPair {
  std::string name;
  ParameterValues scene, image;
  friend std::ostream& operator<<(std::ostream& out, const FieldPair& pair) {
    return out << pair.name;
  }
};

/// 5 × 4 nodes, flat.
std::shared_ptr<Surface> make_grid() {
  const Setup setup([](const PluginUse& use, const Setup& inner) {
    return std::static_pointer_cast<Plugin>(make_builtin<Shape>(use.name, {}, inner));
  });
  return make_builtin<Surface>("grid", parameters({{"nodes", std::array<std::int64_t, 2>{5, 4}}}),
                               setup);
}

class MirroredFields : public testing::TestWithParam<FieldPair> {
 protected:
  MirroredFields() : motion_(Motion(surface_->nodes()).mirror_image()) {
    auto setup = test::bare_setup();
    setup.with_surface(*surface_, surface_->rest(), surface_->areas());
    const auto& [name, scene, image] = GetParam();
    scene_ = make_builtin<ForceField>(name, scene, setup);
    image_ = make_builtin<ForceField>(name, image, setup);
    mirrored_ = mirrored(scene_, surface_->nodes());
  }

  [[nodiscard]] NodeBlock block(const Motion& m, Index first, Index size) const {
    const auto length = static_cast<std::size_t>(size);
    return {.first = first,
            .size = size,
            .time = kTime,
            .r = rows_from(m.r, first),
            .v = rows_from(m.v, first),
            .normal = rows_from(m.n, first),
            .area = {surface_->areas().data() + first, length},
            .mass = {surface_->areas().data() + first, length},
            .all_r = rows_from(m.r, 0),
            .all_v = rows_from(m.v, 0)};
  }
  [[nodiscard]] NodeBlock all(const Motion& m) const { return block(m, 0, surface_->nodes()); }

  /// Added to something, in blocks of some size.
  [[nodiscard]] NodeVectors force(const ForceField& field, const Motion& m,
                                  Index size = kBlock) const {
    NodeVectors f = random_vectors(surface_->nodes(), 4);
    for (Index first = 0; first < f.rows(); first += size)
      field.add_force(block(m, first, std::min(size, f.rows() - first)), rows_from(f, first));
    return f;
  }
  [[nodiscard]] double potential(const ForceField& field, const Motion& m) const {
    NodeValues energy = NodeValues::Zero(surface_->nodes());
    field.add_potential(all(m), {energy.data(), static_cast<std::size_t>(energy.size())});
    return energy.sum();
  }
  [[nodiscard]] NodeVectors tangent(const ForceField& field, const Motion& m) const {
    NodeVectors both = NodeVectors::Zero(surface_->nodes(), 3);  // stiffness, damping
    const auto size = static_cast<std::size_t>(both.rows());
    field.add_tangent(all(m), {both.col(0).data(), size}, {both.col(1).data(), size});
    return both;
  }
  /// w·K w for the blocks of pairs of nodes, of which only the upper half is kept.
  template <class AddBlocks>
  [[nodiscard]] double quadratic(const NodeVectors& w, const AddBlocks& add) const {
    const auto pairs = mirrored_->tangent_pairs();
    std::vector<Eigen::Matrix3d> blocks(pairs.size(), Eigen::Matrix3d::Zero());
    add(blocks);
    double sum = 0;
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const auto& [a, b] = pairs[p];
      sum += (a == b ? 1 : 2) * w.row(a).dot(blocks[p] * w.row(b).transpose());
    }
    return sum;
  }
  /// −w·(∂f) w by differences.
  [[nodiscard]] double quadratic_of_force(const NodeVectors& w, bool of_velocity) const {
    const NodeVectors step = kStep * w, none = 0 * w;
    const auto at = [&](double sign) {
      return force(*mirrored_, of_velocity ? motion_.moved(none, sign * step)
                                           : motion_.moved(sign * step, none));
    };
    return -w.cwiseProduct(at(1) - at(-1)).sum() / (2 * kStep);
  }

  std::shared_ptr<Surface> surface_ = make_grid();
  Motion motion_;  // of the mirrored world
  std::shared_ptr<ForceField> scene_, image_, mirrored_;
};

TEST_P(MirroredFields, AreTheFieldsOfTheReflectedWorld) {
  const NodeVectors f = force(*mirrored_, motion_);
  EXPECT_LT((f - force(*image_, motion_)).norm(), kRounding);
  EXPECT_EQ(f, force(*mirrored_, motion_, 7));  // whatever the blocks
  EXPECT_GT((f - force(*scene_, motion_)).norm(), 1e-3);
  const ForceTraits traits = mirrored_->traits();
  EXPECT_EQ(traits.neighbours, scene_->traits().neighbours);
  if (traits.potential) {
    EXPECT_NEAR(potential(*mirrored_, motion_), potential(*image_, motion_), kRounding);
  }
  if (traits.isotropic_tangent || traits.damping_bound) {
    EXPECT_LT((tangent(*mirrored_, motion_) - tangent(*image_, motion_)).norm(), kRounding);
  }
}

TEST_P(MirroredFields, HaveTheTangentsOfTheirForces) {
  const ForceTraits traits = mirrored_->traits();
  for (unsigned seed = 10; seed < 14; ++seed) {
    const NodeVectors w = random_vectors(surface_->nodes(), seed);
    if (traits.exact_tangent) {
      EXPECT_NEAR(quadratic(w, [&](auto& b) { mirrored_->add_exact_tangent(all(motion_), b); }),
                  quadratic_of_force(w, false), kDifference);
    }
    if (traits.exact_damping) {
      EXPECT_NEAR(quadratic(w, [&](auto& b) { mirrored_->add_exact_damping(all(motion_), b); }),
                  quadratic_of_force(w, true), kDifference);
    }
    if (traits.isotropic_tangent) {
      const NodeValues k = tangent(*mirrored_, motion_).col(0);
      EXPECT_NEAR(k.dot(w.rowwise().squaredNorm()), quadratic_of_force(w, false), kDifference);
    }
    if (traits.potential) {
      const NodeVectors step = kStep * w, none = 0 * w;
      const double change = potential(*mirrored_, motion_.moved(step, none)) -
                            potential(*mirrored_, motion_.moved(-step, none));
      const NodeVectors f = force(*mirrored_, motion_) - random_vectors(surface_->nodes(), 4);
      EXPECT_NEAR(-w.cwiseProduct(f).sum(), change / (2 * kStep), kDifference);
    }
  }
}

NodeSelection left_side() {
  NodeSelector selector;
  selector.form = NodeSelector::Form::boundary;
  selector.names = {"left"};
  return {{selector}};
}

ParameterValues spring(const Vec3& anchor, double rest_length) {
  return parameters({{"anchor", anchor},
                     {"stiffness", 2.0},
                     {"rest_length", rest_length},
                     {"where", nodes_numbered({1, 7, 8})}});
}

ParameterValues wind(const Vec3& velocity) {
  return parameters(
      {{"velocity", velocity}, {"air_density", 1.5}, {"drag", 1.2}, {"friction", 0.3}});
}

ParameterValues moment(const Vec3& axis) {
  return parameters({{"moment", 0.7}, {"axis", axis}, {"where", left_side()}});
}

ParameterValues stream(const Vec3& velocity) {
  return parameters({{"viscosity", 0.4}, {"velocity", velocity}});
}

// Vectors are reflected. A pressure pushes along the normal, which is turned round besides, and so
// is the axis that something turns about.
INSTANTIATE_TEST_SUITE_P(
    BuiltIn, MirroredFields,
    testing::Values(FieldPair{"gravity", parameters({{"acceleration", Vec3(1, 2, -3)}}),
                              parameters({{"acceleration", Vec3(1, 2, 3)}})},
                    FieldPair{"spring", spring({0.1, 0.2, 2}, 0), spring({0.1, 0.2, -2}, 0)},
                    FieldPair{"spring", spring({0.1, 0.2, 2}, 0.5), spring({0.1, 0.2, -2}, 0.5)},
                    FieldPair{"viscous_fluid", stream({1, 2, 3}), stream({1, 2, -3})},
                    FieldPair{"wind", wind({1, -2, 3}), wind({1, -2, -3})},
                    FieldPair{"moment", moment({0.3, 1, 0.5}), moment({-0.3, -1, 0.5})},
                    FieldPair{"pressure", parameters({{"pressure", 3.0}}),
                              parameters({{"pressure", -3.0}})}),
    [](const auto& field) { return field.param.name + "_" + std::to_string(field.index); });

/// Pushes along the surface's normals.
class AlongNormals final : public ForceField {
 public:
  [[nodiscard]] ForceTraits traits() const override { return {.normals = true}; }
  void add_force(const NodeBlock& nodes, Vectors force) const override {
    for (Index a = 0; a < nodes.size; ++a) force.add(a, nodes.normal[a]);
  }
};

TEST(MirroredParts, SeeNormalsOnTheOtherSide) {
  const auto field =
      mirrored(std::static_pointer_cast<ForceField>(std::make_shared<AlongNormals>()), 3);
  const Motion motion(3);
  NodeBlock nodes{.size = 3};
  nodes.r = rows_from(motion.r, 0), nodes.v = rows_from(motion.v, 0);
  nodes.normal = rows_from(motion.n, 0);
  NodeVectors f = NodeVectors::Zero(3, 3);
  field->add_force(nodes, rows_from(f, 0));
  EXPECT_EQ(f, -motion.n);
}

/// Remembers a number and knows times.
class Remembering final : public ForceField {
 public:
  void add_force(const NodeBlock& /*nodes*/, Vectors /*force*/) const override {}
  void save(Memory& memory) const override { memory.put("number", {number}); }
  void load(const Memory& memory) override { number = memory.get("number", 1).front(); }
  [[nodiscard]] double longest_step(double time) const override { return time + 1; }
  [[nodiscard]] double next_break(double after) const override { return after + 2; }
  double number = 0;
};

TEST(MirroredParts, RememberAndKnowTimesAsTheirPartsDo) {
  const auto part = std::make_shared<Remembering>();
  const auto image = mirrored(std::static_pointer_cast<ForceField>(part), 1);
  part->number = 5;
  Memory memory;
  image->save(memory);
  EXPECT_EQ(memory.get("number", 1).front(), 5);
  part->number = 0;
  image->load(memory);
  EXPECT_EQ(part->number, 5);
  EXPECT_EQ(image->longest_step(3), 4);
  EXPECT_EQ(image->next_break(3), 5);
}

/// z of a node follows what others do, at a distance.
class Tied final : public Constraint {
 public:
  explicit Tied(double sign) : sign_(sign) {}
  void reduce(Reduction& reduction) const override {
    reduction.prescribe(3, 2);
    reduction.tie({{1, 2}, {{{0, 2}, 0.5}, {{0, 0}, sign_ * 2}, {{2, 1}, sign_ * 3}}, sign_ * 4});
    reduction.tie({{2, 1}, {{{0, 1}, 1}, {{3, 2}, sign_ * 0.5}}, 6});
  }
  void prescribe(double time, NodeVectors& r) const override { r(3, 2) = sign_ * (7 + time); }

 private:
  double sign_;  // −1: of the reflected world
};

TEST(MirroredParts, ConstraintsAreThoseOfTheReflectedWorld) {
  const auto reduced = [](const Constraint& constraint) {
    Reduction reduction(4);
    reduction.tie({{0, 0}, {{{2, 2}, 1.5}}, 1});  // another constraint's: stays as it is
    constraint.reduce(reduction);
    return reduction;
  };
  const auto image = mirrored(std::make_shared<Tied>(1));
  const ReductionMap map(reduced(*image)), expected(reduced(Tied(-1)));
  NodeVectors r = random_vectors(4, 1), s = r;
  image->prescribe(kTime, r);
  Tied(-1).prescribe(kTime, s);
  EXPECT_EQ(r, s);
  map.complete_positions(r);
  expected.complete_positions(s);
  EXPECT_EQ(r, s);
  NodeVectors f = random_vectors(4, 2), g = f;
  map.transpose(f);
  expected.transpose(g);
  EXPECT_EQ(f, g);
  EXPECT_TRUE(map.reduction().prescribed(3, 2));
}

TEST(MirroredParts, CollidersAreThoseOfTheReflectedWorld) {
  struct Pair {
    const char* name;
    ParameterValues scene, image;
  };
  const std::vector<Pair> pairs{
      {"sphere", parameters({{"centre", Vec3(0, 0.1, 0.5)}, {"radius", 0.4}}),
       parameters({{"centre", Vec3(0, 0.1, -0.5)}, {"radius", 0.4}})},
      {"plane", parameters({{"point", Vec3(0, 0, 0.3)}, {"normal", Vec3(0.1, 0.2, 1)}}),
       parameters({{"point", Vec3(0, 0, -0.3)}, {"normal", Vec3(0.1, 0.2, -1)}})},
  };
  const NodeVectors points = random_vectors(300, 1);
  const auto measure = [&](const Collider& body, NodeValues& distance) {
    NodeVectors normal(points.rows(), 3);
    distance.resize(points.rows());
    body.measure(kTime, rows_from(points, 0),
                 {distance.data(), static_cast<std::size_t>(distance.size())},
                 rows_from(normal, 0));
    return normal;
  };
  for (const auto& [name, scene, image] : pairs) {
    const auto body = mirrored(make_builtin<Collider>(name, scene));
    const auto expected = make_builtin<Collider>(name, image);
    NodeValues distance, known;
    const NodeVectors normal = measure(*body, distance);
    EXPECT_LT((normal - measure(*expected, known)).norm(), kRounding) << name;
    EXPECT_LT((distance - known).norm(), kRounding) << name;
    EXPECT_EQ(body->is_convex(), expected->is_convex()) << name;
  }
}

}  // namespace
}  // namespace deform
