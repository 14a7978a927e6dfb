"""Draw the picture on the book's cover and in the README: Lake Superior, fine at the shore."""

import sys
from io import BytesIO
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

import distmesh_edu as de

COVER = Path(__file__).parents[1] / "book" / "images" / "cover.png"


def main() -> int:
    """Mesh the lake until its worst triangle is good, and save the picture."""
    lake, box = de.examples.lake_superior(), ((-310, -120), (276, 166))
    grid = de.Grid(box, 2)
    size = grid.interpolate(6 + 0.12 * np.abs(lake(grid.points)), degree=1)
    for mesh in de.distmesh2d_steps(lake, size, 6, box, max_steps=1000):
        latest = mesh.history[-1]
        if latest["step"] == mesh.steps and latest["minimum_quality"] > 0.4:
            break
    fig, ax = plt.subplots(figsize=(9, 4.4), layout="constrained")
    de.plot_mesh(ax, mesh)
    ax.set(xlim=(-312, 278), ylim=(-122, 168))
    ax.set_axis_off()
    with BytesIO() as full:
        fig.savefig(full, dpi=170)
        # Few colours: 64 of them look the same and weigh a quarter.
        Image.open(full).convert("RGB").quantize(64).save(COVER, optimize=True)
    print(f"{COVER}: {mesh}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
