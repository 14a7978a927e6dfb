"""`make bench`: what the library costs, beside plain transcriptions, a floor, and its peers."""

import platform
import sys
import warnings

import matplotlib
import numpy as np

import distmesh_edu as de

from . import grading, level_sets, limiting, meshes

PARTS = {
    "meshes": meshes.report,
    "limiting": limiting.report,
    "level_sets": level_sets.report,
    "grading": grading.report,
}


def main(names):
    """Print the parts asked for, as in `python -m benchmarks meshes`, or all, in one run."""
    matplotlib.use("Agg")
    warnings.simplefilter("ignore", de.ConvergenceWarning)
    warnings.simplefilter("ignore", de.ResolutionWarning)
    versions = f"Python {platform.python_version()}, NumPy {np.__version__}"
    print(f"{platform.system()} {platform.machine()}, {versions}")
    print("Medians of up to three runs, taken in turns; trust the ratios, not the seconds.")
    for name in names or PARTS:
        PARTS[name]()


if __name__ == "__main__":
    main(sys.argv[1:])
