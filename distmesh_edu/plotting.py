"""Pictures of fields and meshes, drawn on Matplotlib axes that you pass in."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize, to_rgba_array
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

from ._simplices import facets_and_owners
from ._types import ArrayLike, BoolArray, Field, FloatArray, IntArray
from ._validation import as_bbox, as_count, as_field, as_numbers, evaluate
from .grid import Grid
from .mesh import NAMES, Mesh

# Told apart by everyone, colour-blind or not, and dark enough to be read on white.
WATER, INK, ACCENT = "#dcebf5", "#1f3b57", "#b3470b"
OPENED = "#f6d9a8"  # what a cut has laid open
QUALITY_COLOURS = colormaps["cividis"].resampled(5)  # fifths: a reader tells five colours apart


def plot_mesh(
    ax: Axes, mesh: Mesh, *, by_quality: bool = False, cut: tuple[ArrayLike, float] | None = None
) -> PolyCollection:
    """Draw the triangles of a mesh, or the surface of its tetrahedra, and fit the axes to it.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw: for tetrahedra axes in space, ``figure.add_subplot(projection="3d")``.
    mesh : Mesh
        What to draw.
    by_quality : bool
        Fill each triangle with the colour of its radius ratio, dark for 0 and bright for 1; in
        space, with that of the tetrahedron behind it.
    cut : (array_like of shape (dim,), float), optional
        A normal and an offset. Only the simplices are drawn whose centroids c have
        normal . c < offset; in space the faces that this lays open are `OPENED` in colour.

    Returns
    -------
    matplotlib.collections.PolyCollection
        The triangles; with `by_quality` it can be given to ``figure.colorbar``.

    Raises
    ------
    TypeError, ValueError
        If the axes are flat and the mesh is not, or the other way; if `cut` is no plane.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> mesh = Mesh([(0, 0), (1, 0), (1, 1)], [(0, 1, 2)])
    >>> len(plot_mesh(Figure().subplots(), mesh).get_paths())
    1
    """
    _check_axes(ax, mesh)
    kept = np.arange(len(mesh.t)) if cut is None else np.flatnonzero(_is_below(mesh, cut))
    if mesh.dim == 3:
        faces, owners = facets_and_owners(mesh.t[kept])
        drawn: PolyCollection = Poly3DCollection(mesh.p[faces], facecolors=_lit(mesh, faces))
    else:
        faces, owners = mesh.t[kept], np.arange(len(kept))
        drawn = PolyCollection(list(mesh.p[faces]), facecolors=WATER)
    width = {2: 30, 3: 15}[mesh.dim] / np.sqrt(len(faces) + 1)
    drawn.set(edgecolors=INK, linewidths=float(np.clip(width, 0.25, 1.0)))
    if by_quality:
        drawn.set(array=mesh.quality[kept[owners]], cmap=QUALITY_COLOURS, norm=Normalize(0, 1))
    # The artist's name says how far it may differ on another machine: where a tie between two
    # Delaunay triangulations falls otherwise, or, in a truss that shakes, in everything but size.
    drawn.set_gid("mesh" if mesh.converged else "unsettled mesh")
    ax.add_collection(drawn, autolim=mesh.dim == 2)
    _fit(ax, mesh)
    return drawn


def _check_axes(ax: Axes, mesh: Mesh) -> None:
    if mesh.dim == 1:
        raise ValueError("mesh must have triangles or tetrahedra to draw; it has intervals.")
    in_space = ax.name == "3d"
    if in_space and mesh.dim == 2:
        raise ValueError("ax must be flat for a mesh of triangles; it is in space.")
    if mesh.dim == 3 and not in_space:
        raise ValueError(
            "ax must be in space for a mesh of tetrahedra; it is flat. Make it with "
            'figure.add_subplot(projection="3d").'
        )


def _is_below(mesh: Mesh, cut: tuple[ArrayLike, float]) -> BoolArray:
    """Return which simplices have their centroids on the side of a plane that stays."""
    try:
        first, second = cut
    except (TypeError, ValueError):
        raise TypeError(
            f"cut must be a normal and an offset, such as ((0, 1, 0), 0.5); got {cut!r}."
        ) from None
    normal, offset = as_numbers("cut[0]", first), as_numbers("cut[1]", second)
    length = float(np.sqrt((normal**2).sum()))
    if normal.shape != (mesh.dim,) or offset.ndim or not length:
        raise ValueError(
            f"cut must be a normal of {mesh.dim} numbers, not all 0, and one offset; got {cut!r}."
        )
    heights = mesh.p[mesh.t].mean(axis=1) @ normal / length
    # So that no rounding decides about the centroids in the plane itself: they go.
    slack = 1e-9 * float(np.abs(mesh.p).max(initial=0))
    return np.asarray(heights < offset / length - slack)


def _lit(mesh: Mesh, faces: IntArray) -> FloatArray:
    """Return the colours of faces in space, in light from above.

    Without it the tetrahedra that stand out of a cut would look like a flat pattern.
    """
    outside = set(map(tuple, mesh.boundary_facets.tolist()))
    names = [WATER if tuple(face) in outside else OPENED for face in faces.tolist()]
    a, b, c = mesh.p[faces.T]
    normals = np.cross(b - a, c - a)
    lengths = np.sqrt((normals**2).sum(axis=1))
    upward = normals[:, 2] / np.where(lengths == 0, 1, lengths)
    colours = to_rgba_array(names)
    colours[:, :3] *= 0.82 + 0.18 * upward[:, None]
    return colours


def _fit(ax: Axes, mesh: Mesh) -> None:
    if mesh.dim == 3:
        # To all of the mesh: a cut that moves leaves the view as it was.
        cast(Any, ax).auto_scale_xyz(*mesh.p.T)
    else:
        ax.autoscale_view()
    ax.set_aspect("equal")


def plot_quality(ax: Axes, mesh: Mesh, *, bins: int = 20) -> None:
    """Draw a histogram of the radius ratios of a mesh, in per cent of its simplices.

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
    ax.set(xlim=(0, 1), xlabel="quality (radius ratio)", ylabel=f"{NAMES[mesh.dim]} (%)")


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
