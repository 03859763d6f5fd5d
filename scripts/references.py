#!/usr/bin/env python3
"""Computes the values that beams, plates and shells are measured against, and prints them."""

import argparse
import json
import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

sys.path.insert(0, str(Path(__file__).resolve().parent))

from reference_values import annulus, beams, koiter, plates, shells, strips  # noqa: E402

HELP = """Computes reference values from the theories of beams, plates and shells: differential
equations, series and polynomials solved here with numpy, nothing taken from tables. Beside each
value stands by how much (relative) a coarser computation differs from it, an upper estimate of its
error; for closed forms, by how much an independent computation does. The slit annulus takes most of
a minute, everything else a few seconds."""


@dataclass(frozen=True)
class Reference:
    """One problem: figures by name, finely and coarsely computed."""

    name: str
    quantity: str  # what the figures are, in which units
    theory: str
    fine: Callable[[], dict]
    coarse: Callable[[], dict]

    def compute(self):
        """Figures with the relative change from the coarse ones, and the seconds of the fine."""
        start = time.perf_counter()
        fine = self.fine()
        seconds = time.perf_counter() - start
        coarse = self.coarse()
        return {"quantity": self.quantity, "theory": self.theory, "seconds": round(seconds, 3),
                "figures": {name: {"value": value, "change": _change(value, coarse[name])}
                            for name, value in fine.items()}}


def _change(value, other):
    """Relative to the value, or to 1 where the figure is of the order of rounding."""
    return abs(value - other) / (abs(value) if abs(value) > 1e-12 else 1.0)


def _value(function, *arguments):
    return lambda: {"value": function(*arguments)}


def _elastica():
    tip = ("tip in units of L: drop w/L, shortening u/L, span 1 − u/L, ratio drop/span; its angle "
           "in radians; curvature·L at the clamp")
    for alpha in (1, 2, 3, 5, 10):
        yield Reference(f"elastica/tip_load/{alpha}", f"{tip}; P L²/EI = {alpha}", "elastica",
                        lambda a=alpha: beams.tip_load(a), lambda a=alpha: beams.tip_load(a, 100))
    for beta in (1, 5, 20):
        yield Reference(f"elastica/self_weight/{beta}", f"{tip}; q L³/EI = {beta}", "elastica",
                        lambda b=beta: beams.self_weight(b),
                        lambda b=beta: beams.self_weight(b, 100))
    for name, turn in (("quarter", math.pi / 2), ("half", math.pi), ("whole", 2 * math.pi)):
        yield Reference(f"elastica/end_moment/{name}_turn", "tip along and across the rest line "
                        "and radius, in units of L", "elastica, closed form",
                        lambda t=turn: beams.end_moment(t),
                        lambda t=turn: beams.arc_by_quadrature(t))


def _small_beams():
    yield Reference("strip/buckling/tip_load", "critical P L²/√(EI·GJ)", "Prandtl–Michell",
                    _value(beams.lateral_buckling_tip), _value(beams.lateral_buckling_tip, 16))
    yield Reference("strip/buckling/self_weight", "critical q L³/√(EI·GJ)", "Prandtl–Michell",
                    _value(beams.lateral_buckling_weight),
                    _value(beams.lateral_buckling_weight, 16))
    yield Reference("cantilever/vibration", "ω1 √(μ L⁴/EI)", "Euler–Bernoulli beam",
                    _value(beams.cantilever_frequency),
                    _value(beams.frequency_by_polynomials, 8))


def _wide_strips():
    quantity = "critical ρ g h L³/D, width/length = {}, Poisson's ratio {}"
    theory = "plane stress and Kirchhoff plate, Ritz"
    for width, nu, along, across in ((0.02, 0, 48, 6), *((w, 0.35, 24, 12)
                                                         for w in (0.1, 0.3, 0.5, 0.7, 0.9))):
        def value(*size, w=width, n=nu):
            return _value(strips.lateral_buckling_of_plate, w, n, *size)
        yield Reference(f"strip/buckling/plate/{width}", quantity.format(width, nu), theory,
                        value(along, across), value(3 * along // 4, 3 * across // 4))


def _plates():
    theory = "Kirchhoff plate, linear"
    yield Reference("plate/supported/uniform", "w D/(q a⁴) of the centre", theory,
                    _value(plates.supported_uniform), _value(plates.supported_uniform, 6))
    yield Reference("plate/supported/point", "w D/(P a²) under the load", theory,
                    _value(plates.supported_point), _value(plates.supported_point, 6))
    yield Reference("plate/clamped/uniform", "w D/(q a⁴) of the centre", theory,
                    _value(plates.clamped_uniform), _value(plates.clamped_uniform, 16))


def _koiter():
    """In units in which neither size nor stiffness is left; nu = 0.3."""
    sheet, radius, width = koiter.Sheet(1e6, 0.3, 0.1), 2.0, 3.0
    rolled = sheet.bending / radius**2 * math.pi * radius * width
    sphere = 4 * math.pi * sheet.bending
    quadratures = {"rolled": lambda: koiter.rolled_half_cylinder_quadrature(sheet, radius, width),
                   "sphere": lambda: koiter.flat_sphere_quadrature(sheet, radius)}
    yield Reference(
        "koiter/rolled_half_cylinder", "energy/(D area/R²) of a flat sheet rolled to radius R",
        "Koiter", lambda: {"value": koiter.rolled_half_cylinder(sheet, radius, width) / rolled},
        lambda: {"value": sum(quadratures["rolled"]()) / rolled})
    yield Reference(
        "koiter/flat_sphere", "energy/(D area/R²) of a sphere with its own metric, B0 = 0, nu 0.3",
        "Koiter", lambda: {"value": koiter.flat_sphere(sheet) / sphere},
        lambda: {"value": sum(quadratures["sphere"]()) / sphere})


def _shells():
    theory = "linear Koiter (Kirchhoff–Love) shell"
    yield Reference("shell/scordelis_lo", "downward displacement, middle of the free edge", theory,
                    _value(shells.scordelis_lo), _value(shells.scordelis_lo, 14, 30))
    yield Reference("shell/pinched_cylinder", "displacement under one of the two loads", theory,
                    _value(shells.pinched_cylinder), _value(shells.pinched_cylinder, 300))
    for name, hole in (("hole", 18.0), ("closed", 0.0)):
        yield Reference(f"shell/pinched_hemisphere/{name}",
                        "displacement under one of the four loads", theory,
                        _value(shells.pinched_hemisphere, hole),
                        _value(shells.pinched_hemisphere, hole, 40, 60))


def _annulus():
    yield Reference("shell/slit_annulus", "height of the lifted side's inner and outer corner",
                    "Koiter's energy of finite strains (Kirchhoff–Love)", annulus.slit_annulus,
                    lambda: annulus.slit_annulus(radial=6, angular=30))


def references():
    """All references, in the order of the table."""
    return [r for group in (_elastica, _small_beams, _wide_strips, _plates, _koiter, _shells, _annulus)
            for r in group()]


def _rows(name, result):
    for figure, entry in result["figures"].items():
        label = name if figure == "value" else f"{name}.{figure}"
        yield f"{label:<44}{entry['value']:>22.13g}{entry['change']:>10.1e}"


def main():
    parser = argparse.ArgumentParser(prog="scripts/references.py", description=HELP)
    parser.add_argument("name", nargs="*", help="only references whose name contains one of these")
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--list", action="store_true", help="print names and meanings only")
    options = parser.parse_args()
    chosen = [r for r in references()
              if not options.name or any(part in r.name for part in options.name)]
    if not chosen:
        parser.error(f"no reference has {' or '.join(options.name)} in its name; see --list")
    if options.list:
        for reference in chosen:
            print(f"{reference.name}: {reference.quantity} [{reference.theory}]")
        return
    results = {}
    if not options.json:
        print(f"{'reference':<44}{'value':>22}{'change':>10}")
    for reference in chosen:
        results[reference.name] = reference.compute()
        if not options.json:
            print("\n".join(_rows(reference.name, results[reference.name])), flush=True)
    if options.json:
        json.dump(results, sys.stdout, indent=1, ensure_ascii=False)
        print()


if __name__ == "__main__":
    main()
