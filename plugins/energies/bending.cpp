#include <deform/model/quadratic_term.h>

namespace {
using namespace deform;

struct Parameters {
  PairWeights xi = PairWeights::all(1e-6);
  std::string form = "divergence";
  PluginUse normal{.kind = PluginKind::normal, .name = "exact"};
  static void declare(Declaration<Parameters>& d) {
    d("xi", &Parameters::xi, "N·m", "resistance to bending, one number or [[11,12],[21,22]]")
        .at_least(0);
    d("form", &Parameters::form, "",
      "of ∂_ij(β_ij n): as it stands, or expanded by Weingarten's formula (22)")
        .one_of({"divergence", "expanded"});
    d("normal", &Parameters::normal, "", "the estimator of n");
  }
};

/// ½ Σ xi_ij (B_ij − B⁰_ij)² with all of its gradient.
class CurvatureNorm final : public QuadraticTerm {
 public:
  explicit CurvatureNorm(const PairWeights& xi)
      : QuadraticTerm(Form::curvature), c_(weighted_norm_stiffness(0.5, xi)) {}
  [[nodiscard]] bool is_diagonal() const override { return true; }
  void stiffness(const GeometryBlock& rest, FormStiffness& c) const override {
    for (Index s = 0; s < rest.size(); ++s) c.set(s, c_);
  }

 private:
  Eigen::Matrix3d c_;
};

/// ½ Σ xi_ij (B_ij − B⁰_ij)², and of its gradient the part that the paper keeps, e = Σ ∂_ij(β_ij n)
/// (19) with β_ij = xi_ij (B_ij − B⁰_ij) (20), for any normal estimator.
class Bending final : public JetTerm {
 public:
  Bending(const Parameters& p, const Setup& setup)
      : xi_(p.xi),
        norm_(p.xi),
        normal_(setup.create<NormalEstimator>(p.normal)),
        expanded_(p.form == "expanded") {}

  [[nodiscard]] TermTraits traits() const override {
    const bool symmetric = !expanded_ && normal_->dependence() != Dependence::jet;
    return {.potential = false,
            .lagged = symmetric ? Lagged::symmetric : Lagged::unsymmetric,
            .strong_form = expanded_};
  }
  [[nodiscard]] const NormalEstimator* normal() const override { return normal_.get(); }

  void energy_density(const SampleBlock& block, Values density) const override {
    add_weighted_norm(0.5, xi_, block, &GeometryBlock::B, density);
  }

  [[nodiscard]] std::vector<Coupling> couplings() const override {
    std::vector<Coupling> all;
    for (const Pair ij : kPairs)
      for (const Derivative n : normal_depends_on(ij))
        all.emplace_back(expanded_ ? Channel::d0 : channel(second(ij)), n);
    if (expanded_)
      for (const Channel m : {Channel::d0, Channel::minus1, Channel::minus2})
        for (const Derivative n : {Derivative::d1, Derivative::d2}) all.emplace_back(m, n);
    return all;
  }

  void affine_stress(const SampleBlock& block, const AffineStress& sigma) const override {
    for (const Pair ij : kPairs)
      expanded_ ? add_expanded(block, ij, sigma) : add_divergence(block, ij, sigma);
  }

  /// That of the whole gradient, from which e differs in terms of lower order.
  void tangent(const SampleBlock& block, Tangent kind, const JetTangent& h) const override {
    norm_.tangent(block, kind, h);
  }
  [[nodiscard]] TangentShape tangent_shape(Tangent kind) const override {
    return norm_.tangent_shape(kind);
  }
  void tangent_factors(const SampleBlock& block, Tangent kind,
                       const TangentFactors& c) const override {
    norm_.tangent_factors(block, kind, c);
  }

  [[nodiscard]] int auxiliary_fields() const override { return expanded_ ? 3 : 0; }
  /// β_ij at every sample, for (22) to difference.
  void auxiliary(const SampleBlock& block, std::span<const Values> fields) const override {
    for (const Pair ij : kPairs) beta(block, ij, fields[static_cast<std::size_t>(slot(ij))]);
  }

 private:
  using Numbers = std::array<double, kBlock>;

  /// β_ij = xi_ij (B_ij − B⁰_ij) (20).
  void beta(const SampleBlock& block, Pair ij, Values out) const {
    const ConstValues B = block.lagged.B(ij), B0 = block.rest.B(ij);
    for (std::size_t s = 0; s < B.size(); ++s) out[s] = xi_(ij) * (B[s] - B0[s]);
  }

  [[nodiscard]] std::vector<Derivative> normal_depends_on(Pair ij) const {
    if (normal_->dependence() == Dependence::none) return {};
    if (normal_->dependence() == Dependence::second_derivative) return {second(ij)};
    return {second(ij), Derivative::d1, Derivative::d2};
  }

  /// Adds factor · n_ij to the stress of a channel.
  void add_normal(const SampleBlock& block, Pair ij, ConstValues factor, const AffineStress& sigma,
                  Channel m) const {
    AffineNormal n;
    normal_->estimate(block.lagged, ij, n);
    const std::size_t size = factor.size();
    const auto add = [&](Derivative on, const Numbers& coefficient) {
      const Values k = sigma.k(m, on);
      for (std::size_t s = 0; s < size; ++s) k[s] += factor[s] * coefficient[s];
    };
    if (normal_->dependence() != Dependence::none) add(second(ij), n.p);
    if (normal_->dependence() == Dependence::jet) {
      add(Derivative::d1, n.s[0]);
      add(Derivative::d2, n.s[1]);
    }
    const Vectors c = sigma.c(m);
    for (std::size_t s = 0; s < size; ++s)
      c.add(static_cast<Index>(s), factor[s] * Vec3(n.c[0][s], n.c[1][s], n.c[2][s]));
  }

  /// σ_ij = β_ij n_ij, once for each of the four pairs that is this one.
  void add_divergence(const SampleBlock& block, Pair ij, const AffineStress& sigma) const {
    Numbers factor;
    const Values beta_ij{factor.data(), static_cast<std::size_t>(block.size())};
    beta(block, ij, beta_ij);
    for (double& b : beta_ij) b *= multiplicity(ij);
    add_normal(block, ij, beta_ij, sigma, channel(second(ij)));
  }

  /// (22): D_ij^-(β_ij) n_ij + Σ_k D_j^-(β_ij) d_ki r_k + D_i^-(β_ij Σ_k d_kj r_k). The first two
  /// act at the sample itself (channel d0), the third through −D_i^-, hence its sign.
  void add_expanded(const SampleBlock& block, Pair ij, const AffineStress& sigma) const {
    const auto size = static_cast<std::size_t>(block.size());
    Numbers beta_numbers, difference_numbers;
    const Values beta_ij{beta_numbers.data(), size}, difference{difference_numbers.data(), size};
    beta(block, ij, beta_ij);

    block.difference(second(ij), slot(ij), difference);
    for (double& b : difference) b *= multiplicity(ij);
    add_normal(block, ij, difference, sigma, Channel::d0);

    for (const auto& [i, j] : kOrders) {
      if (pair(i, j) != ij) continue;
      block.difference(first(j), slot(ij), difference);
      for (const int k : {1, 2}) {
        const ConstValues d_ki = block.lagged.d(k, i), d_kj = block.lagged.d(k, j);
        const Values at_sample = sigma.k(Channel::d0, first(k));
        const Values differenced = sigma.k(i == 1 ? Channel::minus1 : Channel::minus2, first(k));
        for (std::size_t s = 0; s < size; ++s) {
          at_sample[s] += difference[s] * d_ki[s];
          differenced[s] -= beta_ij[s] * d_kj[s];
        }
      }
    }
  }

  /// The sum over all four (i, j).
  static constexpr std::array<std::pair<int, int>, 4> kOrders{{{1, 1}, {1, 2}, {2, 1}, {2, 2}}};

  PairWeights xi_;
  CurvatureNorm norm_;
  std::shared_ptr<NormalEstimator> normal_;
  bool expanded_;
};

}  // namespace

DEFORM_PLUGIN(Bending, Parameters, .name = "bending", .version = "1.0",
              .summary = "resistance to bending as the paper has it, with any normal",
              .formula = "w = ½ Σ xi_ij (B_ij − B⁰_ij)², e = Σ ∂_ij(β_ij n_ij)",
              .source = "Wu & Melo (19)–(22), second part")
