#include <cmath>

#include <deform/model/normal_estimator.h>
#include <deform/surface/surface.h>

namespace {
using namespace deform;

struct Parameters {
  double delta = 0.5;
  std::string delta_unit = "absolute";
  static void declare(Declaration<Parameters>& d) {
    d("delta", &Parameters::delta, "1/m", "where |B_ij| is not above it, |B_ij| = 1 is taken")
        .at_least(0)
        .may_be_infinite();
    d("delta_unit", &Parameters::delta_unit, "",
      "absolute; or delta is a number: times 1/size (root of the parameter area) or 1/cell (root "
      "of "
      "the mean node's)")
        .one_of({"absolute", "size", "cell"});
  }
};

/// The length by which a dimensionless delta is divided.
double delta_length(const std::string& unit, const Setup& setup) {
  if (unit == "absolute") return 1.0;
  const double area = setup.surface().areas().sum();
  return std::sqrt(unit == "size" ? area : area / static_cast<double>(setup.surface().nodes()));
}

/// Gauss' formula (9) solved for n, with B_ij and Γ^k_ij of the previous state. Conventions where
/// the paper is silent: |B_ij| = delta belongs to (25), (26); at B_ij = 0 the estimate is 0, which
/// alone is mirror symmetric.
class Gauss final : public NormalEstimator {
 public:
  Gauss(const Parameters& p, const Setup& setup)
      : delta_(p.delta / delta_length(p.delta_unit, setup)) {}

  void estimate(const GeometryBlock& lagged, Pair ij, AffineNormal& normal) const override {
    const ConstValues B = lagged.B(ij), gamma_1 = lagged.gamma(1, ij),
                      gamma_2 = lagged.gamma(2, ij);
    for (std::size_t s = 0; s < B.size(); ++s) {
      const double w = std::abs(B[s]) > delta_ ? 1 / B[s] : sign(B[s]);  // (24); (25), (26)
      normal.p[s] = w;
      normal.s[0][s] = -w * gamma_1[s];
      normal.s[1][s] = -w * gamma_2[s];
    }
  }

  [[nodiscard]] std::vector<std::string> branches() const override {
    return {"normalised", "positive", "negative", "flat"};  // (24), (25), (26), B_ij = 0
  }
  void branch(const GeometryBlock& lagged, Pair ij, std::span<std::uint8_t> out) const override {
    const ConstValues B = lagged.B(ij);
    for (std::size_t s = 0; s < B.size(); ++s)
      out[s] = std::abs(B[s]) > delta_ ? 0 : B[s] > 0 ? 1 : B[s] < 0 ? 2 : 3;
  }

 private:
  static double sign(double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : 0.0; }
  double delta_;
};

}  // namespace

DEFORM_PLUGIN(Gauss, Parameters, .name = "gauss", .version = "1.0",
              .summary = "Gauss' formula with the previous state's B and Γ, and the delta fallback",
              .formula = "n_ij ≈ w (r_ij − Γ¹_ij r_1 − Γ²_ij r_2), w = 1/B_ij or ±1",
              .source = "Wu & Melo (23)–(26)")
