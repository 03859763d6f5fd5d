"""Lateral buckling of cantilever strips of finite width: plates on edge under their own weight."""

import numpy as np

from .numerics import gauss, legendre


class _Products:
    """Products x^power P_i(x) · P_j(y) on a strip of length 1 and `width`, with derivatives at the
    points of Gauss's rule: functions that the clamp at x = 0 allows.
    """

    def __init__(self, width, along, across):
        self.x, weights_x = gauss(along + 6, 0, 1)
        y, weights_y = gauss(across + 6, -width / 2, width / 2)
        self.along, self.weights = legendre(along, self.x, 0, 1), np.outer(weights_x, weights_y)
        self.across = legendre(across, y, -width / 2, width / 2)

    def functions(self, power):
        """By (orders of d/dx, of d/dy), up to two in all: (functions, points)."""
        x = self.x[:, None]
        p, dp, ddp = self.along
        factor = [x**power, power * x ** (power - 1), power * (power - 1) * x ** max(power - 2, 0)]
        of_x = [factor[0] * p, factor[1] * p + factor[0] * dp,
                factor[2] * p + 2 * factor[1] * dp + factor[0] * ddp]
        return {(a, b): np.einsum("xi,yj->ijxy", of_x[a], self.across[b]).reshape(
                    p.shape[1] * self.across[0].shape[1], -1)
                for a in range(3) for b in range(3 - a)}

    def inner(self, f, g, factor=1.0):
        """∫ factor f g over the strip, of all functions f with all g."""
        return (f * (self.weights * factor).ravel()) @ g.T


def _stress_under_weight(products, nu):
    """N_xx, N_xy, N_yy at the points, of a strip clamped at x = 0 under a unit load a area along −y.

    Minimises the energy of plane stress, ½ ∫ N·ε + ∫ v; N does not depend on Young's modulus.
    """
    f = products.functions(1)
    f_x, f_y = f[1, 0], f[0, 1]
    membrane, shear = 1 / (1 - nu * nu), 1 / (2 * (1 + nu))
    xx, xy, yy = products.inner(f_x, f_x), products.inner(f_x, f_y), products.inner(f_y, f_y)
    stiffness = np.block([[membrane * xx + shear * yy, membrane * nu * xy + shear * xy.T],
                          [membrane * nu * xy.T + shear * xy, membrane * yy + shear * xx]])
    load = np.concatenate([np.zeros(len(f_x)), -f[0, 0] @ products.weights.ravel()])
    u, v = np.split(np.linalg.solve(stiffness, load), 2)
    e_xx, e_yy, e_xy = u @ f_x, v @ f_y, u @ f_y + v @ f_x
    shape = products.weights.shape
    return tuple(n.reshape(shape) for n in
                 (membrane * (e_xx + nu * e_yy), shear * e_xy, membrane * (e_yy + nu * e_xx)))


def lateral_buckling_of_plate(width, nu, along=24, across=12):
    """Critical Γ* = ρ g h L³/D of a cantilever strip on edge, of a width in units of its length L.

    Ritz's method with products of `along` × `across` polynomials, twice: the stress N under the
    weight, and then the least load at which the plate's energy
    D ∫ (Δw)² − 2(1 − ν)(w_xx w_yy − w_xy²) + ∫ N_xx w_x² + 2 N_xy w_x w_y + N_yy w_y²
    ceases to be positive, with w = w_x = 0 at the clamp. The weight is a dead load. From above;
    converged to 2e-4, as both stresses are singular at the clamp's corners; strips narrower than a
    tenth take more polynomials along, as the clamp is felt over a width only.
    Source: S. Timoshenko, J. M. Gere, Theory of Elastic Stability (1961), chapters 6 and 8.
    """
    products = _Products(width, along, across)
    n_xx, n_xy, n_yy = _stress_under_weight(products, nu)
    f = products.functions(2)
    laplacian = f[2, 0] + f[0, 2]
    cross = products.inner(f[2, 0], f[0, 2])
    stiffness = products.inner(laplacian, laplacian) - (1 - nu) * (
        cross + cross.T - 2 * products.inner(f[1, 1], f[1, 1]))
    shear = products.inner(f[1, 0], f[0, 1], n_xy)
    geometric = (products.inner(f[1, 0], f[1, 0], n_xx) + shear + shear.T
                 + products.inner(f[0, 1], f[0, 1], n_yy))
    inverse = np.linalg.inv(np.linalg.cholesky(stiffness))
    return float(1 / np.linalg.eigvalsh(-inverse @ geometric @ inverse.T)[-1])


def lateral_buckling_of_beam(nu, of_beam):
    """Γ* of the narrow strip, width → 0, whose q L³/√(EI·GJ) is `of_beam`.

    With q = ρ g h w, EI = E h³ w/12, GJ = E h³ w/(6 (1 + ν)) and D = E h³/(12 (1 − ν²)).
    """
    return of_beam * 2 * (1 - nu * nu) / np.sqrt(2 * (1 + nu))
