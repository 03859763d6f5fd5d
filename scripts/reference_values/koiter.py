"""Koiter's energy of a thin shell: of finite strains at given jets, and its linear strains.

Per unit rest area, with M = G0⁻¹(G − G0), S = G0⁻¹(B − B0):
W = E h/(8(1−nu²)) [(1−nu) tr(M²) + nu tr(M)²] + E h³/(24(1−nu²)) [the same in S].
Source: W. T. Koiter, On the nonlinear theory of thin elastic shells (1966).
"""

import math
from dataclasses import dataclass

import numpy as np

from .numerics import gauss


@dataclass(frozen=True)
class Sheet:
    """Isotropic material: Young's modulus (force/length²), Poisson's ratio, thickness."""

    young: float
    poisson: float
    thickness: float

    @property
    def membrane(self):
        """C = E h/(1 − nu²), force/length."""
        return self.young * self.thickness / (1 - self.poisson**2)

    @property
    def bending(self):
        """D = E h³/(12(1 − nu²)), force·length."""
        return self.membrane * self.thickness**2 / 12


def forms(jet):
    """First and second fundamental forms, each of shape (…, 2, 2), and the area element.

    `jet` is (r_1, r_2, r_11, r_12, r_22), each of shape (…, 3).
    """
    r1, r2, r11, r12, r22 = jet
    normal = np.cross(r1, r2)
    area = np.linalg.norm(normal, axis=-1)
    normal = normal / area[..., None]

    def form(f11, f12, f22):
        return np.stack([np.stack([f11, f12], -1), np.stack([f12, f22], -1)], -2)

    def dot(a, b):
        return np.sum(a * b, axis=-1)
    return (form(dot(r1, r1), dot(r1, r2), dot(r2, r2)),
            form(dot(normal, r11), dot(normal, r12), dot(normal, r22)), area)


def energy(sheet, jet, metric, curvature, weights):
    """Membrane and bending energy of the surface with this jet.

    `metric` G0 and `curvature` B0 are the rest state (…, 2, 2), `weights` those of a quadrature
    over the parameters.
    """
    G, B, _ = forms(jet)
    inverse = np.linalg.inv(metric)
    area = np.sqrt(np.linalg.det(metric))

    def norm(strain):
        trace = np.trace(strain, axis1=-2, axis2=-1)
        square = np.trace(strain @ strain, axis1=-2, axis2=-1)
        return float(np.sum(weights * area
                            * ((1 - sheet.poisson) * square + sheet.poisson * trace**2)))
    return (sheet.membrane / 8 * norm(inverse @ (G - metric)),
            sheet.bending / 2 * norm(inverse @ (B - curvature)))


def rolled_half_cylinder(sheet, radius, width):
    """Energy of a flat sheet π R × width rolled to half a cylinder: ½ D/R² · area, all bending."""
    return sheet.bending / (2 * radius**2) * math.pi * radius * width


def flat_sphere(sheet):
    """Energy of a whole sphere with its own metric at rest and B0 = 0: D(1 + nu)/R² · area.

    It does not depend on the radius: 4π D(1 + nu).
    """
    return 4 * math.pi * sheet.bending * (1 + sheet.poisson)


def rolled_half_cylinder_quadrature(sheet, radius, width, count=8):
    """`rolled_half_cylinder` from jets of the cylinder and Gauss's quadrature."""
    a, wa = gauss(count, 0, math.pi * radius)
    b, wb = gauss(count, 0, width)
    a = np.broadcast_to(a[:, None], (a.size, b.size))
    zero = np.zeros_like(a)
    sine, cosine = np.sin(a / radius), np.cos(a / radius)

    def vector(x, y, z):
        return np.stack([x, y, z], -1)
    jet = (vector(-sine, zero, cosine), vector(zero, zero + 1, zero),
           vector(-cosine, zero, -sine) / radius, vector(zero, zero, zero),
           vector(zero, zero, zero))
    flat = np.broadcast_to(np.eye(2), a.shape + (2, 2))
    return energy(sheet, jet, flat, 0 * flat, np.outer(wa, wb))


def flat_sphere_quadrature(sheet, radius, count=24):
    """`flat_sphere` from jets in angles and Gauss's quadrature, which never meets the poles."""
    polar, wp = gauss(count, 0, math.pi)
    around, wa = gauss(count, 0, 2 * math.pi)
    p, q = np.meshgrid(polar, around, indexing="ij")
    sp, cp, sq, cq = np.sin(p), np.cos(p), np.sin(q), np.cos(q)

    def vector(x, y, z):
        return radius * np.stack([x, y, z + 0 * p], -1)
    jet = (vector(cp * cq, cp * sq, -sp), vector(-sp * sq, sp * cq, 0.0),
           vector(-sp * cq, -sp * sq, -cp), vector(-cp * sq, cp * cq, 0.0),
           vector(-sp * cq, -sp * sq, 0.0))
    G, B, _ = forms(jet)
    return energy(sheet, jet, G, 0 * B, np.outer(wp, wa))


def linear_strains(jet, displacement):
    """Linear membrane and bending strains, in physical components (11, 22, 12), of every basis
    function at every point.

    membrane_ij = ½(r_i·u_j + r_j·u_i); bending_ij = n·(u_ij − Γ^k_ij u_k), the change of B_ij.
    `jet` holds r_1, r_2, r_11, r_12, r_22 of orthogonal coordinates, each (points, 3);
    `displacement` the same derivatives of u, each (points, 3, functions). All are components in one
    orthonormal frame at each point, in which derivatives of the frame are already accounted for.
    Results: two arrays (points, 3, functions).
    """
    r1, r2, r11, r12, r22 = jet
    u1, u2, u11, u12, u22 = displacement
    length1, length2 = np.linalg.norm(r1, axis=-1), np.linalg.norm(r2, axis=-1)
    if np.max(np.abs(np.sum(r1 * r2, -1))) > 1e-9 * np.max(length1 * length2):
        raise ValueError("the coordinates are not orthogonal")
    normal = np.cross(r1, r2) / (length1 * length2)[:, None]

    def along(vector, field):
        return np.einsum("qc,qcn->qn", vector, field)

    def change(r_ij, u_ij):
        gamma1 = np.sum(r_ij * r1, -1) / length1**2
        gamma2 = np.sum(r_ij * r2, -1) / length2**2
        return along(normal, u_ij - gamma1[:, None, None] * u1 - gamma2[:, None, None] * u2)

    scale = np.stack([length1**2, length2**2, length1 * length2], -1)[:, :, None]
    membrane = np.stack([along(r1, u1), along(r2, u2), (along(r1, u2) + along(r2, u1)) / 2], 1)
    bending = np.stack([change(r11, u11), change(r22, u22), change(r12, u12)], 1)
    return membrane / scale, bending / scale


def energy_rows(sheet, strains, weights):
    """The matrix A with ½ |A c|² = energy of the coefficients c: (6 points, functions).

    `strains` are those of `linear_strains`, `weights` the areas of the points. Working with A by
    orthogonal transformations keeps twice the digits of working with the stiffness Aᵀ A.
    """
    nu = sheet.poisson
    law = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, 2 * (1 - nu)]])
    factor = np.linalg.cholesky(law).T
    rows = [np.einsum("ij,qjn->qin", factor, strain) * np.sqrt(stiffness * weights)[:, None, None]
            for strain, stiffness in zip(strains, (sheet.membrane, sheet.bending))]
    return np.concatenate(rows).reshape(-1, strains[0].shape[-1])


def response(rows, load, measure):
    """measure·c where c minimises ½ |rows c|² − load·c."""
    triangle = np.linalg.qr(rows, mode="r").T
    return float(np.linalg.solve(triangle, load) @ np.linalg.solve(triangle, measure))
