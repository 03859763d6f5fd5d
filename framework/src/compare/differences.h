/// How one run differs from another.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/recorded_run.h"

namespace deform {

/// At one recorded time. Nodes are compared with the points of equal parameters. Where the two
/// surfaces have different nodes, the largest distance is that at the nodes of both, the root mean
/// square that at the nodes of the one that has fewer.
struct Difference {
  Moment moment;         ///< as the compared run counts
  double rms = 0;        ///< of the distances of nodes, weighted by their areas [m]
  double max = 0;        ///< largest of them [m]
  Index node = 0;        ///< where
  Vec2 where{0, 0};      ///< (a1, a2) of it [m]
  double hausdorff = 0;  ///< distance of the surfaces as sets of points [m]
  std::vector<double>
      probes;  ///< run − reference, of RunDifferences::probes; NaN where there is none
};

struct RunDifferences {
  std::vector<std::string> probes, units;  ///< that both have
  std::vector<Difference> rows;
  std::size_t recorded = 0;  ///< frames of the run: there may be fewer rows
  std::string impossible;    ///< why there are no rows; else empty

  /// The first row whose largest distance is more than `tolerance` [m].
  [[nodiscard]] const Difference* parting(double tolerance) const;
};

[[nodiscard]] RunDifferences differences(const RecordedRun& run, const RecordedRun& reference);

}  // namespace deform
