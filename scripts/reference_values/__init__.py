"""Reference values of elastic beams, plates and shells, computed from their theories with numpy.

One subject a file: `beams`, `plates`, `koiter` (the energy, its strains), `shells`, `annulus`, and
the numerical tools that they share in `numerics`. Lengths, forces and moduli are in any consistent
units.
"""
