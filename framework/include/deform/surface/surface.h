/// A discretised surface: nodes, faces, selections, and the sample sets with their difference
/// operators.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "deform/plugin/descriptor.h"
#include "deform/plugin/field.h"
#include "deform/surface/prolongation.h"
#include "deform/surface/sample_set.h"
#include "deform/surface/scalar_unknown.h"
#include "deform/types.h"

namespace deform {

/// Polygons over the nodes, counter-clockwise seen from where n points.
struct Faces {
  std::vector<std::int32_t> nodes;     ///< all polygons' nodes, one after another
  std::vector<std::int32_t> begin{0};  ///< polygon f: nodes[begin[f]] … nodes[begin[f+1]−1]
  [[nodiscard]] Index size() const { return static_cast<Index>(begin.size()) - 1; }
};

/// A node on an open part of the boundary, with first derivatives there as rows over the nodes. A
/// row names each node once, and its coefficients sum to 0: a constant has no derivative.
/// Constraints solve rows for one of their nodes, so that `inwards` has
/// - a coefficient of the node itself, for which `symmetry` solves it, and
/// - coefficients of nodes beside the boundary's, for the largest of which `clamp` solves it: a
/// node
///   that no other row of the side is solved for. Rows that need each other in a circle, the first
///   for the second's node and the second for the first's, cannot be solved one by one.
struct EdgeNode {
  struct Entry {
    Index node = 0;
    double coefficient = 0;  ///< [1/m]
  };
  Index node = 0;
  double length = 0;  ///< of the boundary that the node stands for, in parameters [m]
  /// The same of the rest surface's boundary [m]: what loads per length go by. Exactly `length`
  /// where a1 and a2 are lengths; 0 where the surface does not say, which means `length`.
  double rest_length = 0;
  std::vector<Entry> inwards;  ///< the derivative across the boundary, towards the inside
  std::vector<Entry> along;    ///< along the boundary, counter-clockwise around the surface
};

/// Owns the discretisation; nothing outside it sees how its nodes are arranged.
class DEFORM_API Surface : public Plugin {
 public:
  static constexpr PluginKind kKind = PluginKind::surface;
  ~Surface() override;

  [[nodiscard]] virtual Index nodes() const = 0;
  /// Whether the parameters are coordinates of the surface as a whole. Where they are not, each
  /// sample has a chart of its own, orthonormal at rest, `parameters` mean nothing, and what needs
  /// them is refused: selections by them, formulas and maps, weights that differ by direction.
  [[nodiscard]] virtual bool has_chart() const { return true; }
  /// (N × 2) parameters (a1, a2) of the nodes [m].
  [[nodiscard]] virtual const Eigen::MatrixX2d& parameters() const = 0;
  /// Length [m] after which a1 and a2 come round again on joined sides; 0 on open ones.
  [[nodiscard]] virtual Vec2 period() const { return Vec2::Zero(); }
  /// (N) parameter area of each node [m²].
  [[nodiscard]] virtual const NodeValues& areas() const = 0;
  /// (N) area of the rest surface that each node stands for [m²]: what mass, damping and loads per
  /// area go by. Their sum is the rest surface's area, if `areas` sum to the parameters'. Exactly
  /// `areas` where the rest surface is flat and a1 and a2 are lengths. Default: `areas` times the
  /// quotient of rest and parameter area of the faces around each node.
  [[nodiscard]] virtual NodeValues rest_areas() const;
  /// (N) parameter area of each node within some rectangles [m²], once where these overlap; sides
  /// that are joined go round. What loads on a patch are shared by: Σ is the patch's area within
  /// the surface and Σ a1, Σ a2 its centroid's where the surface can say. Default: `areas` of the
  /// nodes within.
  [[nodiscard]] virtual NodeValues areas_within(
      const std::vector<ParameterRectangle>& rectangles) const;
  /// (N × 3) rest and initial positions [m].
  [[nodiscard]] virtual const NodeVectors& rest() const = 0;
  [[nodiscard]] virtual const NodeVectors& initial() const = 0;
  [[nodiscard]] virtual const Faces& faces() const = 0;
  /// The set that terms of a role live on; roles may share one (same address).
  [[nodiscard]] virtual const SampleSet& samples(SampleRole role) const = 0;
  /// Names of the parts of the boundary ("left", …), and of the corners; "all" is understood
  /// everywhere.
  [[nodiscard]] virtual std::vector<std::string> boundary_names() const = 0;
  [[nodiscard]] virtual std::vector<std::string> corner_names() const = 0;
  /// Nodes of a part of the boundary or of a corner, ascending; empty for a name that is not one.
  [[nodiscard]] virtual std::vector<Index> boundary(const std::string& name) const = 0;
  [[nodiscard]] virtual std::vector<Index> corner(const std::string& name) const = 0;

  /// The nodes of a part of the boundary ("left", …) with their derivatives, in the order of
  /// `boundary`, for constraints and loads on edges; empty where the surface has none.
  [[nodiscard]] virtual std::vector<EdgeNode> edge(const std::string& /*name*/) const { return {}; }

  /// Scalar unknowns that go with the surface (rotations at its edges, say), which energies on
  /// tuples may share; fixed for the object's life. Default: none.
  [[nodiscard]] virtual std::vector<ScalarUnknown> scalars() const;

  /// Fewer and fewer nodes for multigrid, from fine to coarse, each with a quarter to a half of
  /// those before, down to a few dozen; empty where the surface has none.
  [[nodiscard]] virtual std::vector<Prolongation> coarsening() const { return {}; }
  /// The same with smoother interpolation, for matrices of bending.
  [[nodiscard]] virtual std::vector<Prolongation> smooth_coarsening() const { return coarsening(); }

  /// What to change in a scene for the same surface with nodes twice as close: pointers below the
  /// surface ("/nodes") and JSON values. Empty where the surface cannot say.
  [[nodiscard]] virtual std::vector<std::pair<std::string, std::string>> refinement() const {
    return {};
  }
};

/// Throws InputError unless a surface has a chart; `what` needs one.
DEFORM_API void require_chart(const Surface& surface, const std::string& what);

/// Nodes that a selection takes, ascending, each once; throws InputError when none, a name is
/// unknown, or parameters are asked for where there is no chart.
[[nodiscard]] DEFORM_API std::vector<Index> select_nodes(const Surface& surface,
                                                         const NodeSelection& where);
/// (N) parameter area that a selection takes of each node [m²]: of patches (`centre` with a radius,
/// `box` with two extents) as the surface's `areas_within` has it, of nodes, corners, sides and
/// lines all of the nodes. Throws as select_nodes does, but for patches between nodes.
[[nodiscard]] DEFORM_API NodeValues select_areas(const Surface& surface,
                                                 const NodeSelection& where);

}  // namespace deform
