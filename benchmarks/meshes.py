"""What a mesh costs and is worth, beside the published algorithm, a floor, and other programs."""

import os
import platform
import time
import warnings
from datetime import date
from functools import cache, partial
from statistics import median
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from scipy.spatial import Delaunay

import distmesh_edu as de

from . import mesh_cases, mesh_peers, transcription
from .measuring import absent, peak_megabytes, seconds, side_by_side
from .transcription import Run

FAST, CORRECTED = "generate_mesh", "distmesh2d, 3d"
PRINTED, INTENDED = "the listing, as printed", "the listing, test mended"
HEADER = (
    "  program                    nodes  steps calls  seconds  ratio (from - to)       "
    "least   mean  area off  pieces  rest"
)


class Outcome(NamedTuple):
    """One run of one program."""

    seconds: float  # of the processor
    ratio: float  # to the time of ours, at the same start, in the same turns
    nodes: int
    steps: int | None
    calls: int | None  # of Delaunay
    rest: bool | None  # whether it came to rest below its cap
    least: float  # quality
    mean: float
    area: float  # or volume: its relative error
    right: bool  # the Euler characteristic
    edge: float  # the mean edge over the wanted one
    floor: float  # seconds that one Delaunay triangulation of the nodes takes


def report():
    """Print all the measurements of meshes."""
    found = suite()
    totals(found)
    aims(found)
    short_form(found)
    distance_to_a_shore()
    frames()


def programs():
    """Return each program as a function of a case and a seed, by its name, and say what is absent.

    The first is ours; what the others take is measured in units of its time.
    """
    fast = getattr(de, "generate_mesh", None)
    found = {FAST: partial(_ours, fast)} if fast else {}
    found |= {CORRECTED: _corrected, PRINTED: _listing, INTENDED: _mended_listing}
    for name, mesher in mesh_peers.all_of_them().items():
        if mesher is None:
            print(absent(name))
        else:
            found[name] = partial(_peer, mesher)
    return found


def _ours(mesher, case, seed, **options):
    mesh = mesher(*case.variant(seed), rng=seed, **options)
    return Run(*mesh, mesh.steps, len(mesh.history), mesh.converged)


def _corrected(case, seed):
    mesher = getattr(de, f"distmesh{case.dim}d", None)
    return mesher and _ours(mesher, case, seed, max_steps=case.cap)


def _listing(case, seed, **options):
    fd, _, *place = case.variant(seed)
    listing = getattr(transcription, f"distmesh{case.dim}d")
    rng = np.random.default_rng(seed)
    return listing(fd, case.edge, *place, rng, max_steps=case.cap, **options)


def _mended_listing(case, seed):
    return _listing(case, seed, intended=True) if case.dim == 2 else None


def _peer(mesher, case, seed):
    found = mesher(case, seed)
    return found and Run(*found, None, None, None)


def suite(cases=None, starts=mesh_cases.STARTS, works=None):
    """Run every program on every case, print a table for each case, and return the outcomes.

    They are keyed by the name of the case and then of the program: a list, one for each start.
    Where a plain program takes long, all but the first see the first start only.
    """
    works = works or programs()
    print("\nMeshes. Processor time, medians over the starts; the programs take turns.")
    print("The ratio is to the first program at the same start; qualities are the worst ones.")
    found = {}
    for case in cases or mesh_cases.ALL.values():
        rows = found[case.name] = {name: [] for name in works}
        failures = {}
        for seed in range(starts):
            chosen = dict(list(works.items())[:1]) if case.slow and seed else works
            for name, outcome in _one_start(case, seed, chosen).items():
                if isinstance(outcome, Exception):
                    failures[name] = outcome
                elif outcome:
                    rows[name].append(outcome)
        _table(case, rows, failures)
    return found


def _one_start(case, seed, works):
    """Return what each program makes of one start: an outcome, an error, or None."""
    timed = _in_turns({name: partial(work, case, seed) for name, work in works.items()})
    base = next((taken for run, taken in timed.values() if isinstance(run, Run)), np.nan)
    outcomes = {}
    for name, (run, taken) in timed.items():
        outcomes[name] = run
        if isinstance(run, Run):
            try:
                outcomes[name] = _judged(case, run, taken, taken / base)
            except ValueError as error:  # no mesh: a NaN, or a corner twice
                outcomes[name] = error
    return outcomes


def _in_turns(works, budget=1.0):
    """Return what each work returned or raised, and the median of its processor times."""
    times = {name: [] for name in works}

    def timed(name, work):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the table says what did not come to rest
            start = time.process_time()
            try:
                return work()
            except Exception as error:
                return error
            finally:
                times[name].append(time.process_time() - start)

    turns = {name: partial(timed, name, work) for name, work in works.items()}
    found = side_by_side(turns, budget=budget)
    return {name: (result, median(times[name])) for name, (result, _) in found.items()}


def _judged(case, run, taken, ratio):
    mesh = de.Mesh(run.p, run.t)
    wanted = case.edge(mesh.p[mesh.edges].mean(axis=1))
    _, floor = _in_turns({"": lambda: Delaunay(mesh.p)})[""]
    return Outcome(
        seconds=taken,
        ratio=ratio,
        nodes=len(mesh.p) - len(mesh.orphans),
        steps=run.steps,
        calls=run.calls,
        rest=run.converged,
        least=mesh.quality.min(),
        mean=mesh.quality.mean(),
        area=mesh.volume / case.measure - 1,
        right=mesh.euler_characteristic == case.euler,
        edge=(mesh.edge_lengths / wanted).mean(),
        floor=floor,
    )


def _table(case, rows, failures):
    first = next(iter(rows.values()))
    floor = f"one Delaunay of its nodes: {_middle(first, 'floor'):.3g} s" if first else ""
    print(f"\n{case.name}    {floor}\n{HEADER}")
    for name, outcomes in rows.items():
        if outcomes:
            print(f"  {name:<25} {_row(outcomes)}", flush=True)
        if name in failures:
            print(f"  {name:<25} failed: {str(failures[name])[:70]}", flush=True)


def _row(outcomes):
    ratios = sorted(o.ratio for o in outcomes)
    spread = f"({ratios[0]:.3f} - {ratios[-1]:.3f})" if len(ratios) > 1 else "(one start)"
    worst = max((o.area for o in outcomes), key=abs)
    right = f"{sum(o.right for o in outcomes)}/{len(outcomes)}"
    known = outcomes[0].steps is not None
    rest = f"{sum(o.rest for o in outcomes)}/{len(outcomes)}" if known else "-"
    steps, calls = (
        f"{_middle(outcomes, name):.0f}" if known else "-" for name in ("steps", "calls")
    )
    return (
        f"{_middle(outcomes, 'nodes'):6.0f} {steps:>6} {calls:>5} "
        f"{_middle(outcomes, 'seconds'):8.3f} {median(ratios):7.3f} {spread:<18} "
        f"{min(o.least for o in outcomes):5.3f}  {min(o.mean for o in outcomes):.3f}  "
        f"{100 * worst:+7.3f}%  {right:>6}  {rest:>4}"
    )


def _middle(outcomes, measure):
    return median(getattr(o, measure) for o in outcomes)


def _plane(found):
    return [case.name for case in mesh_cases.PLANE if case.name in found]


def totals(found):
    """Print each program's sums over the cases in the plane, the lake left out."""
    names = _plane(found)
    rested = [name for name in names if all(o.rest for o in found[name][PRINTED])]
    _sums(found, names, "in the plane")
    if rested != names:
        _sums(found, rested, "in the plane where the listing came to rest")


def _sums(found, names, title):
    print(f"\nTotal of {len(names)} cases {title}")
    print(
        "  program                  cases  seconds  of ours  middle ratio   least   mean  "
        "pieces  at rest"
    )
    for program in found[names[0]]:
        done = [name for name in names if found[name][program]]
        if not done:
            continue
        runs = [o for name in done for o in found[name][program]]
        seconds, share = _share(found, done, program)
        ratios = [_middle(found[name][program], "ratio") for name in done]
        rest = "-" if runs[0].rest is None else f"{sum(o.rest for o in runs)}/{len(runs)}"
        right = f"{sum(o.right for o in runs)}/{len(runs)}"
        print(
            f"  {program:<25} {len(done):4} {seconds:8.2f} {share:8.3f} {median(ratios):13.3f} "
            f"{min(o.least for o in runs):7.3f}  {min(o.mean for o in runs):.3f}  "
            f"{right:>6}  {rest:>7}"
        )


def _share(found, names, program):
    """Return a program's seconds over some cases, and their ratio to ours at the same starts."""
    ours = next(iter(found[names[0]]))
    runs = [found[name][program] for name in names]
    taken = sum(_middle(outcomes, "seconds") for outcomes in runs)
    if not all(found[name][ours] for name in names):
        return taken, np.nan
    return taken, taken / sum(median(o.seconds / o.ratio for o in outcomes) for outcomes in runs)


def aims(found):
    """Say which of the aims that were set for generate_mesh are met."""
    print("\nAims")
    if not any(rows.get(FAST) for rows in found.values()):
        print(f"  unknown: there is no {FAST}")
        return
    _aims_in_the_plane(found)
    for name, rows in found.items():
        if name.startswith("lake"):
            _aims_on_the_lake(name, rows[FAST])
    if found.get("ball 0.1", {}).get(FAST):
        _aims_in_space("ball 0.1", found["ball 0.1"])


def _aims_in_the_plane(found):
    done = [name for name in _plane(found) if found[name][FAST]]
    failed = sorted(set(_plane(found)) - set(done))
    _say(not failed, f"plane: every case has a mesh{', but ' * bool(failed)}{'; '.join(failed)}")
    if not done:
        return
    runs = [o for name in done for o in found[name][FAST]]
    quick = _share(found, done, PRINTED)[1]
    _say(quick >= 7, f"plane: {quick:.1f} times as fast as the listing in total (7, better 10)")
    capped = sum(not o.rest for o in runs)
    _say(not capped, f"plane: {capped} of {len(runs)} runs at their cap (0)")
    least, mean = min(o.least for o in runs), min(o.mean for o in runs)
    _say(least >= 0.35, f"plane: least quality {least:.3f} (0.35)")
    _say(mean >= 0.93, f"plane: lowest mean quality {mean:.3f} (0.93)")
    if "disc 0.01" in done:
        calls = median(o.seconds / o.floor for o in found["disc 0.01"][FAST])
        _say(calls <= 12, f"disc 0.01: the time of {calls:.1f} Delaunay triangulations (12)")


def _aims_on_the_lake(name, runs):
    capped = sum(not o.rest for o in runs)
    _say(runs and not capped, f"{name}: {capped} of {len(runs)} runs at their cap (0)")
    if not runs:
        return
    least, mean = min(o.least for o in runs), min(o.mean for o in runs)
    _say(least >= 0.4 and mean >= 0.95, f"{name}: quality {least:.3f}, {mean:.3f} (0.4, 0.95)")
    area = max(abs(o.area) for o in runs)
    _say(area <= 0.01, f"{name}: area off by {100 * area:.2f} % (1)")
    slowest = max(o.seconds for o in runs)
    _say(slowest <= 10, f"{name}: {slowest:.1f} s at most (10)")


def _aims_in_space(name, rows):
    runs = rows[FAST]
    quick = _middle(rows[PRINTED], "ratio")
    _say(quick >= 15, f"{name}: {quick:.1f} times as fast as the listing (15)")
    least, mean = min(o.least for o in runs), min(o.mean for o in runs)
    _say(least >= 0.25 and mean >= 0.9, f"{name}: quality {least:.3f}, {mean:.3f} (0.25, 0.90)")
    edge = max((o.edge for o in runs), key=lambda ratio: abs(ratio - 1))
    _say(abs(edge - 1) <= 0.1, f"{name}: mean edge {edge:.3f} of the wanted one (within 10 %)")


def _say(met, text):
    print(f"  {'met    ' if met else 'NOT met'} {text}")


def short_form(found):
    """Print the table that the README shows."""
    rows = {
        f"{len(_plane(found))} regions in the plane": _plane(found),
        "disc, h0 = 0.01": ["disc 0.01"],
        "Lake Superior, 3 km at its shore": ["lake, 3 km at its shore"],
        "ball, h0 = 0.1": ["ball 0.1"],
    }
    rows = {title: names for title, names in rows.items() if set(names) <= set(found)}
    shown = [name for name in next(iter(found.values())) if name != INTENDED]
    print("\nFor the README:\n")
    print(f"| time / least quality | {' | '.join(shown)} |\n|---|{'---|' * len(shown)}")
    for title, names in rows.items():
        print(f"| {title} | {' | '.join(_cell(found, names, who) for who in shown)} |")
    machine = f"{date.today()}, {platform.machine()} with {os.cpu_count()} cores"
    print(
        f"\nProcessor time in units of that of `{shown[0]}`, and the worst triangle or "
        f"tetrahedron of all runs; ≥: stopped at a cap. Measured {machine}, "
        f"Python {platform.python_version()}, NumPy {np.__version__}."
    )


def _cell(found, names, program):
    if not all(found[name][program] for name in names):
        return "–"
    runs = [o for name in names for o in found[name][program]]
    capped = any(o.rest is False for o in runs)
    least = min(o.least for o in runs)
    return f"{'≥ ' * capped}{_share(found, names, program)[1]:.2g} / {least:.2f}"


def distance_to_a_shore():
    """Measure the distance to a real shore."""
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


def frames():
    """Count how many pictures a second a live slider shows."""
    box = ((-1, -1), (1, 1))
    meshes = cache(lambda: list(de.distmesh2d_steps(de.circle(), None, 0.1, box)))

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
