#include "compare/differences.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "deform/error.h"

#include "compare/hausdorff.h"
#include "compare/mesh_map.h"

namespace deform {
namespace {

/// Two surfaces and the way from the points of one to those of the other.
class SurfacePair {
 public:
  SurfacePair(const Trajectory& run, const Trajectory& reference)
      : run_(run),
        reference_(reference),
        to_run_(reference.mesh(), run.mesh().parameters),
        to_reference_(run.mesh(), reference.mesh().parameters),
        run_faces_(triangles_of(run.mesh().faces)),
        reference_faces_(triangles_of(reference.mesh().faces)) {
    if (!has_chart(run.mesh()) && run.mesh().faces.nodes != reference.mesh().faces.nodes)
      throw InputError(
          "the surfaces are different meshes without parameters, by which a node of one could be "
          "found on the other, so the two cannot be compared");
  }

  [[nodiscard]] Difference compare(std::size_t frame, std::size_t reference_frame) const {
    const NodeVectors r = run_.positions(frame), s = reference_.positions(reference_frame);
    const NodeValues at_run = (r - to_run_.apply(s)).rowwise().norm();
    const NodeValues at_reference = (to_reference_.apply(r) - s).rowwise().norm();
    // The root mean square at the nodes of the coarser surface, the largest at those of both: what
    // lies between the coarser one's nodes must not be missed.
    const bool fewer = at_run.size() <= at_reference.size();
    const NodeValues& distances = fewer ? at_run : at_reference;
    const TrajectoryMesh& mesh = fewer ? run_.mesh() : reference_.mesh();
    Difference difference;
    difference.moment = run_.moments()[frame];
    difference.rms = std::sqrt(distances.cwiseAbs2().dot(mesh.areas) / mesh.areas.sum());
    const bool largest_at_run = at_run.maxCoeff() >= at_reference.maxCoeff();
    difference.max = (largest_at_run ? at_run : at_reference).maxCoeff(&difference.node);
    const TrajectoryMesh& place = largest_at_run ? run_.mesh() : reference_.mesh();
    difference.where = place.parameters.row(difference.node).transpose();
    difference.hausdorff =
        hausdorff_distance(r, run_faces_, at_run, s, reference_faces_, at_reference);
    return difference;
  }

 private:
  const Trajectory& run_;
  const Trajectory& reference_;
  MeshMap to_run_, to_reference_;
  std::vector<Triangle> run_faces_, reference_faces_;
};

/// Numbers of the columns that two tables share, (run, reference).
std::vector<std::pair<std::size_t, std::size_t>> shared_columns(const FigureTable& run,
                                                                const FigureTable& reference) {
  std::vector<std::pair<std::size_t, std::size_t>> shared;
  for (std::size_t i = 0; i < run.names.size(); ++i) {
    const auto found = std::ranges::find(reference.names, run.names[i]);
    if (found != reference.names.end())
      shared.emplace_back(i, static_cast<std::size_t>(found - reference.names.begin()));
  }
  return shared;
}

void add_probes(const FigureTable& run, const FigureTable& reference, RunDifferences& all) {
  const auto columns = shared_columns(run, reference);
  for (const auto& [column, other] : columns) {
    all.probes.push_back(run.names[column]);
    all.units.push_back(run.units[column]);
  }
  std::map<long, std::pair<std::size_t, std::size_t>> rows_of_step;
  for (const auto& [row, other] : same_times(run.moments, reference.moments))
    rows_of_step[run.moments[row].step] = {row, other};
  for (Difference& difference : all.rows) {
    difference.probes.assign(columns.size(), std::numeric_limits<double>::quiet_NaN());
    const auto found = rows_of_step.find(difference.moment.step);
    if (found == rows_of_step.end()) continue;
    const auto [row, other] = found->second;
    for (std::size_t i = 0; i < columns.size(); ++i)
      difference.probes[i] =
          run.figures[row][columns[i].first] - reference.figures[other][columns[i].second];
  }
}

}  // namespace

const Difference* RunDifferences::parting(double tolerance) const {
  const auto found = std::ranges::find_if(
      rows, [tolerance](const Difference& row) { return row.max > tolerance; });
  return found == rows.end() ? nullptr : &*found;
}

RunDifferences differences(const RecordedRun& run, const RecordedRun& reference) {
  RunDifferences all;
  if (!run.trajectory || !reference.trajectory) {
    all.impossible =
        run.trajectory ? "the reference has no recorded states" : "it has no recorded states";
    return all;
  }
  try {
    const SurfacePair pair(*run.trajectory, *reference.trajectory);
    for (const auto& [frame, other] :
         same_times(run.trajectory->moments(), reference.trajectory->moments()))
      all.rows.push_back(pair.compare(frame, other));
  } catch (const InputError& e) {
    all.impossible = e.what();
    return all;
  }
  all.recorded = run.trajectory->frames();
  if (all.rows.empty() || (all.rows.size() == 1 && all.recorded > 1)) {
    all.rows.clear();
    all.impossible = "it has no recorded time but the start in common with the reference";
    return all;
  }
  add_probes(run.probes, reference.probes, all);
  return all;
}

}  // namespace deform
