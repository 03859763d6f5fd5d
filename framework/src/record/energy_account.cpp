#include "deform/record/energy_account.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "deform/model/reduction.h"
#include "deform/record/loads_at.h"

#include "solve/asked.h"

namespace deform {
namespace {

double dot(const NodeVectors& a, const NodeVectors& b) { return a.cwiseProduct(b).sum(); }

double kinetic(const System& system, const NodeVectors& v) {
  return 0.5 * system.mass().dot(v.rowwise().squaredNorm());
}

double internal(const Frame& frame) {
  const auto& terms = frame.system.energies();
  double sum = 0;
  for (std::size_t i = 0; i < terms.size(); ++i)
    if (has_potential(terms[i])) sum += frame.system.terms().energy(i, frame.state);
  return sum;
}

/// A state, and the forces there (each N × 3) [N].
struct Instant {
  NodeVectors r, v;
  NodeVectors load, internal, damping;
};

/// What went in and out since the first state that was seen [J].
struct Account {
  double first = 0;  ///< energy of that state
  double loads = 0, constraints = 0, damping = 0, contact = 0, friction = 0;
  double turnover = 0;         ///< sum of the sizes of all of these, step by step
  double largest_kinetic = 0;  ///< so far

  [[nodiscard]] std::vector<double> numbers() const {
    return {first, loads, constraints, damping, contact, friction, turnover, largest_kinetic};
  }
  static Account of(const Memory& memory) {
    const std::vector<double>& n = memory.get("account", 8);
    return {n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7]};
  }
};

template <class Of, class Action>
void each_vector(Of& at, const Action& action) {
  action("r", at.r);
  action("v", at.v);
  action("load", at.load);
  action("internal", at.internal);
  action("damping", at.damping);
}

}  // namespace

double EnergyFigures::scale() const { return turnover + largest_kinetic + std::abs(change); }

struct EnergyAccount::Impl {
  explicit Impl(const System& system)
      : nodes(system.rows()), reduction(system.constraints().reduction()) {
    for (int c = 0; c < 3; ++c)
      for (Index a = 0; a < nodes; ++a)
        any_prescribed = any_prescribed || reduction.reduction().prescribed(a, c);
  }

  /// The state of a frame under these loads (N × 3) [N].
  [[nodiscard]] Instant instant(const Frame& frame, NodeVectors load) const;
  void add_work(const Frame& frame, const Instant& now);
  void add_contact(const ContactReport& contact, End end);
  [[nodiscard]] double work_of_constraints(const Frame& frame, const Instant& now,
                                           const NodeVectors& displacement) const;
  [[nodiscard]] NodeVectors prescribed_part(NodeVectors change) const;

  Index nodes;
  ReductionMap reduction;
  bool any_prescribed = false;
  bool started = false;
  Account account;
  double counted_normal = 0, counted_friction = 0;  // of the step under way [J]
  Instant last;
};

Instant EnergyAccount::Impl::instant(const Frame& frame, NodeVectors load) const {
  const System& system = frame.system;
  Instant m{frame.state.r, frame.state.v, std::move(load), NodeVectors::Zero(nodes, 3),
            system.evaluator().damping_force(frame.state)};
  if (!any_prescribed) return m;  // only the reaction of constraints asks for it
  for (std::size_t i = 0; i < system.energies().size(); ++i)
    m.internal += system.terms().internal_force(i, frame.state);
  return m;
}

void EnergyAccount::Impl::add_work(const Frame& frame, const Instant& now) {
  const NodeVectors displacement = now.r - last.r;
  const double loads = 0.5 * dot(last.load + now.load, displacement);
  const double damping = -0.5 * dot(last.damping + now.damping, displacement);
  const double constraints = any_prescribed ? work_of_constraints(frame, now, displacement) : 0;
  account.loads += loads;
  account.damping += damping;
  account.constraints += constraints;
  account.turnover += std::abs(loads) + std::abs(damping) + std::abs(constraints);
  account.largest_kinetic = std::max(account.largest_kinetic, kinetic(frame.system, now.v));
}

/// What the report of the scene's step has since the last part.
void EnergyAccount::Impl::add_contact(const ContactReport& contact, End end) {
  const double normal = contact.normal_work() - counted_normal,
               friction = contact.friction_work() - counted_friction;
  account.contact += normal;
  account.friction += friction;
  account.turnover += std::abs(normal) + std::abs(friction);
  const bool goes_on = end == End::at_break;
  counted_normal = goes_on ? contact.normal_work() : 0;
  counted_friction = goes_on ? contact.friction_work() : 0;
}

/// The reactions do no work on what the free components bring about: T^T reaction = 0.
double EnergyAccount::Impl::work_of_constraints(const Frame& frame, const Instant& now,
                                                const NodeVectors& displacement) const {
  const NodeVectors moved = prescribed_part(displacement);
  const NodeVectors mean_velocity = prescribed_part(0.5 * (last.v + now.v));
  if (moved.isZero(0) && mean_velocity.isZero(0)) return 0;
  const NodeVectors gained = frame.system.mass().asDiagonal() * (now.v - last.v);
  const NodeVectors force =
      0.5 * (last.load + now.load + last.internal + now.internal + last.damping + now.damping);
  return dot(gained, mean_velocity) - dot(force, moved);
}

/// Of changes of positions: what the prescribed components do alone, and what is tied to them.
NodeVectors EnergyAccount::Impl::prescribed_part(NodeVectors change) const {
  const Reduction& of = reduction.reduction();
  for (int c = 0; c < 3; ++c)
    for (Index a = 0; a < nodes; ++a)
      if (!of.prescribed(a, c)) change(a, c) = 0;
  reduction.complete_changes(change);
  return change;
}

EnergyAccount::EnergyAccount(const System& system) : impl_(std::make_unique<Impl>(system)) {}
EnergyAccount::~EnergyAccount() = default;
EnergyAccount::EnergyAccount(EnergyAccount&&) noexcept = default;
EnergyAccount& EnergyAccount::operator=(EnergyAccount&&) noexcept = default;

bool EnergyAccount::has_started() const { return impl_->started; }

void EnergyAccount::start(const Frame& frame) {
  Impl& s = *impl_;
  s.started = true;
  s.counted_normal = s.counted_friction = 0;
  s.last = s.instant(frame, loads_at(frame, frame.step_size).after);
  s.account = {};
  s.account.largest_kinetic = kinetic(frame.system, s.last.v);
  s.account.first = s.account.largest_kinetic + internal(frame);
}

void EnergyAccount::add_part(const Frame& frame, double length, End end) {
  Impl& s = *impl_;
  if (!s.started) return start(frame);
  s.add_contact(frame.system.step_report().contact, end);
  LoadsAt loads = loads_at(frame, length);
  Instant now = s.instant(frame, std::move(loads.before));
  s.add_work(frame, now);
  s.last = std::move(now);
  s.last.load = std::move(loads.after);
}

EnergyFigures EnergyAccount::figures(const Frame& frame) const {
  const Account& a = impl_->account;
  return {.change = kinetic(frame.system, frame.state.v) + internal(frame) - a.first,
          .loads = a.loads,
          .constraints = a.constraints,
          .damping = a.damping,
          .contact = a.contact,
          .friction = a.friction,
          .turnover = a.turnover,
          .largest_kinetic = a.largest_kinetic};
}

void EnergyAccount::save(Memory& memory) const {
  memory.put("started", {impl_->started ? 1.0 : 0.0});
  if (!impl_->started) return;
  memory.put("account", impl_->account.numbers());
  each_vector(impl_->last, [&](const std::string& name, const NodeVectors& v) {
    memory.put(name, {v.data(), v.data() + v.size()});
  });
}

void EnergyAccount::load(const Memory& memory) {
  Impl& s = *impl_;
  s.started = memory.get("started", 1).front() != 0;
  if (!s.started) return;
  s.account = Account::of(memory);
  each_vector(s.last, [&](const std::string& name, NodeVectors& v) {
    const auto& values = memory.get(name, static_cast<std::size_t>(3 * s.nodes));
    v = Eigen::Map<const NodeVectors>(values.data(), s.nodes, 3);
  });
}

}  // namespace deform
