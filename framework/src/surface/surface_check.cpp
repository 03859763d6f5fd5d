#include "surface/surface_check.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "deform/error.h"

#include "not_finite.h"
#include "plugin/guard.h"

namespace deform {
namespace {

/// Collects the contradictions of one surface.
class SurfaceCheck {
 public:
  explicit SurfaceCheck(const Surface& surface) : surface_(surface), nodes_(surface.nodes()) {}

  std::vector<std::string> contradictions() {
    if (nodes_ < 1) return {fmt::format("nodes() is {}, expected 1 at least", nodes_)};
    check_arrays();
    check_faces();
    // Its default looks at the arrays and the faces, which must be sound.
    if (contradictions_.empty() && surface_.rest_areas().size() != nodes_)
      note("rest_areas() has {} rows, expected {}, the number of nodes",
           surface_.rest_areas().size(), nodes_);
    for (const SampleRole role : {SampleRole::membrane, SampleRole::bending}) check_samples(role);
    const std::vector<Prolongation> linear = surface_.coarsening(),
                                    smooth = surface_.smooth_coarsening();
    check_coarsening("coarsening()", linear);
    check_coarsening("smooth_coarsening()", smooth);
    if (!std::ranges::equal(linear, smooth, {}, &Prolongation::coarse, &Prolongation::coarse))
      note("smooth_coarsening() must have as many coarse nodes as coarsening()");
    for (const std::string& name : surface_.boundary_names()) {
      check_selection("boundary", name, surface_.boundary(name));
      check_edge(name);
    }
    for (const std::string& name : surface_.corner_names())
      check_selection("corner", name, surface_.corner(name));
    return std::move(contradictions_);
  }

 private:
  template <class... Values>
  void note(fmt::format_string<Values...> text, Values&&... values) {
    contradictions_.push_back(fmt::format(text, std::forward<Values>(values)...));
  }

  template <class Matrix>
  void check_array(const char* what, const Matrix& values) {
    if (values.rows() != nodes_) {
      note("{} has {} rows, expected {}, the number of nodes", what, values.rows(), nodes_);
    } else if (const Index node = first_not_finite(values); node >= 0) {
      note("{} of node {} is not finite", what, node);
    }
  }

  void check_arrays() {
    check_array("parameters()", surface_.parameters());
    check_array("areas()", surface_.areas());
    check_array("rest()", surface_.rest());
    check_array("initial()", surface_.initial());
    const double smallest = surface_.areas().size() == 0 ? 1 : surface_.areas().minCoeff();
    if (smallest <= 0) note("areas() has {}, expected a positive area for each node", smallest);
  }

  void check_faces() {
    const Faces& faces = surface_.faces();
    const bool is_table = !faces.begin.empty() && faces.begin.front() == 0 &&
                          std::is_sorted(faces.begin.begin(), faces.begin.end()) &&
                          faces.begin.back() == static_cast<std::int64_t>(faces.nodes.size());
    if (!is_table) {
      note("faces().begin must ascend from 0 to the {} entries of faces().nodes",
           faces.nodes.size());
    }
    for (const std::int32_t node : faces.nodes) {
      if (!is_node(node)) return note_node("faces()", node);
    }
  }

  void check_samples(SampleRole role) {
    const char* const what =
        role == SampleRole::membrane ? "samples(membrane)" : "samples(bending)";
    const SampleSet& samples = surface_.samples(role);
    if (samples.nodes() != nodes_) {
      note("{} was built for {} nodes, expected {}", what, samples.nodes(), nodes_);
    }
    const ConstValues weights = samples.weights();
    const auto bad =
        std::ranges::find_if(weights, [](double w) { return !(w >= 0 && w < kInfinity); });
    if (bad != weights.end()) {
      note("{} has a sample of weight {}, expected a finite area", what, *bad);
    }
  }

  /// Each prolongation starts where the one before ended, and keeps constants.
  void check_coarsening(const char* what, const std::vector<Prolongation>& all) {
    Index fine = nodes_;
    for (std::size_t l = 0; l < all.size(); ++l) {
      const Prolongation& p = all[l];
      const bool is_table = static_cast<Index>(p.begin.size()) == fine + 1 &&
                            p.begin.front() == 0 && std::ranges::is_sorted(p.begin) &&
                            p.begin.back() == static_cast<std::int64_t>(p.node.size()) &&
                            p.weight.size() == p.node.size() && p.coarse > 0 && p.coarse < fine;
      if (!is_table) return note("{}[{}] is no table of {} rows with fewer columns", what, l, fine);
      for (Index a = 0; a < fine; ++a) {
        double sum = 0;
        for (auto q = static_cast<std::size_t>(p.begin[static_cast<std::size_t>(a)]);
             q < static_cast<std::size_t>(p.begin[static_cast<std::size_t>(a) + 1]); ++q) {
          if (p.node[q] < 0 || p.node[q] >= p.coarse)
            return note("{}[{}] names coarse node {}, expected 0 to {}", what, l, p.node[q],
                        p.coarse - 1);
          sum += p.weight[q];
        }
        if (!(std::abs(sum - 1) < 1e-9))
          return note("{}[{}] has weights of node {} that sum to {}, expected 1", what, l, a, sum);
      }
      fine = p.coarse;
    }
  }

  void check_selection(const char* what, const std::string& name, const std::vector<Index>& nodes) {
    const std::string place = fmt::format("{}(\"{}\")", what, name);
    if (!std::is_sorted(nodes.begin(), nodes.end(), std::less_equal<>())) {
      note("{} must give each node once, ascending", place);
    }
    for (const Index node : nodes) {
      if (!is_node(node)) return note_node(place, node);
    }
  }

  /// An edge is that part of the boundary, node by node, or not described.
  void check_edge(const std::string& name) {
    const std::vector<EdgeNode> edge = surface_.edge(name);
    if (edge.empty()) return;
    const std::string place = fmt::format("edge(\"{}\")", name);
    const std::vector<Index> boundary = surface_.boundary(name);
    if (!std::ranges::equal(edge, boundary, {}, &EdgeNode::node))
      note("{} must have the nodes of boundary(\"{}\") in its order", place, name);
    for (const EdgeNode& at : edge) {
      if (!(at.length > 0 && at.length < kInfinity))
        return note("{} has a length of {} at node {}, expected a finite one above 0", place,
                    at.length, at.node);
      if (at.rest_length < 0)
        return note("{} has a rest length of {} at node {}, expected 0 at least", place,
                    at.rest_length, at.node);
      for (const auto* row : {&at.inwards, &at.along})
        for (const EdgeNode::Entry& entry : *row) {
          if (!is_node(entry.node)) return note_node(place, entry.node);
          if (!std::isfinite(entry.coefficient))
            return note("{} has a coefficient at node {} that is not finite", place, at.node);
          if (std::ranges::count(*row, entry.node, &EdgeNode::Entry::node) > 1)
            return note("{} has a row at node {} that names node {} twice, expected each once",
                        place, at.node, entry.node);
        }
    }
  }

  [[nodiscard]] bool is_node(Index node) const { return node >= 0 && node < nodes_; }
  void note_node(const std::string& place, Index node) {
    note("{} names node {}, expected 0 to {}", place, node, nodes_ - 1);
  }

  const Surface& surface_;
  Index nodes_;
  std::vector<std::string> contradictions_;
};

}  // namespace

void check_surface(const Surface& surface, const std::string& origin) {
  const auto found = guarded(origin, "describing its nodes",
                             [&] { return SurfaceCheck(surface).contradictions(); });
  if (found.empty()) return;
  throw PluginFailure(fmt::format("plugin {} made a surface that contradicts itself: {}", origin,
                                  fmt::join(found, "; ")));
}

}  // namespace deform
