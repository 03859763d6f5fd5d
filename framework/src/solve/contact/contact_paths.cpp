#include "solve/contact/contact_paths.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace deform {
namespace {

/// A node this near to a body, in lengths of its path, is there.
constexpr double kThere = 1e-9;
/// The shortest step along the surface of a body that may not be convex, in lengths of the path.
constexpr double kShortest = 1.0 / 64;
/// Looks at the body, at most: enough for the shortest steps and a bisection.
constexpr int kMostLooks = 200;

struct Path {
  Index number;
  Vec3 start, along;   // along: of length 1
  double length;       // [m]
  double at = 0;       // where it looks next [m]
  double outside = 0;  // the farthest look that was outside, if …
  double inside = -1;  // … one beyond was inside: where [m]; −1: none yet
};

enum class Look : std::uint8_t { on, in, past };

/// How far to go from a gap where a body may not be convex: as far as that is known to be free;
/// along a surface `shortest`, or to where the surface would be met if it were flat.
double step_near(double gap, double approach, double shortest) {
  if (gap >= shortest) return gap;
  return gap > 0 && approach * shortest > gap ? gap / approach : shortest;
}

/// What a look at the gap says: goes on, is in, or does not come in at all.
Look advance(Path& path, double gap, const Vec3& normal, bool is_convex) {
  const double there = kThere * path.length;
  const double approach = -normal.dot(path.along);
  if (path.inside >= 0) {  // bisection
    (gap < 0 ? path.inside : path.outside) = path.at;
    if (gap < 0 && path.inside - path.outside <= there) return Look::in;
    path.at =
        path.inside - path.outside <= there ? path.inside : 0.5 * (path.inside + path.outside);
    return Look::on;
  }
  if (gap <= there) {
    if (approach > 0 && (is_convex || gap >= -there || path.at == 0)) return Look::in;
    if (is_convex) return Look::past;
    if (gap < -there && path.at > 0) {
      path.inside = path.at;
      path.at = 0.5 * (path.inside + path.outside);
      return Look::on;
    }
  }
  path.outside = path.at;
  if (is_convex && !(approach > 0)) return Look::past;
  path.at += is_convex ? gap / approach : step_near(gap, approach, kShortest * path.length);
  return path.at < path.length ? Look::on : Look::past;
}

std::vector<Path> paths_of(const NodeVectors& from, const NodeVectors& to) {
  std::vector<Path> paths;
  for (Index i = 0; i < from.rows(); ++i) {
    const Vec3 along = (to.row(i) - from.row(i)).transpose();
    const double length = along.norm();
    if (length > 0 && std::isfinite(length))
      paths.push_back({i, from.row(i).transpose(), along / length, length});
  }
  return paths;
}

}  // namespace

std::vector<EntryPlane> first_entries(const PathBody& body, const NodeVectors& from,
                                      const NodeVectors& to) {
  std::vector<EntryPlane> entries;
  std::vector<Path> paths = paths_of(from, to);
  NodeVectors points, normal;
  NodeValues gap;
  for (int look = 0; look < kMostLooks && !paths.empty(); ++look) {
    points.resize(static_cast<Index>(paths.size()), 3);
    for (std::size_t i = 0; i < paths.size(); ++i)
      points.row(static_cast<Index>(i)) =
          (paths[i].start + paths[i].at * paths[i].along).transpose();
    body.measure(points, gap, normal);
    std::size_t left = 0;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const auto row = static_cast<Index>(i);
      const Vec3 n = normal.row(row).transpose();
      const Look found = advance(paths[i], gap[row], n, body.is_convex);
      if (found == Look::in)
        entries.push_back(
            {paths[i].number, n, n.dot(Vec3(points.row(row).transpose())) - gap[row]});
      else if (found == Look::on)
        paths[left++] = paths[i];
    }
    paths.resize(left);
  }
  std::ranges::sort(entries, {}, &EntryPlane::path);
  return entries;
}

}  // namespace deform
