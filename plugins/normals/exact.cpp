#include <algorithm>

#include <deform/model/normal_estimator.h>

namespace {
using namespace deform;

/// The cross product's unit normal at the previous state, held fixed over the step.
class Exact final : public NormalEstimator {
 public:
  Exact(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void estimate(const GeometryBlock& lagged, Pair /*ij*/, AffineNormal& normal) const override {
    const ConstVectors n = lagged.n();
    std::copy_n(n.x, lagged.size(), normal.c[0].begin());
    std::copy_n(n.y, lagged.size(), normal.c[1].begin());
    std::copy_n(n.z, lagged.size(), normal.c[2].begin());
  }
  [[nodiscard]] Dependence dependence() const override { return Dependence::none; }
};

}  // namespace

DEFORM_PLUGIN(Exact, NoParameters, .name = "exact", .version = "1.0",
              .summary = "the normal of the previous state by the cross product",
              .formula = "n = r_1×r_2/|r_1×r_2|", .source = "Wu & Melo (6)")
