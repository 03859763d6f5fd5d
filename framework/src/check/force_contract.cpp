/// Force fields: potentials and tangents against differences, blocks of nodes.
#include <cmath>
#include <random>

#include "check/bitwise.h"
#include "check/contracts.h"

namespace deform {
namespace {

/// Positions, velocities and normals of some nodes, and the force field that acts on them.
struct Cloud {
  const ForceField& field;
  NodeVectors r, v, normal;
  NodeValues area, mass;
  double time = 0;

  [[nodiscard]] NodeBlock block(Index first, Index size) const {
    const auto count = static_cast<std::size_t>(size);
    return {.first = first,
            .size = size,
            .time = time,
            .r = rows_from(r, first),
            .v = rows_from(v, first),
            .normal = field.traits().normals ? rows_from(normal, first) : ConstVectors{},
            .area = {area.data() + first, count},
            .mass = {mass.data() + first, count}};
  }
  [[nodiscard]] NodeVectors force() const {
    NodeVectors f = NodeVectors::Zero(r.rows(), 3);
    field.add_force(block(0, r.rows()), rows_from(f, 0));
    return f;
  }
  [[nodiscard]] NodeValues potential() const {
    NodeValues energy = NodeValues::Zero(r.rows());
    field.add_potential(block(0, r.rows()), {energy.data(), static_cast<std::size_t>(r.rows())});
    return energy;
  }
};

Cloud cloud(const Made<ForceField>& made, double time) {
  std::mt19937 random(54321);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Index n = made.surface->nodes();
  const auto scattered = [&] {
    return NodeVectors::NullaryExpr(n, 3, [&] { return uniform(random); });
  };
  Cloud c{*made.object,          made.surface->rest(),        {},  {},
          made.surface->areas(), 0.1 * made.surface->areas(), time};
  c.r += 0.1 * NodeVectors(scattered());
  c.v = scattered();
  c.normal = scattered();
  c.normal.rowwise().normalize();
  return c;
}

/// Forces (and tangents, potentials where they are offered), node by node.
Evaluate evaluation(const Cloud& c) {
  return [&c](Index block_size, double prefill) {
    Evaluated all;
    const ForceTraits traits = c.field.traits();
    for (Index first = 0; first < c.r.rows(); first += block_size) {
      const Index size = std::min(block_size, c.r.rows() - first);
      std::vector<GuardedRoom> rooms(6, GuardedRoom(size, prefill));
      const NodeBlock block = c.block(first, size);
      c.field.add_force(block, {rooms[0].data(), rooms[1].data(), rooms[2].data()});
      if (traits.isotropic_tangent)
        c.field.add_tangent(block, rooms[3].values(), rooms[4].values());
      if (traits.potential) c.field.add_potential(block, rooms[5].values());
      for (Index i = 0; i < size; ++i)
        for (GuardedRoom& room : rooms) all.numbers.push_back(room.data()[i]);
      for (const GuardedRoom& room : rooms)
        all.margins_intact = all.margins_intact && room.margins_intact();
    }
    return all;
  };
}

double relative(double error, double scale) { return error == 0 ? 0 : error / scale; }

/// Every node is moved at once: a node's force and energy depend on that node alone.
void check_potential(Cloud c, Checks& checks) {
  constexpr double h = 1e-5;
  const NodeVectors force = c.force(), r = c.r;
  NodeVectors difference(r.rows(), 3);
  for (int k = 0; k < 3; ++k) {
    const auto energy_at = [&](double step) {
      c.r = r;
      c.r.col(k).array() += step;
      return c.potential();
    };
    difference.col(k) =
        -(8 * (energy_at(h) - energy_at(-h)) - (energy_at(2 * h) - energy_at(-2 * h))) / (12 * h);
  }
  checks.below("force = −gradient of the potential, as promised",
               relative((force - difference).norm(), force.norm()), 1e-6);
}

/// −∂f/∂x against the factor that add_tangent gives; x: positions or velocities.
void check_tangent(Cloud c, NodeVectors Cloud::*x, const NodeValues& factor, const char* name,
                   Checks& checks) {
  constexpr double h = 1e-5;
  const NodeVectors at = c.*x;
  const double scale = c.force().norm() + factor.norm();
  double error = 0;
  for (int k = 0; k < 3; ++k) {
    const auto force_at = [&](double step) {
      c.*x = at;
      (c.*x).col(k).array() += step;
      return c.force();
    };
    NodeVectors tangent = -(force_at(h) - force_at(-h)) / (2 * h);
    tangent.col(k) -= factor;
    error = std::max(error, tangent.norm());
  }
  checks.below(name, relative(error, scale), 1e-6);
}

void check_tangents(const Cloud& c, Checks& checks) {
  NodeValues stiffness = NodeValues::Zero(c.r.rows()), damping = stiffness;
  const auto size = static_cast<std::size_t>(c.r.rows());
  c.field.add_tangent(c.block(0, c.r.rows()), {stiffness.data(), size}, {damping.data(), size});
  check_tangent(c, &Cloud::r, stiffness, "−∂f/∂r = the stiffness of its tangent", checks);
  check_tangent(c, &Cloud::v, damping, "−∂f/∂v = the damping of its tangent", checks);
}

/// Moves every other node and looks at the rest.
void check_locality(Cloud c, Checks& checks) {
  const NodeVectors before = c.force();
  for (Index a = 1; a < c.r.rows(); a += 2) {
    c.r.row(a).array() += 0.1;
    c.v.row(a).array() -= 0.1;
  }
  const NodeVectors after = c.force();
  bool is_same = true;
  for (Index a = 0; a < c.r.rows(); a += 2) is_same = is_same && before.row(a) == after.row(a);
  checks.holds("a node's force depends on that node alone", is_same,
               "it changed when the neighbours were moved");
}

}  // namespace

void check_force_contract(const Subject& subject, Checks& checks) {
  for (const Terrain& terrain : terrains(17, 13)) {
    checks.at(terrain.name);
    checks.runs("computes forces", [&] {
      const Made<ForceField> made = subject.make<ForceField>(terrain);
      const ForceTraits traits = made.object->traits();
      for (const double time : {0.0, 0.37, 5.0}) {
        const Cloud c = cloud(made, time);
        check_evaluation(checks, evaluation(c), true);
        check_locality(c, checks);
        if (traits.potential) check_potential(c, checks);
        if (traits.isotropic_tangent) check_tangents(c, checks);
        checks.report("largest force on a node", c.force().rowwise().norm().maxCoeff(), "N");
      }
    });
  }
  if (!checks.has_failed(kWritesWithin)) check_run(subject, checks);
}

}  // namespace deform
