"""`make bench`: what the library costs, beside plain transcriptions, a floor, and its peers."""

import platform
import warnings

import matplotlib
import numpy as np

import distmesh_edu as de

from . import level_sets, meshes


def main():
    """Print everything in one run."""
    matplotlib.use("Agg")
    warnings.simplefilter("ignore", de.ConvergenceWarning)
    versions = f"Python {platform.python_version()}, NumPy {np.__version__}"
    print(f"{platform.system()} {platform.machine()}, {versions}")
    print("Medians of up to three runs, taken in turns; trust the ratios, not the seconds.")
    meshes.disc()
    meshes.lake()
    meshes.frames()
    level_sets.report()


if __name__ == "__main__":
    main()
