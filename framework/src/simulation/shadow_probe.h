/// Shadows: normal estimators that are evaluated beside the run's own, on the same states.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "deform/record/jet_terms.h"
#include "deform/record/probe.h"

#include "simulation/part_maker.h"
#include "simulation/recorders.h"

namespace deform {

/// Measures how far the shadows' normals and forces are from those of the estimators that drive the
/// run. Looks at the run's states and changes nothing of it: the forces are computed by a System of
/// its own, made of the shadowed terms and their shadows, which is evaluated at recorded steps
/// only.
class ShadowProbe final : public Probe {
 public:
  /// Makes the terms with their estimators replaced; problems are left with the maker. Throws
  /// PluginFailure, naming the shadow, for what else their plugins throw.
  ShadowProbe(const std::vector<ShadowUse>& uses, const PluginRegistry& registry, PartMaker& maker,
              const Setup& setup);

  void begin(const RunContext& context) override;
  /// kFigures of each shadow.
  [[nodiscard]] std::vector<ProbeColumn> columns() const override;
  void measure(const Frame& frame, Values figures) override;
  void save(Memory& memory) const override;
  void load(const Memory& memory) override;

 private:
  struct Shadow {
    std::string name;        // of the estimator: "gauss_2"
    std::size_t of = 0;      // number of the shadowed term in the run's System
    Named<EnergyTerm> term;  // with the shadow's estimator; its origin says so
    std::size_t number = 0;  // of this term in system_
  };
  /// An energy term of the run, as it is in system_.
  struct Driver {
    std::size_t number = 0;
    std::vector<std::size_t> shadows;  // of it
  };
  /// Where normals are estimated: coefficients of the lagged geometry on the present jets.
  struct Estimation {
    const Geometry& lagged;
    const Geometry& now;
    Pair ij;
  };

  [[nodiscard]] const JetTermUse* estimating(std::size_t number) const;
  void measure_angles(const Driver& driver, const Frame& frame, Values figures);
  void add_angles(const Shadow& shadow, const JetTermUse& term, const Estimation& at,
                  Angles& angles);
  void measure_forces(const Driver& driver, const State& state, Values figures);

  std::vector<Shadow> shadows_;
  std::vector<Driver> drivers_;
  std::vector<std::string> term_names_;  // of each shadow's term in the run
  std::unique_ptr<System> system_;
  std::vector<JetTermUse> estimating_;  // the terms of system_ that show their estimator
  NodeVectors driver_normals_, shadow_normals_;
};

/// Adds the scene's shadows to the probes of its run, if it has any.
void add_shadows(const Scene& scene, const PluginRegistry& registry, PartMaker& maker,
                 const Setup& setup, ProbeRecorder& probes);

}  // namespace deform
