#include <deform/model/normal_estimator.h>

namespace {
using namespace deform;

/// n_ij ≈ r_ij: the second derivative itself, neither a unit vector nor normal to the surface.
class Terzopoulos final : public NormalEstimator {
 public:
  Terzopoulos(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void estimate(const GeometryBlock& /*lagged*/, Pair /*ij*/, AffineNormal& normal) const override {
    normal.p.fill(1.0);
  }
  [[nodiscard]] Dependence dependence() const override { return Dependence::second_derivative; }
};

}  // namespace

DEFORM_PLUGIN(Terzopoulos, NoParameters, .name = "terzopoulos", .version = "1.0",
              .summary = "the second derivative in place of the normal", .formula = "n_ij ≈ r_ij",
              .source = "Terzopoulos, Platt, Barr, Fleischer 1987; Wu & Melo (21)")
