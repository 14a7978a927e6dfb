"""Pictures of fields and meshes, drawn on Matplotlib axes that you pass in."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize

from ._types import ArrayLike, Field, FloatArray
from ._validation import as_bbox, as_count, as_field, evaluate
from .grid import Grid
from .mesh import Mesh

# Told apart by everyone, colour-blind or not, and dark enough to be read on white.
WATER, INK, ACCENT = "#dcebf5", "#1f3b57", "#b3470b"
QUALITY_COLOURS = colormaps["cividis"].resampled(5)  # fifths: a reader tells five colours apart


def plot_mesh(ax: Axes, mesh: Mesh, *, by_quality: bool = False) -> PolyCollection:
    """Draw the triangles of a mesh, and set the axes to its size.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    mesh : Mesh
        What to draw.
    by_quality : bool
        Fill each triangle with the colour of its radius ratio, dark for 0 and bright for 1.

    Returns
    -------
    matplotlib.collections.PolyCollection
        The triangles; with `by_quality` it can be given to ``figure.colorbar``.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> mesh = Mesh([(0, 0), (1, 0), (1, 1)], [(0, 1, 2)])
    >>> len(plot_mesh(Figure().subplots(), mesh).get_paths())
    1
    """
    width = float(np.clip(30 / np.sqrt(len(mesh.t) + 1), 0.25, 1.0))
    triangles = PolyCollection(
        list(mesh.p[mesh.t]), facecolors=WATER, edgecolors=INK, linewidths=width
    )
    if by_quality:
        triangles.set(array=mesh.quality, cmap=QUALITY_COLOURS, norm=Normalize(0, 1))
    # The artist's name says how far it may differ on another machine: where a tie between two
    # Delaunay triangulations falls otherwise, or, in a truss that shakes, in everything but size.
    triangles.set_gid("mesh" if mesh.converged else "unsettled mesh")
    ax.add_collection(triangles)
    ax.set_aspect("equal")
    ax.autoscale_view()
    return triangles


def plot_quality(ax: Axes, mesh: Mesh, *, bins: int = 20) -> None:
    """Draw a histogram of the radius ratios of a mesh, in per cent of its triangles.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    mesh : Mesh
        What to measure.
    bins : int
        The number of bars between 0 and 1.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> ax = Figure().subplots()
    >>> plot_quality(ax, Mesh([(0, 0), (1, 0), (1, 1)], [(0, 1, 2)]))
    >>> len(ax.patches)
    20
    """
    counts, edges = np.histogram(mesh.quality, bins=bins, range=(0, 1))
    share = 100 * counts / max(len(mesh.t), 1)
    bars = ax.bar(edges[:-1], share, np.diff(edges), align="edge", color=INK, edgecolor="white")
    for bar in bars:
        bar.set_gid("mesh")
    ax.set(xlim=(0, 1), xlabel="quality (radius ratio)", ylabel="triangles (%)")


def plot_field(
    ax: Axes, field: Field, bbox: ArrayLike, *, levels: int | list[float] = 12, nodes: int = 200
) -> FloatArray:
    """Draw the contours of a field, the one where it is zero in a heavy line.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    field : Field
        What to draw.
    bbox : array_like of shape (2, 2), length
        The box to draw it in, ((xmin, ymin), (xmax, ymax)).
    levels : int or list of float
        How many contours, or which.
    nodes : int
        About how many samples along the longer side of the box.

    Returns
    -------
    ndarray of shape (nx, ny)
        The samples that were drawn.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> from distmesh_edu import circle
    >>> plot_field(Figure().subplots(), circle(), ((-2, -2), (2, 2)), nodes=4).shape
    (5, 5)
    """
    lower, upper = as_bbox(bbox, dim=2)
    cells = np.ceil(as_count("nodes", nodes) * (upper - lower) / (upper - lower).max())
    grid = Grid((lower, upper), tuple((upper - lower) / cells))
    values = evaluate("field", as_field("field", field), grid.points)
    # Matplotlib wants rows of y: here alone, arrays are transposed.
    ax.contour(*grid.axes, values.T, levels=levels, colors="#8195a8", linewidths=0.8)
    ax.contour(*grid.axes, values.T, levels=[0.0], colors=ACCENT, linewidths=2.0)
    ax.set_aspect("equal")
    return values
