"""Thin (Kirchhoff) square plates: deflection of the centre, in factors free of Poisson's ratio.

Plates of side a and stiffness D; edges that stay straight make the deflection free of Poisson's
ratio, apart from that in D.
"""

import math

import numpy as np

from .numerics import gauss, legendre, progression_sum


def supported_uniform(terms=12):
    """w D/(q a⁴), simply supported, uniform load q: Navier's double series, one sum in closed form.

    Lévy: w = 5/384 − (4/π⁵) Σ_(m odd) ±(2 + α tanh α)/(2 cosh α)/m⁵, α = mπ/2; the terms fall like
    exp(−α). Converged to 1e-15. Source: S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and
    Shells (1959), §30.
    """
    total = 5 / 384
    for m in range(1, 2 * terms, 2):
        a = m * math.pi / 2
        sign = 1 if m % 4 == 1 else -1
        total -= sign * 4 / math.pi**5 * (2 + a * math.tanh(a)) / (2 * math.cosh(a)) / m**5
    return total


def supported_point(terms=12):
    """w D/(P a²), simply supported, point load P at the centre, where w is taken.

    Navier's series (4/π⁴) Σ 1/(m² + n²)² over odd m, n with the sum over n in closed form:
    (1/(2π³)) Σ (tanh α − α/cosh² α)/m³, α = mπ/2. What is left after Σ 1/m³ falls like
    exp(−2α). Converged to 1e-14. Source: Timoshenko and Woinowsky-Krieger, §34.
    """
    total = progression_sum(3, 1, 2)
    for m in range(1, 2 * terms, 2):
        a = m * math.pi / 2
        total += (math.tanh(a) - 1 - a / math.cosh(a) ** 2) / m**3
    return total / (2 * math.pi**3)


def navier(load, count):
    """Navier's double series of the two above, `count` odd terms each way: a check."""
    m = np.arange(1, 2 * count, 2, dtype=float)
    denominator = np.add.outer(m**2, m**2) ** 2
    if load == "point":
        return 4 / math.pi**4 * float(np.sum(1 / denominator))
    sign = np.where(m % 4 == 1, 1.0, -1.0) / m
    return 16 / math.pi**6 * float(np.sum(np.outer(sign, sign) / denominator))


def clamped_uniform(count=24):
    """w D/(q a⁴) of the centre, all edges clamped, uniform load q.

    Minimises ½ D ∫ (Δw)² − ∫ q w (which for clamped edges is the plate's energy at any Poisson's
    ratio) over products of `count` even polynomials a direction that vanish with their slope at the
    edges (Shen's combinations of Legendre polynomials). Converged to 1e-11 at the default.
    Source of the problem: H. Hencky (1913); Timoshenko and Woinowsky-Krieger, §44.
    """
    x, weights = gauss(2 * count + 8)
    tables = legendre(2 * count + 4, np.append(x, 0.0))
    k = np.arange(0, 2 * count, 2)
    w, dw, ddw = (t[:, k] - (2 * (2 * k + 5) / (2 * k + 7)) * t[:, k + 2]
                  + ((2 * k + 3) / (2 * k + 7)) * t[:, k + 4] for t in tables)
    centre, w, dw, ddw = w[-1], w[:-1], dw[:-1], ddw[:-1]
    mass, first, second = ((f.T * weights) @ f for f in (w, dw, ddw))
    stiffness = np.kron(second, mass) + 2 * np.kron(first, first) + np.kron(mass, second)
    load = w.T @ weights
    solution = np.linalg.solve(stiffness, np.kron(load, load))
    return float(np.kron(centre, centre) @ solution) / 16  # the plate is two units wide
