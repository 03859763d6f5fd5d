#include "simulation/shadow_probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "not_finite.h"
#include "simulation/memory_sections.h"

namespace deform {
namespace {

/// A shadow's figures, in the order of its columns.
enum Figure : std::uint8_t { angle_mean, angle_max, force_rms, force_max, force_relative };
struct FigureText {
  const char* name;
  const char* unit;
};
constexpr std::array<FigureText, 5> kFigures{{{"angle.mean", "rad"},
                                              {"angle.max", "rad"},
                                              {"force.rms", "N"},
                                              {"force.max", "N"},
                                              {"force.relative", "1"}}};

/// A message on a shadow, which names it.
std::string naming(const std::string& who, const std::string& message) {
  return message.find(who) == std::string::npos ? who + ": " + message : message;
}

/// Calls f() for a shadow. What fails there is a failure of the shadow's plugin, of numbers that
/// are not finite too: the run itself did not diverge.
template <class F>
decltype(auto) as_shadow(const std::string& who, F&& f) {
  try {
    return std::forward<F>(f)();
  } catch (const NotFinite& e) {
    throw PluginFailure(naming(who, e.what()));
  } catch (const PluginFailure& e) {
    throw PluginFailure(naming(who, e.what()));
  }
}

/// A problem with making a shadow's term, which the message says after its place.
Problem of_shadow(Problem problem, const std::string& who) {
  const std::string place = "at " + problem.pointer + ": ";
  if (problem.message.starts_with(place)) problem.message.erase(0, place.size());
  problem.message = place + naming(who, problem.message);
  return problem;
}

/// What messages call a shadow: plugins and files.
std::string origin_of(const ShadowUse& use, const PluginRegistry& registry) {
  return fmt::format("the shadow {} of {}",
                     registry.load(PluginKind::normal, use.normal.name).origin(),
                     registry.load(PluginKind::energy, use.energy.name).origin());
}

/// Lengths of the rows of an (N × 3) array; neither overflow nor underflow on the way.
NodeValues lengths(const NodeVectors& v) {
  NodeValues result(v.rows());
  for (Index a = 0; a < v.rows(); ++a) result[a] = std::hypot(v(a, 0), v(a, 1), v(a, 2));
  return result;
}

double rms(const NodeValues& values) {
  return values.stableNorm() / std::sqrt(static_cast<double>(values.size()));
}

}  // namespace

ShadowProbe::ShadowProbe(const std::vector<ShadowUse>& uses, const PluginRegistry& registry,
                         PartMaker& maker, const Setup& setup) {
  for (const ShadowUse& use : uses) {
    const std::string origin = origin_of(use, registry);
    try {
      auto object =
          as_shadow(origin, [&] { return registry.create<EnergyTerm>(use.energy, setup); });
      shadows_.push_back({use.name, use.term, {use.energy.name, origin, std::move(object)}});
    } catch (const InputError& e) {
      std::vector<Problem> problems;
      for (const Problem& problem : e.problems()) problems.push_back(of_shadow(problem, origin));
      maker.add(problems);
    }
  }
}

void ShadowProbe::begin(const RunContext& context) {
  const System& run = context.system;
  ModelParts parts;
  // Of the run, which outlives its probes.
  parts.surface = {std::shared_ptr<const Surface>(), &run.surface()};
  parts.rest = run.rest();
  parts.mass = run.mass();
  parts.damping = run.damping();
  std::map<std::size_t, std::size_t> driver_of;  // a term of the run
  for (std::size_t i = 0; i < shadows_.size(); ++i) {
    Shadow& shadow = shadows_[i];
    const auto [driver, is_new] = driver_of.try_emplace(shadow.of, drivers_.size());
    // The run's own terms are in the same System as their shadows: their forces are the same sums
    // in the same order, and what is equal differs by exactly nothing.
    if (is_new) {
      drivers_.push_back({parts.energies.size(), {}});
      parts.energies.push_back(run.energies()[shadow.of]);
    }
    drivers_[driver->second].shadows.push_back(i);
    shadow.number = parts.energies.size();
    parts.energies.push_back(shadow.term);
    term_names_.push_back(run.energies()[shadow.of].name);
  }
  system_ = std::make_unique<System>(std::move(parts));
  estimating_ = terms_with_normal(*system_);
}

std::vector<ProbeColumn> ShadowProbe::columns() const {
  std::vector<ProbeColumn> columns;
  for (std::size_t i = 0; i < shadows_.size(); ++i) {
    for (const auto& [figure, unit] : kFigures) {
      columns.push_back(
          {fmt::format("shadow.{}.{}.{}", shadows_[i].name, term_names_[i], figure), unit});
    }
  }
  return columns;
}

void ShadowProbe::measure(const Frame& frame, Values figures) {
  std::ranges::fill(figures, kNoFigure);
  for (const Driver& driver : drivers_) {
    if (frame.step > 0) measure_angles(driver, frame, figures);  // else no previous state
    measure_forces(driver, frame.state, figures);
  }
}

const JetTermUse* ShadowProbe::estimating(std::size_t number) const {
  const auto found = std::ranges::find(estimating_, number, &JetTermUse::number);
  return found == estimating_.end() ? nullptr : &*found;
}

void ShadowProbe::measure_angles(const Driver& driver, const Frame& frame, Values figures) {
  const JetTermUse* const own = estimating(driver.number);
  if (own == nullptr) return;
  std::vector<Angles> angles(driver.shadows.size());
  const auto lagged = frame.previous_geometry(*own->samples), now = frame.geometry(*own->samples);
  for (const Pair ij : kPairs) {
    const Estimation at{*lagged, *now, ij};
    estimate_normals(*own, at.lagged, at.now, ij, driver_normals_);
    for (std::size_t i = 0; i < driver.shadows.size(); ++i) {
      const Shadow& shadow = shadows_[driver.shadows[i]];
      const JetTermUse* const term = estimating(shadow.number);
      if (term != nullptr) add_angles(shadow, *term, at, angles[i]);
    }
  }
  for (std::size_t i = 0; i < driver.shadows.size(); ++i) {
    if (angles[i].none()) continue;
    const Values own_figures =
        figures.subspan(driver.shadows[i] * kFigures.size(), kFigures.size());
    own_figures[angle_mean] = angles[i].mean();
    own_figures[angle_max] = angles[i].max();
  }
}

void ShadowProbe::add_angles(const Shadow& shadow, const JetTermUse& term, const Estimation& at,
                             Angles& angles) {
  as_shadow(shadow.term.origin,
            [&] { estimate_normals(term, at.lagged, at.now, at.ij, shadow_normals_); });
  const ConstValues area = term.samples->weights();
  for (Index s = 0; s < shadow_normals_.rows(); ++s) {
    angles.add(angle_between(shadow_normals_.row(s), driver_normals_.row(s)),
               area[static_cast<std::size_t>(s)] * multiplicity(at.ij));
  }
}

void ShadowProbe::measure_forces(const Driver& driver, const State& state, Values figures) {
  const NodeVectors own = system_->terms().internal_force(driver.number, state);
  const double own_rms = rms(lengths(own));
  for (const std::size_t i : driver.shadows) {
    const Shadow& shadow = shadows_[i];
    const NodeVectors force = as_shadow(
        shadow.term.origin, [&] { return system_->terms().internal_force(shadow.number, state); });
    const NodeValues difference = lengths(force - own);
    const Values own_figures = figures.subspan(i * kFigures.size(), kFigures.size());
    own_figures[force_rms] = rms(difference);
    own_figures[force_max] = difference.maxCoeff();
    const double relative = own_figures[force_rms] / own_rms;
    if (own_rms > 0 && std::isfinite(relative)) own_figures[force_relative] = relative;
  }
}

void ShadowProbe::save(Memory& memory) const {
  for (std::size_t i = 0; i < shadows_.size(); ++i) {
    const Shadow& shadow = shadows_[i];
    save_plugin(*shadow.term.object, shadow.term.origin, shadow.name + '/' + term_names_[i],
                memory);
  }
}

void ShadowProbe::load(const Memory& memory) {
  for (std::size_t i = 0; i < shadows_.size(); ++i) {
    const Shadow& shadow = shadows_[i];
    load_plugin(*shadow.term.object, shadow.term.origin, shadow.name + '/' + term_names_[i],
                memory);
  }
}

void add_shadows(const Scene& scene, const PluginRegistry& registry, PartMaker& maker,
                 const Setup& setup, ProbeRecorder& probes) {
  if (scene.shadows.empty()) return;
  auto probe = std::make_shared<ShadowProbe>(scene.shadows, registry, maker, setup);
  // No plugin has a name with a space.
  probes.add({"the shadows", "shadow (of the framework)", std::move(probe)}, "/shadow");
}

}  // namespace deform
