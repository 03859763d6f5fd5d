"""Numerical tools that the reference values share: roots, quadrature, polynomials, tails."""

import math

import numpy as np


def root(function, low, high, tolerance=1e-14):
    """The zero of `function` between `low` and `high`, where its signs differ.

    Regula falsi in the Illinois variant: superlinear, and the bracket is never left.
    """
    f_low, f_high = function(low), function(high)
    if f_low * f_high > 0:
        raise ValueError(f"no change of sign between {low} and {high}")
    for _ in range(200):
        if f_low == f_high:
            break
        middle = high - f_high * (high - low) / (f_high - f_low)
        f_middle = function(middle)
        if f_middle * f_high < 0:
            low, f_low = high, f_high
        else:
            f_low /= 2
        moved = abs(middle - high)
        high, f_high = middle, f_middle
        if f_middle == 0 or moved <= tolerance * max(1.0, abs(middle)):
            return middle
    return high


def gauss(count, low=-1.0, high=1.0):
    """Nodes and weights of Gauss's quadrature with `count` points on [low, high]."""
    x, w = np.polynomial.legendre.leggauss(count)
    return low + (x + 1) * (high - low) / 2, w * (high - low) / 2


def legendre(count, x, low=-1.0, high=1.0):
    """P_0 … P_(count−1) of the interval [low, high] at the points x, and two derivatives with
    respect to x: three arrays of shape (points, count).
    """
    slope = 2 / (high - low)
    t = (np.asarray(x, dtype=float) - low) * slope - 1
    p, d, dd = (np.zeros((t.size, count)) for _ in range(3))
    p[:, 0] = 1
    if count > 1:
        p[:, 1], d[:, 1] = t, 1
    for n in range(1, count - 1):
        p[:, n + 1] = ((2 * n + 1) * t * p[:, n] - n * p[:, n - 1]) / (n + 1)
        d[:, n + 1] = d[:, n - 1] + (2 * n + 1) * p[:, n]
        dd[:, n + 1] = dd[:, n - 1] + (2 * n + 1) * d[:, n]
    return p, d * slope, dd * slope**2


def zeta(s, a=1.0):
    """Hurwitz' zeta function Σ (n + a)^−s over n ≥ 0, s > 1, by the Euler–Maclaurin formula.

    Sixteen terms are summed; four correction terms leave less than 1e-13 relative for 2 ≤ s ≤ 12.
    """
    count = 16
    x = a + count
    value = sum((a + n) ** -s for n in range(count))
    value += x ** (1 - s) / (s - 1) + x**-s / 2
    # Bernoulli numbers B_2 … B_8 over (2k)!, times the odd derivatives of x^−s.
    rising = s
    for k, bernoulli in enumerate((1 / 6, -1 / 30, 1 / 42, -1 / 30), start=1):
        value += bernoulli / math.factorial(2 * k) * rising * x ** (-s - 2 * k + 1)
        rising *= (s + 2 * k - 1) * (s + 2 * k)
    return value


def progression_sum(power, first, step):
    """Σ m^−power over m = first, first + step, first + 2 step, …"""
    return step**-power * zeta(power, first / step)
