// Scalar unknowns that a surface declares and several energies share.
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "deform/check/mechanics.h"
#include "deform/solve/system.h"

#include "unit/support/fake_surface.h"

namespace deform {
namespace {

/// Two nodes and a scalar: the first edge's elongation.
class Edge final : public test::FakeSurface {
 public:
  Edge() : FakeSurface(2, 2) {}
  [[nodiscard]] std::vector<ScalarUnknown> scalars() const override {
    return {{.initial = 0.25, .mass = 0, .damping = 0}};
  }
};

/// Terms on nodes 0 and 1, the surface's scalar (4) and one of their own (5).
class OnScalars : public TupleTerm {
 public:
  [[nodiscard]] TermTraits traits() const override {
    return {.potential = true, .lagged = Lagged::none};
  }
  [[nodiscard]] std::vector<ScalarUnknown> scalars() const override {
    return {{.initial = -0.5, .mass = 0, .damping = 0}};
  }
  [[nodiscard]] int width() const override { return 4; }
  [[nodiscard]] const std::vector<std::int32_t>& tuples() const override { return tuples_; }

 private:
  std::vector<std::int32_t> tuples_{0, 1, 4, 5};
};

/// E = ½ k (|e| − s)² + ½ (s − o)², s being the surface's scalar and o the term's own.
class Spring final : public OnScalars {
 public:
  explicit Spring(double stiffness) : k_(stiffness) {}
  void energy(const TupleBlock& block, Values energy) const override {
    for (Index i = 0; i < block.size; ++i) {
      const double s = block.r(i, 2).x(), o = block.r(i, 3).x();
      const double stretch = (block.r(i, 0) - block.r(i, 1)).norm() - s;
      energy[i] += 0.5 * k_ * stretch * stretch + 0.5 * (s - o) * (s - o);
    }
  }
  void affine_force(const TupleBlock& block, Values /*k*/, std::span<Vec3> c) const override {
    for (Index i = 0; i < block.size; ++i) {
      const double s = block.r_lagged(i, 2).x(), o = block.r_lagged(i, 3).x();
      const Vec3 e = block.r_lagged(i, 1) - block.r_lagged(i, 0);
      const double tension = k_ * (e.norm() - s);
      c[4 * i] -= tension * e.normalized();
      c[4 * i + 1] += tension * e.normalized();
      c[4 * i + 2].x() += s - o - tension;
      c[4 * i + 3].x() += o - s;
    }
  }

 private:
  double k_;
};

TEST(SharedScalars, AreTheSurfacesAndComeBeforeTheTerms) {
  ModelParts parts;
  parts.surface = std::make_shared<Edge>();
  parts.rest = parts.surface->rest();
  parts.areas = parts.mass = parts.surface->areas();
  parts.damping = NodeValues::Zero(4);
  parts.energies = {{"a", "energy/a", std::make_shared<Spring>(2)},
                    {"b", "energy/b", std::make_shared<Spring>(5)}};
  const System system(std::move(parts));
  ASSERT_EQ(system.rows(), 4 + 3);
  State state = system.at_rest();
  EXPECT_EQ(state.r.col(0).tail(3), Vec3(0.25, -0.5, -0.5));
  state.r(4, 0) = 0.75, state.r(5, 0) = 0.5, state.r(6, 0) = 1;
  // |e| = 1: 2/2 · 0.25² + ½ 0.25² and 5/2 · 0.25² + ½ 0.25²
  EXPECT_DOUBLE_EQ(system.terms().energy(0, state), 0.0625 + 0.03125);
  EXPECT_DOUBLE_EQ(system.terms().energy(1, state), 2.5 * 0.0625 + 0.03125);
  const NodeVectors f = system.evaluator().force(state);
  EXPECT_DOUBLE_EQ(f(4, 0), 2 * 0.25 - 0.25 + 5 * 0.25 + 0.25) << "both act on the shared one";
  EXPECT_DOUBLE_EQ(f(5, 0), 0.25);
  EXPECT_DOUBLE_EQ(f(6, 0), -0.25);
  const State at = disturbed(system, 0.02);
  EXPECT_LT(gradient_error(system, 0, at), 1e-7);
  EXPECT_LT(gradient_error(system, 1, at), 1e-7);
  EXPECT_LT(tangent_error(system, at), 1e-6);
}

}  // namespace
}  // namespace deform
