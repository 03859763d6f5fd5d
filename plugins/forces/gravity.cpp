#include <deform/model/force_field.h>

namespace {
using namespace deform;

struct Parameters {
  Vec3 acceleration{0, 0, -9.81};
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("acceleration", &Parameters::acceleration, "m/s²", "acceleration of free fall");
    d("time", &Parameters::time, "1", "factor of the acceleration over time");
  }
};

class Gravity final : public ForceField {
 public:
  Gravity(const Parameters& p, const Setup& /*setup*/)
      : acceleration_(p.acceleration), time_(p.time) {}

  [[nodiscard]] double next_break(double after) const override { return time_.next_break(after); }
  [[nodiscard]] ForceTraits traits() const override { return {.potential = true}; }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    const Vec3 g = time_(nodes.time) * acceleration_;
    for (Index i = 0; i < nodes.size; ++i) force.add(i, nodes.mass[i] * g);
  }
  void add_potential(const NodeBlock& nodes, Values energy) const override {
    const Vec3 g = time_(nodes.time) * acceleration_;
    for (Index i = 0; i < nodes.size; ++i) energy[i] -= nodes.mass[i] * g.dot(nodes.r[i]);
  }

 private:
  Vec3 acceleration_;
  TimeProfile time_;
};

}  // namespace

DEFORM_PLUGIN(Gravity, Parameters, .name = "gravity", .version = "1.0",
              .summary = "the same acceleration for every node", .formula = "f = m g",
              .source = "Terzopoulos et al. 1987, applied forces")
