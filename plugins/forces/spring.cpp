#include <deform/model/force_field.h>

#include "area_shares.h"

namespace {
using namespace deform;

struct Parameters {
  Vec3 anchor = Vec3::Zero();
  double stiffness = 1;
  double rest_length = 0;
  NodeSelection where;
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("anchor", &Parameters::anchor, "m", "fixed point that the nodes are pulled to").required();
    d("stiffness", &Parameters::stiffness, "N/m", "of all nodes' springs together").at_least(0);
    d("rest_length", &Parameters::rest_length, "m", "distance at which there is no force")
        .at_least(0);
    d("where", &Parameters::where, "",
      "a patch of the surface, or nodes that share the stiffness in proportion to their areas")
        .required();
    d("time", &Parameters::time, "1", "factor of the stiffness over time");
  }
};

class Spring final : public ForceField {
 public:
  Spring(const Parameters& p, const Setup& setup)
      : anchor_(p.anchor),
        length_(p.rest_length),
        time_(p.time),
        k_(p.stiffness * area_shares(p.where, setup)) {}

  [[nodiscard]] double next_break(double after) const override { return time_.next_break(after); }
  /// Only without a rest length is ∂f/∂r a multiple of the identity.
  [[nodiscard]] ForceTraits traits() const override {
    return {.potential = true, .isotropic_tangent = length_ == 0, .exact_tangent = length_ > 0};
  }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    const double factor = time_(nodes.time);
    for (Index i = 0; i < nodes.size; ++i) {
      const Vec3 d = nodes.r[i] - anchor_;
      force.add(i, -factor * k_[nodes.first + i] * secant(d.norm()) * d);
    }
  }
  void add_tangent(const NodeBlock& nodes, Values stiffness, Values /*damping*/) const override {
    const double factor = time_(nodes.time);
    for (Index i = 0; i < nodes.size; ++i) stiffness[i] += factor * k_[nodes.first + i];
  }
  [[nodiscard]] std::vector<std::pair<Index, Index>> tangent_pairs() const override {
    std::vector<std::pair<Index, Index>> pairs;
    for (Index a = 0; a < k_.size(); ++a)
      if (k_[a] > 0) pairs.emplace_back(a, a);
    return pairs;
  }
  /// −∂f/∂r = k (e eᵀ + (1 − L/|d|) (I − e eᵀ)), e = d/|d|: along the spring, and across it.
  void add_exact_tangent(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const override {
    const double factor = time_(nodes.time);
    auto block = blocks.begin();
    for (Index a = 0; a < k_.size(); ++a) {
      if (!(k_[a] > 0)) continue;
      const Vec3 d = nodes.r[a] - anchor_, e = d.stableNormalized();
      const Eigen::Matrix3d along = e * e.transpose();
      *block++ +=
          factor * k_[a] * (along + secant(d.norm()) * (Eigen::Matrix3d::Identity() - along));
    }
  }
  void add_potential(const NodeBlock& nodes, Values energy) const override {
    const double factor = time_(nodes.time);
    for (Index i = 0; i < nodes.size; ++i) {
      const double stretch = (nodes.r[i] - anchor_).norm() - length_;
      energy[i] += 0.5 * factor * k_[nodes.first + i] * stretch * stretch;
    }
  }

 private:
  /// (|d| − L) / |d|; at the anchor a spring with a length has no direction and hence no force.
  [[nodiscard]] double secant(double distance) const {
    if (length_ == 0) return 1;
    return distance > 0 ? 1 - length_ / distance : 0;
  }

  Vec3 anchor_;
  double length_;
  TimeProfile time_;
  NodeValues k_;  // (N) [N/m]
};

}  // namespace

DEFORM_PLUGIN(Spring, Parameters, .name = "spring", .version = "1.0",
              .summary = "springs from some nodes to a fixed point",
              .formula = "f_a = −k_a (|d| − L) d/|d|, d = r_a − anchor, k_a = k A_a / Σ A",
              .source = "Terzopoulos et al. 1987, applied forces")
