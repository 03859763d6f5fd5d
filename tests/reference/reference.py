#!/usr/bin/env python3
"""Reference computation for elastically deformable surfaces (Wu and Melo), in numpy and scipy.

Independent of the C++ code: it exists to pin down the numerical conventions and to reproduce the tables of the
theory notes, section 4.  Equation numbers are the paper's; names too: r_1, r_11, G, B, Gamma, d, eta, xi, alpha, beta.

    python3 reference.py P | L | S [--alternatives]

Arrays: one row per node, node (i, j) at index i + n1 * j, i along a1.  Pairs ij are (1,1), (1,2), (2,1), (2,2):
sums run over all four; symmetric quantities are stored under 11, 12, 22 and looked up with sorted indices.
"""
import sys
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

PAIRS = [(0, 0), (0, 1), (1, 0), (1, 1)]
UNIQUE = [(0, 0), (0, 1), (1, 1)]


@dataclass(frozen=True)
class Conventions:
    """What the paper's text leaves open.  The defaults are those of the tables."""
    sign_at_zero: float = 0.0      # Gauss: weight where B_ij = 0
    border_frame: str = "both"     # normal where D_1+ or D_2+ is missing: replace "both" r_1 and r_2, or the "missing" one
    replacement: str = "central"   # what replaces it: "central" inside, one-sided at the border; "backward"
    second_minus: str = "second"   # D_ii^- of (22): "second" zero rows on first and last line; "DmDp", "DmDm", "transpose"
    first_minus: str = "backward"  # D_i^-, D_12^- of (22): "backward" zero rows on the first line; or "transpose": -D_i+^T
    tangent_terms: str = "implicit"  # the two sums of (22): "implicit" (new r), "explicit" (lagged), "off"
    d_sign: float = 1.0            # sign of (8)
    d_order: str = "paper"         # d_ki and d_kj as printed in (22); "swapped"; "transposed": d_ik and d_jk
    last_term: str = "product"     # D_i^-(beta_ij d_kj D_k+ r), as in (22); "printed": D_i^-(beta_ij) d_kj D_k+ r
    stretching_outer: str = "transpose"  # outer derivative of stretching: "transpose" of D_i+, or "backward" with zero rows
    masks: str = "first"           # Gamma, d vanish where D_1+ or D_2+ is missing ("first"), or any second difference ("all"),
    #                                or use the frame of the normal everywhere ("none")


DEFAULT = Conventions()


def row(v):
    return sp.diags(v)


def dot(a, b):
    return np.einsum("ij,ij->i", a, b)


class Grid:
    """Difference operators on n1 x n2 nodes, border rule "paper": a row that cannot be computed is zero."""

    def __init__(self, nodes, size, conv=DEFAULT):
        self.n1, self.n2 = nodes
        self.h = h1, h2 = size[0] / (nodes[0] - 1), size[1] / (nodes[1] - 1)
        self.cell = h1 * h2                                   # the weight of every node
        j, i = np.mgrid[0:self.n2, 0:self.n1]
        self.i, self.j = i.ravel(), j.ravel()
        self.a1, self.a2 = self.i * h1, self.j * h2

        def along(one_dimensional):
            """A family of 1-D operators made 2-D along both directions."""
            return [sp.kron(sp.identity(self.n2), sp.csr_matrix(one_dimensional(self.n1, h1)), format="csr"),
                    sp.kron(sp.csr_matrix(one_dimensional(self.n2, h2)), sp.identity(self.n1), format="csr")]

        def forward(n, h):
            m = np.zeros((n, n))
            for k in range(n - 1):
                m[k, k:k + 2] = [-1 / h, 1 / h]
            return m                                          # last row zero

        def backward(n, h):
            m = np.zeros((n, n))
            for k in range(1, n):
                m[k, k - 1:k + 1] = [-1 / h, 1 / h]
            return m                                          # first row zero

        def second(n, h):
            m = np.zeros((n, n))
            for k in range(1, n - 1):
                m[k, k - 1:k + 2] = [1 / h**2, -2 / h**2, 1 / h**2]
            return m                                          # first and last row zero

        def central(n, h):                                    # one-sided at both ends
            return (forward(n, h) + backward(n, h)) * np.array([1] + [0.5] * (n - 2) + [1])[:, None]

        def forward_completed(n, h):                          # backward on the last line
            m = forward(n, h)
            m[n - 1] = backward(n, h)[n - 1]
            return m

        self.D = along(forward)                               # D_i+
        S = along(second)
        self.DD = {(0, 0): S[0], (0, 1): (self.D[0] @ self.D[1]).tocsr(), (1, 1): S[1]}   # D_ij+
        self.C = along(forward_completed if conv.replacement == "backward" else central)

        self.Dm = along(backward)                             # D_i^-
        if conv.first_minus == "transpose":
            self.Dm = [-(d.T).tocsr() for d in self.D]
        second_minus = {"second": lambda k: S[k],
                        "DmDp": lambda k: self.Dm[k] @ self.D[k],
                        "DmDm": lambda k: self.Dm[k] @ self.Dm[k],
                        "transpose": lambda k: S[k].T.tocsr()}[conv.second_minus]
        self.DDm = {(0, 0): second_minus(0), (0, 1): self.Dm[0] @ self.Dm[1], (1, 1): second_minus(1)}

        last1, last2 = self.i == self.n1 - 1, self.j == self.n2 - 1
        self.has = [~last1, ~last2]                           # D_i+ computable
        self.has_frame = ~last1 & ~last2                      # both
        self.has_all = self.has_frame & (self.i > 0) & (self.j > 0)
        self.boundary = last1 | last2 | (self.i == 0) | (self.j == 0)

    def flat(self):
        return np.column_stack([self.a1, self.a2, np.zeros_like(self.a1)])

    def node(self, i, j):
        return i + self.n1 * j


class Geometry:
    """G (3), B (6), n, Gamma (15), d (8) of one state."""

    def __init__(self, grid, r, conv=DEFAULT):
        self.r_i = r_i = [D @ r for D in grid.D]
        self.r_ij = {ij: grid.DD[ij] @ r for ij in UNIQUE}
        c = [C @ r for C in grid.C]
        if conv.border_frame == "both":
            t = [np.where(grid.has_frame[:, None], r_i[k], c[k]) for k in (0, 1)]
        else:
            t = [np.where(grid.has[k][:, None], r_i[k], c[k]) for k in (0, 1)]
        n = np.cross(t[0], t[1])
        self.n = n / np.linalg.norm(n, axis=1)[:, None]
        self.G = {ij: dot(r_i[ij[0]], r_i[ij[1]]) for ij in UNIQUE}            # zero rows give zero
        self.B = {ij: dot(self.n, self.r_ij[ij]) for ij in UNIQUE}

        f = t if conv.masks == "none" else r_i                                  # frame of Gamma and d
        mask = {"first": grid.has_frame, "all": grid.has_all, "none": np.ones_like(grid.has_frame)}[conv.masks]
        g11, g12, g22 = dot(f[0], f[0]), dot(f[0], f[1]), dot(f[1], f[1])
        det = np.where(mask, g11 * g22 - g12**2, 1.0)
        inverse = np.where(mask, 1 / det, 0.0)
        conjugate = [[g22 * inverse, -g12 * inverse], [-g12 * inverse, g11 * inverse]]       # (13)
        self.Gamma = {ij: [sum(conjugate[k][l] * dot(self.r_ij[ij], f[l]) for l in (0, 1)) for k in (0, 1)]
                      for ij in UNIQUE}                                                      # (15)
        b11, b12, b22 = (self.B[ij] for ij in UNIQUE)
        s = conv.d_sign * inverse
        self.d = [[s * (b12 * g12 - b11 * g22), s * (b22 * g12 - b12 * g22)],                # (8)
                  [s * (b11 * g12 - b12 * g11), s * (b12 * g12 - b22 * g11)]]


def up(ij):
    return ij if ij[0] <= ij[1] else (ij[1], ij[0])


def four(v):
    """Weights: one number for all four, or {(0,0): .., (0,1): .., (1,1): ..} (12 = 21)."""
    return v if isinstance(v, dict) else {ij: v for ij in UNIQUE}


# Every term gives (K, c): internal force -e = -(K r + c) per unit parameter area, K and c from the previous state.

class Stretching:
    """e = sum_ij D_i^T alpha_ij D_j r, alpha_ij = eta_ij (G_ij - G0_ij): first part of (19), (20)."""

    def __init__(self, grid, rest, eta, conv=DEFAULT):
        self.grid, self.eta, self.G0 = grid, four(eta), Geometry(grid, rest, conv).G
        self.outer = [D.T for D in grid.D]
        if conv.stretching_outer == "backward":
            self.outer = [-Dm for Dm in grid.Dm]

    def assemble(self, geometry, r):
        D = self.grid.D
        K = sum(self.outer[i] @ row(self.eta[up((i, j))] * (geometry.G[up((i, j))] - self.G0[up((i, j))])) @ D[j]
                for i, j in PAIRS)
        return K, np.zeros_like(r)

    def energy(self, geometry):
        return self.grid.cell * sum(0.25 * np.sum(self.eta[up(ij)] * (geometry.G[up(ij)] - self.G0[up(ij)])**2)
                                    for ij in PAIRS)


class Bending:
    """Second part of (19) with a normal estimator n_ij = N_ij r + c_ij, coefficients from the previous state.

    divergence: D_ij^T (beta_ij n_ij);  expanded: (22).
    """

    def __init__(self, grid, rest, xi, form, normal, delta=0.5, conv=DEFAULT):
        self.grid, self.xi, self.form, self.normal, self.delta, self.conv = grid, four(xi), form, normal, delta, conv
        self.B0 = Geometry(grid, rest, conv).B

    def estimator(self, g, ij):
        grid = self.grid
        nothing = sp.csr_matrix(grid.DD[ij].shape)
        if self.normal == "exact":
            return nothing, g.n
        if self.normal == "terzopoulos":
            return grid.DD[ij], np.zeros_like(g.n)
        B = g.B[ij]
        w = np.where(B > 0, 1.0, np.where(B < 0, -1.0, self.conv.sign_at_zero))
        big = np.abs(B) > self.delta
        w[big] = 1 / B[big]
        Gamma = g.Gamma[ij]
        return row(w) @ (grid.DD[ij] - row(Gamma[0]) @ grid.D[0] - row(Gamma[1]) @ grid.D[1]), np.zeros_like(g.n)

    def assemble(self, g, r):
        grid, conv = self.grid, self.conv
        K, c = sp.csr_matrix((len(r), len(r))), np.zeros_like(r)
        for i, j in PAIRS:
            ij = up((i, j))
            beta = self.xi[ij] * (g.B[ij] - self.B0[ij])                        # (20)
            N, constant = self.estimator(g, ij)
            if self.form == "divergence":
                K = K + grid.DD[ij].T @ row(beta) @ N
                c += grid.DD[ij].T @ (beta[:, None] * constant)
                continue
            K = K + row(grid.DDm[ij] @ beta) @ N
            c += (grid.DDm[ij] @ beta)[:, None] * constant
            d = g.d
            if conv.d_order == "swapped":
                first, second = [d[k][j] for k in (0, 1)], [d[k][i] for k in (0, 1)]
            elif conv.d_order == "transposed":
                first, second = [d[i][k] for k in (0, 1)], [d[j][k] for k in (0, 1)]
            else:
                first, second = [d[k][i] for k in (0, 1)], [d[k][j] for k in (0, 1)]
            T = sum(row((grid.Dm[j] @ beta) * first[k]) @ grid.D[k] for k in (0, 1))
            if conv.last_term == "printed":
                T = T + sum(row((grid.Dm[i] @ beta) * second[k]) @ grid.D[k] for k in (0, 1))
            else:
                T = T + sum(grid.Dm[i] @ row(beta * second[k]) @ grid.D[k] for k in (0, 1))
            if conv.tangent_terms == "implicit":
                K = K + T
            elif conv.tangent_terms == "explicit":
                c += T @ r
        return K, c

    def energy(self, g):
        return self.grid.cell * sum(0.5 * np.sum(self.xi[up(ij)] * (g.B[up(ij)] - self.B0[up(ij)])**2) for ij in PAIRS)


class BendingVariational(Bending):
    """e = L_ij^T xi_ij (L_ij r - B0_ij n), L_ij = D_ij - Gamma^k_ij D_k, n of the previous state."""

    def __init__(self, grid, rest, xi, conv=DEFAULT):
        super().__init__(grid, rest, xi, "variational", None, conv=conv)

    def assemble(self, g, r):
        grid = self.grid
        K, c = sp.csr_matrix((len(r), len(r))), np.zeros_like(r)
        for pair in PAIRS:
            ij = up(pair)
            L = grid.DD[ij] - row(g.Gamma[ij][0]) @ grid.D[0] - row(g.Gamma[ij][1]) @ grid.D[1]
            K = K + self.xi[ij] * (L.T @ L)
            c -= L.T @ (self.xi[ij] * self.B0[ij][:, None] * g.n)
        return K, c


class Diverged(Exception):
    pass


def run(grid, r, terms, load, fixed, mu, gamma, dt, steps, conv=DEFAULT, watch=None):
    """Semi-implicit steps: (K + mu/dt^2 + gamma/(2 dt)) r+ = load - c + (mu/dt^2 + gamma/(2 dt)) r + (mu/dt - gamma/2) v."""
    r, previous = r.copy(), r.copy()
    free = ~fixed
    for step in range(1, steps + 1):
        g = Geometry(grid, r, conv)
        parts = [term.assemble(g, r) for term in terms]
        m = mu / dt**2 + gamma / (2 * dt)
        A = (sum(K for K, _ in parts) + m * sp.identity(len(r))).tocsr()
        b = load - sum(c for _, c in parts) + m * r + (mu / dt - gamma / 2) * (r - previous) / dt
        new = r.copy()
        b = b[free] - A[free][:, fixed] @ r[fixed]
        try:
            new[free] = splu(A[free][:, free].tocsc()).solve(b)
        except (RuntimeError, ValueError):
            raise Diverged(step)
        if not np.all(np.isfinite(new)) or np.max(np.linalg.norm(new, axis=1)) > 10:
            raise Diverged(step)
        previous, r = r, new
        if watch:
            watch(step, r)
    return r


METHODS = {  # name: (form, normal, delta)
    "Terzopoulos divergence": ("divergence", "terzopoulos", None),
    "Gauss inf expanded": ("expanded", "gauss", np.inf),
    "Gauss 0 expanded": ("expanded", "gauss", 0.0),
    "Gauss 0.5 expanded": ("expanded", "gauss", 0.5),
    "Gauss 0.5 divergence": ("divergence", "gauss", 0.5),
    "exact divergence": ("divergence", "exact", None),
    "variational": None,
}
MIRROR = np.array([1, 1, -1.0])


def bending(grid, rest, xi, method, conv):
    if METHODS[method] is None:
        return BendingVariational(grid, rest, xi, conv)
    return Bending(grid, rest, xi, *METHODS[method], conv=conv)


def sheet_P(xi, method, conv=DEFAULT, nodes=21, mirror=False, load_sign=-1):
    grid = Grid((nodes, nodes), (1, 1), conv)
    rest, m = grid.flat(), nodes // 2
    load = np.zeros_like(rest)
    patch = (abs(grid.i - m) <= 1) & (abs(grid.j - m) <= 1)
    load[patch, 2] = load_sign * 0.01 / (9 * grid.cell)
    terms = [Stretching(grid, rest, 0.01, conv), bending(grid, rest, xi, method, conv)]
    r = run(grid, rest, terms, load, grid.boundary, 0.1, 1.0, 0.02, 100, conv)
    g = Geometry(grid, r, conv)
    result = dict(lowest=r[:, 2].min(), in_plane=abs(r - rest)[:, :2].max(), energies=[t.energy(g) for t in terms])
    if mirror:
        try:
            image = run(grid, rest, terms, load * MIRROR, grid.boundary, 0.1, 1.0, 0.02, 100, conv)
            result["mirror"] = np.max(np.linalg.norm(image * MIRROR - r, axis=1))
        except Diverged as e:
            result["mirror"] = f"image diverges (step {e})"
    return result


def sheet_L(method, conv=DEFAULT, xi=2e-6):
    grid = Grid((21, 21), (1, 1), conv)
    rest = grid.flat()
    load = np.zeros_like(rest)
    load[:, 2] = -0.01
    load[grid.node(10, 10), 2] += 0.02 / grid.cell
    terms = [Stretching(grid, rest, 0.01, conv), bending(grid, rest, xi, method, conv)]
    r = run(grid, rest, terms, load, np.zeros(len(rest), bool), 0.1, 0.2, 0.01, 150, conv)
    centre = r.mean(axis=0)

    def scale(x):
        return np.sqrt(np.sum((x - x.mean(axis=0))[:, :2]**2))
    return dict(x=centre[0], y=centre[1], scale=scale(r) / scale(rest))


def arc(grid, sign=-1, radius=0.5):
    t = (grid.a1 - 0.5) / radius
    return np.column_stack([0.5 + radius * np.sin(t), grid.a2, sign * radius * (1 - np.cos(t))])


def height(r):
    return np.ptp(r[:, 2])


def strip_S(method, conv=DEFAULT, sign=-1, orientation=1.0, history=None):
    grid = Grid((21, 7), (1, 0.3), conv)
    rest, start = arc(grid, sign), grid.flat()
    start[:, 2] = orientation * 1e-6 * np.cos(np.pi * grid.a1)
    terms = [Stretching(grid, rest, 0.05, conv), bending(grid, rest, 1e-4, method, conv)]
    watch = (lambda step, x: history.append(height(x))) if history is not None else None
    r = run(grid, start, terms, np.zeros_like(rest), np.zeros(len(rest), bool), 0.1, 0.5, 0.02, 200, conv, watch)
    return dict(final=height(r), rest=height(rest), grid=grid, r=r)


def attempt(f, *args, **kw):
    try:
        return f(*args, **kw)
    except Diverged as e:
        return f"diverges (step {e})"


P_METHODS = ["Terzopoulos divergence", "Gauss 0.5 expanded", "Gauss 0.5 divergence", "exact divergence", "variational"]
L_METHODS = ["Terzopoulos divergence", "Gauss inf expanded", "Gauss 0 expanded", "Gauss 0.5 expanded",
             "Gauss 0.5 divergence", "exact divergence", "variational"]
S_METHODS = ["exact divergence", "variational", "Gauss 0.5 expanded", "Terzopoulos divergence", "Gauss 0.5 divergence"]


# What the theory notes, section 4, print.
EXPECTED_P = {
    0: ["-0.2447 / 1.887e-2"] * 5,
    1e-6: ["-0.1967 / 4.2e-2, mirror 0.164", "-0.2444 / 1.85e-2, energies 3.173e-4 1.183e-5", "-0.2444 / 1.87e-2",
           "-0.2444 / 1.87e-2", "-0.2447 / 1.88e-2"],
    1e-5: ["diverges (step 10)", "-0.2380 / 1.31e-2", "-0.2390 / 1.48e-2", "-0.2391 / 1.48e-2", "-0.2435 / 1.59e-2"],
    1e-4: ["diverges", "diverges (step 58)", "-0.1734 / 1.19e-2", "-0.1733 / 1.25e-2", "-0.2082 / 2.39e-2"],
    1e-3: ["diverges", "diverges (step 9)", "-0.0773 / 8.7e-3", "diverges (step 70)", "-0.0686 / 7.1e-3"],
}
EXPECTED_L = ["0.5000 0.563", "0.4631 0.948", "diverges in 5 steps", "0.4981 0.910", "0.5000 0.909", "0.5000 0.908",
              "0.5000 0.908"]
EXPECTED_S = ["0.071", "0.071", "0.008", "0.0000", "diverges at step 8"]


def show(scene, label, got, expected):
    print(f"{scene}  {label:36s} {got:60s} [{expected}]", flush=True)


def print_P(conv=DEFAULT):
    for xi, expected in EXPECTED_P.items():
        for method, entry in zip(P_METHODS, expected):
            x = attempt(sheet_P, xi, method, conv, mirror=(xi == 1e-6))
            if isinstance(x, dict):
                stretching, bent = x["energies"]
                mirror = f" mirror {x['mirror']:.4f}" if "mirror" in x else ""
                x = f"{x['lowest']:.8f} / {x['in_plane']:.6e}  energies {stretching:.5e} {bent:.5e}{mirror}"
            show("P", f"xi {xi:5.0e} {method}", x, entry)


def print_L(conv=DEFAULT):
    for method, entry in zip(L_METHODS, EXPECTED_L):
        x = attempt(sheet_L, method, conv)
        if isinstance(x, dict):
            x = f"centre {x['x']:.7f} {x['y']:.7f}  in-plane scale {x['scale']:.7f}"
        show("L", method, x, entry)


def print_S(conv=DEFAULT):
    for method, entry in zip(S_METHODS, EXPECTED_S):
        x = attempt(strip_S, method, conv)
        if isinstance(x, dict):
            x = f"height {x['final']:.7f} (rest {x['rest']:.5f})"
        show("S", method, x, entry)


ALTERNATIVES = [dict(sign_at_zero=1.0), dict(border_frame="missing"), dict(replacement="backward"),
                dict(second_minus="DmDp"), dict(second_minus="DmDm"), dict(first_minus="transpose"),
                dict(tangent_terms="explicit"), dict(tangent_terms="off"), dict(d_sign=-1.0), dict(d_order="swapped"),
                dict(d_order="transposed"), dict(last_term="printed"), dict(stretching_outer="backward"),
                dict(masks="all"), dict(masks="none")]

if __name__ == "__main__":
    scenes = {"P": print_P, "L": print_L, "S": print_S}
    chosen = [a for a in sys.argv[1:] if a in scenes]
    if not chosen or set(sys.argv[1:]) - set(scenes) - {"--alternatives"}:
        sys.exit(__doc__)
    np.seterr(all="ignore")                                   # diverging runs overflow before they are caught
    for change in [{}] + (ALTERNATIVES if "--alternatives" in sys.argv else []):
        print("default conventions" if not change else f"instead: {change}")
        for name in chosen:
            scenes[name](replace(DEFAULT, **change))
