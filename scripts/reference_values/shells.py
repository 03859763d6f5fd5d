"""The shell obstacle course in linear Koiter (Kirchhoff–Love) theory, free of finite elements.

Trigonometric functions in the direction in which they solve the problem exactly, polynomials or a
second such direction in the other; `koiter.linear_strains` measures all of them.
Source of the problems: T. Belytschko et al., Stress projection for membrane and shear locking in
shell finite elements (1985); R. H. MacNeal, R. L. Harder, A proposed standard set of problems to
test finite element accuracy (1985). Their customary figures come from elements with shear or from
other theories; the values here are those of the theory named above.
"""

import math

import numpy as np

from .koiter import Sheet, energy_rows, linear_strains, response
from .numerics import gauss, legendre, progression_sum


def _cylinder_jet(radius, points):
    """Jet of a cylinder in (angle, length along the axis), frame (outward, around, axis)."""
    def constant(x, y, z):
        return np.tile(np.array([x, y, z], dtype=float), (points, 1))
    return (constant(0, radius, 0), constant(0, 0, 1), constant(-radius, 0, 0),
            constant(0, 0, 0), constant(0, 0, 0))


def scordelis_lo(terms=20, degree=40):
    """Scordelis–Lo roof: downward displacement of the middle of its free edge.

    Radius 25, length 50, thickness 0.25, half-angle 40°, E 4.32e8, nu 0, weight 90 per area; the
    curved ends on diaphragms (no displacement in their plane, free along the axis), the straight
    edges free. Sines along the axis (`terms` odd ones, with cosines for the axial displacement)
    satisfy the ends exactly; polynomials of `degree` around. The terms alternate and fall like m⁻⁵:
    the last sums are averaged as Euler did. Converged to 1e-10 at the defaults.
    """
    radius, length, edge, weight = 25.0, 50.0, math.radians(40), 90.0
    sheet = Sheet(4.32e8, 0.0, 0.25)
    angle, weights = gauss(degree + 8, -edge, edge)
    sums, total = [], 0.0
    for m in range(1, 2 * terms, 2):
        k = m * math.pi / length
        displacement = _roof_functions(angle, edge, degree, k)
        rows = energy_rows(sheet, linear_strains(_cylinder_jet(radius, angle.size),
                                                 displacement[1:]), radius * weights)
        down = np.stack([-np.cos(angle), np.sin(angle), 0 * angle], -1)
        load = np.einsum("q,qc,qcn->n", radius * weights, down, displacement[0])
        corner = _roof_functions(np.array([edge]), edge, degree, k)[0][0]
        measure = np.array([-math.cos(edge), math.sin(edge), 0.0]) @ corner
        sign = 1 if m % 4 == 1 else -1
        total += sign * weight * 4 / (m * math.pi) * response(rows, load, measure)
        sums.append(total)
    while len(sums) > 1:
        sums = [(a + b) / 2 for a, b in zip(sums, sums[1:])][-8:]
    return sums[0]


def _roof_functions(angle, edge, degree, k):
    """Symmetric displacements and their derivatives: u, u_1, u_2, u_11, u_12, u_22.

    Outward a(angle) sin kx, around b sin kx, along the axis c cos kx with even a, c and odd b; only
    the factors that do not depend on x are kept. The outward and the round direction turn.
    """
    even = np.arange(0, degree + 1, 2)
    odd = np.arange(1, degree + 1, 2)
    tables = legendre(degree + 1, angle, -edge, edge)
    columns = (even, odd, even)
    count = sum(c.size for c in columns)
    parts = [np.zeros((angle.size, 3, count)) for _ in range(3)]
    for part, table in zip(parts, tables):
        start = 0
        for component, column in enumerate(columns):
            part[:, component, start:start + column.size] = table[:, column]
            start += column.size

    def turned(value, slope):
        """Derivative of components in a frame with outward' = around, around' = −outward."""
        return np.stack([slope[:, 0] - value[:, 1], slope[:, 1] + value[:, 0], slope[:, 2]], 1)

    def axial(value):
        """Derivative along the axis: sines become cosines and the other way round."""
        return value * np.array([k, k, -k])[None, :, None]
    u, du, ddu = parts
    u1 = turned(u, du)
    u11 = turned(u1, turned(du, ddu))
    return u, u1, axial(u), u11, axial(u1), -k * k * u


def pinched_cylinder(count=400):
    """Pinched cylinder with end diaphragms: displacement under one of the two loads.

    Radius 300, length 600, thickness 3, E 3e6, nu 0.3; two opposite inward loads of 1 at half
    length; ends as those of the roof. Double Fourier series: sin(mπx/L) cos(nφ), m odd, n even, a
    3×3 system each. Far out a term is nearly that of the flat plate of the same stiffness, but for
    a factor 1 + O(h²/R²): the plate's series, summed in closed form, stands for all terms, and the
    differences are summed over `count`² terms, then extrapolated, the rest falling like count⁻².
    Converged to 1e-10 at the default.

    The value belongs to Koiter's bending strains, the change of B: with those of Sanders, which
    differ by terms of the order of membrane strain over radius, the same series gives 1.8277e-5.
    The plain series converges slowly: cut off after 80² terms it gives 1.8259e-5.
    """
    radius, length, load = 300.0, 600.0, 1.0
    sheet = Sheet(3e6, 0.3, 3.0)
    n = 2.0 * np.arange(count)
    # Mean squares of the trigonometric functions: ½ along the axis; around, ½ or, for n = 0, 1.
    norm = np.where(n > 0, 0.5, 1.0) * math.pi * radius * length
    inner = 3 * count // 4
    part = whole = 0.0
    for i in range(count):
        k = (2 * i + 1) * math.pi / length
        plate = 1 / (sheet.bending * (k**2 + (n / radius) ** 2) ** 2)
        difference = (_cylinder_flexibility(sheet, radius, k, n) - plate) / norm
        whole += float(np.sum(difference))
        part += float(np.sum(difference[:inner])) if i < inner else 0.0
    whole += (whole - part) / ((count / inner) ** 2 - 1)
    # Both loads act on each of these waves in the same way.
    return 2 * load * (whole + _plate_cylinder(sheet.bending, radius, length))


def _cylinder_flexibility(sheet, radius, k, n):
    """Outward displacement for a pressure of 1 × sin(kx) cos(nφ), of every n: (n,)."""
    # Outward a sin cos, around b sin sin, along c cos cos; columns are a, b, c.
    u = np.tile(np.eye(3), (n.size, 1, 1))
    n3 = n[:, None]

    def around(value, sign):
        """Derivative in φ; sign +1: of (cos, sin, cos) components, −1: of (sin, cos, sin)."""
        return np.stack([-sign * n3 * value[:, 0] - value[:, 1],
                         sign * n3 * value[:, 1] + value[:, 0],
                         -sign * n3 * value[:, 2]], 1)
    axial = np.array([k, k, -k])[None, :, None]
    u1 = around(u, 1)
    displacement = (u1, axial * u, around(u1, -1), axial * u1, -k * k * u)
    rows = energy_rows(sheet, linear_strains(_cylinder_jet(radius, n.size), displacement),
                       np.ones(n.size))
    # `energy_rows` lists the membrane rows of all points, then the bending rows.
    rows = rows.reshape(2, n.size, 3, 3).transpose(1, 0, 2, 3).reshape(n.size, 6, 3)
    # n = 0 has no displacement around: a unit stiffness for it changes nothing else.
    stiffness = np.einsum("qri,qrj->qij", rows, rows)
    stiffness[:, 1, 1] += np.where(n == 0, 1.0, 0.0)
    return np.linalg.inv(stiffness)[:, 0, 0]


def _plate_cylinder(stiffness, radius, length):
    """Σ over odd m and even n ≥ 0 of 1/(D (k² + n²/R²)² norm), norms as in `pinched_cylinder`.

    Σ over all whole j of 1/(k² + 4j²/R²)² is π R/(4 k³) (coth y + y/sinh² y), y = π k R/2; the sum
    of m⁻³ is split off.
    """
    total = progression_sum(3, 1, 2)
    for m in range(1, 60, 2):
        y = math.pi**2 * m * radius / (2 * length)
        total += (1 / math.tanh(y) - 1 + (y / math.sinh(y) ** 2 if y < 300 else 0.0)) / m**3
    return (total * (length / math.pi) ** 3 * math.pi * radius / 4
            / (stiffness * math.pi * radius * length))


def pinched_hemisphere(hole=18.0, modes=60, degree=70):
    """Pinched hemisphere: displacement under one of its four loads, along it.

    Radius 10, thickness 0.04, E 6.825e7, nu 0.3; a hole of `hole` degrees around the pole or none
    (0), edges free; at the equator four loads of 2, two opposite ones outward, two between them
    inward (the quarter of the customary model carries loads of 1). Modes m = 2, 6, 10, … around,
    `modes` of them; polynomials of `degree` along the meridian. The displacements of the modes fall
    like m⁻³; the tail is summed from their expansion in 1/m. Converged to 2e-11 at the defaults.
    """
    load = 2.0
    orders = 2.0 + 4 * np.arange(modes)
    values = np.array([4 * load / math.pi * math.pi * _hemisphere_mode(int(m), math.radians(hole),
                                                                       degree) for m in orders])
    # values m³ = a0 + a1/m + … fitted to the last third of the modes.
    powers = np.arange(3, 7)
    last = orders[-(modes // 3):]
    scaled = (last[:, None] / last[-1]) ** -(powers - 3.0)
    fit = np.linalg.lstsq(scaled, values[-last.size:] * last**3, rcond=None)[0]
    tail = sum(c * last[-1] ** (p - 3) * progression_sum(int(p), last[-1] + 4, 4.0)
               for c, p in zip(fit, powers))
    return float(np.sum(values) + tail)


def _hemisphere_mode(m, hole, degree):
    """Radial displacement at the equator in mode m for the edge load cos mφ per unit of φ, over π.

    Displacements: from the axis a cos mφ, around b sin mφ, along the axis c cos mφ.
    """
    sheet, radius = Sheet(6.825e7, 0.3, 0.04), 10.0
    angle, weights = gauss(degree + 12, hole, math.pi / 2)
    sine, cosine, zero = np.sin(angle), np.cos(angle), 0 * angle
    jet = [radius * np.stack(v, -1) for v in (
        (cosine, zero, -sine), (zero, sine, zero), (-sine, zero, -cosine), (zero, cosine, zero),
        (-sine, zero, zero))]
    u, du, ddu = _meridian_functions(angle, hole, degree, m)

    def around(value, sign):
        """Derivative in φ; sign +1: of (cos, sin, cos) components, −1: of (sin, cos, sin)."""
        return np.stack([-sign * m * value[:, 0] - value[:, 1],
                         sign * m * value[:, 1] + value[:, 0], -sign * m * value[:, 2]], 1)
    u2 = around(u, 1)
    strains = linear_strains(jet, (du, u2, ddu, around(du, 1), around(u2, -1)))
    rows = energy_rows(sheet, strains, math.pi * radius**2 * sine * weights)
    edge = _meridian_functions(np.array([math.pi / 2]), hole, degree, m)[0][0, 0]
    return response(rows, edge, edge)


def _meridian_functions(angle, hole, degree, m):
    """Basis of displacements and two derivatives along the meridian: (points, 3, functions).

    With a hole, Legendre polynomials in each component. Without one, these times sin², which keeps
    the strains of all modes m ≥ 2 finite at the pole; m = 2 needs besides the plane strain
    (x, −y, 0), whose components are sin θ (cos 2φ, −sin 2φ, 0).
    """
    p, dp, ddp = legendre(degree + 1, angle, hole, math.pi / 2)
    if hole == 0:
        s, c = np.sin(angle)[:, None], np.cos(angle)[:, None]
        f, df, ddf = s * s, 2 * s * c, 2 * (c * c - s * s)
        p, dp, ddp = f * p, df * p + f * dp, ddf * p + 2 * df * dp + f * ddp
    tables = []
    plane = (np.sin(angle), np.cos(angle), -np.sin(angle))
    for table, strain in zip((p, dp, ddp), plane):
        block = np.einsum("qn,cd->qcdn", table, np.eye(3)).reshape(angle.size, 3, -1)
        if hole == 0 and m == 2:
            extra = strain[:, None, None] * np.array([1.0, -1.0, 0.0])[None, :, None]
            block = np.concatenate([block, extra], axis=2)
        tables.append(block)
    return tables
