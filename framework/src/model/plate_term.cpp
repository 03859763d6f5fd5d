#include "deform/model/plate_term.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>

#include "deform/error.h"
#include "deform/geometry/characteristic_length.h"
#include "deform/kernel.h"
#include "deform/plugin/setup.h"
#include "deform/surface/surface.h"

#include "model/form_derivatives.h"
#include "model/form_kernels.h"

namespace deform {
namespace {

// Far above rounding, far below shapes.
constexpr double kMetricRounding = 1e-9, kCurvatureRounding = 1e-6;

/// Whether `is_so(geometry, s)` for every sample s of the rest surface whose tangents exist.
template <class Predicate>
bool holds_at_rest(const Surface& surface, const NodeVectors& rest, const Predicate& is_so) {
  const SampleSet& samples = surface.samples(SampleRole::bending);
  Geometry geometry(samples);
  geometry.compute(samples, rest);
  const GeometryBlock all = geometry.all();
  for (Index s = 0; s < all.size(); ++s)
    if (samples.computable(Derivative::d1, s) && samples.computable(Derivative::d2, s) &&
        !is_so(all, static_cast<std::size_t>(s)))
      return false;
  return true;
}

/// Whether the rest surface is a plane, or can be rolled from one, with lengths for parameters: its
/// metric is 1 and its Christoffel symbols are 0, but for rounding.
bool is_cartesian(const Surface& surface, const NodeVectors& rest) {
  const double size = characteristic_length(rest);
  return holds_at_rest(surface, rest, [&](const GeometryBlock& g, std::size_t s) {
    return std::ranges::all_of(kPairs, [&](Pair ij) {
      const double expected = ij == Pair::p12 ? 0 : 1;
      const double gamma = std::max(std::abs(g.gamma(1, ij)[s]), std::abs(g.gamma(2, ij)[s]));
      return std::abs(g.G(ij)[s] - expected) <= kMetricRounding &&
             size * gamma <= kCurvatureRounding;
    });
  });
}

/// One component of X_ij: r_ij − Γ^1_ij r_1 − Γ^2_ij r_2 − B⁰_ij n⁰.
struct Component {
  const double *r_ij, *r_1, *r_2, *gamma_1, *gamma_2, *B, *n;
};
DEFORM_KERNEL void find_component(Index size, const Component& of, double* __restrict x) {
  const double *const r_ij = of.r_ij, *const r_1 = of.r_1, *const r_2 = of.r_2,
                      *const gamma_1 = of.gamma_1, *const gamma_2 = of.gamma_2, *const B = of.B,
                      *const n = of.n;
  for (Index s = 0; s < size; ++s)
    x[s] = r_ij[s] - gamma_1[s] * r_1[s] - gamma_2[s] * r_2[s] - B[s] * n[s];
}
/// The same where Γ is 0.
DEFORM_KERNEL void find_cartesian_component(Index size, const double* __restrict r_ij,
                                            const double* __restrict B, const double* __restrict n,
                                            double* __restrict x) {
  for (Index s = 0; s < size; ++s) x[s] = r_ij[s] - B[s] * n[s];
}
/// density += ½ x S.
DEFORM_KERNEL void add_half_products(Index size, const double* __restrict x,
                                     const double* __restrict S, double* __restrict density) {
  for (Index s = 0; s < size; ++s) density[s] += 0.5 * (x[s] * S[s]);
}

const double* component(const ConstVectors& v, int c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }
double* component(const Vectors& v, int c) { return c == 0 ? v.x : c == 1 ? v.y : v.z; }

/// X_11, X_12, X_22 of one component of space.
void find_vectors(const SampleBlock& block, bool is_cartesian, int c, BlockTensor& x) {
  const double* n = component(block.rest.n(), c);
  for (const Pair ij : kPairs) {
    double* out = x[static_cast<std::size_t>(slot(ij))].data();
    const double *r_ij = component(block.now.r(ij), c), *B = block.rest.B(ij).data();
    if (is_cartesian)
      find_cartesian_component(block.size(), r_ij, B, n, out);
    else
      find_component(block.size(),
                     {r_ij, component(block.now.r(Derivative::d1), c),
                      component(block.now.r(Derivative::d2), c), block.rest.gamma(1, ij).data(),
                      block.rest.gamma(2, ij).data(), B, n},
                     out);
  }
}

Components values(const BlockTensor& x) { return {x[0].data(), x[1].data(), x[2].data()}; }

/// What X depends on.
std::span<const Derivative> derivatives(bool is_cartesian) {
  using enum Derivative;
  static constexpr std::array kJetOf{d1, d2, d11, d12, d22};
  return std::span<const Derivative>(kJetOf).subspan(is_cartesian ? 2 : 0);
}

const std::vector<Coupling>& couplings_of_plate(bool is_cartesian, PlateTerm::Twist twist) {
  using enum Derivative;
  static const std::vector<Coupling> all = couplings_among({d1, d2, d11, d12, d22}),
                                     second = couplings_among({d11, d12, d22}), straight = [] {
                                       std::vector<Coupling> some = couplings_among({d11, d22});
                                       some.emplace_back(channel(d12), d12);
                                       return some;
                                     }();
  return !is_cartesian ? all : twist == PlateTerm::Twist::coupled ? second : straight;
}

}  // namespace

PlateTerm::PlateTerm(const Surface& surface, const NodeVectors& rest, Twist twist)
    : is_cartesian_(is_cartesian(surface, rest)), twist_(twist) {}
PlateTerm::~PlateTerm() = default;

TermTraits PlateTerm::traits() const {
  return {
      .potential = true, .lagged = Lagged::symmetric, .semidefinite = true, .direct_stress = true};
}

std::vector<Derivative> PlateTerm::dependence() const {
  const std::span<const Derivative> all = derivatives(is_cartesian_);
  return {all.begin(), all.end()};
}

void PlateTerm::energy_density(const SampleBlock& block, Values density) const {
  const Index size = block.size();
  FormStiffness C(size);
  stiffness(block.rest, C);
  BlockTensor x, S;
  for (int c = 0; c < 3; ++c) {
    find_vectors(block, is_cartesian_, c, x);
    multiply(C, x, size, S);
    for (std::size_t a = 0; a < 3; ++a)
      add_half_products(size, x[a].data(), S[a].data(), density.data());
  }
}

void PlateTerm::stress(const SampleBlock& block, const Stress& sigma) const {
  const Index size = block.size();
  FormStiffness C(size);
  stiffness(block.rest, C);
  BlockTensor x, S;
  for (int c = 0; c < 3; ++c) {
    find_vectors(block, is_cartesian_, c, x);
    multiply(C, x, size, S);
    for (const Pair ij : kPairs)
      add_numbers(size, S[static_cast<std::size_t>(slot(ij))].data(),
                  component(sigma(second(ij)), c));
    if (is_cartesian_) continue;
    BlockValues tangential;  // −Γ^k_ij S_ij
    for (const int k : {1, 2}) {
      negated_product(size,
                      {block.rest.gamma(k, Pair::p11).data(), block.rest.gamma(k, Pair::p12).data(),
                       block.rest.gamma(k, Pair::p22).data()},
                      values(S), tangential.data());
      add_numbers(size, tangential.data(), component(sigma(first(k)), c));
    }
  }
}

std::vector<Coupling> PlateTerm::couplings() const {
  return couplings_of_plate(is_cartesian_, twist_);
}

void PlateTerm::affine_stress(const SampleBlock& block, const AffineStress& sigma) const {
  const Index size = block.size();
  FormStiffness C(size);
  stiffness(block.rest, C);
  const CurvatureStiffness k(block.rest, C);
  for (const auto& [m, n] : couplings_of_plate(is_cartesian_, twist_))
    add_numbers(size, k(std::min(slot(m), slot(n)) - 1, std::max(slot(m), slot(n)) - 1),
                sigma.k(m, n).data());
  BlockTensor x, M;  // what X has beside derivatives of r: −B⁰_ij n⁰
  for (const Pair ij : kPairs)
    std::ranges::transform(block.rest.B(ij), x[static_cast<std::size_t>(slot(ij))].begin(),
                           std::negate<>());
  multiply(C, x, size, M);
  const CurvatureStress lambda(block.rest, M);
  const ConstVectors n = block.rest.n();
  for (const Derivative m : derivatives(is_cartesian_)) {
    const Vectors c = sigma.c(m);
    add_along(size, lambda(slot(m) - 1), {n.x, n.y, n.z}, {c.x, c.y, c.z});
  }
}

void PlateTerm::tangent(const SampleBlock& block, Tangent /*kind*/, const JetTangent& h) const {
  FormStiffness C(block.size());
  stiffness(block.rest, C);
  const CurvatureStiffness k(block.rest, C);
  for (const Derivative m : derivatives(is_cartesian_))
    for (const Derivative n : derivatives(is_cartesian_))
      for (int i = 0; m <= n && i < 3; ++i)
        if (double* to = h.entry(m, n, i, i))
          add_numbers(block.size(), k(slot(m) - 1, slot(n) - 1), to);
}

TangentShape PlateTerm::tangent_shape(Tangent /*kind*/) const { return TangentShape::identity; }

void PlateTerm::tangent_factors(const SampleBlock& block, Tangent /*kind*/,
                                const TangentFactors& c) const {
  FormStiffness C(block.size());
  stiffness(block.rest, C);
  const CurvatureStiffness k(block.rest, C);
  for (const Derivative m : derivatives(is_cartesian_))
    for (const Derivative n : derivatives(is_cartesian_))
      if (m <= n) add_numbers(block.size(), k(slot(m) - 1, slot(n) - 1), c.entry(m, n));
}

void require_flat(const Setup& setup) {
  const double size = characteristic_length(setup.rest());
  const bool is_flat =
      holds_at_rest(setup.surface(), setup.rest(), [&](const GeometryBlock& g, std::size_t s) {
        return std::ranges::all_of(
            kPairs, [&](Pair ij) { return size * std::abs(g.B(ij)[s]) <= kCurvatureRounding; });
      });
  if (!is_flat)
    throw InputError(
        "'bending' is \"isometric\", but the rest surface is curved: its energy would change when "
        "the surface turns; \"curvature\" is for any shape");
}

}  // namespace deform
