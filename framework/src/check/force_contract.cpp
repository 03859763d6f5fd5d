/// Force fields: potentials and tangents against differences, blocks of nodes.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <fmt/format.h>

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
            .mass = {mass.data() + first, count},
            .all_r = field.traits().neighbours ? rows_from(r, 0) : ConstVectors{},
            .all_v = field.traits().neighbours ? rows_from(v, 0) : ConstVectors{}};
  }
  [[nodiscard]] NodeVectors force() const {
    NodeVectors f = NodeVectors::Zero(r.rows(), 3);
    field.add_force(block(0, r.rows()), rows_from(f, 0));
    return f;
  }
  [[nodiscard]] NodeValues potential() const {
    NodeValues energy = NodeValues::Zero(r.rows());
    field.add_potential(block(0, r.rows()), values_of(energy));
    return energy;
  }
  /// (N) The factors of add_tangent.
  struct Tangent {
    NodeValues stiffness, damping;
  };
  [[nodiscard]] Tangent tangent() const {
    Tangent t{NodeValues::Zero(r.rows()), NodeValues::Zero(r.rows())};
    field.add_tangent(block(0, r.rows()), values_of(t.stiffness), values_of(t.damping));
    return t;
  }

 private:
  [[nodiscard]] static Values values_of(NodeValues& v) {
    return {v.data(), static_cast<std::size_t>(v.size())};
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
      if (traits.isotropic_tangent || traits.damping_bound)
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

/// Vectors of about unit length at n nodes, the same for the same seed.
NodeVectors random_directions(Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  return NodeVectors::NullaryExpr(n, 3, [&] { return uniform(random); });
}

/// What the numbers of `evaluation` are.
std::string name_of_number(std::size_t i) {
  constexpr std::array<const char*, 6> numbers{"the force along x",     "the force along y",
                                               "the force along z",     "the tangent's stiffness",
                                               "the tangent's damping", "the potential"};
  return fmt::format("{} at node {}", numbers.at(i % 6), i / 6);
}

constexpr const char* kIsGradient = "force = −gradient of the potential, as promised";

/// The whole energy along some directions: nodes depend on each other.
void check_joint_potential(Cloud c, Checks& checks) {
  constexpr double h = 1e-4;
  const NodeVectors force = c.force(), r = c.r;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const NodeVectors w = random_directions(r.rows(), seed);
    const auto energy_at = [&](double step) {
      c.r = r + step * w;
      return c.potential().sum();
    };
    const double slope =
        (8 * (energy_at(h) - energy_at(-h)) - (energy_at(2 * h) - energy_at(-2 * h))) / (12 * h);
    checks.below(kIsGradient, relative(std::abs(force.cwiseProduct(w).sum() + slope), force.norm()),
                 1e-6);
  }
}

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
  checks.below(kIsGradient, relative((force - difference).norm(), force.norm()), 1e-6);
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
  const auto [stiffness, damping] = c.tangent();
  check_tangent(c, &Cloud::r, stiffness, "−∂f/∂r = the stiffness of its tangent", checks);
  check_tangent(c, &Cloud::v, damping, "−∂f/∂v = the damping of its tangent", checks);
}

/// The largest −w·(∂f/∂v) w / Σ d |w|² that a power iteration finds: at most 1 where d is a bound.
void check_damping_bound(Cloud c, Checks& checks) {
  constexpr double h = 1e-5;
  const auto [stiffness, damping] = c.tangent();
  checks.holds("a bound of the damping comes without a stiffness", stiffness.isZero(0),
               "it has written one");
  const NodeVectors v = c.v;
  const auto drag = [&](const NodeVectors& w) {  // −(∂f/∂v) w
    c.v = v - h * w;
    NodeVectors f = c.force();
    c.v = v + h * w;
    f -= c.force();
    return NodeVectors(f / (2 * h));
  };
  const double floor = 1e-12 * damping.maxCoeff();  // nodes that nothing holds back
  NodeVectors w = random_directions(v.rows(), 1);
  double largest = 0;
  for (int iteration = 0; iteration < 12; ++iteration) {
    const NodeVectors dragged = drag(w);
    const double bound = w.rowwise().squaredNorm().dot(damping);
    largest = std::max(largest, relative(dragged.cwiseProduct(w).sum(), bound));
    if (floor == 0 || dragged.isZero(0)) break;
    for (int k = 0; k < 3; ++k)
      w.col(k) = dragged.col(k).array() / (damping.array().max(floor) + floor);
    w /= w.cwiseAbs().maxCoeff();
  }
  checks.below("−∂f/∂v is at most the damping that bounds it", largest, 1 + 1e-6);
}

void check_pairs(const Cloud& c, Checks& checks) {
  auto pairs = c.field.tangent_pairs();
  const Index n = c.r.rows();
  std::ranges::sort(pairs);
  checks.holds("its tangent's pairs of nodes are ascending, existing, each once",
               std::ranges::adjacent_find(pairs) == pairs.end() &&
                   std::ranges::all_of(pairs,
                                       [&](const auto& p) {
                                         return 0 <= p.first && p.first <= p.second && p.second < n;
                                       }),
               "one is not");
}

/// y·K y for the matrix of blocks between pairs of nodes, the lower half being the upper's mirror.
double quadratic_form(const Cloud& c, const std::vector<Eigen::Matrix3d>& blocks,
                      const NodeVectors& y) {
  const auto pairs = c.field.tangent_pairs();
  double sum = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto& [a, b] = pairs[p];
    sum += (a == b ? 1 : 2) * y.row(a).dot(blocks[p] * y.row(b).transpose());
  }
  return sum;
}

/// y·K y against the change of y·f along y in x, positions or velocities, by fourth-order
/// differences: for all y, that is the symmetric part of −∂f/∂x.
void check_blocks(Cloud c, NodeVectors Cloud::*x, const std::vector<Eigen::Matrix3d>& blocks,
                  const char* name, Checks& checks) {
  constexpr double h = 1e-5;
  double scale = c.force().norm();
  for (const Eigen::Matrix3d& block : blocks) scale = std::max(scale, block.norm());
  const NodeVectors at = c.*x;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const NodeVectors y = random_directions(at.rows(), seed);
    const auto along = [&](double step) {
      c.*x = at + step * y;
      return c.force().cwiseProduct(y).sum();
    };
    const double found = -(8 * (along(h) - along(-h)) - (along(2 * h) - along(-2 * h))) / (12 * h);
    checks.below(name, relative(std::abs(quadratic_form(c, blocks, y) - found), scale), 1e-6);
  }
}

void check_exact_tangent(const Cloud& c, Checks& checks) {
  check_pairs(c, checks);
  std::vector<Eigen::Matrix3d> blocks(c.field.tangent_pairs().size(), Eigen::Matrix3d::Zero());
  c.field.add_exact_tangent(c.block(0, c.r.rows()), blocks);
  check_blocks(c, &Cloud::r, blocks, "exact tangent = −∂f/∂r, symmetric part", checks);
}

void check_exact_damping(const Cloud& c, Checks& checks) {
  check_pairs(c, checks);
  std::vector<Eigen::Matrix3d> blocks(c.field.tangent_pairs().size(), Eigen::Matrix3d::Zero());
  c.field.add_exact_damping(c.block(0, c.r.rows()), blocks);
  check_blocks(c, &Cloud::v, blocks, "exact damping = −∂f/∂v, symmetric part", checks);
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const NodeVectors y = random_directions(c.r.rows(), seed);
    checks.holds("exact damping takes energy", quadratic_form(c, blocks, y) >= 0,
                 "it gives energy to a random motion");
  }
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
      check_breaks(*made.object, checks);
      for (const double time : {0.0, 0.37, 5.0}) {
        const Cloud c = cloud(made, time);
        check_evaluation(checks, evaluation(c), true, name_of_number);
        if (!traits.neighbours) check_locality(c, checks);
        if (traits.potential)
          traits.neighbours ? check_joint_potential(c, checks) : check_potential(c, checks);
        if (traits.isotropic_tangent) check_tangents(c, checks);
        if (traits.damping_bound) check_damping_bound(c, checks);
        if (traits.exact_tangent) check_exact_tangent(c, checks);
        if (traits.exact_damping) check_exact_damping(c, checks);
        checks.report("largest force on a node", c.force().rowwise().norm().maxCoeff(), "N");
      }
    });
  }
  if (!checks.has_failed(kWritesWithin)) check_run(subject, checks);
}

}  // namespace deform
