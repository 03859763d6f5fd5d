"""Inextensible elastica, lateral buckling of strips, vibration of a cantilever.

Everything is without dimension: lengths in units of the length L; see each function for the loads.
"""

import math

import numpy as np

from .numerics import gauss, legendre, root


def _runge_kutta(rate, state, steps):
    """Integrates state' = rate(s, state) from s = 0 to 1 by the classical fourth-order method."""
    ds = 1 / steps
    for i in range(steps):
        s = i * ds
        k1 = rate(s, state)
        k2 = rate(s + ds / 2, [y + ds / 2 * k for y, k in zip(state, k1)])
        k3 = rate(s + ds / 2, [y + ds / 2 * k for y, k in zip(state, k2)])
        k4 = rate(s + ds, [y + ds * k for y, k in zip(state, k3)])
        state = [y + ds / 6 * (a + 2 * b + 2 * c + d)
                 for y, a, b, c, d in zip(state, k1, k2, k3, k4)]
    return state


def _cantilever(load, weight, steps):
    """Solves EI θ'' = −(transverse dead load beyond the section) cos θ for a beam clamped level.

    θ is the angle below the horizontal, s runs from the free end (θ' = 0) to the clamp (θ = 0), and
    `weight(s)` is the load beyond s in units of the whole. The unknown of the shooting is the angle
    of the free end: bounded by a right angle however large the load. Two solutions, of `steps` and
    of twice as many steps, are extrapolated to remove the error of fourth order.
    """
    def integrate(angle, count):
        return _runge_kutta(
            lambda s, y: (y[1], -load * weight(s) * math.cos(y[0]), math.cos(y[0]), math.sin(y[0])),
            [angle, 0.0, 0.0, 0.0], count)

    def solve(count):
        angle = root(lambda angle: integrate(angle, count)[0], 0.0, math.pi / 2)
        _, slope, span, drop = integrate(angle, count)
        return angle, -slope, span, drop

    angle, curvature, span, drop = (
        fine + (fine - coarse) / 15 for coarse, fine in zip(solve(steps), solve(2 * steps)))
    return {"drop": drop, "shortening": 1 - span, "span": span, "ratio": drop / span,
            "angle": angle, "root_curvature": curvature}


def tip_load(alpha, steps=200):
    """Cantilever with a dead load P across its end, alpha = P L²/EI: tip in units of L.

    `drop` w/L, `shortening` u/L, `span` = 1 − u/L, `ratio` drop/span, `angle` of the tip (radians),
    `root_curvature` κL at the clamp. Euler's elastica: θ'' = −alpha cos θ. Converged to 1e-11.
    Source: K. E. Bisshopp, D. C. Drucker, Large deflection of cantilever beams (1945).
    """
    return _cantilever(alpha, lambda s: 1.0, steps)


def self_weight(beta, steps=200):
    """Cantilever under its weight q per length, beta = q L³/EI; figures as those of `tip_load`.

    θ'' = −beta s cos θ with s from the free end. Converged to 1e-10.
    Source: the elastica; `ratio` is the figure of merit of the cantilever test of fabrics
    (F. T. Peirce, The "handle" of cloth as a measurable quantity, 1930).
    """
    return _cantilever(beta, lambda s: s, steps)


def end_moment(turn):
    """Cantilever with an end moment M, turn = M L/EI in radians: an arc of that angle, exactly.

    `along` and `across` are the tip's coordinates in units of L; 2π closes the circle.
    """
    if turn == 0:
        return {"along": 1.0, "across": 0.0, "radius": math.inf}
    return {"along": math.sin(turn) / turn, "across": 2 * math.sin(turn / 2) ** 2 / turn,
            "radius": 1 / turn}


def arc_by_quadrature(turn, count=24):
    """`end_moment` by Gauss's quadrature of the tangent: an independent check."""
    s, w = gauss(count, 0, 1)
    return {"along": float(w @ np.cos(turn * s)), "across": float(w @ np.sin(turn * s)),
            "radius": 1 / turn}


def _free_end_series(factor, power, terms):
    """β(1) of β'' + factor s^power β = 0 with β(0) = 1, β'(0) = 0, as the power series of β."""
    term = total = 1.0
    for n in range(1, terms + 1):
        degree = n * (power + 2)
        term *= -factor / (degree * (degree - 1))
        total += term
    return total


def lateral_buckling_tip(terms=40):
    """Critical P L²/√(EI·GJ) of a narrow strip cantilever, load P at the centroid of its end.

    The strip, infinitely stiff in its own plane, bends sideways by u and twists by β. With the
    bending moment M(s) at the distance s from the free end, EI u'' = M β (the part of the moment
    that the turned section feels sideways) and, along the bent axis, GJ β'' + M u'' = 0. So
    β'' + M²/(EI·GJ) β = 0, free end β'(0) = 0, clamp β(1) = 0. Here M = P s, hence
    β'' + k² s² β = 0. The power series in s is summed to rounding: converged to 1e-13.
    Source: L. Prandtl, Kipperscheinungen (1899); A. G. M. Michell (1899).
    """
    return root(lambda k: _free_end_series(k * k, 2, terms), 3.0, 5.0)


def lateral_buckling_weight(terms=40):
    """Critical q L³/√(EI·GJ) of a narrow strip cantilever under its weight q per length.

    As `lateral_buckling_tip` with M = q s²/2, hence β'' + (k²/4) s⁴ β = 0. Converged to 1e-13.
    """
    return root(lambda k: _free_end_series(k * k / 4, 4, terms), 10.0, 15.0)


def buckling_residual(k, weight, steps=400):
    """β(1) for the load factor k by Runge–Kutta: an independent check of the series."""
    power, factor = (4, k * k / 4) if weight else (2, k * k)
    return _runge_kutta(lambda s, y: (y[1], -factor * s**power * y[0]), [1.0, 0.0], steps)[0]


def cantilever_frequency(mode=1):
    """ω √(μ L⁴/EI) of a cantilever of mass μ per length: λ² with 1 + cos λ cosh λ = 0.

    Divided by cosh λ, which keeps high modes finite. Converged to 1e-13.
    """
    middle = (mode - 0.5) * math.pi
    return root(lambda x: 1 / math.cosh(x) + math.cos(x), middle - 0.5, middle + 0.5) ** 2


def frequency_by_polynomials(count=10):
    """`cantilever_frequency` as the least root of ∫ w''² / ∫ w² over w = s² × polynomials: an
    independent check.
    """
    s, weights = gauss(count + 4, 0, 1)
    p, dp, ddp = legendre(count, s, 0, 1)
    s = s[:, None]
    mass = np.linalg.cholesky((s**2 * p).T * weights @ (s**2 * p))
    bent = np.linalg.solve(mass, (2 * p + 4 * s * dp + s**2 * ddp).T * np.sqrt(weights))
    return float(np.linalg.svd(bent, compute_uv=False)[-1])
