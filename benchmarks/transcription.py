"""The listings of sections 5.5 and 5.7 as printed, in Python: the baselines of the benchmarks.

Rewritten from the mathematics of the thesis "Mesh generation with a signed distance function",
line by line, slips included (in the plane the stopping test measures sqrt(dt) |F|; the projection
takes |grad d| = 1; t is older than p). Only the cap is new. Not for use: see the book's errata.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.spatial import Delaunay


class Run(NamedTuple):
    """What a listing left behind, and what it did."""

    p: np.ndarray
    t: np.ndarray
    steps: int
    calls: int  # of Delaunay
    converged: bool


def distmesh2d(fd, fh, h0, bbox, pfix, rng, max_steps=10_000, intended=False):
    """Run the listing of section 5.5; if so intended, with the test that it means to make."""
    dptol, ttol, Fscale, deltat = 0.001, 0.1, 1.2, 0.2
    geps, deps = 0.001 * h0, np.sqrt(np.finfo(float).eps) * h0
    x, y = np.meshgrid(
        np.arange(bbox[0][0], bbox[1][0] + 1e-9 * h0, h0),
        np.arange(bbox[0][1], bbox[1][1] + 1e-9 * h0, h0 * np.sqrt(3) / 2),
    )
    x[1::2] += h0 / 2
    p = np.column_stack((x.ravel(), y.ravel()))
    p = p[fd(p) < geps]
    r0 = 1 / fh(p) ** 2
    p = np.vstack((pfix, p[rng.random(len(p)) < r0 / r0.max()]))
    N = len(p)
    pold = np.inf
    step = calls = 0
    converged = False
    while step < max_steps and not converged:
        step += 1
        if np.sqrt(((p - pold) ** 2).sum(axis=1)).max() / h0 > ttol:
            pold = p.copy()
            t = Delaunay(p).simplices
            calls += 1
            pmid = p[t].sum(axis=1) / 3
            t = t[fd(pmid) < -geps]
            bars = np.vstack((t[:, [0, 1]], t[:, [0, 2]], t[:, [1, 2]]))
            bars = np.unique(np.sort(bars, axis=1), axis=0)
        barvec = p[bars[:, 0]] - p[bars[:, 1]]
        L = np.sqrt((barvec**2).sum(axis=1))
        hbars = fh((p[bars[:, 0]] + p[bars[:, 1]]) / 2)
        L0 = hbars * Fscale * np.sqrt((L**2).sum() / (hbars**2).sum())
        F = np.maximum(L0 - L, 0)
        Fvec = (F / L)[:, None] * barvec
        rows, columns = bars[:, [0, 0, 1, 1]], np.tile([0, 1, 0, 1], (len(bars), 1))
        values = np.hstack((Fvec, -Fvec))
        Ftot = coo_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=(N, 2)).toarray()
        Ftot[: len(pfix)] = 0
        p = p + deltat * Ftot
        d = fd(p)
        ix = d > 0
        dgradx = (fd(p[ix] + [deps, 0]) - d[ix]) / deps
        dgrady = (fd(p[ix] + [0, deps]) - d[ix]) / deps
        p[ix] -= np.column_stack((d[ix] * dgradx, d[ix] * dgrady))
        # The slip: the power binds before the product, so the first is sqrt(deltat) |F|.
        printed, meant = deltat * Ftot[d < -geps] ** 2, (deltat * Ftot[d < -geps]) ** 2
        move = np.sqrt((meant if intended else printed).sum(axis=1)).max() / h0
        converged = bool(move < dptol)
    return Run(p, t, step, calls, converged)


def distmesh3d(fd, fh, h0, bbox, pfix, rng, max_steps=10_000):
    """Run the listing of section 5.7; its stopping test measures the step, as it should."""
    ptol, ttol, Fscale, deltat = 0.001, 0.1, 1.1, 0.1
    geps, deps = 0.1 * h0, np.sqrt(np.finfo(float).eps) * h0
    axes = [np.arange(a, b + 1e-9 * h0, h0) for a, b in zip(*bbox, strict=True)]
    p = np.stack([x.ravel(order="F") for x in np.meshgrid(*axes, indexing="ij")], axis=1)
    p = p[fd(p) < geps]
    r0 = fh(p)
    p = np.vstack((pfix, p[rng.random(len(p)) < r0.min() ** 3 / r0**3]))
    N = len(p)
    pold = np.inf
    step = calls = 0
    converged = False
    while step < max_steps and not converged:
        step += 1
        if np.sqrt(((p - pold) ** 2).sum(axis=1)).max() > ttol * h0:
            pold = p.copy()
            t = Delaunay(p).simplices
            calls += 1
            pmid = p[t].sum(axis=1) / 4
            t = t[fd(pmid) < -geps]
            pair = np.vstack([t[:, two] for two in combinations(range(4), 2)])
            pair = np.unique(np.sort(pair, axis=1), axis=0)
        bars = p[pair[:, 0]] - p[pair[:, 1]]
        L = np.sqrt((bars**2).sum(axis=1))
        L0 = fh((p[pair[:, 0]] + p[pair[:, 1]]) / 2)
        L0 = L0 * Fscale * ((L**3).sum() / (L0**3).sum()) ** (1 / 3)
        F = np.maximum(L0 - L, 0)
        Fbar = np.hstack((bars, -bars)) * (F / L)[:, None]
        rows, columns = np.repeat(pair, 3, axis=1), np.tile([0, 1, 2, 0, 1, 2], (len(pair), 1))
        dp = coo_array((Fbar.ravel(), (rows.ravel(), columns.ravel())), shape=(N, 3)).toarray()
        dp[: len(pfix)] = 0
        p = p + deltat * dp
        d = fd(p)
        ix = d > 0
        gradd = np.empty((ix.sum(), 3))
        for i in range(3):
            gradd[:, i] = (fd(p[ix] + deps * np.eye(3)[i]) - d[ix]) / deps
        p[ix] -= d[ix][:, None] * gradd
        converged = bool((deltat * np.sqrt((dp[d < -geps] ** 2).sum(axis=1))).max() < ptol * h0)
    return Run(p, t, step, calls, converged)
