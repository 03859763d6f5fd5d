#include <algorithm>

#include <deform/model/force_field.h>

#include "corners_of_nodes.h"
#include "pairs_of_corners.h"

namespace {
using namespace deform;

struct Parameters {
  double pressure = 0;
  TimeProfile time;
  static void declare(Declaration<Parameters>& d) {
    d("pressure", &Parameters::pressure, "N/m²",
      "pascals by which it is higher on the side that n does not point to: pushes along n")
        .required();
    d("time", &Parameters::time, "1", "factor of the pressure over time");
  }
};

/// True when every edge is gone along once in each direction: the surface has no boundary.
bool is_closed(const Faces& faces) {
  std::vector<std::pair<std::int32_t, std::int32_t>> there, back;
  for (Index f = 0; f < faces.size(); ++f) {
    const std::int32_t* node = faces.nodes.data() + faces.begin[f];
    const int corners = faces.begin[f + 1] - faces.begin[f];
    for (int c = 0; c < corners; ++c) {
      there.emplace_back(node[c], node[(c + 1) % corners]);
      back.emplace_back(node[(c + 1) % corners], node[c]);
    }
  }
  std::sort(there.begin(), there.end());
  std::sort(back.begin(), back.end());
  return !there.empty() && there == back &&
         std::adjacent_find(there.begin(), there.end()) == there.end();
}

/// A follower load: it turns and grows with the faces. Each polygon stands for the triangles
/// between its edges and the mean m of its corners (two triangles side by side in the mean of both
/// diagonals, for a quadrilateral); a triangle shares p times its area vector equally, and m
/// passes its part on to all corners. Where the faces around a node close, that is p times the
/// gradient of the volume below the surface, exactly. At an open border it is what a uniform
/// pressure puts there, p times the total area vector in sum, but has no potential, as no such
/// load has.
class Pressure final : public ForceField {
 public:
  Pressure(const Parameters& p, const Setup& setup)
      : pressure_(p.pressure),
        time_(p.time),
        corners_(setup.surface()),
        pairs_(corners_.faces()),
        closed_(is_closed(corners_.faces())) {}

  [[nodiscard]] double next_break(double after) const override { return time_.next_break(after); }
  [[nodiscard]] ForceTraits traits() const override {
    return {.potential = closed_, .neighbours = true, .exact_tangent = true};
  }

  void add_force(const NodeBlock& nodes, Vectors force) const override {
    const double p = time_(nodes.time) * pressure_;
    for (Index i = 0; i < nodes.size; ++i)
      force.add(i, p * volume_gradient(nodes.first + i, nodes.all_r));
  }
  /// −p V: as V is homogeneous of degree 3, 3 V = Σ r_a·∂V/∂r_a.
  void add_potential(const NodeBlock& nodes, Values energy) const override {
    const double p = time_(nodes.time) * pressure_;
    for (Index i = 0; i < nodes.size; ++i)
      energy[i] -= p / 3 * nodes.r[i].dot(volume_gradient(nodes.first + i, nodes.all_r));
  }
  [[nodiscard]] std::vector<std::pair<Index, Index>> tangent_pairs() const override {
    return pairs_.nodes();
  }
  /// Its symmetric part; the rest of it is nothing but what stands at an open border.
  void add_exact_tangent(const NodeBlock& nodes, std::span<Eigen::Matrix3d> blocks) const override {
    const double p = time_(nodes.time) * pressure_;
    pairs_.visit([&](std::size_t pair, Face face, std::size_t c, std::size_t d) {
      const Eigen::Matrix3d there = derivative(face, c, d, nodes.all_r),
                            back = derivative(face, d, c, nodes.all_r);
      blocks[pair] -= p / 2 * (there + back.transpose());
    });
  }

 private:
  using Face = std::span<const std::int32_t>;

  /// By how much one face's part of volume_gradient at corner c changes with corner d [m].
  static Eigen::Matrix3d derivative(Face face, std::size_t c, std::size_t d, ConstVectors r) {
    const std::size_t k = face.size();
    const auto corners = static_cast<double>(k);
    const auto chord = [&](std::size_t i) {
      return Vec3(r[face[(i + 1) % k]] - r[face[(i + k - 1) % k]]);
    };
    const double after = (c + 1) % k == d ? 1 : 0, before = (c + k - 1) % k == d ? 1 : 0;
    const Vec3 out = r[face[c]] - mean(face, r);
    return cross(-((c == d ? 1 : 0) - 1 / corners) / 6 * chord(c) + (after - before) / 6 * out -
                 chord(d) / (6 * corners));
  }
  /// The matrix of x ↦ a × x.
  static Eigen::Matrix3d cross(const Vec3& a) {
    Eigen::Matrix3d m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
  }

  [[nodiscard]] Vec3 volume_gradient(Index node, ConstVectors r) const {
    Vec3 sum = Vec3::Zero();
    for (const auto& [face, c] : corners_.of(node)) {
      const std::size_t k = face.size();
      const Vec3 m = mean(face, r);
      const Vec3 before = r[face[(c + k - 1) % k]], after = r[face[(c + 1) % k]];
      // The two triangles of which the node is a corner, and its part of what m bears.
      sum += (r[node] - m).cross(after - before) / 6 +
             area_vector(face, r, m) / static_cast<double>(3 * k);
    }
    return sum;
  }

  double pressure_;
  TimeProfile time_;
  CornersOfNodes corners_;
  PairsOfCorners pairs_;
  bool closed_;
};

}  // namespace

DEFORM_PLUGIN(Pressure, Parameters, .name = "pressure", .version = "1.0",
              .summary =
                  "a uniform difference of pressure between both sides; with a potential, −p V, "
                  "on a surface without boundary",
              .formula =
                  "f_a = p ∂V/∂r_a, V = Σ ⟨m, r_b × r_c⟩/6 over the faces' edges bc, m: "
                  "mean of the face's corners",
              .source = "the gradient of a polyhedron's volume")
