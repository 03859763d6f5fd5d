#include "model/form_derivatives.h"

namespace deform {
namespace {

Derivative derivative(int m) { return static_cast<Derivative>(m + 1); }

Components components(const ConstVectors& v) { return {v.x, v.y, v.z}; }
Components components(const BlockTensor& t) { return {t[0].data(), t[1].data(), t[2].data()}; }
std::array<double*, 3> writable(const Vectors& v) { return {v.x, v.y, v.z}; }
std::array<double*, 3> writable(BlockTensor& t) { return {t[0].data(), t[1].data(), t[2].data()}; }

Symmetric entries(const FormStiffness& C) {
  using enum Pair;
  return {C.values(p11, p11), C.values(p11, p12), C.values(p11, p22),
          C.values(p12, p12), C.values(p12, p22), C.values(p22, p22)};
}
/// Γ^m_11, Γ^m_12, Γ^m_22; m counted from 0.
Components gamma(const GeometryBlock& g, int m) {
  return {g.gamma(m + 1, Pair::p11).data(), g.gamma(m + 1, Pair::p12).data(),
          g.gamma(m + 1, Pair::p22).data()};
}
/// B_11, B_12, B_22.
Components curvature(const GeometryBlock& g) {
  return {g.B(Pair::p11).data(), g.B(Pair::p12).data(), g.B(Pair::p22).data()};
}
const double* reciprocal(const GeometryBlock& g, int k, int l) {
  return g.reciprocal(kPairs[static_cast<std::size_t>(k + l)]).data();
}
EntriesOut block(const JetTangent& h, Derivative m, Derivative n) {
  return {h.entry(m, n, 0, 0), h.stride()};
}

/// ∂G_a/∂r_m has two columns that are not 0: (2 r_1, r_2, ·) for m = 1, (·, r_1, 2 r_2) for m = 2.
struct Columns {
  std::size_t first;               ///< a of the one along r_1; that along r_2 is the next
  std::array<double, 2> of_r_1_2;  ///< factors
};
constexpr std::array<Columns, 2> kColumns{{{0, {2, 1}}, {1, {1, 2}}}};

/// What Σ_a M_a ∂²B_a has beside λ.
struct SecondDerivatives {
  SecondDerivatives(const GeometryBlock& g, const BlockTensor& M) : lambda(g, M) {
    const ConstVectors r_1 = g.r(Derivative::d1), r_2 = g.r(Derivative::d2);
    for (int k = 0; k < 2; ++k)
      find_dual(g.size(), {reciprocal(g, k, 0), reciprocal(g, k, 1)}, components(r_1),
                components(r_2), writable(dual[static_cast<std::size_t>(k)]));
    negated_product(g.size(), curvature(g), components(M), minus_MB.data());
  }
  CurvatureStress lambda;
  std::array<BlockTensor, 2> dual;  // r^1, r^2
  BlockValues minus_MB;             // −Σ_a M_a B_a
};

}  // namespace

void multiply(const FormStiffness& C, const BlockTensor& x, Index size, BlockTensor& out) {
  multiply_tensor(size, entries(C), components(x), writable(out));
}

void add_metric_stress(const GeometryBlock& geometry, const BlockTensor& S, const Stress& sigma) {
  const Index size = geometry.size();
  const Components r_1 = components(geometry.r(Derivative::d1)),
                   r_2 = components(geometry.r(Derivative::d2));
  add_twice_and_once(size, S[0].data(), r_1, S[1].data(), r_2, writable(sigma(Derivative::d1)));
  add_twice_and_once(size, S[2].data(), r_2, S[1].data(), r_1, writable(sigma(Derivative::d2)));
}

void add_metric_tangent(const GeometryBlock& geometry, const FormStiffness& C, const BlockTensor* K,
                        const JetTangent& h) {
  const Components r_1 = components(geometry.r(Derivative::d1)),
                   r_2 = components(geometry.r(Derivative::d2));
  for (std::size_t m = 0; m < 2; ++m)
    for (std::size_t n = m; n < 2; ++n) {
      std::array<const double*, 4> c{};
      for (std::size_t a = 0; a < 2; ++a)
        for (std::size_t b = 0; b < 2; ++b)
          c[2 * a + b] = C.values(kPairs[kColumns[m].first + a], kPairs[kColumns[n].first + b]);
      add_block(geometry.size(),
                MetricBlock{r_1, r_2, c, kColumns[m].of_r_1_2, kColumns[n].of_r_1_2,
                            K == nullptr ? nullptr : (*K)[m + n].data()},
                block(h, static_cast<Derivative>(m + 1), static_cast<Derivative>(n + 1)));
    }
}

CurvatureStress::CurvatureStress(const GeometryBlock& geometry, const BlockTensor& M) {
  for (int m = 0; m < kJet; ++m) {
    const auto at = static_cast<std::size_t>(m);
    if (m < 2)
      negated_product(geometry.size(), gamma(geometry, m), components(M), tangential_[at].data());
    lambda_[at] = m < 2 ? tangential_[at].data() : M[at - 2].data();
  }
}

CurvatureStiffness::CurvatureStiffness(const GeometryBlock& geometry, const FormStiffness& C) {
  const Index size = geometry.size();
  for (std::size_t m = 0; m < 2; ++m)
    multiply_gamma(size, gamma(geometry, static_cast<int>(m)), entries(C), writable(mixed_[m]));
  for (std::size_t m = 0; m < kJet; ++m)
    for (std::size_t k = m; k < kJet; ++k) {
      if (k < 2) {
        BlockValues& out = tangential_[m + k];
        negated_product(size, gamma(geometry, static_cast<int>(k)), components(mixed_[m]),
                        out.data());
        c_[m][k] = out.data();
      } else {
        c_[m][k] = m < 2 ? mixed_[m][k - 2].data() : C.values(kPairs[m - 2], kPairs[k - 2]);
      }
    }
}

void add_normal_stress(const GeometryBlock& geometry, const BlockTensor& M, const Stress& sigma) {
  const CurvatureStress lambda(geometry, M);
  const Components n = components(geometry.n());
  for (int m = 0; m < kJet; ++m)
    add_along(geometry.size(), lambda(m), n, writable(sigma(derivative(m))));
}

void add_curvature_stress(const GeometryBlock& geometry, const GeometryBlock& origin,
                          const FormStiffness& C, const Stress& sigma) {
  CurvatureJet jet{.r = {},
                   .n = components(geometry.n()),
                   .gamma = {gamma(geometry, 0), gamma(geometry, 1)},
                   .C = entries(C),
                   .B_origin = curvature(origin)};
  std::array<std::array<double*, 3>, kJet> out{};
  for (int m = 0; m < kJet; ++m) {
    const auto at = static_cast<std::size_t>(m);
    jet.r[at] = components(geometry.r(derivative(m)));
    out[at] = writable(sigma(derivative(m)));
  }
  add_curvature_stress(geometry.size(), jet, out);
}

void add_curvature_factors(const GeometryBlock& geometry, const FormStiffness& C,
                           const TangentFactors& to) {
  const CurvatureStiffness c(geometry, C);
  for (int m = 0; m < kJet; ++m)
    for (int k = m; k < kJet; ++k)
      add_numbers(geometry.size(), c(m, k), to.entry(derivative(m), derivative(k)));
}

void add_curvature_tangent(const GeometryBlock& geometry, const FormStiffness& C,
                           const BlockTensor* M, const JetTangent& h) {
  const Index size = geometry.size();
  const Components n = components(geometry.n());
  const CurvatureStiffness c(geometry, C);
  const auto each = [&](int from, const auto& add) {
    for (int m = from; m < kJet; ++m)
      for (int k = m; k < kJet; ++k) add(m, k, block(h, derivative(m), derivative(k)));
  };
  const auto add_along_normal = [&](int m, int k, const EntriesOut& out) {
    add_normal_block(size, c(m, k), n, out);
  };
  if (M == nullptr) return each(0, add_along_normal);
  each(2, add_along_normal);
  const SecondDerivatives second(geometry, *M);
  for (int m = 0; m < 2; ++m)
    for (int k = m; k < kJet; ++k) {
      const Components dual_m = components(second.dual[static_cast<std::size_t>(m)]);
      const MixedBlock mixed{n, c(m, k), second.lambda(k), dual_m};
      const EntriesOut out = block(h, derivative(m), derivative(k));
      if (k >= 2)
        add_block(size, mixed, out);
      else
        add_block(
            size,
            TangentialBlock{mixed, second.minus_MB.data(), reciprocal(geometry, m, k),
                            second.lambda(m), components(second.dual[static_cast<std::size_t>(k)])},
            out);
    }
}

}  // namespace deform
