/// Energy terms: gradients, lagged operators, momenta, blocks.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "deform/check/mechanics.h"

#include "check/bitwise.h"
#include "check/contracts.h"
#include "model/numerical_stress.h"

namespace deform {
namespace {

constexpr double kStrain = 0.05;

std::vector<double> numbers_of(const NodeVectors& v) { return {v.data(), v.data() + v.size()}; }

/// A term on jets with the geometry of one state, evaluated block by block without the framework's
/// assembly.
class JetBench {
 public:
  JetBench(const JetTerm& term, const Surface& surface, const NodeVectors& r,
           Geometry::Detail detail)
      : term_(term), traits_(term.traits()), samples_(surface.samples(term.role())) {
    for (Geometry* g : {&now_, &rest_}) *g = Geometry(samples_);
    now_.compute(samples_, r, detail);
    rest_.compute(samples_, surface.rest());
    make_auxiliary();
  }

  [[nodiscard]] Evaluated evaluate(Index block_size, double prefill) const {
    Evaluated all;
    for (Index first = 0; first < samples_.size(); first += block_size) {
      const Index size = std::min(block_size, samples_.size() - first);
      const SampleBlock block = block_at(first, size);
      GuardedRoom density(size, prefill);
      term_.energy_density(block, density.values());
      take(density, all);
      evaluate_stress(block, prefill, all);
    }
    return all;
  }

  /// Whether the stress is a numerical derivative, for want of a better one.
  [[nodiscard]] bool has_numerical_stress() const {
    return traits_.lagged == Lagged::none &&
           deform::has_numerical_stress(term_, block_at(0, std::min(kBlock, samples_.size())));
  }

  /// The largest difference of second derivatives from the multiples of n nᵀ or I that the term
  /// promises, relative to the largest.
  [[nodiscard]] double tangent_shape_error(Tangent kind) const {
    const bool is_normal = term_.tangent_shape(kind) == TangentShape::normal;
    JetTangent::Places places{};
    std::int16_t blocks = 0;
    for (std::size_t m = 1; m < kDerivatives; ++m)
      for (std::size_t n = m; n < kDerivatives; ++n) places[m][n] = blocks++;
    const Index size = samples_.size(), numbers = Index{9} * blocks * size;
    std::vector<double> h(static_cast<std::size_t>(numbers), 0.0), c(h);
    double largest = 0, difference = 0;
    for (Index first = 0; first < size; first += kBlock) {
      const SampleBlock block = block_at(first, std::min(kBlock, size - first));
      const JetTangent whole(h.data() + first, size, places, block.size());
      const TangentFactors factors(c.data() + first, size, places, block.size());
      term_.tangent(block, kind, whole);
      term_.tangent_factors(block, kind, factors);
      for (int m = 1; m < kDerivatives; ++m)
        for (int n = m; n < kDerivatives; ++n)
          for (Index s = 0; s < 9 * block.size(); ++s) {
            const auto [i, j, at] = std::array{s % 3, s / 3 % 3, s / 9};
            const auto dm = static_cast<Derivative>(m), dn = static_cast<Derivative>(n);
            const Vec3 normal = block.now.n()[at];
            const double entry = whole.entry(dm, dn, static_cast<int>(i), static_cast<int>(j))[at];
            largest = std::max(largest, std::abs(entry));
            const double shape = is_normal ? normal[i] * normal[j] : i == j ? 1.0 : 0.0;
            difference = std::max(difference, std::abs(entry - factors.entry(dm, dn)[at] * shape));
          }
    }
    return largest > 0 ? difference / largest : difference;
  }

 private:
  [[nodiscard]] SampleBlock block_at(Index first, Index size) const {
    return {.now = now_.block(first, size),
            .lagged = now_.block(first, size),
            .rest = rest_.block(first, size),
            .origin = rest_.block(first, size),
            .differences = samples_.field_differences(),
            .auxiliary = views_};
  }

  void make_auxiliary() {
    const auto m = static_cast<std::size_t>(samples_.size());
    const auto fields = static_cast<std::size_t>(term_.auxiliary_fields());
    auxiliary_.resize(fields * m);
    std::vector<Values> out;
    for (std::size_t f = 0; f < fields; ++f) out.emplace_back(auxiliary_.data() + f * m, m);
    if (fields == 0) return;
    for (Index first = 0; first < samples_.size(); first += kBlock) {
      const Index size = std::min(kBlock, samples_.size() - first);
      std::vector<Values> part;
      for (const Values& field : out)
        part.push_back(
            field.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size)));
      term_.auxiliary(block_at(first, size), part);
    }
    views_.assign(out.begin(), out.end());
  }

  void evaluate_stress(const SampleBlock& block, double prefill, Evaluated& all) const {
    std::vector<GuardedRoom> rooms(3 * kChannels, GuardedRoom(block.size(), prefill));
    AffineStress::ConstantTable constants;
    for (std::size_t m = 0; m < constants.size(); ++m)
      constants[m] = {rooms[3 * m].data(), rooms[3 * m + 1].data(), rooms[3 * m + 2].data()};
    if (traits_.lagged == Lagged::none || traits_.direct_stress)
      term_.stress(block, Stress{constants});
    if (traits_.lagged != Lagged::none) {
      std::vector<Coupling> couplings = term_.couplings();
      const std::size_t first_k = rooms.size();
      rooms.resize(first_k + couplings.size(), GuardedRoom(block.size(), prefill));
      AffineStress::CouplingTable table{};
      for (std::size_t m = 0; m < constants.size(); ++m)
        constants[m] = {rooms[3 * m].data(), rooms[3 * m + 1].data(), rooms[3 * m + 2].data()};
      for (std::size_t c = 0; c < couplings.size(); ++c)
        table[static_cast<std::size_t>(slot(couplings[c].first))]
             [static_cast<std::size_t>(slot(couplings[c].second))] = rooms[first_k + c].data();
      term_.affine_stress(block, AffineStress(table, constants, block.size()));
    }
    for (GuardedRoom& room : rooms) take(room, all);
  }

  static void take(GuardedRoom& room, Evaluated& all) {
    const Values values = room.values();
    all.numbers.insert(all.numbers.end(), values.begin(), values.end());
    all.margins_intact = all.margins_intact && room.margins_intact();
  }

  const JetTerm& term_;
  TermTraits traits_;
  const SampleSet& samples_;
  Geometry now_, rest_;
  std::vector<double> auxiliary_;
  std::vector<ConstValues> views_;
};

/// The same numbers in another order of blocks: what differs between block sizes must not be the
/// order in which blocks are written one after another.
Evaluate in_sample_order(const std::shared_ptr<JetBench>& bench, Index samples) {
  return [bench, samples](Index block, double prefill) {
    Evaluated cut = bench->evaluate(block, prefill);
    const std::size_t arrays = cut.numbers.size() / static_cast<std::size_t>(samples);
    std::vector<double> ordered(cut.numbers.size());
    std::size_t from = 0;
    for (Index first = 0; first < samples; first += block) {
      const Index size = std::min(block, samples - first);
      for (std::size_t a = 0; a < arrays; ++a)
        for (Index s = 0; s < size; ++s)
          ordered[a * static_cast<std::size_t>(samples) + static_cast<std::size_t>(first + s)] =
              cut.numbers[from++];
    }
    cut.numbers = std::move(ordered);
    return cut;
  };
}

/// "12" of a derivative, a channel or a pair: its indices.
std::string indices(int slot) {
  constexpr std::array<const char*, kChannels> names{"0",  "1",  "2",      "11",
                                                     "12", "22", "minus1", "minus2"};
  return names.at(static_cast<std::size_t>(slot));
}

/// What the numbers of a JetBench are, in the order of samples: arrays of all samples.
NameOfNumber names_of_jets(const JetTerm& term, Index samples) {
  std::vector<std::string> arrays{"the energy density"};
  for (int m = 0; m < kChannels; ++m)
    for (const char c : {'x', 'y', 'z'})
      arrays.push_back(fmt::format("{} of the stress σ_{}", c, indices(m)));
  if (term.traits().lagged != Lagged::none)
    for (const auto& [m, n] : term.couplings())
      arrays.push_back(
          fmt::format("the coupling k of ({}, {})", indices(slot(m)), indices(slot(n))));
  return [arrays, m = static_cast<std::size_t>(samples)](std::size_t i) {
    return fmt::format("{} at sample {}", arrays.at(i / m), i % m);
  };
}

/// What the numbers of `tuple_evaluation` are.
NameOfNumber names_of_tuples(int width) {
  const auto w = static_cast<std::size_t>(width);
  return [w](std::size_t i) {
    const std::size_t tuple = i / (1 + w * w + 3 * w), k = i % (1 + w * w + 3 * w);
    std::string what = "the energy";
    if (k > w * w) {
      what = fmt::format("{} of the constant of its node {}", "xyz"[(k - 1 - w * w) % 3],
                         (k - 1 - w * w) / 3);
    } else if (k > 0) {
      what = fmt::format("the coefficient K of its nodes ({}, {})", (k - 1) / w, (k - 1) % w);
    }
    return fmt::format("{} of tuple {}", what, tuple);
  };
}

/// Energies, matrices and constants of all tuples, tuple by tuple.
Evaluate tuple_evaluation(const TupleTerm& term, const NodeVectors& r) {
  return [&term, &r](Index block, double prefill) {
    Evaluated all;
    const std::vector<std::int32_t>& nodes = term.tuples();
    const Index w = term.width(), count = static_cast<Index>(nodes.size()) / w;
    for (Index first = 0; first < count; first += block) {
      const Index size = std::min(block, count - first);
      const TupleBlock tuples{first, size, static_cast<int>(w), nodes.data() + first * w, &r, &r};
      GuardedRoom energy(size, prefill), k(size * w * w, prefill);
      std::vector<Vec3> c(static_cast<std::size_t>(size * w), Vec3::Constant(prefill));
      term.energy(tuples, energy.values());
      term.affine_force(tuples, k.values(), c);
      for (Index t = 0; t < size; ++t) {
        all.numbers.push_back(energy.data()[t]);
        all.numbers.insert(all.numbers.end(), k.data() + t * w * w, k.data() + (t + 1) * w * w);
        for (Index a = 0; a < w; ++a)
          for (const double x : c[static_cast<std::size_t>(t * w + a)]) all.numbers.push_back(x);
      }
      all.margins_intact = all.margins_intact && energy.margins_intact() && k.margins_intact();
    }
    return all;
  };
}

/// What a term says that it does not depend on is not computed for it.
void check_reading(const JetTerm& term, const Surface& surface, const NodeVectors& r,
                   Checks& checks) {
  if (term.reads() == Geometry::Detail::second) return;
  const auto is_finite = [&](Geometry::Detail detail) {
    return all_finite(JetBench(term, surface, r, detail).evaluate(kBlock, 0).numbers);
  };
  checks.holds("reads only what it says",
               is_finite(term.reads()) || !is_finite(Geometry::Detail::second), "it reads more");
}

void check_tangent_shapes(const JetTerm& term, const JetBench& bench, Checks& checks) {
  if (!term.traits().potential) return;
  for (const Tangent kind : kTangents)
    if (term.tangent_shape(kind) != TangentShape::blocks)
      checks.below("tangent_factors: of what `tangent` gives, relative",
                   bench.tangent_shape_error(kind), 1e-12);
}

void check_blocks_of(const EnergyTerm& term, const Surface& surface, Checks& checks) {
  const NodeVectors r = disturbed(surface.rest(), kStrain).r;
  if (const auto* tuples = dynamic_cast<const TupleTerm*>(&term)) {
    check_evaluation(checks, tuple_evaluation(*tuples, r), true, names_of_tuples(tuples->width()));
  } else if (const auto* jets = dynamic_cast<const JetTerm*>(&term)) {
    check_reading(*jets, surface, r, checks);
    const auto bench = std::make_shared<JetBench>(*jets, surface, r, jets->reads());
    const Index samples = surface.samples(jets->role()).size();
    check_evaluation(checks, in_sample_order(bench, samples), true, names_of_jets(*jets, samples));
    if (bench->has_numerical_stress())
      checks.report("stress",
                    "none: forces are differences of energy_density, tangents differences "
                    "of these; `stress` makes both exact, and faster");
    check_tangent_shapes(*jets, JetBench(*jets, surface, r, Geometry::Detail::second), checks);
  } else {
    checks.holds("is a JetTerm or a TupleTerm, or a sum of such", false,
                 "it is neither: no force comes of it");
  }
}

void check_blocks(const Subject& subject, const Terrain& terrain, Checks& checks) {
  const Made<EnergyTerm> made = subject.make<EnergyTerm>(terrain);
  const auto* compound = dynamic_cast<const CompoundTerm*>(made.object.get());
  if (compound == nullptr) return check_blocks_of(*made.object, *made.surface, checks);
  for (const CompoundTerm::Part& part : compound->parts())
    check_blocks_of(*part.term, *made.surface, checks);
}

/// The limit of an error that is measured by differences which resolve so much: 1e-6, or what they
/// can tell where that is more; beyond kLeast they tell nothing that could be called passed.
double limit_of(double resolution) {
  constexpr double kPromised = 1e-6, kLeast = 1e-4;
  constexpr double kCertain = 10;  // by this an estimate of rounding may be too low
  return std::clamp(kCertain * resolution, kPromised, kLeast);
}
constexpr const char* kCureOfForces =
    "where the energy is right, `stress` (or `affine_stress`) is not its derivative, or is missing "
    "and the energy's rounding is too large for differences";
constexpr const char* kCureOfTangents =
    "`tangent` or `dependence` is wrong; where there is no `stress`, tangents are differences of "
    "differences, which `stress` makes exact to 1e-9";

void check_operator(const System& system, std::size_t term, const TermTraits& traits,
                    const State& state, Checks& checks) {
  if (traits.lagged == Lagged::none) return;
  checks.below("lagged operator: f = c − K r where it is lagged", lagged_error(system, term, state),
               1e-10);
  const SparseMatrix k = system.terms().lagged_force(term, state).k;
  if (traits.lagged == Lagged::symmetric)
    checks.below("lagged operator: symmetric, as promised", asymmetry(k), 1e-12);
  if (traits.semidefinite)
    checks.below("lagged operator: semidefinite, as promised", indefiniteness(k), 1e-12);
}

/// Energy and force of the rest state turned and moved, against those of the disturbed one.
void report_rigid_motion(const System& system, std::size_t term, const State& state,
                         Checks& checks) {
  State moved = system.at_rest();
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.1, Vec3(1, -2, 0.7).normalized()).toRotationMatrix();
  auto r = moved.r.topRows(system.nodes());
  r = (r * turn.transpose()).eval().rowwise() + Eigen::RowVector3d(3, -1, 2);
  const double scale = system.terms().internal_force(term, state).norm();
  const double force = system.terms().internal_force(term, moved).norm();
  checks.report("force after a rigid motion of the rest state, relative",
                scale > 0 ? force / scale : force);
}

void check_mechanics_of(const System& system, std::size_t term, bool one_frame, Checks& checks) {
  const TermTraits traits = system.energies()[term].object->traits();
  const State state = disturbed(system, kStrain);
  const NodeVectors force = system.terms().internal_force(term, state);
  checks.holds("force is finite", force.allFinite(),
               what_is_not_finite(numbers_of(force), [&](std::size_t i) {
                 const auto n = static_cast<std::size_t>(force.rows());
                 return fmt::format("{} at node {}", "xyz"[i / n], i % n);
               }));
  const double energy = system.terms().energy(term, state);
  checks.holds("energy is finite", std::isfinite(energy), fmt::format("it is {}", energy));
  checks.holds("same force on any number of threads", same_on_threads([&] {
                 return numbers_of(system.terms().internal_force(term, state));
               }),
               "one thread and several differ");
  if (traits.potential && one_frame)
    checks.below("force = −gradient of the energy, as promised",
                 gradient_error(system, term, state),
                 limit_of(gradient_resolution(system, term, state)), kCureOfForces);
  else if (!traits.potential)
    checks.report("force against −gradient of the energy, relative",
                  gradient_error(system, term, state));
  check_operator(system, term, traits, state, checks);
  const Momenta sums = momenta(force.topRows(system.nodes()), state.r.topRows(system.nodes()));
  checks.report("|Σ f| / Σ |f|: momentum", sums.force);
  checks.report("|Σ r×f| / Σ |r||f|: angular momentum", sums.torque);
  report_rigid_motion(system, term, state, checks);
}

/// Tangents of the whole system: there is nothing else in its scene.
void check_tangents(const System& system, Checks& checks) {
  const State state = disturbed(system, kStrain);
  checks.below("exact tangent = −derivative of the force", tangent_error(system, state),
               limit_of(tangent_resolution(system, state)), kCureOfTangents);
  for (const Tangent kind : {Tangent::projected, Tangent::gauss_newton})
    checks.below(kind == Tangent::projected ? "projected tangent: positive semidefinite"
                                            : "Gauss–Newton tangent: positive semidefinite",
                 tangent_indefiniteness(system, state, kind), 1e-10);
}

void check_mechanics(const Subject& subject, const Terrain& terrain, Checks& checks) {
  Simulation simulation = subject.simulation(terrain);
  System& system = simulation.system();
  bool have_potential = true;
  for (std::size_t term = 0; term < system.energies().size(); ++term) {
    check_mechanics_of(system, term, terrain.one_frame, checks);
    have_potential = have_potential && system.energies()[term].object->traits().potential;
  }
  if (have_potential && terrain.one_frame) check_tangents(system, checks);
}

}  // namespace

void check_energy_contract(const Subject& subject, Checks& checks) {
  for (const Terrain& terrain : terrains(17, 13)) {  // more than one block
    checks.at(terrain.name);
    checks.runs("computes forces and energies", [&] { check_blocks(subject, terrain, checks); });
  }
  if (checks.has_failed(kWritesWithin)) return;
  for (const Terrain& terrain : terrains(9, 7)) {
    checks.at(terrain.name);
    checks.runs("computes forces and energies", [&] { check_mechanics(subject, terrain, checks); });
  }
  check_run(subject, checks);
}

}  // namespace deform
