#include <algorithm>
#include <functional>

#include <deform/model/constraint.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

struct Parameters {
  NodeSelection where;
  std::vector<std::string> components{"x", "y", "z"};
  std::vector<double> times;
  std::vector<Vec3> displacements;
  static void declare(Declaration<Parameters>& d) {
    d("where", &Parameters::where, "", "nodes that are moved").required();
    d("components", &Parameters::components, "", "what is prescribed of them")
        .one_of({"x", "y", "z"});
    d("times", &Parameters::times, "s", "when the displacements are reached, ascending").required();
    d("displacements", &Parameters::displacements, "m",
      "from the initial position, one for each time; linear between, constant before and after")
        .required();
  }
};

void check_path(const Parameters& p) {
  if (p.times.empty()) throw InputError("'times' is empty: a path needs one point at least");
  if (p.times.size() != p.displacements.size())
    throw InputError("'times' has " + std::to_string(p.times.size()) +
                     " entries, 'displacements' " + std::to_string(p.displacements.size()) +
                     ": they must be as many");
  const auto later = std::adjacent_find(p.times.begin(), p.times.end(), std::greater_equal<>());
  if (later != p.times.end())
    throw InputError("'times' must ascend, but " + std::to_string(*later) + " is followed by " +
                     std::to_string(*std::next(later)));
}

/// Moves nodes, all by the same displacement, along a path of straight pieces.
class Move final : public Constraint {
 public:
  Move(const Parameters& p, const Setup& setup)
      : nodes_(setup.select(p.where)),
        times_(p.times),
        displacements_(p.displacements),
        initial_(setup.surface().initial()) {
    check_path(p);
    for (const std::string& name : p.components) components_.push_back(name[0] - 'x');
    if (components_.empty()) throw InputError("'components' is empty: name some of x, y, z");
  }

  void reduce(Reduction& reduction) const override {
    for (const Index node : nodes_)
      for (const int c : components_) reduction.prescribe(node, c);
  }
  [[nodiscard]] double next_break(double after) const override {
    return first_after(times_, after);
  }
  void prescribe(double time, NodeVectors& r) const override {
    const Vec3 u = displacement(time);
    for (const Index node : nodes_)
      for (const int c : components_) r(node, c) = initial_(node, c) + u[c];
  }

 private:
  [[nodiscard]] Vec3 displacement(double time) const {
    const auto after = std::upper_bound(times_.begin(), times_.end(), time);
    if (after == times_.begin()) return displacements_.front();
    if (after == times_.end()) return displacements_.back();
    const auto k = static_cast<std::size_t>(after - times_.begin());
    const double s = (time - times_[k - 1]) / (times_[k] - times_[k - 1]);
    return (1 - s) * displacements_[k - 1] + s * displacements_[k];
  }

  std::vector<Index> nodes_;
  std::vector<int> components_;      // 0: x, 1: y, 2: z
  std::vector<double> times_;        // [s]
  std::vector<Vec3> displacements_;  // [m]
  NodeVectors initial_;              // (N × 3) [m]
};

}  // namespace

DEFORM_PLUGIN(Move, Parameters, .name = "move", .version = "1.0",
              .summary = "moves nodes, or single components of them, along a given path",
              .formula = "r_a(t) = r_a(0) + u(t)", .source = "")
