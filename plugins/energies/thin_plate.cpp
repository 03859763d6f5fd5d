#include <algorithm>
#include <array>
#include <cmath>

#include <deform/geometry/characteristic_length.h>
#include <deform/model/energy_term.h>
#include <deform/surface/surface.h>

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

using Jet = std::array<Derivative, kJet>;
constexpr Jet kJetOf{Derivative::d1, Derivative::d2, Derivative::d11, Derivative::d12,
                     Derivative::d22};

/// What the energy needs of the rest surface at a sample: G^ij, det G, and Γ^k_ij; as they stand
/// here those of a plane whose parameters are lengths.
struct RestMetric {
  std::array<double, 3> reciprocal{1, 0, 1};     ///< G^11, G^12, G^22
  double area = 1, determinant = 1;              ///< √det G, det G
  std::array<std::array<double, 2>, 3> gamma{};  ///< of the pairs 11, 12, 22; k = 1, 2
};

RestMetric metric_at(const GeometryBlock& rest, std::size_t s) {
  if (!(rest.area_element()[s] > 0))  // a border where the tangents do not exist
    return {.reciprocal = {}, .area = 0, .determinant = 1, .gamma = {}};
  RestMetric g;
  g.area = rest.area_element()[s];
  g.determinant = g.area * g.area;
  for (const Pair ij : kPairs) {
    const auto p = static_cast<std::size_t>(slot(ij));
    g.reciprocal[p] = rest.reciprocal(ij)[s];
    g.gamma[p] = {rest.gamma(1, ij)[s], rest.gamma(2, ij)[s]};
  }
  return g;
}

/// Whether the rest surface is a plane, or can be rolled from one, with lengths for parameters: its
/// metric is 1 and its Christoffel symbols are 0, but for rounding.
bool is_cartesian(const Surface& surface, const NodeVectors& rest) {
  constexpr double kMetric = 1e-9, kChristoffel = 1e-6;  // far above rounding, far below shapes
  const SampleSet& samples = surface.samples(SampleRole::bending);
  const double size = characteristic_length(rest);
  Geometry geometry(samples);
  geometry.compute(samples, rest);
  const GeometryBlock all = geometry.all();
  for (std::size_t s = 0; s < static_cast<std::size_t>(all.size()); ++s) {
    const auto exists = [&](Derivative d) { return samples.computable(d, static_cast<Index>(s)); };
    if (!exists(Derivative::d1) || !exists(Derivative::d2)) continue;
    for (const Pair ij : kPairs) {
      const double expected = ij == Pair::p12 ? 0 : 1;
      const double gamma = std::max(std::abs(all.gamma(1, ij)[s]), std::abs(all.gamma(2, ij)[s]));
      if (!(std::abs(all.G(ij)[s] - expected) <= kMetric) || !(size * gamma <= kChristoffel))
        return false;
    }
  }
  return true;
}

/// The thin plate's linear energy of each component of u = r − r⁰ by itself, with the second
/// covariant derivatives u_;ij = u_ij − Γ^k_ij u_k on the rest surface: quadratic in r, so that its
/// lagged operator is its tangent. A baseline: it knows no rotation, and resists what bends a sheet
/// that has turned as if it had not.
class ThinPlate final : public JetTerm {
 public:
  ThinPlate(const Parameters& p, const Setup& setup)
      : D_(p.xi), nu_(p.poisson), cartesian_(is_cartesian(setup.surface(), setup.rest())) {}

  [[nodiscard]] TermTraits traits() const override {
    return {.potential = true, .lagged = Lagged::symmetric, .semidefinite = true};
  }
  [[nodiscard]] std::vector<Derivative> dependence() const override {
    if (cartesian_) return {Derivative::d11, Derivative::d12, Derivative::d22};
    return {kJetOf.begin(), kJetOf.end()};
  }

  void energy_density(const SampleBlock& block, Values density) const override {
    for (Index s = 0; s < block.size(); ++s) {
      const RestMetric g = metric(block, s);
      const auto u = [&](Derivative d) { return Vec3(block.now.r(d)[s] - block.rest.r(d)[s]); };
      const auto second_covariant = [&](Pair ij) {
        Vec3 sum = u(second(ij));
        if (cartesian_) return sum;
        const auto& [gamma_1, gamma_2] = g.gamma[static_cast<std::size_t>(slot(ij))];
        sum -= gamma_1 * u(Derivative::d1) + gamma_2 * u(Derivative::d2);
        return sum;
      };
      const Vec3 u_11 = second_covariant(Pair::p11), u_12 = second_covariant(Pair::p12),
                 u_22 = second_covariant(Pair::p22);
      const Vec3 trace =
          g.reciprocal[0] * u_11 + 2 * g.reciprocal[1] * u_12 + g.reciprocal[2] * u_22;
      density[static_cast<std::size_t>(s)] +=
          0.5 * D_ * g.area *
          (trace.squaredNorm() -
           2 * (1 - nu_) * (u_11.dot(u_22) - u_12.squaredNorm()) / g.determinant);
    }
  }

  [[nodiscard]] std::vector<Coupling> couplings() const override {
    std::vector<Coupling> all;
    visit_entries([&](std::size_t m, std::size_t n) {
      all.emplace_back(channel(kJetOf[m]), kJetOf[n]);
      if (m != n) all.emplace_back(channel(kJetOf[n]), kJetOf[m]);
    });
    return all;
  }
  void affine_stress(const SampleBlock& block, const AffineStress& sigma) const override {
    for (Index s = 0; s < block.size(); ++s) {
      const Stiffness k = stiffness(metric(block, s));
      const auto add = [&](Derivative m, Derivative n, double value) {
        sigma.k(m, n)[static_cast<std::size_t>(s)] += value;
        sigma.c(m).add(s, -value * block.rest.r(n)[s]);
      };
      visit_entries([&](std::size_t m, std::size_t n) {
        add(kJetOf[m], kJetOf[n], k[m][n]);
        if (m != n) add(kJetOf[n], kJetOf[m], k[m][n]);
      });
    }
  }
  void tangent(const SampleBlock& block, Tangent /*kind*/, const JetTangent& h) const override {
    for (Index s = 0; s < block.size(); ++s) {
      const Stiffness k = stiffness(metric(block, s));
      visit_entries([&](std::size_t m, std::size_t n) {
        h.add(s, kJetOf[m], kJetOf[n], k[m][n] * Eigen::Matrix3d::Identity());
      });
    }
  }

 private:
  /// ∂²W/∂(D_m r)∂(D_n r) as multiples of the identity, for m ≤ n.
  using Stiffness = std::array<std::array<double, kJet>, kJet>;

  [[nodiscard]] RestMetric metric(const SampleBlock& block, Index s) const {
    return cartesian_ ? RestMetric{} : metric_at(block.rest, static_cast<std::size_t>(s));
  }

  /// Calls visit(m, n), m ≤ n, for what couples: of lengths as parameters second derivatives alone.
  template <class Visit>
  void visit_entries(const Visit& visit) const {
    if (cartesian_) {
      visit(2, 2), visit(2, 4), visit(3, 3), visit(4, 4);
      return;
    }
    for (std::size_t m = 0; m < kJet; ++m)
      for (std::size_t n = m; n < kJet; ++n) visit(m, n);
  }

  /// Aᵀ Q A with u_;ij = A u_m and, for x = (u_;11, u_;12, u_;22), 2W = xᵀ Q x, where
  /// tr(M²) = xᵀ S x and tr(M) = t·x for M = G⁻¹ u_;ij: Q = D √det G [(1 − ν) S + ν t tᵀ].
  [[nodiscard]] Stiffness stiffness(const RestMetric& g) const {
    const auto& [g_11, g_12, g_22] = g.reciprocal;
    const std::array<double, 3> t{g_11, 2 * g_12, g_22};
    const std::array<std::array<double, 3>, 3> S{
        {{g_11 * g_11, 2 * g_11 * g_12, g_12 * g_12},
         {2 * g_11 * g_12, 2 * (g_11 * g_22 + g_12 * g_12), 2 * g_12 * g_22},
         {g_12 * g_12, 2 * g_12 * g_22, g_22 * g_22}}};
    Stiffness k{};
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) {
        const double Q = D_ * g.area * ((1 - nu_) * S[a][b] + nu_ * (t[a] * t[b]));
        k[2 + a][2 + b] += Q;
        if (cartesian_) continue;
        for (std::size_t l = 0; l < 2; ++l) {
          k[l][2 + b] -= g.gamma[a][l] * Q;
          for (std::size_t m = 0; m < 2; ++m) k[l][m] += g.gamma[a][l] * Q * g.gamma[b][m];
        }
      }
    return k;
  }

  double D_, nu_;
  bool cartesian_;
};

}  // namespace

DEFORM_PLUGIN(
    ThinPlate, Parameters, .name = "thin_plate", .version = "1.0",
    .summary = "linear thin plate, a baseline for small deflections of flat sheets",
    .formula =
        "w = ½ D (|tr u_;ij|² − 2(1 − ν) det u_;ij) per rest area, u = r − r⁰, with covariant "
        "derivatives on the rest surface; |u_11 + u_22|² − 2(1 − ν)(u_11·u_22 − |u_12|²) where a1 "
        "and a2 are lengths",
    .source = "Kirchhoff 1850; Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells")
