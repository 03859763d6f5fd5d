/// Do G and B belong to one surface? Residuals of the equations of Gauss and of Codazzi and
/// Mainardi at the samples. The discrete G and B of a smooth surface satisfy them up to the
/// differences' error.
///
/// Both say that the third derivatives of r commute, (r_11)_2 = (r_12)_1 and (r_12)_2 = (r_22)_1,
/// with r_ij = Γ^k_ij r_k + B_ij n and n_j = −G^kl B_lj r_k (sums over k, l, m = 1, 2).
///
/// Gauss, the first one's product with r_2 (do Carmo, section 4-3, writes its component k = 2
/// alone, G_11 K up to sign; with the index lowered the left side is R_1212 = K det G):
///   G_2k (∂_2 Γ^k_11 − ∂_1 Γ^k_12 + Γ^m_11 Γ^k_m2 − Γ^m_12 Γ^k_m1) = B_11 B_22 − B_12²
/// Codazzi and Mainardi, the parts along n (as in do Carmo, whose e, f, g are B_11, B_12, B_22):
///   ∂_2 B_11 − ∂_1 B_12 = B_11 Γ¹_12 + B_12 (Γ²_12 − Γ¹_11) − B_22 Γ²_11
///   ∂_2 B_12 − ∂_1 B_22 = B_11 Γ¹_22 + B_12 (Γ²_22 − Γ¹_12) − B_22 Γ²_12
#include <algorithm>
#include <cmath>

#include <deform/record/probe.h>

namespace {

using namespace deform;

/// G, B, Γ at one sample.
struct Forms {
  std::array<double, 3> G{}, B{};
  std::array<std::array<double, 3>, 2> gamma{};

  Forms(const GeometryBlock& g, std::size_t s) {
    for (const Pair ij : kPairs) {
      const auto p = static_cast<std::size_t>(slot(ij));
      G[p] = g.G(ij)[s];
      B[p] = g.B(ij)[s];
      for (const int k : {1, 2}) gamma[static_cast<std::size_t>(k - 1)][p] = g.gamma(k, ij)[s];
    }
  }
  [[nodiscard]] double Gamma(int k, int i, int j) const {
    return gamma[static_cast<std::size_t>(k - 1)][static_cast<std::size_t>(slot(pair(i, j)))];
  }
};

/// The differences of Γ and B that the equations need, each at every sample.
struct Differences {
  std::array<std::vector<double>, 2> d2_Gamma_11, d1_Gamma_12;  // of Γ^1, Γ^2
  std::vector<double> d2_B_11, d1_B_12, d2_B_12, d1_B_22;

  void compute(const FieldDifferences& differences, const GeometryBlock& g) {
    const auto apply = [&](Derivative op, ConstValues field, std::vector<double>& out) {
      out.resize(field.size());
      differences.apply(op, field, 0, out);
    };
    for (const int k : {1, 2}) {
      const auto i = static_cast<std::size_t>(k - 1);
      apply(Derivative::d2, g.gamma(k, Pair::p11), d2_Gamma_11[i]);
      apply(Derivative::d1, g.gamma(k, Pair::p12), d1_Gamma_12[i]);
    }
    apply(Derivative::d2, g.B(Pair::p11), d2_B_11);
    apply(Derivative::d1, g.B(Pair::p12), d1_B_12);
    apply(Derivative::d2, g.B(Pair::p12), d2_B_12);
    apply(Derivative::d1, g.B(Pair::p22), d1_B_22);
  }
};

double gauss_residual(const Forms& f, const Differences& d, std::size_t s) {
  const std::array<double, 2> G_2{f.G[1], f.G[2]};
  double R_1212 = 0;
  for (const int k : {1, 2}) {
    const auto i = static_cast<std::size_t>(k - 1);
    double sum = d.d2_Gamma_11[i][s] - d.d1_Gamma_12[i][s];
    for (const int m : {1, 2})
      sum += f.Gamma(m, 1, 1) * f.Gamma(k, m, 2) - f.Gamma(m, 1, 2) * f.Gamma(k, m, 1);
    R_1212 += G_2[i] * sum;
  }
  return R_1212 - (f.B[0] * f.B[2] - f.B[1] * f.B[1]);
}

Vec2 codazzi_residual(const Forms& f, const Differences& d, std::size_t s) {
  const auto [B_11, B_12, B_22] = f.B;
  return {d.d2_B_11[s] - d.d1_B_12[s] -
              (B_11 * f.Gamma(1, 1, 2) + B_12 * (f.Gamma(2, 1, 2) - f.Gamma(1, 1, 1)) -
               B_22 * f.Gamma(2, 1, 1)),
          d.d2_B_12[s] - d.d1_B_22[s] -
              (B_11 * f.Gamma(1, 2, 2) + B_12 * (f.Gamma(2, 2, 2) - f.Gamma(1, 1, 2)) -
               B_22 * f.Gamma(2, 1, 2))};
}

/// True where the whole jet, and so G, B and Γ, is computable.
bool has_jet(const SampleSet& samples, Index s) {
  for (const Derivative d :
       {Derivative::d1, Derivative::d2, Derivative::d11, Derivative::d12, Derivative::d22})
    if (!samples.computable(d, s)) return false;
  return true;
}

/// True where the difference exists and reaches only samples with a whole jet.
bool has_difference(const SampleSet& samples, Derivative op, Index s) {
  const auto row = samples.field_differences()->row(op, s);
  return !row.empty() && std::all_of(row.begin(), row.end(), [&](const auto& term) {
    return has_jet(samples, term.sample);
  });
}

class Compatibility final : public Probe {
 public:
  Compatibility(const NoParameters& /*parameters*/, const Setup& /*setup*/) {}

  void begin(const RunContext& context) override {
    samples_ = &context.system.surface().samples(SampleRole::bending);
    interior_.clear();
    if (samples_->field_differences() == nullptr) return;
    for (Index s = 0; s < samples_->size(); ++s)
      if (has_jet(*samples_, s) && has_difference(*samples_, Derivative::d1, s) &&
          has_difference(*samples_, Derivative::d2, s))
        interior_.push_back(s);
  }

  [[nodiscard]] std::vector<ProbeColumn> columns() const override {
    return {{"compatibility.gauss", "1/m²"}, {"compatibility.codazzi", "1/m²"}};
  }

  void measure(const Frame& frame, Values figures) override {
    figures[0] = figures[1] = kNoFigure;
    if (interior_.empty()) return;
    const auto all = frame.geometry(*samples_);
    const GeometryBlock geometry = all->all();
    differences_.compute(*samples_->field_differences(), geometry);
    double gauss = 0, codazzi = 0, area = 0;
    for (const Index sample : interior_) {
      const auto s = static_cast<std::size_t>(sample);
      const Forms forms(geometry, s);
      const double weight = samples_->weights()[s];
      const double residual = gauss_residual(forms, differences_, s);
      gauss += weight * residual * residual;
      codazzi += weight * codazzi_residual(forms, differences_, s).squaredNorm();
      area += weight;
    }
    figures[0] = std::sqrt(gauss / area);
    figures[1] = std::sqrt(codazzi / area);
  }

 private:
  const SampleSet* samples_ = nullptr;
  std::vector<Index> interior_;
  Differences differences_;
};

}  // namespace

DEFORM_PLUGIN(Compatibility, NoParameters, .name = "compatibility", .version = "1.0",
              .summary =
                  "Residuals of the Gauss and of the Codazzi-Mainardi equations, area-weighted "
                  "root mean square over the samples whose neighbours have all derivatives",
              .formula =
                  "R_1212 - det B; B_11,2 - B_12,1 - (B_11 Γ¹_12 + B_12 (Γ²_12 - Γ¹_11) - "
                  "B_22 Γ²_11), and the same with B_12,2 - B_22,1",
              .source = "do Carmo, Differential Geometry of Curves and Surfaces, section 4-3")
