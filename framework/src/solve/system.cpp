#include "deform/solve/system.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "not_finite.h"
#include "plugin/guard.h"
#include "solve/system_parts.h"

namespace deform {

namespace {

/// Throws PluginFailure where one cannot be.
void check_scalars(const std::string& origin, const std::vector<ScalarUnknown>& scalars) {
  for (const ScalarUnknown& s : scalars)
    if (!std::isfinite(s.initial) || !(s.mass >= 0) || !(s.damping >= 0) ||
        !std::isfinite(s.mass + s.damping))
      throw PluginFailure(fmt::format(
          "plugin {} has a scalar unknown that is not finite, or whose mass or damping is negative",
          origin));
}

/// Collects the scalar unknowns of the surface and of terms: rows beyond the nodes'.
ModelParts with_scalars(ModelParts parts) {
  parts.scalars = parts.surface->scalars();
  check_scalars("of the surface", parts.scalars);
  for (const Named<EnergyTerm>& energy : parts.energies)
    if (const auto term = std::dynamic_pointer_cast<const TupleTerm>(energy.object)) {
      const std::vector<ScalarUnknown> own =
          guarded(energy.origin, "naming its scalar unknowns", [&] { return term->scalars(); });
      check_scalars(energy.origin, own);
      parts.scalars.insert(parts.scalars.end(), own.begin(), own.end());
    }
  const Index nodes = parts.mass.size(), rows = nodes + std::ssize(parts.scalars);
  parts.mass.conservativeResize(rows);
  parts.damping.conservativeResize(rows);
  for (Index a = nodes; a < rows; ++a) {
    parts.mass[a] = parts.scalars[static_cast<std::size_t>(a - nodes)].mass;
    parts.damping[a] = parts.scalars[static_cast<std::size_t>(a - nodes)].damping;
  }
  return parts;
}

}  // namespace

SystemParts::SystemParts(ModelParts p)
    : model(with_scalars(std::move(p))),
      solvers(model.make_solvers),
      constraints(model),
      contact(model.bodies, model.surface->nodes(), constraints.map()),
      assembly(model, meter),
      evaluator(assembly),
      terms(assembly),
      mass_matrix(*this) {}

System::System(ModelParts parts) : parts_(std::make_unique<SystemParts>(std::move(parts))) {}
System::~System() = default;

Index System::nodes() const { return parts_->model.surface->nodes(); }
Index System::rows() const { return nodes() + std::ssize(parts_->model.scalars); }
const std::vector<ScalarUnknown>& System::scalars() const { return parts_->model.scalars; }
State System::at_rest() const {
  State state{NodeVectors::Zero(rows(), 3), NodeVectors::Zero(rows(), 3), 0};
  state.r.topRows(nodes()) = rest();
  for (Index a = nodes(); a < rows(); ++a)
    state.r(a, 0) = scalars()[static_cast<std::size_t>(a - nodes())].initial;
  return state;
}
const Surface& System::surface() const { return *parts_->model.surface; }
const NodeVectors& System::rest() const { return parts_->model.rest; }
const NodeValues& System::areas() const { return parts_->model.areas; }
const NodeValues& System::mass() const { return parts_->model.mass; }
const NodeValues& System::damping() const { return parts_->model.damping; }
const std::vector<Named<EnergyTerm>>& System::energies() const { return parts_->model.energies; }

const Evaluator& System::evaluator() const { return parts_->evaluator; }
const TermEvaluator& System::terms() const { return parts_->terms; }
const ConstraintSet& System::constraints() const { return parts_->constraints; }
const ColliderContact& System::contact() const { return parts_->contact; }
const MassMatrix& System::mass_matrix() const { return parts_->mass_matrix; }

void System::begin_step() {
  StepReport& report = parts_->meter.report;
  // Their memory is kept.
  std::vector<double> residuals = std::move(report.residuals);
  residuals.clear();
  ContactReport contact = std::move(report.contact);
  contact.clear();
  report = {};
  report.residuals = std::move(residuals);
  report.contact = std::move(contact);
  ++parts_->meter.step;
}

StepReport& System::step_report() { return parts_->meter.report; }
const StepReport& System::step_report() const { return parts_->meter.report; }

const std::string& System::solver_choice() const {
  static const std::string none = "none was needed";
  for (const std::string& choice : parts_->meter.choices)
    if (!choice.empty()) return choice;
  return none;
}

namespace {

/// Calls ask(origin, plugin) for each part of a model that may depend on time.
template <class Ask>
void ask_parts(const ModelParts& parts, const Ask& ask) {
  for (const auto& e : parts.energies) ask(e.origin, *e.object);
  for (const auto& f : parts.forces) ask(f.origin, *f.object);
  for (const auto& c : parts.constraints) ask(c.origin, *c.object);
  for (const auto& b : parts.bodies) ask(b.collider.origin, *b.collider.object);
}

}  // namespace

double System::longest_step(double time) const {
  double longest = kInfinity;
  ask_parts(parts_->model, [&](const std::string& origin, const Plugin& part) {
    const double step =
        guarded(origin, "saying what step it stands", [&] { return part.longest_step(time); });
    if (!(step > 0))
      throw PluginFailure("plugin " + origin + " stands steps of " + std::to_string(step) +
                          " s, expected more than 0");
    longest = std::min(longest, step);
  });
  return longest;
}

double System::next_break(double after) const {
  double first = kInfinity;
  ask_parts(parts_->model, [&](const std::string& origin, const Plugin& part) {
    const double time = guarded(origin, "saying when it is not smooth in time",
                                [&] { return part.next_break(after); });
    if (!(time > after))
      throw PluginFailure(
          fmt::format("plugin {} is not smooth at {} s when asked for later times than {} s",
                      origin, time, after));
    first = std::min(first, time);
  });
  return first;
}

double root_mean_square(const NodeVectors& field, const NodeValues& mass) {
  double sum = 0;
  for (Index c = 0; c < 3; ++c) sum += mass.dot(field.col(c).cwiseAbs2());
  return std::sqrt(sum / mass.sum());
}

}  // namespace deform
