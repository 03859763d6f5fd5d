#include <algorithm>

#include <deform/model/force_field.h>

#include "corners_of_nodes.h"
#include "pairs_of_corners.h"

namespace {
using namespace deform;

struct Parameters {
  Vec3 velocity = Vec3::Zero();
  double air_density = 1.2;
  double drag = 1.0;
  double friction = 0.1;
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("velocity", &Parameters::velocity, "m/s", "velocity of the air");
    d("air_density", &Parameters::air_density, "kg/m³", "ρ: mass per volume of the air")
        .at_least(0);
    d("drag", &Parameters::drag, "1",
      "c_n: a face square to the wind bears ½ ρ c_n u² times its own area (one side's)")
        .at_least(0);
    d("friction", &Parameters::friction, "1",
      "c_t: a face along the wind bears ½ ρ c_t u² times its own area (both sides together)")
        .at_least(0);
    d("time", &Parameters::time, "1", "factor of the air's velocity over time");
  }
};

/// Quadratic drag of each face, shared equally by its corners. Its normal part depends on the
/// air's speed square to the face alone: at an angle α between wind and face it is c_n sin²α.
/// Whichever side n points to, the force is the same; still air only brakes (F·u ≥ 0 for each face,
/// u = −v). The time profile makes gusts: between them the air is still there, at rest.
class Wind final : public ForceField {
 public:
  Wind(const Parameters& p, const Setup& setup)
      : velocity_(p.velocity),
        half_density_(0.5 * p.air_density),
        drag_(p.drag),
        friction_(p.friction),
        time_(p.time),
        corners_(setup.surface()),
        pairs_(corners_.faces()) {}

  [[nodiscard]] double next_break(double after) const override { return time_.next_break(after); }
  [[nodiscard]] ForceTraits traits() const override {
    return {.neighbours = true, .damping_bound = true, .exact_damping = true};
  }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    for (Index i = 0; i < nodes.size; ++i) {
      Vec3 sum = Vec3::Zero();
      for (const auto& [face, place] : corners_.of(nodes.first + i)) {
        const Stream s = stream(face, nodes);
        const Vec3 f = drag_ * std::abs(s.normal) * s.normal * s.n +
                       friction_ * s.tangential.norm() * s.tangential;
        sum += half_density_ * s.area / static_cast<double>(face.size()) * f;
      }
      force.add(i, sum);
    }
  }

  [[nodiscard]] std::vector<std::pair<Index, Index>> tangent_pairs() const override {
    return pairs_.nodes();
  }
  /// Of a face with k corners, −∂f_a/∂v_b = J/k² for each two of them.
  void add_exact_damping(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const override {
    const std::int32_t* last = nullptr;
    Eigen::Matrix3d part;  // of the last face
    pairs_.visit([&](std::size_t pair, Face face, std::size_t /*c*/, std::size_t /*d*/) {
      const auto corners = static_cast<double>(face.size());
      if (face.data() != last) part = derivative(stream(face, nodes)) / (corners * corners);
      last = face.data();
      blocks[pair] += part;
    });
  }
  /// J's largest eigenvalue is ρ A max(c_n |u·n|, c_t |u_t|): that, divided by k, at every corner
  /// bounds it. It is at least twice the force over u, so that a step cannot overshoot.
  void add_tangent(const NodeBlock& nodes, Values /*stiffness*/, Values damping) const override {
    for (Index i = 0; i < nodes.size; ++i)
      for (const auto& [face, place] : corners_.of(nodes.first + i)) {
        const Stream s = stream(face, nodes);
        damping[i] += 2 * half_density_ * s.area / static_cast<double>(face.size()) *
                      std::max(drag_ * std::abs(s.normal), friction_ * s.tangential.norm());
      }
  }

 private:
  using Face = std::span<const std::int32_t>;

  /// The air as a face feels it.
  struct Stream {
    double area = 0;  ///< [m²]
    Vec3 n = Vec3::Zero();
    double normal = 0;               ///< u·n [m/s]
    Vec3 tangential = Vec3::Zero();  ///< u − (u·n) n [m/s]
  };

  /// J = ∂F/∂u of a face's force F, symmetric and positive semi-definite.
  [[nodiscard]] Eigen::Matrix3d derivative(const Stream& s) const {
    const Eigen::Matrix3d across = s.n * s.n.transpose();
    const Eigen::Matrix3d along = Eigen::Matrix3d::Identity() - across;
    const Vec3 e = s.tangential.stableNormalized();
    return half_density_ * s.area *
           (2 * drag_ * std::abs(s.normal) * across +
            friction_ * s.tangential.norm() * (along + e * e.transpose()));
  }

  [[nodiscard]] Stream stream(Face face, const NodeBlock& nodes) const {
    const Vec3 area = area_vector(face, nodes.all_r, mean(face, nodes.all_r));
    Stream s;
    s.area = area.norm();
    if (s.area == 0) return s;  // no direction, no force
    s.n = area / s.area;
    const Vec3 u = time_(nodes.time) * velocity_ - mean(face, nodes.all_v);
    s.normal = u.dot(s.n);
    s.tangential = u - s.normal * s.n;
    return s;
  }

  Vec3 velocity_;
  double half_density_;
  double drag_, friction_;
  TimeProfile time_;
  CornersOfNodes corners_;
  PairsOfCorners pairs_;
};

}  // namespace

DEFORM_PLUGIN(Wind, Parameters, .name = "wind", .version = "1.0",
              .summary = "drag of moving air on the faces, quadratic in its speed relative to them",
              .formula =
                  "F = ½ ρ A (c_n |u·n| (u·n) n + c_t |u_t| u_t), u = wind − mean velocity "
                  "of the face's nodes",
              .source = "the drag equation, for the parts normal and tangential to a face")
