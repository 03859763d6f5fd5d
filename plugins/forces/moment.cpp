#include <cmath>
#include <map>
#include <numbers>

#include <deform/model/force_field.h>

#include "../sides.h"

namespace {
using namespace deform;

struct Parameters {
  double moment = 0;
  Vec3 axis = Vec3::Zero();
  NodeSelection where;
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("moment", &Parameters::moment, "N·m",
      "total about the axis, right-handed, of all the sides; nodes share it by length")
        .required();
    d("axis", &Parameters::axis, "1", "direction of the axis; stays, and is made a unit vector")
        .required();
    d("where", &Parameters::where, "", "open sides: {\"boundary\": names}").required();
    d("time", &Parameters::time, "1", "factor of the moment over time");
  }
};

/// Nodes from an edge node straight across the surface, over the faces' sides, to where it ends.
class PathsAcross {
 public:
  explicit PathsAcross(const Surface& surface) : parameters_(surface.parameters()) {
    neighbours_.resize(static_cast<std::size_t>(surface.nodes()));
    const Faces& faces = surface.faces();
    for (Index f = 0; f < faces.size(); ++f) {
      const auto face = static_cast<std::size_t>(f);
      const auto begin = static_cast<std::size_t>(faces.begin[face]),
                 corners = static_cast<std::size_t>(faces.begin[face + 1]) - begin;
      for (std::size_t c = 0; c < corners; ++c) {
        const auto a = faces.nodes[begin + c], b = faces.nodes[begin + (c + 1) % corners];
        neighbours_[static_cast<std::size_t>(a)].push_back(b);
        neighbours_[static_cast<std::size_t>(b)].push_back(a);
      }
    }
  }

  [[nodiscard]] std::vector<Index> from(const EdgeNode& edge) const {
    Vec2 inwards = Vec2::Zero();
    for (const auto& [node, coefficient] : edge.inwards)
      inwards += coefficient * Vec2(parameters_.row(node));
    std::vector<Index> path{edge.node};
    for (Index next = edge.node; next >= 0; next = after(path.back(), inwards.normalized()))
      if (next != edge.node) path.push_back(next);
    return path;
  }

 private:
  /// The neighbour that lies straightest ahead, or −1; every step goes ahead, so that paths end.
  [[nodiscard]] Index after(Index node, const Vec2& ahead) const {
    Index best = -1;
    double straightest = std::numbers::sqrt2 / 2;
    for (const Index other : neighbours_[static_cast<std::size_t>(node)]) {
      const Vec2 way = parameters_.row(other) - parameters_.row(node);
      const double cosine = way.normalized().dot(ahead);
      if (cosine > straightest) best = other, straightest = cosine;
    }
    return best;
  }

  const Eigen::MatrixX2d& parameters_;
  std::vector<std::vector<Index>> neighbours_;
};

/// The couple that does the work M dθ when the derivative t across the side turns by dθ about a
/// fixed axis e, node by node of the side. It turns with the side: f_k = M c_k ∂θ/∂t for the nodes
/// of t = Σ c_k r_k, which sum to no force and to the moment M about e.
///
/// Its potential −M θ is that of an angle, and positions only say angles up to whole turns. They
/// are counted along the surface: θ is the angle at which the path of nodes straight across ends,
/// relative to the initial one and up to half a turn, and what it turns by from segment to segment
/// up to the side, each less than half a turn. That is right for any number of turns as long as the
/// path's other end turns by less than half of one, as a clamped side does. When it does not, the
/// potential jumps by a whole turn's work there; the force and its tangent never do.
class Moment final : public ForceField {
 public:
  Moment(const Parameters& p, const Setup& setup)
      : axis_(unit(p.axis)), time_(p.time), initial_(setup.surface().initial()) {
    const PathsAcross paths(setup.surface());
    double length = 0;
    for (const Side& side : select_sides(p.where, setup))
      for (const EdgeNode& edge : side.nodes) {
        require_angle(edge);
        const double own = length_of(edge, setup);
        couples_.push_back({p.moment * own, edge, paths.from(edge)});
        length += own;
      }
    acting_.resize(static_cast<std::size_t>(setup.surface().nodes()));
    for (std::size_t i = 0; i < couples_.size(); ++i) {
      couples_[i].moment /= length;
      for (const auto& [node, coefficient] : couples_[i].edge.inwards)
        acting_[static_cast<std::size_t>(node)].push_back({i, coefficient});
    }
    number_pairs();
  }

  [[nodiscard]] double next_break(double after) const override { return time_.next_break(after); }
  [[nodiscard]] ForceTraits traits() const override {
    return {.potential = true, .neighbours = true, .exact_tangent = true};
  }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    const double factor = time_(nodes.time);
    for (Index i = 0; i < nodes.size; ++i)
      for (const auto& [couple, coefficient] : acting_[static_cast<std::size_t>(nodes.first + i)]) {
        const Couple& c = couples_[couple];
        const Vec3 t = across(derivative(c.edge.inwards, nodes.all_r));
        const double square = t.squaredNorm();
        if (square > 0) force.add(i, factor * c.moment * coefficient / square * axis_.cross(t));
      }
  }
  void add_potential(const NodeBlock& nodes, Values energy) const override {
    const double factor = time_(nodes.time);
    for (const Couple& c : couples_) {
      const Index i = c.edge.node - nodes.first;
      if (i >= 0 && i < nodes.size)
        energy[static_cast<std::size_t>(i)] -= factor * c.moment * angle(c, nodes.all_r);
    }
  }
  [[nodiscard]] std::vector<std::pair<Index, Index>> tangent_pairs() const override {
    return pairs_;
  }
  /// ∂²θ/∂t² = −(u wᵀ + w uᵀ)/|t|², u along t (without its part along e) and w = e × u.
  void add_exact_tangent(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const override {
    const double factor = time_(nodes.time);
    auto place = places_.begin();
    for (const Couple& c : couples_) {
      const Vec3 t = across(derivative(c.edge.inwards, nodes.all_r));
      const double square = t.squaredNorm();
      const Vec3 w = axis_.cross(t);
      Eigen::Matrix3d twice = Eigen::Matrix3d::Zero();
      if (square > 0)
        twice = factor * c.moment / (square * square) * (t * w.transpose() + w * t.transpose());
      for (const EdgeNode::Entry& a : c.edge.inwards)
        for (const EdgeNode::Entry& b : c.edge.inwards)
          if (a.node <= b.node) blocks[*place++] += a.coefficient * b.coefficient * twice;
    }
  }

 private:
  struct Couple {
    double moment = 0;  ///< the node's part [N·m]
    EdgeNode edge;
    std::vector<Index> path;  ///< from the edge node across the surface
  };
  struct Action {
    std::size_t couple = 0;
    double coefficient = 0;  ///< of the node in the couple's t [1/m]
  };

  static Vec3 unit(const Vec3& axis) {
    if (!(axis.norm() > 0)) throw InputError("'axis' is zero: it has no direction");
    return axis.normalized();
  }
  /// The part of a vector that turns about the axis.
  [[nodiscard]] Vec3 across(const Vec3& t) const { return t - axis_.dot(t) * axis_; }
  void require_angle(const EdgeNode& edge) const {
    const Vec3 t = derivative(edge.inwards, initial_);
    if (!(across(t).norm() > 1e-6 * t.norm()))
      throw InputError("the initial surface goes inwards along 'axis' at node " +
                       std::to_string(edge.node) + ": a turn about it is no rotation there");
  }

  /// By which a vector has turned about the axis, in [−π, π].
  [[nodiscard]] double turned(const Vec3& from, const Vec3& to) const {
    return std::atan2(axis_.dot(from.cross(to)), across(from).dot(across(to)));
  }
  [[nodiscard]] double angle(const Couple& c, ConstVectors r) const {
    double theta = 0;
    const auto go_on = [&](double raw) {
      theta += std::remainder(raw - theta, 2 * std::numbers::pi);
    };
    for (std::size_t k = c.path.size() - 1; k > 0; --k) {
      const Index there = c.path[k], here = c.path[k - 1];
      go_on(turned(initial_.row(there) - initial_.row(here), r[there] - r[here]));
    }
    go_on(turned(derivative(c.edge.inwards, initial_), derivative(c.edge.inwards, r)));
    return theta;
  }

  void number_pairs() {
    std::map<std::pair<Index, Index>, std::size_t> number;
    for (const Couple& c : couples_)
      for (const EdgeNode::Entry& a : c.edge.inwards)
        for (const EdgeNode::Entry& b : c.edge.inwards) {
          if (a.node > b.node) continue;
          const auto [at, is_new] = number.try_emplace({a.node, b.node}, pairs_.size());
          if (is_new) pairs_.push_back(at->first);
          places_.push_back(at->second);
        }
  }

  Vec3 axis_;
  TimeProfile time_;
  NodeVectors initial_;  // (N × 3) [m]
  std::vector<Couple> couples_;
  std::vector<std::vector<Action>> acting_;  // on each node
  std::vector<std::pair<Index, Index>> pairs_;
  std::vector<std::size_t> places_;  // in pairs_, of each couple's, one after another
};

}  // namespace

DEFORM_PLUGIN(Moment, Parameters, .name = "moment", .version = "1.0",
              .summary = "a couple about a fixed axis that turns the surface at open sides",
              .formula =
                  "f_k = M_a c_k (e × t)/|t − ⟨e, t⟩e|², t = Σ c_k r_k: derivative across "
                  "the side, M_a = M l_a / Σ l; potential −Σ M_a θ_a, θ_a: angle of t",
              .source = "")
