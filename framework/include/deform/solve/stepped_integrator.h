/// Integrators that choose their own steps: halving on failure, error control, dense output.
#pragma once

#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "deform/export.h"
#include "deform/plugin/declaration.h"
#include "deform/solve/contact_report.h"
#include "deform/solve/integrator.h"

namespace deform {

class Headway;

/// Parameters that every such integrator has; a plugin's own derive from it and call
/// `StepControl::declare(d)` in their `declare`.
struct StepControl {
  double error = 0;                 ///< of one step, in characteristic lengths; 0: steps are fixed
  double largest_step = kInfinity;  ///< [s]

  template <class Parameters>
  static void declare(Declaration<Parameters>& d) {
    d("error", &StepControl::error, "1",
      "local error that a step may have: root mean square over the mass, in characteristic "
      "lengths; "
      "0: every step is the scene's")
        .at_least(0);
    d("largest_step", &StepControl::largest_step, "s",
      "longest step that error control may choose; states between steps are interpolated")
        .above(0)
        .may_be_infinite();
  }
};

/// An integrator by its single step; this class does the rest:
///
/// A step that fails (no solution, a number that is not finite, a plugin that asks for a shorter
/// one) is tried again with half of it, ten times at most, which the log says; later ones grow
/// again. Steps end where the model's parts stand no longer one (Plugin::longest_step), and where
/// the model is not smooth in time (Plugin::next_break). Without error control the parts of a
/// scene's step end with it. With it, steps go on beyond, as long as the local error allows, and
/// recorded states are interpolated by cubic Hermite polynomials (third order in r).
class DEFORM_API SteppedIntegrator : public Integrator {
 public:
  explicit SteppedIntegrator(StepControl control);
  ~SteppedIntegrator() override;

  void advance(System& system, State& state, double step) final;
  /// As if there had been no step yet, unless a derived class tells what goes on (contact, say)
  /// from what does not.
  void restart() override { forget(); }
  [[nodiscard]] bool resolves_contacts() const final { return true; }
  /// A derived class that remembers anything overrides both and calls these.
  void save(Memory& memory) const override;
  void load(const Memory& memory) override;

 protected:
  /// How a try at a step ended.
  struct Attempt {
    std::string failure;  ///< "" when it succeeded
    /// (N × 3) estimate of the step's local error in r [m]; empty where there is none.
    NodeVectors error;
    bool resolved_contacts = false;  ///< else the framework amends the step's end
    /// Of contact in the step, where that was resolved (ImplicitStage::settle), for its report.
    std::vector<ContactImpulse> contact{};
  };
  /// Makes `to` the state `step` seconds after `from`, prescribed components where constraints say.
  /// May throw what a System throws; that counts as failure, if another step may help.
  [[nodiscard]] virtual Attempt attempt(System& system, const State& from, double step,
                                        State& to) = 0;
  /// Order of the local error in r that `attempt` estimates.
  [[nodiscard]] virtual int local_order() const = 0;
  /// Whether velocities are wrong by the first power of the step: between ends of steps they are
  /// interpolated linearly then, as the slope of positions would be wrong by more.
  [[nodiscard]] virtual bool is_of_first_order() const { return false; }
  /// The last attempt was taken: multistep methods remember it.
  virtual void accept(const State& from, const State& to);
  /// The next step does not go on from the last one.
  virtual void forget();

  /// When loads are looked at for a time of the step that begins at `begin`, whose length is
  /// `step`: within it, as what jumps at its ends belongs to the steps before and after.
  [[nodiscard]] static double within_step(double time, double begin, double step);
  /// Whether attempts are asked for an error.
  [[nodiscard]] bool with_error() const { return control_.error > 0; }
  /// A state in a memory, under names that begin with `name`.
  static void put(Memory& memory, const std::string& name, const State& state);
  [[nodiscard]] static bool has(const Memory& memory, const std::string& name);
  [[nodiscard]] static State get(const Memory& memory, const std::string& name);

 private:
  [[nodiscard]] bool goes_on_from(const State& state) const;
  void advance_fixed(System& system, State& state, double step);
  void advance_adaptive(System& system, State& state, double step);
  void require_representable_error(const System& system, const State& state) const;
  void require_headway(double h, double step) const;
  /// Tries once, with `to` amended by colliders; never throws what a shorter step may mend.
  [[nodiscard]] Attempt try_step(System& system, const State& from, double step, State& to);
  void shorten(double& step, double wanted, const std::string& why);
  /// A try was taken: its steps and its contact go into the step's report.
  static void count(System& system, const State& from, const State& to, double step,
                    const Attempt& attempt);
  [[nodiscard]] static double error_of(const System& system, NodeVectors error);
  void require_last_step() const;
  void interpolate(const System& system, double time, State& state) const;

  StepControl control_;
  State last_;          // that advance gave back
  State to_;            // end of the step that is tried
  State left_, right_;  // ends of the last step, with error control
  double next_ = 0;     // step to try next [s]; 0: not known
  double longest_ = 0;  // that a plugin asked for in the last try [s]; 0: half
  int halvings_ = 0;    // since a step was taken
  std::unique_ptr<Headway> headway_;
  std::exception_ptr cause_;  // of the last failure, where it was thrown
};

}  // namespace deform
