/// Whether a state of equilibrium is one that the surface stays at.
#include <cmath>
#include <numbers>
#include <optional>

#include <deform/record/probe.h>
#include <deform/solve/newton_matrix.h>

namespace {

using namespace deform;

/// Eigenvalues of K x = λ M x with the exact tangent K and the nodes' masses M: squares of circular
/// frequencies; a negative one says that the surface leaves the state.
class StabilityProbe final : public Probe {
 public:
  StabilityProbe(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {
        {"stability.lowest", "1/s²"}, {"stability.negative", ""}, {"stability.frequency", "Hz"}};
  }

  void measure(const Frame& frame, Values figures) override {
    if (!frame.system.evaluator()
             .without_tangent()
             .empty()) {  // what has no potential has no such eigenvalues
      for (double& figure : figures) figure = kNoFigure;
      return;
    }
    if (!tangent_) tangent_.emplace(frame.system);
    tangent_->evaluate(frame.state);
    const NewtonMatrix::Stability s = tangent_->stability();
    figures[0] = s.lowest;
    figures[1] = static_cast<double>(s.negative);
    figures[2] = s.lowest >= 0 ? std::sqrt(s.lowest) / (2 * std::numbers::pi) : kNoFigure;
  }

 private:
  std::optional<NewtonMatrix> tangent_;  // of the run's system
};

}  // namespace

DEFORM_PLUGIN(StabilityProbe, NoParameters, .name = "stability", .version = "1.0",
              .summary = "lowest eigenvalue of the exact tangent, and its frequency",
              .formula = "K x = λ M x, frequency √λ/2π", .source = "")
