"""How the benchmarks measure: time, memory, and peers that may be absent."""

import statistics
import time
import tracemalloc
from importlib import import_module


def seconds(work, repeats=3):
    """Return the result of `work()` and its median time over some runs."""
    return side_by_side({"": work}, repeats)[""]


def side_by_side(works, repeats=3, budget=20.0):
    """Return the result of each work and its median time, by its name.

    The works take turns, so that a busy moment of the machine meets all of them. No new round
    begins once the budget, in seconds, is spent.
    """
    times = {name: [] for name in works}
    results = {}
    begin = time.perf_counter()
    for done in range(repeats):
        if done and time.perf_counter() - begin > budget:
            break
        for name, work in works.items():
            start = time.perf_counter()
            results[name] = work()
            times[name].append(time.perf_counter() - start)
    return {name: (results[name], statistics.median(times[name])) for name in works}


def peak_megabytes(work):
    """Return the most memory that `work()` held at once; a run of its own, for it is slow."""
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    return peak


def peer(name):
    """Return a package that may be installed, or None."""
    try:
        return import_module(name)
    except ImportError:
        return None


def absent(name):
    """Return the line that stands for a peer that is not there."""
    return f"  {name}: not installed (pip install 'distmesh-edu[bench]')"
