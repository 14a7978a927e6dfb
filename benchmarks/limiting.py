"""What gradient limiting costs, and how far from the exact envelope it ends."""

import itertools
from functools import partial

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial.distance import cdist

from distmesh_edu.gradient_limiting import limit_gradient, limit_gradient_pde

from .measuring import peak_megabytes, side_by_side

G = 0.3
SOLVERS = {"limit_gradient": limit_gradient, "the equation (PDE)": limit_gradient_pde}


def report():
    """Print both tables, and what was to be reached."""
    small((2, 65), (3, 17))
    large((2, 512), (3, 101))
    around_a_disc()


def small(*grids):
    """Print errors against all pairs of nodes, of which a large grid has too many."""
    print(
        "\nGradient limiting, g = 0.3: the largest error over the range of h, and nodes off by more"
    )
    print("than rounding, against the minimum over all pairs of nodes")
    works = {**SOLVERS, "Dijkstra, nearest neighbours": shortest_ways}
    for dim, n in grids:
        dx = 1 / (n - 1)
        for kind, h in wishes(dim, n).items():
            exact = envelope(h, G, dx)
            row = f"  {n}^{dim} {kind:20}"
            for name, solver in works.items():
                error = np.abs(solver(h, G, dx) - exact)
                share = 100 * (error > 1e-11).mean()
                row += f" | {name} {error.max() / np.ptp(h):8.1e} {share:5.1f} %"
            print(row)


def large(*grids):
    """Print times, as ratios to ours, and what is held of memory."""
    print("\nGradient limiting: seconds of limit_gradient, times as long, error of the PDE")
    ratios = []
    for dim, n in grids:
        dx = 1 / (n - 1)
        for kind, h in wishes(dim, n).items():
            solvers = {**SOLVERS, "Dijkstra": shortest_ways} if dim == 2 else SOLVERS
            works = {name: partial(solver, h, G, dx) for name, solver in solvers.items()}
            found = side_by_side(works, budget=2.0)
            ours, time = found["limit_gradient"]
            row = f"  {n}^{dim} {kind:20} {time:6.2f} s"
            for name in list(solvers)[1:]:
                row += f" | {name} x {found[name][1] / time:5.1f}"
                if dim == 2 and name != "Dijkstra":
                    ratios.append(found[name][1] / time)
            error = np.abs(found["the equation (PDE)"][0] - ours).max() / np.ptp(h)
            print(f"{row} | {error:.1e}")
        peak = peak_megabytes(works["limit_gradient"])
        print(f"  {n}^{dim}: {peak:.0f} MB at most, in the last case")
    print(f"  Aim: 3 times faster than the PDE on 512^2; the median is {np.median(ratios):.1f}.")


def around_a_disc(n=161):
    """Print what ways around a disc come to, for which the exact lengths are known."""
    x = np.linspace(0, 1, n)
    begin, radius = round(0.1 * (n - 1)), 0.25
    across, up = np.meshgrid(x, x, indexing="ij")
    r = np.hypot(across - 0.5, up - 0.5)
    h = np.full((n, n), 10.0)
    h[begin, n // 2] = 0.05
    touch = np.arccos(radius / 0.4) + np.arccos(radius / np.maximum(r, radius))
    bend = np.arccos(np.clip((0.5 - across) / np.maximum(r, 1e-9), -1, 1)) - touch
    tangents = np.sqrt(0.4**2 - radius**2) + np.sqrt(np.maximum(r**2 - radius**2, 0))
    way = np.where(bend > 0, tangents + radius * bend, np.hypot(across - 0.1, up - 0.5))
    inside = r >= radius
    works = {name: partial(one, h, G, x[1], inside=inside) for name, one in SOLVERS.items()}
    print(f"\nWays around a disc, {n}^2: the largest error in cells, and the time")
    for name, (found, time) in side_by_side(works).items():
        error = np.abs(found - 0.05 - G * way)[inside].max() / G / x[1]
        print(f"  {name:20} {error:5.2f} {time:6.2f} s")


def wishes(dim, n):
    """Return sizes of several kinds on the nodes of the unit box."""
    rng = np.random.default_rng(0)
    x = np.moveaxis(np.indices((n,) * dim), 0, -1) / (n - 1)
    peaks = np.full((n,) * dim, 0.3)
    peaks[tuple(rng.integers(0, n, (dim, 40)))] = rng.uniform(0.01, 0.2, 40)
    d = np.linalg.norm(x - 0.5, axis=-1) - 0.3
    waves = 0.08 + 0.5 * np.maximum(np.sin(9 * x[..., 0]) * np.cos(7 * x[..., 1]), 0)
    along = x[..., :2] @ (np.cos(0.4), np.sin(0.4))
    return {
        "forty points": peaks,
        "a thin curve": np.where(np.abs(d) < 1 / n, 0.01 + 0.3 * np.abs(np.sin(5 * x[..., 0])), 1),
        "a band and waves": np.where(np.abs(d) < 0.02, 0.01 + 0.02 * x[..., 0], waves),
        "a cone, 3 % too steep": 0.1 + 1.03 * G * np.linalg.norm(x - 0.31, axis=-1),
        "a plane, 1 % too steep": 0.1 + 1.01 * G * along,
    }


def envelope(h, g, dx, rows=400):
    """Return the minimum over y of h(y) + g |x - y|, from all pairs."""
    places, sizes = np.indices(h.shape).reshape(h.ndim, -1).T * dx, h.ravel()
    parts = [
        (g * cdist(places[k : k + rows], places) + sizes).min(axis=1)
        for k in range(0, len(sizes), rows)
    ]
    return np.concatenate(parts).reshape(h.shape)


def shortest_ways(h, g, dx):
    """Return what limiting along the edges of the grid and its diagonals gives, by Dijkstra."""
    number = np.arange(h.size).reshape(h.shape)
    a, b, cost = [np.full(h.size, h.size)], [number.ravel()], [h.ravel()]
    for way in itertools.product((-1, 0, 1), repeat=h.ndim):
        if way > (0,) * h.ndim:
            ends = [
                tuple(slice(max(0, s * w), min(0, s * w) or None) for w in way) for s in (1, -1)
            ]
            a.append(number[ends[0]].ravel())
            b.append(number[ends[1]].ravel())
            cost.append(np.full(len(a[-1]), g * dx * np.linalg.norm(way)))
    lengths = (np.concatenate(cost), (np.concatenate(a), np.concatenate(b)))
    graph = coo_array(lengths, shape=(h.size + 1, h.size + 1)).tocsr()
    return dijkstra(graph, directed=False, indices=h.size)[:-1].reshape(h.shape)
