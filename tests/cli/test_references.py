"""Reference values converge, and agree with independent computations and customary figures."""

import json
import math
import os
import subprocess
import sys
import unittest
from pathlib import Path

# A few small systems of equations: threads only get in their way.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np  # noqa: E402

SCRIPTS = Path(os.environ.get("DEFORM_SOURCE", Path(__file__).resolve().parents[2])) / "scripts"
sys.path.insert(0, str(SCRIPTS))

from reference_values import annulus, beams, koiter, numerics, plates, shells, strips  # noqa: E402


class Numerics(unittest.TestCase):
    def test_zeta_agrees_with_its_closed_forms(self):
        self.assertAlmostEqual(numerics.zeta(2), math.pi**2 / 6, delta=1e-14)
        self.assertAlmostEqual(numerics.zeta(4), math.pi**4 / 90, delta=1e-14)
        self.assertAlmostEqual(numerics.progression_sum(2, 1, 2), math.pi**2 / 8, delta=1e-14)

    def test_legendre_derivatives_are_those_of_numpy(self):
        x = np.linspace(2, 5, 7)
        tables = numerics.legendre(9, x, 2, 5)
        for n in range(9):
            p = np.polynomial.Legendre.basis(n, [2, 5])
            for order, table in enumerate(tables):
                np.testing.assert_allclose(table[:, n], p.deriv(order)(x) if order else p(x),
                                           rtol=1e-10, atol=1e-10)

    def test_root_refuses_an_interval_without_one(self):
        with self.assertRaises(ValueError):
            numerics.root(lambda x: x * x + 1, 0, 1)


class Beams(unittest.TestCase):
    def test_tip_loads(self):
        customary = {1: (.30172, .05643), 2: (.49346, .16064), 3: (.60325, .25442),
                     5: (.71379, .38763), 10: (.81061, .55500)}
        for alpha, (drop, shortening) in customary.items():
            with self.subTest(alpha=alpha):
                tip = beams.tip_load(alpha)
                self.assertAlmostEqual(tip["drop"], drop, delta=0.51e-5)
                self.assertAlmostEqual(tip["shortening"], shortening, delta=0.51e-5)
                # Moments about the clamp, and the first integral ½κ² = alpha (sin θ_tip − sin θ).
                self.assertAlmostEqual(tip["root_curvature"], alpha * tip["span"], delta=1e-10)
                self.assertAlmostEqual(tip["root_curvature"] ** 2 / 2,
                                       alpha * math.sin(tip["angle"]), delta=1e-10)

    def test_self_weight(self):
        for beta, ratio, digit in ((1, .12456, 1e-5), (5, .58572, 1e-5), (20, 1.8639, 1e-4)):
            with self.subTest(beta=beta):
                tip = beams.self_weight(beta)
                self.assertAlmostEqual(tip["ratio"], ratio, delta=0.51 * digit)
                for name, value in beams.self_weight(beta, 300).items():
                    self.assertAlmostEqual(tip[name], value, delta=1e-10)

    def test_small_loads_are_those_of_the_linear_beam(self):
        self.assertAlmostEqual(beams.tip_load(1e-4)["drop"] / 1e-4, 1 / 3, delta=1e-8)
        self.assertAlmostEqual(beams.self_weight(1e-4)["drop"] / 1e-4, 1 / 8, delta=1e-8)

    def test_end_moment(self):
        for turn in (0.3, math.pi, 2 * math.pi):
            for name, value in beams.arc_by_quadrature(turn).items():
                self.assertAlmostEqual(beams.end_moment(turn)[name], value, delta=1e-14)
        self.assertEqual(beams.end_moment(0)["along"], 1)

    def test_lateral_buckling(self):
        for weight, k, customary, digit in ((False, beams.lateral_buckling_tip(), 4.0126, 1e-4),
                                            (True, beams.lateral_buckling_weight(), 12.854, 1e-3)):
            self.assertAlmostEqual(k, customary, delta=0.51 * digit)
            self.assertAlmostEqual(beams.buckling_residual(k, weight), 0, delta=1e-8)

    def test_vibration(self):
        self.assertAlmostEqual(beams.cantilever_frequency(), 3.516, delta=0.51e-3)
        self.assertAlmostEqual(beams.cantilever_frequency(), beams.frequency_by_polynomials(),
                               delta=1e-11)


class Strips(unittest.TestCase):
    def test_lateral_buckling_of_plates(self):
        # An independent Ritz computation of some hundred functions, nu = 0.35.
        for width, customary in ((.1, 14.88), (.3, 17.66), (.5, 20.82), (.7, 24.16), (.9, 27.53)):
            with self.subTest(width=width):
                few = strips.lateral_buckling_of_plate(width, .35, 12, 8)
                self.assertAlmostEqual(few, customary, delta=0.51e-2)
                value = strips.lateral_buckling_of_plate(width, .35, 18, 10)
                self.assertLess(value, few)  # Ritz's loads come from above
                self.assertAlmostEqual(value / few, 1, delta=1.5e-3)

    def test_narrow_strips_are_beams(self):
        for nu in (0, .35):
            beam = strips.lateral_buckling_of_beam(nu, beams.lateral_buckling_weight())
            wide, narrow = (strips.lateral_buckling_of_plate(width, nu, 48, 6) / beam
                            for width in (.02, .01))
            self.assertAlmostEqual(narrow, 1, delta=0.01)
            # The clamp hinders twist over a length of the width: of first order in it.
            self.assertAlmostEqual((wide - 1) / (narrow - 1), 2, delta=0.2)


class Plates(unittest.TestCase):
    def test_supported(self):
        self.assertAlmostEqual(plates.supported_uniform(), .00406235, delta=0.51e-8)
        self.assertAlmostEqual(plates.supported_uniform(), plates.navier("uniform", 100),
                               delta=1e-13)
        self.assertAlmostEqual(plates.supported_point(), .0116008, delta=0.51e-7)
        # What is cut off falls with the square of the number of terms.
        few, many = plates.navier("point", 400), plates.navier("point", 800)
        self.assertAlmostEqual(plates.supported_point(), many + (many - few) / 3, delta=1e-11)

    def test_clamped(self):
        self.assertAlmostEqual(plates.clamped_uniform(), .00126532, delta=0.51e-8)
        self.assertAlmostEqual(plates.clamped_uniform(), plates.clamped_uniform(16), delta=1e-13)


class Koiter(unittest.TestCase):
    SHEET = koiter.Sheet(2e5, 0.3, 0.05)

    def test_closed_forms_agree_with_quadratures(self):
        for closed, (membrane, bending) in (
                (koiter.rolled_half_cylinder(self.SHEET, 2, 3),
                 koiter.rolled_half_cylinder_quadrature(self.SHEET, 2, 3)),
                (koiter.flat_sphere(self.SHEET), koiter.flat_sphere_quadrature(self.SHEET, 2))):
            self.assertAlmostEqual(membrane, 0, delta=1e-12 * closed)
            self.assertAlmostEqual(bending, closed, delta=1e-12 * closed)

    def test_linear_strains_are_the_change_of_the_forms(self):
        random = np.random.default_rng(1)
        jet = [random.normal(size=(6, 3)) for _ in range(5)]
        jet[1] -= jet[0] * (np.sum(jet[0] * jet[1], 1) / np.sum(jet[0] ** 2, 1))[:, None]
        change = [random.normal(size=(6, 3)) for _ in range(5)]
        membrane, bending = koiter.linear_strains(jet, [c[:, :, None] for c in change])
        step = 1e-6

        def forms(sign):
            return koiter.forms([r + sign * step * u for r, u in zip(jet, change)])
        more, less = forms(1), forms(-1)
        lengths = np.stack([np.linalg.norm(jet[0], axis=1), np.linalg.norm(jet[1], axis=1)], 1)
        scale = lengths[:, :, None] * lengths[:, None, :]
        for strain, form, factor in ((membrane, 0, 2), (bending, 1, 1)):
            measured = (more[form] - less[form]) / (2 * step * factor) / scale
            for component, (i, j) in enumerate(((0, 0), (1, 1), (0, 1))):
                np.testing.assert_allclose(strain[:, component, 0], measured[:, i, j],
                                           rtol=1e-7, atol=1e-7)


class Shells(unittest.TestCase):
    """Kirchhoff–Love shells; the customary figures are given to half a per cent."""

    def check(self, function, customary, coarse, converged):
        value = function()
        self.assertAlmostEqual(value / customary, 1, delta=0.005)
        self.assertAlmostEqual(function(*coarse) / value, 1, delta=converged)

    def test_scordelis_lo(self):
        self.check(shells.scordelis_lo, .3006, (16, 36), 1e-9)

    def test_pinched_cylinder(self):
        self.check(shells.pinched_cylinder, 1.827e-5, (250,), 1e-9)

    def test_pinched_hemisphere_with_a_hole(self):
        self.check(shells.pinched_hemisphere, .0935, (18, 40, 60), 1e-9)

    def test_pinched_hemisphere(self):
        self.check(lambda *a: shells.pinched_hemisphere(*(a or (0,))), .0924, (0, 40, 60), 1e-9)

    def test_cylinder_flexibility_of_the_breathing_wave(self):
        # n = 0: D w'''' + E h w/R² = p, the beam on an elastic bed; Koiter's D adds to the bed.
        sheet, radius, k = koiter.Sheet(3e6, 0.3, 3.0), 300.0, 0.01
        breathing = shells._cylinder_flexibility(sheet, radius, k, np.zeros(1))[0]
        bed = sheet.bending * (k**4 + 2 * 0.3 * k**2 / radius**2 + 1 / radius**4) \
            + 3e6 * 3.0 / radius**2
        self.assertAlmostEqual(breathing * bed, 1, delta=1e-12)

    def test_cylinder_flexibility_of_a_long_ring(self):
        # Without stretching, a ring of plane strain: D (n² − 1)² w/R⁴ = p, up to (h/R)².
        sheet, radius, n = koiter.Sheet(3e6, 0.3, 3.0), 300.0, np.array([2.0, 4.0, 6.0])
        ring = radius**4 / (sheet.bending * (n**2 - 1) ** 2)
        np.testing.assert_allclose(shells._cylinder_flexibility(sheet, radius, 1e-6, n), ring,
                                   rtol=5e-4)

    def test_rigid_motions_do_not_strain_the_hemisphere(self):
        angle = np.linspace(0.4, 1.5, 5)
        s, c, zero = np.sin(angle), np.cos(angle), 0 * angle
        jet = [np.stack(v, -1) for v in ((c, zero, -s), (zero, s, zero), (-s, zero, -c),
                                         (zero, c, zero), (-s, zero, zero))]
        axis = np.array([0.3, -0.7, 0.5])
        turned = [np.cross(axis, r)[:, :, None] for r in jet]
        for strain in koiter.linear_strains(jet, turned):
            self.assertLess(np.max(np.abs(strain)), 1e-14)


class Annulus(unittest.TestCase):
    def test_gradient_and_hessian_are_derivatives_of_the_energy(self):
        energy = annulus._Energy(koiter.Sheet(2.1e3, 0.2, 0.03), 6, 10, 3, 5)
        random = np.random.default_rng(2)
        state, change = 0.05 * random.normal(size=(2, energy.size))
        step = 1e-4
        slope = (energy.value(state + step * change)
                 - energy.value(state - step * change)) / 2 / step
        self.assertAlmostEqual(energy.gradient(state) @ change / slope, 1, delta=1e-6)
        bend = (energy.gradient(state + step * change)
                - energy.gradient(state - step * change)) / 2 / step
        np.testing.assert_allclose(energy.hessian(state) @ change, bend,
                                   atol=1e-6 * np.max(np.abs(bend)))

    def test_a_coarse_solution_is_a_little_too_stiff(self):
        coarse = annulus.slit_annulus(radial=5, angular=20)
        for name, customary in (("inner", 13.891), ("outer", 17.528)):
            self.assertLess(coarse[name], customary)
            self.assertAlmostEqual(coarse[name] / customary, 1, delta=0.025)


class Program(unittest.TestCase):
    def run_program(self, *arguments):
        return subprocess.run([sys.executable, "-B", SCRIPTS / "references.py", *arguments],
                              capture_output=True, text=True, timeout=60)

    def test_json_has_every_figure_with_its_error(self):
        done = self.run_program("--json", "plate/supported", "plate/clamped", "koiter")
        self.assertEqual(done.returncode, 0, done.stderr)
        results = json.loads(done.stdout)
        self.assertEqual(len(results), 5)
        for result in results.values():
            for figure in result["figures"].values():
                self.assertLess(figure["change"], 1e-9)

    def test_table_and_list(self):
        self.assertIn("3.5160152685", self.run_program("vibration").stdout)
        self.assertIn("shell/slit_annulus:", self.run_program("--list").stdout)

    def test_unknown_names_are_refused(self):
        done = self.run_program("scordelia")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--list", done.stderr)


if __name__ == "__main__":
    unittest.main()
