/// Folds along a hem: how often a line of nodes turns back from one side of its smoothed course to
/// the other. A turn counts when it stands out by more than a share of the surface's size, so that
/// neither rounding nor the sag of the whole hem is a fold.
#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <deform/geometry/characteristic_length.h>
#include <deform/record/probe.h>
#include <deform/surface/surface.h>

#include "node_line.h"

namespace {

using namespace deform;

struct Parameters {
  NodeSelection where;
  double prominence = 0.005;
  static void declare(Declaration<Parameters>& d) {
    d("where", &Parameters::where, "", "the hem's nodes: one line along a1 or a2").required();
    d("prominence", &Parameters::prominence, "1",
      "how far a fold stands out at least, in characteristic lengths")
        .at_least(0);
  }
};

/// Positions (in the list) at which the offsets turn by more than `least` before and after; the
/// ends of the list are no turns.
std::vector<Index> turns(const NodeValues& offset, double least) {
  std::vector<Index> found;
  Index low = 0;
  Index high = 0;
  int direction = 0;  // of the last move that was large enough; 0: there was none
  for (Index k = 1; k < offset.size(); ++k) {
    if (offset[k] > offset[high]) high = k;
    if (offset[k] < offset[low]) low = k;
    if (direction >= 0 && offset[high] - offset[k] > least) {
      if (high != 0) found.push_back(high);
      direction = -1;
      low = k;
    } else if (direction <= 0 && offset[k] - offset[low] > least) {
      if (low != 0) found.push_back(low);
      direction = 1;
      high = k;
    }
  }
  return found;
}

class Folds final : public Probe {
 public:
  Folds(const Parameters& p, const Setup& setup)
      : hem_(in_order(setup.select(p.where), setup.surface().parameters())) {
    least_ = p.prominence * characteristic_length(setup.rest());
    const auto count = static_cast<Index>(hem_.size());
    if (count < kFewest)
      throw InputError({{"/where", "a hem needs at least " + std::to_string(kFewest) + " nodes"}});
    Eigen::MatrixX3d powers(count, 3);
    const Eigen::VectorXd s = Eigen::VectorXd::LinSpaced(count, -1, 1);
    powers << Eigen::VectorXd::Ones(count), s, s.cwiseAbs2();
    smooth_ = powers * powers.completeOrthogonalDecomposition().pseudoInverse();
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"folds.count", ""}, {"folds.wavelength", "m"}};
  }

  void measure(const Frame& frame, Values figures) override {
    const NodeVectors line = frame.positions()(hem_, Eigen::all);
    const NodeVectors smoothed = smooth_ * line;
    const std::vector<Index> folds = turns(sideways(line - smoothed), least_);
    figures[0] = static_cast<double>(folds.size());
    figures[1] = kNoFigure;
    if (folds.size() < 2) return;
    double length = 0;
    for (Index k = folds.front(); k < folds.back(); ++k)
      length += (smoothed.row(k + 1) - smoothed.row(k)).norm();
    figures[1] = 2 * length / static_cast<double>(folds.size() - 1);
  }

 private:
  static constexpr Index kFewest = 5;

  /// The component of the deviations along which they are largest.
  static NodeValues sideways(const NodeVectors& deviation) {
    const Eigen::Matrix3d covariance = deviation.transpose() * deviation;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(covariance);
    return deviation * axes.eigenvectors().col(2);
  }

  std::vector<Index> hem_;
  double least_ = 0;        // [m]
  Eigen::MatrixXd smooth_;  // projection of the hem's positions onto parabolas
};

}  // namespace

DEFORM_PLUGIN(Folds, Parameters, .name = "folds", .version = "1.0",
              .summary =
                  "Folds along a hem, crests and troughs, and their wavelength along its course: "
                  "twice the mean distance from one to the next",
              .formula =
                  "turns of (r - s).e that stand out by more than prominence x size on both "
                  "sides; s: least-squares parabola of the hem, e: direction of the largest "
                  "deviation",
              .source = "")
