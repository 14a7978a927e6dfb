"""What a mesh costs, and a picture of one."""

from functools import cache

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial import Delaunay

import distmesh_edu as de

from . import transcription
from .measuring import absent, peak_megabytes, peer, seconds

BOX = ((-1.0, -1.0), (1.0, 1.0))
PEERS = ["distmeshpy"]


def peers_distmesh2d():
    """Return the distmesh2d of each peer that is installed, as a function of fd, fh and h0."""
    found = {}
    for name in PEERS:
        package = peer(name)
        if package is None:
            print(absent(name))
            continue
        sides = tuple(zip(*BOX, strict=True))  # this peer wants the box side by side
        found[name] = lambda fd, fh, h0, p=package, b=sides: p.distmesh2d(fd, fh, h0, b)
    return found


def disc():
    """Compare ways to mesh the unit disc with a uniform size."""
    print("\nUnit disc, uniform. The transcription stops by the printed test, about half as large.")
    peers = peers_distmesh2d()
    print("     h0 program          nodes  steps  seconds  ratio  quality least / mean")
    circle, ones = de.circle(), lambda p: np.ones(len(p))
    for h0 in (0.05, 0.02):
        mesh, ours = seconds(lambda h0=h0: de.distmesh2d(circle, None, h0, BOX))

        def row(name, p, t, steps, time, h0=h0, ours=ours):
            q = de.Mesh(p, t).quality
            print(
                f"  {h0:5g} {name:<15} {len(p):6} {steps:>6} {time:8.2f} {time / ours:6.2f}  "
                f"{q.min():.3f} / {q.mean():.3f}"
            )

        row("distmesh_edu", mesh.p, mesh.t, mesh.steps, ours)
        printed = lambda h0=h0: transcription.distmesh2d(  # noqa: E731
            circle, ones, h0, BOX, np.empty((0, 2)), np.random.default_rng(0)
        )
        (p, t, steps), plain = seconds(printed)
        row("transcription", p, t, steps, plain)
        per_step = (plain / steps) / (ours / mesh.steps)
        print(f"        a step of the transcription costs {per_step:.2f} of ours")
        for name, mesher in peers.items():
            (p, t), taken = seconds(lambda h0=h0, mesher=mesher: mesher(circle, ones, h0))
            row(name, p, t, "-", taken)
        _, floor = seconds(lambda mesh=mesh: Delaunay(mesh.p))
        calls = len(mesh.history)
        print(
            f"        one Delaunay of these nodes: {floor:.3f} s, {floor / ours:.3f} of the whole; "
            f"{calls} were made"
        )


def lake():
    """Measure the distance to a real shore, and two meshes of it."""
    shore, *islands = de.examples.lake_superior_shores()
    fd = de.polygon(shore, islands)
    p = np.random.default_rng(0).uniform((-330, -140), (296, 186), (100_000, 2))

    def every_side_in_turn():
        best = np.full(len(p), np.inf)
        for ring in (shore, *islands):
            for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                u = p - a
                s = np.clip(u @ (b - a) / ((b - a) @ (b - a)), 0, 1)
                best = np.minimum(best, ((u - s[:, None] * (b - a)) ** 2).sum(axis=1))
        return np.sqrt(best)

    slow, naive = seconds(every_side_in_turn)
    fast, ours = seconds(lambda: fd(p))
    print("\nLake Superior: distance of 100,000 points to 436 sides")
    print(f"  every side in turn, no sign: {naive:.2f} s; k-d tree, with sign: {ours:.2f} s")
    print(f"  {naive / ours:.1f} times faster; peak memory {peak_megabytes(lambda: fd(p)):.0f} MB")
    print(f"  largest difference {np.abs(np.abs(fast) - slow).max():.1e} km")

    box = ((-310, -120), (276, 166))
    grid = de.Grid(box, 2)
    d = fd(grid.points)
    print("Lake Superior: 300 steps of distmesh2d")
    for name, h0, grading in (("8 km", 8, 0.0), ("6 km at the shore, grading 0.2", 6, 0.2)):
        fh = grid.interpolate(h0 + grading * np.abs(d), degree=1)
        work = lambda h0=h0, fh=fh: de.distmesh2d(fd, fh, h0, box, max_steps=300)  # noqa: E731
        mesh, taken = seconds(work, repeats=1)
        q = mesh.quality
        print(
            f"  {name}: {len(mesh.p)} nodes, {taken:.1f} s, {len(mesh.history)} Delaunay calls, "
            f"peak memory {peak_megabytes(work):.0f} MB, quality {q.min():.2f} / {q.mean():.3f}"
        )


def frames():
    """Count how many pictures a second a live slider shows."""
    meshes = cache(lambda: list(de.distmesh2d_steps(de.circle(), None, 0.1, BOX)))

    def relaxing(step):
        fig, ax = plt.subplots()
        de.plot_mesh(ax, meshes()[step], by_quality=True)
        return fig

    widget = de.explore(relaxing, step=(0, 100, 1)).widget
    sliders = [w for w in _all_children(widget) if type(w).__name__ == "SelectionSlider"]
    (slider,) = sliders

    def slide():
        for step in range(1, 101):
            slider.index = step
        slider.index = 0

    _, taken = seconds(slide, repeats=1)
    print(f"\nexplore, live, disc with h0 = 0.1: {101 / taken:.0f} pictures a second")


def _all_children(widget):
    yield widget
    for child in getattr(widget, "children", ()):
        yield from _all_children(child)
