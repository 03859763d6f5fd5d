/// An account of energy over every step, recorded or not: what loads and constraints put in, what
/// damping took, and what is left over, which the method did (or contact, or a term whose force is
/// not the gradient of an energy).
///
/// Forces count by the mean of both ends of a step, times the way in between: exact where they
/// change linearly along it. Where loads or supports are not smooth in time within a step, its
/// parts count one by one, and a load that jumps at the end of one counts before the jump for that
/// one and after it for the next. What prescribed components are pushed by is what is missing in
/// the equation of motion there, m a = f + damping + reaction. Its inertia counts by the mean
/// velocity of the step instead, m (v⁺ − v) · (v + v⁺)/2: that is the change of kinetic energy
/// exactly, also where a prescribed velocity jumps.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <deform/model/reduction.h>
#include <deform/record/probe.h>
#include <deform/surface/surface.h>

namespace {

using namespace deform;

/// Part of a step by which times of breaks may be wrong.
constexpr double kRounding = 1e-9;

double dot(const NodeVectors& a, const NodeVectors& b) { return a.cwiseProduct(b).sum(); }

/// A state, and the forces there (each N × 3) [N].
struct Instant {
  NodeVectors r, v;
  NodeVectors load, internal, damping;
};

/// What went in and out since the first state that was seen [J].
struct Account {
  double first = 0;  ///< energy of that state
  double loads = 0, constraints = 0, damping = 0;
  double turnover = 0;         ///< sum of the sizes of all of these, step by step
  double largest_kinetic = 0;  ///< so far
};

class EnergyBalance final : public Probe {
 public:
  EnergyBalance(const NoParameters& /*parameters*/, const Setup& setup)
      : nodes_(setup.surface().initial().rows()) {}

  void begin(const RunContext& context) override {
    reduction_.emplace(context.system.reduction());
    for (int c = 0; c < 3; ++c)
      for (Index a = 0; a < nodes_; ++a)
        any_prescribed_ = any_prescribed_ || reduction_->reduction().prescribed(a, c);
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"energy_balance.change", "J"},      {"energy_balance.loads", "J"},
            {"energy_balance.constraints", "J"}, {"energy_balance.damping", "J"},
            {"energy_balance.drift", "J"},       {"energy_balance.relative_drift", "1"}};
  }

  void follow(const Frame& frame) override {
    add_part(frame, frame.step_size - counted_);
    counted_ = 0;
  }
  void follow_break(const Frame& frame) override {
    add_part(frame, frame.step_size);
    counted_ += frame.step_size;
  }

  void measure(const Frame& frame, Values figures) override {
    if (!started_) start(frame);
    const double change = kinetic(frame.system, frame.state.v) + internal(frame) - account_.first;
    const double drift = change - account_.loads - account_.constraints + account_.damping;
    const double scale = account_.turnover + account_.largest_kinetic + std::abs(change);
    const double relative = scale > 0 ? drift / scale : 0;
    const std::array all{change,           account_.loads, account_.constraints,
                         account_.damping, drift,          relative};
    std::ranges::copy(all, figures.begin());
  }

  void save(Memory& memory) const override {
    memory.put("started", {started_ ? 1.0 : 0.0});
    if (!started_) return;
    const Account& a = account_;
    memory.put("account",
               {a.first, a.loads, a.constraints, a.damping, a.turnover, a.largest_kinetic});
    each_vector(last_, [&](const std::string& name, const NodeVectors& v) {
      memory.put(name, {v.data(), v.data() + v.size()});
    });
  }

  void load(const Memory& memory) override {
    started_ = memory.get("started", 1).front() != 0;
    if (!started_) return;
    const std::vector<double>& a = memory.get("account", 6);
    account_ = {a[0], a[1], a[2], a[3], a[4], a[5]};
    each_vector(last_, [&](const std::string& name, NodeVectors& v) {
      const auto& values = memory.get(name, static_cast<std::size_t>(3 * nodes_));
      v = Eigen::Map<const NodeVectors>(values.data(), nodes_, 3);
    });
  }

 private:
  template <class Of, class Action>
  static void each_vector(Of& at, const Action& action) {
    action("r", at.r);
    action("v", at.v);
    action("load", at.load);
    action("internal", at.internal);
    action("damping", at.damping);
  }

  static double kinetic(const System& system, const NodeVectors& v) {
    return 0.5 * system.mass().dot(v.rowwise().squaredNorm());
  }

  static double internal(const Frame& frame) {
    const auto& terms = frame.system.energies();
    double sum = 0;
    for (std::size_t i = 0; i < terms.size(); ++i)
      if (terms[i].object->traits().potential) sum += frame.system.energy(i, frame.state);
    return sum;
  }

  [[nodiscard]] Instant instant(const Frame& frame) const {
    System& system = frame.system;
    Instant m{frame.state.r, frame.state.v, system.external_force(frame.state),
              NodeVectors::Zero(nodes_, 3), system.damping_force(frame.state)};
    if (!any_prescribed_) return m;  // only the reaction of constraints asks for it
    for (std::size_t i = 0; i < system.energies().size(); ++i)
      m.internal += system.internal_force(i, frame.state);
    return m;
  }

  void start(const Frame& frame) {
    started_ = true;
    last_ = instant(frame);
    account_ = {};
    account_.largest_kinetic = kinetic(frame.system, last_.v);
    account_.first = account_.largest_kinetic + internal(frame);
  }

  /// A step, or the part of it that ends with this frame, `length` [s].
  void add_part(const Frame& frame, double length) {
    if (!started_) return start(frame);
    Instant now = instant(frame);
    const std::optional<NodeVectors> after = load_after_break(frame, length, now);
    add_work(frame, length, now);
    last_ = std::move(now);
    if (after) last_.load = *after;
  }

  /// At a break makes the load that before it; returns that after it.
  [[nodiscard]] static std::optional<NodeVectors> load_after_break(const Frame& frame,
                                                                   double length, Instant& now) {
    const double time = frame.state.time;
    const double rounding =
        kRounding * length + 16 * std::numeric_limits<double>::epsilon() * std::abs(time);
    if (!(frame.system.next_break(time - rounding) <= time + rounding)) return {};
    State beside = frame.state;
    beside.time = time - 2 * rounding;
    now.load = frame.system.external_force(beside);
    beside.time = time + 2 * rounding;
    return frame.system.external_force(beside);
  }

  void add_work(const Frame& frame, double length, const Instant& now) {
    const NodeVectors way = now.r - last_.r;
    const double loads = 0.5 * dot(last_.load + now.load, way);
    const double damping = -0.5 * (dot(last_.damping, last_.v) + dot(now.damping, now.v)) * length;
    const double constraints = any_prescribed_ ? work_of_constraints(frame, now, way) : 0;
    account_.loads += loads;
    account_.damping += damping;
    account_.constraints += constraints;
    account_.turnover += std::abs(loads) + std::abs(damping) + std::abs(constraints);
    account_.largest_kinetic = std::max(account_.largest_kinetic, kinetic(frame.system, now.v));
  }

  /// The reactions do no work on what the free components bring about: T^T reaction = 0.
  [[nodiscard]] double work_of_constraints(const Frame& frame, const Instant& now,
                                           const NodeVectors& way) const {
    const NodeVectors moved = prescribed_part(way);
    const NodeVectors mean_velocity = prescribed_part(0.5 * (last_.v + now.v));
    if (moved.isZero(0) && mean_velocity.isZero(0)) return 0;
    const NodeVectors gained = frame.system.mass().asDiagonal() * (now.v - last_.v);
    const NodeVectors force =
        0.5 * (last_.load + now.load + last_.internal + now.internal + last_.damping + now.damping);
    return dot(gained, mean_velocity) - dot(force, moved);
  }

  /// Of changes of positions: what the prescribed components do alone, and what is tied to them.
  [[nodiscard]] NodeVectors prescribed_part(NodeVectors change) const {
    const Reduction& reduction = reduction_->reduction();
    for (int c = 0; c < 3; ++c)
      for (Index a = 0; a < nodes_; ++a)
        if (!reduction.prescribed(a, c)) change(a, c) = 0;
    reduction_->complete_changes(change);
    return change;
  }

  Index nodes_;
  std::optional<ReductionMap> reduction_;
  bool any_prescribed_ = false;
  bool started_ = false;
  double counted_ = 0;  // of the step under way, by calls of follow_break [s]
  Account account_;
  Instant last_;
};

}  // namespace

DEFORM_PLUGIN(
    EnergyBalance, NoParameters, .name = "energy_balance", .version = "1.0",
    .summary =
        "Change of kinetic and internal energy (terms with a potential) since the start, work of "
        "loads and of constraints that move nodes, what damping took, all over every step; and "
        "the drift, which is none of these: that of the method, of contact, of terms without a "
        "potential",
    .formula =
        "drift = change - loads - constraints + damping; relative to |change| + largest "
        "kinetic energy + sums of |work| and damping of each step")
