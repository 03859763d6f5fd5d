#include <deform/model/energy_term.h>

namespace {
using namespace deform;

struct Parameters {
  double xi = 1e-6;
  double poisson = 0.3;
  static void declare(Declaration<Parameters>& d) {
    d("xi", &Parameters::xi, "N·m", "bending rigidity D").at_least(0);
    d("poisson", &Parameters::poisson, "1", "Poisson's ratio").at_least(0).at_most(0.5);
  }
};

/// The thin plate's linear energy of each component of u = r − r⁰ by itself: quadratic in r, so
/// that its lagged operator is its tangent. A baseline: it knows no rotation, and resists what
/// bends a sheet that has turned as if it had not.
class ThinPlate final : public JetTerm {
 public:
  ThinPlate(const Parameters& p, const Setup& /*setup*/) : D_(p.xi), nu_(p.poisson) {}

  [[nodiscard]] TermTraits traits() const override {
    return {.potential = true, .lagged = Lagged::symmetric, .semidefinite = true};
  }
  [[nodiscard]] std::vector<Derivative> dependence() const override {
    return {Derivative::d11, Derivative::d12, Derivative::d22};
  }

  void energy_density(const SampleBlock& block, Values density) const override {
    for (Index s = 0; s < block.size(); ++s) {
      const auto u = [&](Derivative d) { return Vec3(block.now.r(d)[s] - block.rest.r(d)[s]); };
      const Vec3 u_11 = u(Derivative::d11), u_12 = u(Derivative::d12), u_22 = u(Derivative::d22);
      density[static_cast<std::size_t>(s)] +=
          0.5 * D_ *
          ((u_11 + u_22).squaredNorm() - 2 * (1 - nu_) * (u_11.dot(u_22) - u_12.squaredNorm()));
    }
  }

  [[nodiscard]] std::vector<Coupling> couplings() const override {
    std::vector<Coupling> all;
    for (const auto& [m, n, k] : stiffness()) {
      all.emplace_back(channel(m), n);
      if (m != n) all.emplace_back(channel(n), m);
    }
    return all;
  }
  void affine_stress(const SampleBlock& block, const AffineStress& sigma) const override {
    const auto add = [&](Derivative m, Derivative n, double k) {
      const Values values = sigma.k(m, n);
      const Vectors c = sigma.c(m);
      for (Index s = 0; s < block.size(); ++s) {
        values[static_cast<std::size_t>(s)] += k;
        c.add(s, -k * block.rest.r(n)[s]);
      }
    };
    for (const auto& [m, n, k] : stiffness()) {
      add(m, n, k);
      if (m != n) add(n, m, k);
    }
  }
  void tangent(const SampleBlock& block, Tangent /*kind*/, const JetTangent& h) const override {
    for (Index s = 0; s < block.size(); ++s)
      for (const auto& [m, n, k] : stiffness()) h.add(s, m, n, k * Eigen::Matrix3d::Identity());
  }

 private:
  struct Entry {
    Derivative m, n;
    double k;
  };
  /// ∂²W/∂(D_m r)∂(D_n r), the upper triangle.
  [[nodiscard]] std::array<Entry, 4> stiffness() const {
    using enum Derivative;
    return {{{d11, d11, D_}, {d11, d22, nu_ * D_}, {d12, d12, 2 * (1 - nu_) * D_}, {d22, d22, D_}}};
  }

  double D_, nu_;
};

}  // namespace

DEFORM_PLUGIN(
    ThinPlate, Parameters, .name = "thin_plate", .version = "1.0",
    .summary = "linear thin plate, a baseline for small deflections of flat sheets",
    .formula = "w = ½ D (|u_11 + u_22|² − 2(1 − ν)(u_11·u_22 − |u_12|²)), u = r − r⁰",
    .source = "Kirchhoff 1850; Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells")
