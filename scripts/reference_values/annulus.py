"""Slit annular plate lifted along one side of its slit: finite rotations, Koiter's energy."""

import math

import numpy as np

from .koiter import Sheet
from .numerics import gauss, legendre

# Where the lifted sheet folds, in turns from the clamp: angles are dense there.
FOLDS = (0.14, 0.53)
WIDTH = 0.05
DENSITY = 2.0


class _Energy:
    """Koiter's energy of an annular sheet as a function of the coefficients of its displacement.

    Polar coordinates (ρ, φ). Displacements are polynomials in both, times φ (in the plane) or φ²
    (across it), which clamps the side φ = 0. Coefficients are ordered (function, component).
    """

    def __init__(self, sheet, inner, outer, radial, angular):
        self.sheet = sheet
        radius, radius_weights = gauss(radial + 6, inner, outer)
        t, angle_weights = gauss(angular * 5 // 4 + 8, 0, 1)
        angle, slope, _ = self._angle(t)
        angle_weights = angle_weights * slope
        rho, phi = (g.ravel() for g in np.meshgrid(radius, angle, indexing="ij"))
        self.weights = np.outer(radius_weights, angle_weights).ravel() * rho
        cosine, sine, zero = np.cos(phi), np.sin(phi), 0 * phi
        # Derivatives along unit directions of the rest state: r_1, r_2/ρ, r_11, r_12/ρ, r_22/ρ².
        self.scale = np.stack([zero + 1, 1 / rho, zero + 1, 1 / rho, 1 / rho**2], 1)
        flat = [(cosine, sine), (-rho * sine, rho * cosine), (zero, zero), (-sine, cosine),
                (-rho * cosine, -rho * sine)]
        self.rest = np.stack([np.stack([x, y, zero], 1) for x, y in flat], 1)
        self.rest *= self.scale[:, :, None]
        # Of the displacement's five derivatives: (component, points, derivative, functions).
        self.tables = np.stack([self._table(radius, t, (inner, outer), radial, angular, power)
                                for power in (1, 1, 2)]) * self.scale[None, :, :, None]
        self.size = 3 * self.tables.shape[-1]
        self.law = np.array([[1, sheet.poisson, 0], [sheet.poisson, 1, 0],
                             [0, 0, 2 * (1 - sheet.poisson)]])
        edge = self._angular(np.array([1.0]), angular, 2)[0][0]
        at = legendre(radial + 1, radius, inner, outer)[0]
        corners = legendre(radial + 1, np.array([inner, outer]), inner, outer)[0]
        self.lift = np.kron(radius_weights @ at, edge)
        self.corners = np.stack([np.kron(c, edge) for c in corners])

    @staticmethod
    def _angle(t):
        """Angle of the parameter t in [0, 1], dense where the sheet folds, and two derivatives.

        t is the angle plus steps of the inverse tangent, scaled to [0, 1]; inverted by Newton.
        """
        centres = np.array(FOLDS)[:, None]

        def parameter(x):
            z = (x - centres) / WIDTH
            return (x + DENSITY * WIDTH * np.sum(np.arctan(z), 0),
                    1 + DENSITY * np.sum(1 / (1 + z * z), 0),
                    -2 * DENSITY / WIDTH * np.sum(z / (1 + z * z) ** 2, 0))
        low, high = (parameter(np.array([end]))[0] for end in (0.0, 1.0))
        span = high - low
        x = np.array(t, dtype=float)
        grid = np.linspace(0, 1, 2001)
        x = np.interp(x, (parameter(grid)[0] - low) / span, grid)
        for _ in range(6):
            value, slope, _ = parameter(x)
            x = x - (value - low - span * t) / slope
        _, slope, bend = parameter(x)
        turn = 2 * math.pi
        return turn * x, turn * span / slope, -turn * span**2 * bend / slope**3

    @classmethod
    def _angular(cls, t, degree, power):
        """Polynomials in t times t^power, and two derivatives with respect to the angle."""
        p, dp, ddp = legendre(degree + 1, t, 0, 1)
        _, slope, bend = (v[:, None] for v in cls._angle(t))
        t = t[:, None]
        f, df, ddf = t**power, power * t ** (power - 1), power * (power - 1) * t**0
        first = (df * p + f * dp) / slope
        second = ddf * p + 2 * df * dp + f * ddp
        return f * p, first, (second - bend * first) / slope**2

    def _table(self, radius, t, interval, radial, angular, power):
        a = legendre(radial + 1, radius, *interval)
        b = self._angular(t, angular, power)
        return np.stack([np.kron(a[i], b[j]) for i, j in ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))],
                        axis=1)

    def jets(self, coefficients):
        c = coefficients.reshape(-1, 3)
        return self.rest + np.stack([self.tables[i] @ c[:, i] for i in range(3)], axis=-1)

    def density(self, jets):
        """Energy per rest area and its gradient in the jet: (points,), (points, 5, 3).

        Analytic in the jet, so that a complex step differentiates the gradient exactly.
        """
        r1, r2, *second = (jets[:, i] for i in range(5))

        def dot(a, b):
            return np.sum(a * b, axis=-1)[:, None]
        cross = np.cross(r1, r2)
        area = np.sqrt(dot(cross, cross))
        normal = cross / area
        G11, G12, G22 = dot(r1, r1), dot(r1, r2), dot(r2, r2)
        strain = np.concatenate([G11 - 1, G22 - 1, G12], 1) / 2
        order = (0, 2, 1)  # components 11, 22, 12 in a jet's 11, 12, 22
        curvature = np.concatenate([dot(normal, second[i]) for i in order], 1)
        stress = self.sheet.membrane * strain @ self.law
        moment = self.sheet.bending * curvature @ self.law
        value = (np.sum(strain * stress, 1) + np.sum(curvature * moment, 1)) / 2
        gradient = np.zeros_like(jets)
        s11, s22, s12 = (stress[:, i:i + 1] for i in range(3))
        gradient[:, 0] = s11 * r1 + s12 / 2 * r2
        gradient[:, 1] = s22 * r2 + s12 / 2 * r1
        # The normal turns by −(n·dr_k) r^k, r^k the dual base.
        dual1 = (G22 * r1 - G12 * r2) / area**2
        dual2 = (G11 * r2 - G12 * r1) / area**2
        for i, component in enumerate(order):
            m = moment[:, i:i + 1]
            gradient[:, 2 + component] = m * normal
            gradient[:, 0] -= m * dot(dual1, second[component]) * normal
            gradient[:, 1] -= m * dot(dual2, second[component]) * normal
        return value, gradient

    def value(self, coefficients):
        return float(self.weights @ self.density(self.jets(coefficients))[0])

    def gradient(self, coefficients):
        g = self.density(self.jets(coefficients))[1] * self.weights[:, None, None]
        return np.stack([np.einsum("qdn,qd->n", self.tables[i], g[:, :, i]) for i in range(3)],
                        axis=1).ravel()

    def hessian(self, coefficients):
        jets = self.jets(coefficients).astype(complex)
        points, count = jets.shape[0], self.size // 3
        step = 1e-30
        local = np.empty((points, 5, 3, 5, 3))
        for d in range(5):
            for i in range(3):
                jets[:, d, i] += 1j * step
                local[:, :, :, d, i] = self.density(jets)[1].imag / step
                jets[:, d, i] = jets[:, d, i].real
        local *= self.weights[:, None, None, None, None]
        result = np.empty((count, 3, count, 3))
        for i in range(3):
            for j in range(i + 1):
                half = np.matmul(local[:, :, i, :, j], self.tables[j])
                block = self.tables[i].reshape(-1, count).T @ half.reshape(-1, count)
                result[:, i, :, j] = block
                result[:, j, :, i] = block.T
        return result.reshape(self.size, self.size)


def slit_annulus(load=0.8, radial=8, angular=40, steps=20):
    """Slit annular plate: heights (inner, outer) of the lifted side's corners.

    Radii 6 and 10, thickness 0.03, E 2.1e7, nu 0; clamped along one side of a radial slit, a line
    load of `load` per length, across the flat plate, on the other. Newton's method on the energy
    of finite strains; the load grows in steps, at first as if there were to be `steps` of them,
    each started by extrapolation. The sheet folds sharply where its curvature changes sign, so that
    polynomials converge slowly, from below: 13.8281, 17.4627 with (`radial`, `angular`) = (6, 24);
    13.8439, 17.4815 with (8, 40), the default, half a minute; 13.8448, 17.4824 with (11, 50).
    Converged to 1e-4.
    Source of the problem: Y. Başar, Y. Ding (1992); K. Y. Sze, X. H. Liu, S. H. Lo, Popular
    benchmark problems for geometric nonlinear analysis of shells (2004).
    """
    energy = _Energy(Sheet(2.1e7, 0.0, 0.03), 6.0, 10.0, radial, angular)
    force = np.zeros((energy.size // 3, 3))
    force[:, 2] = energy.lift
    force = force.ravel()
    state = np.zeros(energy.size)
    done, step = 0.0, 1 / steps
    rate = None
    while done < 1:
        factor = min(1.0, done + step)
        trial, iterations = _equilibrium(energy, factor**2 * load * force, state if rate is None
                                         else state + (factor - done) * rate)
        if trial is None:
            step /= 2
            if step < 1e-5:
                raise ArithmeticError(f"no equilibrium beyond {done**2:.4f} of the load")
            continue
        rate = (trial - state) / (factor - done)
        state, done = trial, factor
        step *= 1.5 if iterations < 8 else 1.0
    inner, outer = energy.corners @ state.reshape(-1, 3)[:, 2]
    return {"inner": float(inner), "outer": float(outer)}


def _equilibrium(energy, force, state, iterations=25):
    """Newton's method; (None, count) if it does not converge."""
    for count in range(1, iterations + 1):
        change = np.linalg.solve(energy.hessian(state), force - energy.gradient(state))
        state = state + change
        size = np.max(np.abs(change))
        if not np.isfinite(size) or size > 50:
            return None, count
        if size < 1e-9:
            return state, count
    return None, iterations
