// Gauss' formula where the surface is curved, the exact normal where it is flat, and a smooth
// passage between them instead of the delta rule's jump: w = B/(B² + δ²) never divides by zero, and
// what w B lacks to 1 the exact normal of the previous state gives, so that at that state the
// estimate is exact.
#include <deform/model/normal_estimator.h>

namespace {
using namespace deform;

struct Parameters {
  double delta = 0.5;
  static void declare(Declaration<Parameters>& d) {
    d("delta", &Parameters::delta, "1/m", "|B_ij| at which both normals weigh the same").above(0);
  }
};

struct CurvatureBlend final : NormalEstimator {
  CurvatureBlend(const Parameters& p, const Setup& /*setup*/) : delta(p.delta) {}

  void estimate(const GeometryBlock& lagged, Pair ij, AffineNormal& normal) const override {
    for (Index s = 0; s < lagged.size(); ++s) {
      const double B = lagged.B(ij)[s], w = B / (B * B + delta * delta);
      normal.p[s] = w;
      for (const int k : {1, 2}) normal.s[k - 1][s] = -w * lagged.gamma(k, ij)[s];
      for (const int c : {0, 1, 2}) normal.c[c][s] = (1 - w * B) * lagged.n()[s][c];
    }
  }
  double delta;
};
}  // namespace

DEFORM_PLUGIN(CurvatureBlend, Parameters, .name = "curvature_blend", .version = "1.0",
              .summary = "Gauss' formula where curved, the exact normal where flat, smoothly",
              .formula = "n_ij ≈ w (r_ij − Γ^k_ij r_k) + (1 − w B_ij) n, w = B_ij/(B_ij² + δ²)")
