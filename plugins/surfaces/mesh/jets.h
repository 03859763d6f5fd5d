/// Derivatives on triangles and at nodes, each in a chart of its own or in one of the whole
/// surface.
#pragma once

#include <optional>

#include <deform/surface/sample_set.h>

#include "triangles.h"

namespace mesh {

/// Axes of a surface that lies in a plane, right-handed seen from where its triangles run
/// counter-clockwise: one chart for all samples. Of a plane normal to z they are x and y.
using Axes = Eigen::Matrix<double, 3, 2>;
[[nodiscard]] std::optional<Axes> axes_of_plane(const Triangles& t);

/// First derivatives on each triangle, of the linear function through its corners: exact for the
/// rest metric, which is the identity in the chart of the triangle's plane.
[[nodiscard]] deform::SampleSet triangle_samples(const Triangles& t,
                                                 const std::optional<Axes>& axes);

/// First and second derivatives at each node, by the quadratic function of its tangent plane's
/// coordinates that goes through the node and fits its neighbours best, weighted by 1/distance²:
/// of the first ring where the node is inside and these determine it well, else of two rings or
/// more. Second derivatives have order 1, order 2 where the neighbours lie symmetrically. Throws
/// InputError that names a node whose neighbours do not determine them.
[[nodiscard]] deform::SampleSet node_samples(const Triangles& t, const deform::NodeValues& areas,
                                             const std::optional<Axes>& axes);

/// (N) a third of the areas of the triangles around each node [m²].
[[nodiscard]] deform::NodeValues node_areas(const Triangles& t);

}  // namespace mesh
