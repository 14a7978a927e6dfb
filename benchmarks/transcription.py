"""The listing of section 5.5 as printed, in Python: the baseline of the benchmarks.

Rewritten from the mathematics of the thesis "Mesh generation with a signed distance function",
line by line, its slips included (the stopping test measures sqrt(dt) |F|; the projection takes
|grad d| = 1). Not for use: see the book's errata.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.spatial import Delaunay


def distmesh2d(fd, fh, h0, bbox, pfix, rng, max_steps=10_000):
    """Return p, t and the number of steps; t is older than p, as printed."""
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
    step = 0
    while step < max_steps:
        step += 1
        if np.sqrt(((p - pold) ** 2).sum(axis=1)).max() / h0 > ttol:
            pold = p.copy()
            t = Delaunay(p).simplices
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
        # The slip: the power binds before the product, so this is sqrt(deltat) |F|.
        if np.sqrt((deltat * Ftot[d < -geps] ** 2).sum(axis=1)).max() / h0 < dptol:
            break
    return p, t, step
