/// Loops over the samples of a block for energies of G and B: what form_derivatives.h is made of,
/// on raw arrays of one number a sample.
#pragma once

#include <array>

#include "deform/types.h"

namespace deform {

/// x, y, z of one vector a sample; of some quantity for 11, 12, 22.
using Components = std::array<const double*, 3>;
/// An entry a sample of a symmetric matrix over 11, 12, 22: 00 01 02 11 12 22.
using Symmetric = std::array<const double*, 6>;

/// The nine entries of a 3 × 3 block at each sample, row by row.
struct EntriesOut {
  double* data;
  Index stride;  ///< from an entry to the next
};

/// M = C x for x and M over 11, 12, 22.
void multiply_tensor(Index size, const Symmetric& C, const Components& x,
                     const std::array<double*, 3>& M);
/// out = −Σ_a X_a M_a: of B, or of one m's Γ^m.
void negated_product(Index size, const Components& X, const Components& M, double* out);
/// out_b = −Σ_a Γ^m_a C_ab for one m.
void multiply_gamma(Index size, const Components& gamma, const Symmetric& C,
                    const std::array<double*, 3>& out);
/// r^k = G^k1 r_1 + G^k2 r_2.
void find_dual(Index size, const std::array<const double*, 2>& reciprocal, const Components& r_1,
               const Components& r_2, const std::array<double*, 3>& dual);

/// σ += a u.
void add_along(Index size, const double* a, const Components& u,
               const std::array<double*, 3>& sigma);
/// σ += 2 a u + b v.
void add_twice_and_once(Index size, const double* a, const Components& u, const double* b,
                        const Components& v, const std::array<double*, 3>& sigma);

/// σ_m += Σ_ab L_am C_ab (L_b r − B⁰_b n), L_b r = r_b − Γ^k_b r_k.
struct CurvatureJet {
  std::array<Components, 5> r;  ///< r_1, r_2, r_11, r_12, r_22
  Components n;
  std::array<Components, 2> gamma;  ///< Γ^1, Γ^2
  Symmetric C;
  Components B_origin;
};
void add_curvature_stress(Index size, const CurvatureJet& of,
                          const std::array<std::array<double*, 3>, 5>& to);

/// to += (m_1 r_1 (C_11, C_12) + m_2 r_2 (C_21, C_22)) (n_1 r_1, n_2 r_2)ᵀ + K I, a 3 × 3 block at
/// each sample, C and K one number there.
struct MetricBlock {
  Components r_1, r_2;
  std::array<const double*, 4> C;
  std::array<double, 2> m, n;
  const double* K;  ///< null: 0
};
void add_block(Index size, const MetricBlock& of, const EntriesOut& to);

/// to += x, one number a sample.
void add_numbers(Index size, const double* x, double* to);
/// to += c n nᵀ.
void add_normal_block(Index size, const double* c, const Components& n, const EntriesOut& to);
/// to += c n nᵀ − λ n uᵀ.
struct MixedBlock {
  Components n;
  const double* c;
  const double* lambda;
  Components u;
};
void add_block(Index size, const MixedBlock& of, const EntriesOut& to);
/// to += (c + b g) n nᵀ − λ n uᵀ − μ v nᵀ.
struct TangentialBlock {
  MixedBlock mixed;
  const double *b, *g;
  const double* mu;
  Components v;
};
void add_block(Index size, const TangentialBlock& of, const EntriesOut& to);

}  // namespace deform
