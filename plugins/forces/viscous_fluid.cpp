#include <deform/model/force_field.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

struct Parameters {
  double viscosity = 1;
  Vec3 velocity = Vec3::Zero();
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("viscosity", &Parameters::viscosity, "N·s/m³", "force per area at rest and normal velocity")
        .at_least(0);
    d("velocity", &Parameters::velocity, "m/s", "velocity of the stream");
    d("time", &Parameters::time, "1", "factor of the stream's velocity over time");
  }
};

/// A stream that the surface resists along its normal only. Whichever side n points to, the force
/// is the same. The time profile makes gusts: between them the fluid is still there, at rest.
class ViscousFluid final : public ForceField {
 public:
  ViscousFluid(const Parameters& p, const Setup& setup)
      : nodes_(setup.surface().nodes()),
        viscosity_(p.viscosity),
        velocity_(p.velocity),
        time_(p.time) {}

  [[nodiscard]] double next_break(double after) const override { return time_.next_break(after); }
  [[nodiscard]] ForceTraits traits() const override {
    return {.normals = true, .exact_damping = true};
  }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    const Vec3 u = time_(nodes.time) * velocity_;
    for (Index i = 0; i < nodes.size; ++i) {
      const Vec3 n = nodes.normal[i];
      force.add(i, viscosity_ * nodes.area[i] * n.dot(u - nodes.v[i]) * n);
    }
  }

  [[nodiscard]] std::vector<std::pair<Index, Index>> tangent_pairs() const override {
    std::vector<std::pair<Index, Index>> pairs;
    for (Index a = 0; a < nodes_; ++a) pairs.emplace_back(a, a);
    return pairs;
  }
  /// c A n nᵀ.
  void add_exact_damping(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const override {
    for (Index a = 0; a < nodes_; ++a) {
      const Vec3 n = nodes.normal[a];
      blocks[static_cast<std::size_t>(a)] += viscosity_ * nodes.area[a] * n * n.transpose();
    }
  }

 private:
  Index nodes_;
  double viscosity_;
  Vec3 velocity_;
  TimeProfile time_;
};

}  // namespace

DEFORM_PLUGIN(ViscousFluid, Parameters, .name = "viscous_fluid", .version = "1.0",
              .summary = "wind: a viscous stream through which the surface moves",
              .formula = "f = c A (n·(u − v)) n",
              .source = "Terzopoulos et al. 1987, applied forces")
