#include <algorithm>

#include <deform/model/energy_term.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

struct Parameters {
  Field stiffness = 1;
  bool diagonals = true;
  static void declare(Declaration<Parameters>& d) {
    d("stiffness", &Parameters::stiffness, "N/m",
      "of each spring, however long; where it varies, the mean of the spring's two nodes")
        .at_least(0);
    d("diagonals", &Parameters::diagonals, "", "also along both diagonals of every quadrilateral");
  }
};

/// The two nodes of each spring, the smaller number first; each pair once, ascending.
std::vector<std::int32_t> spring_nodes(const Faces& faces, bool diagonals) {
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (Index f = 0; f < faces.size(); ++f) {
    const std::int32_t* node = faces.nodes.data() + faces.begin[f];
    const int corners = faces.begin[f + 1] - faces.begin[f];
    for (int c = 0; c < corners; ++c)
      pairs.emplace_back(std::minmax(node[c], node[(c + 1) % corners]));
    if (!diagonals || corners != 4) continue;
    for (const int c : {0, 1}) pairs.emplace_back(std::minmax(node[c], node[c + 2]));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<std::int32_t> nodes;
  for (const auto& [a, b] : pairs) nodes.insert(nodes.end(), {a, b});
  return nodes;
}

/// The mass-spring sheet that continuum models are compared with: it resists stretching and
/// shearing, not bending, and its stiffness depends on the mesh.
class EdgeSprings final : public TupleTerm {
 public:
  EdgeSprings(const Parameters& p, const Setup& setup)
      : nodes_(spring_nodes(setup.surface().faces(), p.diagonals)) {
    const NodeVectors& rest = setup.rest();
    const NodeValues stiffness = p.stiffness.at_nodes(setup.surface());
    for (std::size_t i = 0; i < nodes_.size(); i += 2) {
      length_.push_back((rest.row(nodes_[i]) - rest.row(nodes_[i + 1])).norm());
      stiffness_.push_back(0.5 * (stiffness[nodes_[i]] + stiffness[nodes_[i + 1]]));
    }
  }

  [[nodiscard]] TermTraits traits() const override {
    return {.potential = true, .lagged = Lagged::symmetric};
  }
  [[nodiscard]] int width() const override { return 2; }
  [[nodiscard]] const std::vector<std::int32_t>& tuples() const override { return nodes_; }

  void energy(const TupleBlock& block, Values energy) const override {
    for (Index i = 0; i < block.size; ++i) {
      const double stretch = (block.r(i, 0) - block.r(i, 1)).norm() - length_[block.first + i];
      energy[i] += 0.5 * stiffness_[block.first + i] * stretch * stretch;
    }
  }

  // f_0 = −s (r_0 − r_1) = −f_1 with the secant stiffness s = k (1 − L0/|r_0 − r_1|) of the lagged
  // state.
  void affine_force(const TupleBlock& block, Values k, std::span<Vec3> /*c*/) const override {
    for (Index i = 0; i < block.size; ++i) {
      const double distance = (block.r_lagged(i, 0) - block.r_lagged(i, 1)).norm();
      if (distance == 0) continue;  // no direction, no force
      const double s = stiffness_[block.first + i] * (1 - length_[block.first + i] / distance);
      k[4 * i] += s, k[4 * i + 1] -= s;
      k[4 * i + 2] -= s, k[4 * i + 3] += s;
    }
  }

 private:
  std::vector<std::int32_t> nodes_;         // (springs × 2)
  std::vector<double> length_, stiffness_;  // L0 [m], k [N/m]
};

}  // namespace

DEFORM_PLUGIN(EdgeSprings, Parameters, .name = "edge_springs", .version = "1.0",
              .summary = "mass-spring rival: a spring along every edge, and along quads' diagonals",
              .formula = "E = Σ ½ k (|r_a − r_b| − L0)²",
              .source = "Provot 1995 (structural and shear springs)")
