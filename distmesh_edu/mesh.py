"""The mesh: points, simplices, and what can be measured on them, on a line, in plane and space."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._simplices import (
    boundary_facets,
    facets_and_owners,
    mean_ratio,
    minimum_angle,
    number_of_facets,
    oriented,
    radius_ratio,
    simplex_volumes,
    unique_edges,
)
from ._types import ArrayLike, FloatArray, IntArray
from ._validation import as_numbers

__all__ = [
    "HISTORY",
    "Mesh",
    "boundary_facets",
    "mean_ratio",
    "minimum_angle",
    "oriented",
    "radius_ratio",
    "simplex_volumes",
    "unique_edges",
]

#: One row of `Mesh.history`: how the mesh stood at a retriangulation.
HISTORY = np.dtype(
    [
        ("step", np.int64),
        ("move", np.float64),
        ("minimum_quality", np.float64),
        ("mean_quality", np.float64),
    ]
)

# What meshio calls the simplices, and the formats of files by their endings.
CELLS = {1: "line", 2: "triangle", 3: "tetra"}
FORMATS = {".msh": "gmsh", ".vtk": "vtk", ".vtu": "vtu"}

NAMES = {1: "intervals", 2: "triangles", 3: "tetrahedra"}
CORNERS = {1: "two", 2: "three", 3: "four"}
MEASURES = {1: "length", 2: "area", 3: "volume"}
AXES = {1: "x axis", 2: "plane z = 0"}


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh of simplices: points p, simplices t, and how they came about.

    It unpacks as ``p, t``. The simplices are intervals on a line, triangles in the plane and
    tetrahedra in space.

    Parameters
    ----------
    p : array_like of shape (n, dim), length
        The nodes, in one, two or three dimensions.
    t : array_like of int, of shape (m, dim + 1)
        Each row holds the numbers of a simplex's corners. One of negative volume has two of them
        exchanged: in a mesh all triangles run anticlockwise, and no volume is negative.
    converged : bool
        Whether the generator reached its equilibrium, rather than its cap of steps.
    steps : int
        How many steps it took.
    history : ndarray of dtype HISTORY
        A row for each retriangulation: its step, the largest move of an interior node in the
        step before it (in units of h0), and the least and the mean quality.

    Raises
    ------
    TypeError, ValueError
        If the shapes are others, `p` is not finite, or `t` names a node twice or one that does
        not exist.

    Examples
    --------
    >>> mesh = Mesh([(0, 0), (1, 0), (1, 1), (0, 1)], [(0, 1, 2), (0, 3, 2)])
    >>> mesh.area, mesh.euler_characteristic, len(mesh.edges)
    (1.0, 1, 5)
    >>> mesh.t.tolist()
    [[0, 1, 2], [3, 0, 2]]
    """

    p: FloatArray
    t: IntArray
    converged: bool = True
    steps: int = 0
    history: NDArray[np.void] = field(default_factory=lambda: np.zeros(0, HISTORY), repr=False)

    def __post_init__(self) -> None:
        p = _as_nodes(self.p)
        object.__setattr__(self, "p", p)
        object.__setattr__(self, "t", oriented(p, _as_simplices(self.t, *p.shape)))

    def __iter__(self) -> Iterator[FloatArray | IntArray]:
        return iter((self.p, self.t))

    def __repr__(self) -> str:
        ended = "converged" if self.converged else "not converged"
        counts = f"{len(self.p)} nodes, {len(self.t)} {NAMES[self.dim]}"
        return f"Mesh({counts}, {ended}, {self.steps} steps)"

    @property
    def dim(self) -> int:
        """The number of dimensions: 1, 2 or 3."""
        return int(self.p.shape[1])

    @cached_property
    def volumes(self) -> FloatArray:
        """The length, area or volume of each simplex: positive, or 0 where it is flat."""
        return simplex_volumes(self.p, self.t)

    @property
    def volume(self) -> float:
        """The sum of the volumes: in the plane the area (length to the power dim)."""
        return float(self.volumes.sum())

    @property
    def areas(self) -> FloatArray:
        """The area of each triangle (length squared); a mesh of other simplices has none."""
        if self.dim != 2:
            raise AttributeError(
                f"a mesh of {NAMES[self.dim]} has no area; .volume is its {MEASURES[self.dim]}."
            )
        return self.volumes

    @property
    def area(self) -> float:
        """The sum of the areas (length squared); a mesh of other simplices has none."""
        return float(self.areas.sum())

    @cached_property
    def orientation(self) -> IntArray:
        """1 for each simplex, as it is turned in a mesh, and 0 for a flat one."""
        return np.sign(self.volumes).astype(np.int64)

    @cached_property
    def quality(self) -> FloatArray:
        """The radius ratio dim r_in / r_circ of each simplex: 1 equilateral, 0 flat."""
        return radius_ratio(self.p, self.t)

    @cached_property
    def mean_ratio(self) -> FloatArray:
        """The volume over the mean square of the edges, so scaled: 1 equilateral, 0 flat."""
        return mean_ratio(self.p, self.t)

    @cached_property
    def minimum_angle(self) -> FloatArray:
        """The smallest angle of each triangle, dihedral of each tetrahedron (degrees)."""
        return minimum_angle(self.p, self.t)

    @cached_property
    def edges(self) -> IntArray:
        """The edges, of shape (k, 2): each once, with the smaller node number first."""
        return unique_edges(self.t)

    @cached_property
    def edge_lengths(self) -> FloatArray:
        """The length of each row of `edges`."""
        a, b = self.p[self.edges.T]
        return np.asarray(np.sqrt(((a - b) ** 2).sum(axis=1)))

    @cached_property
    def boundary_facets(self) -> IntArray:
        """The facets of one simplex only, of shape (k, dim), turned outward.

        In the plane edges with the region on their left; in space triangles that run anticlockwise
        for who looks at them from outside; on a line the ends.
        """
        return boundary_facets(self.t)

    @cached_property
    def boundary_simplices(self) -> IntArray:
        """The number of the simplex that each row of `boundary_facets` belongs to."""
        return facets_and_owners(self.t)[1]

    @cached_property
    def boundary_nodes(self) -> IntArray:
        """The numbers of the nodes on the boundary, in ascending order."""
        return np.unique(self.boundary_facets)

    @cached_property
    def orphans(self) -> IntArray:
        """The numbers of the nodes that no simplex uses: a solver would find no equation there."""
        used = np.zeros(len(self.p), dtype=bool)
        used[self.t] = True
        return np.flatnonzero(~used)

    @cached_property
    def euler_characteristic(self) -> int:
        """Nodes in use - edges + faces - tetrahedra.

        In the plane the number of pieces less the number of holes; in space pieces less tunnels
        plus cavities.
        """
        faces = [number_of_facets(self.t)] if self.dim == 3 else []
        edges = [len(self.edges)] if self.dim > 1 else []
        counts = [len(self.p) - len(self.orphans), *edges, *faces, len(self.t)]
        return sum((-1) ** k * count for k, count in enumerate(counts))

    def summary(self) -> str:
        """Return a table of what one looks at first: edges, qualities, angles, boundary.

        Returns
        -------
        str

        Examples
        --------
        >>> print(Mesh([(0, 0), (4, 0), (0, 3)], [(0, 1, 2)]).summary())
        Mesh(3 nodes, 1 triangles, converged, 0 steps)
                         least      mean  greatest
        edge length          3         4         5
        radius ratio       0.8       0.8       0.8
        mean ratio      0.8314    0.8314    0.8314
        least angle      36.87     36.87     36.87
        area 6, boundary facets 3, orphans 0, Euler characteristic 1
        """
        if not len(self.t):
            return repr(self)
        rows = {
            "edge length": self.edge_lengths,
            "radius ratio": self.quality,
            "mean ratio": self.mean_ratio,
            **({"least angle": self.minimum_angle} if self.dim > 1 else {}),
        }
        table = [
            f"{name:<12}{row.min():>10.4g}{row.mean():>10.4g}{row.max():>10.4g}"
            for name, row in rows.items()
        ]
        facts = (
            f"{MEASURES[self.dim]} {self.volume:.6g}, boundary facets {len(self.boundary_facets)}, "
            f"orphans {len(self.orphans)}, Euler characteristic {self.euler_characteristic}"
        )
        head = f"{'':<12}{'least':>10}{'mean':>10}{'greatest':>10}"
        return "\n".join([repr(self), head, *table, facts])

    def write(self, path: str | PathLike[str]) -> None:
        """Write the points and simplices to a file that other programs read, through meshio.

        Parameters
        ----------
        path : str or path
            Its ending chooses the format: VTK's ``.vtk`` or ``.vtu``, or Gmsh's ``.msh``. A file
            that stands there is replaced when the new one is whole.

        Raises
        ------
        ImportError
            If meshio is absent.
        ValueError
            If the ending is another, or the mesh has no simplices.

        Notes
        -----
        These formats have points in space: missing coordinates are written as 0. How the mesh
        came about, `converged`, `steps` and `history`, is not written.

        Examples
        --------
        >>> mesh = Mesh([(0, 0), (1, 0), (0, 1)], [(0, 1, 2)])
        >>> mesh.write("mesh.vtu")  # doctest: +SKIP
        """
        path = Path(path)
        file_format = _file_format(path)
        if not len(self.t):
            raise ValueError(f"the mesh has no {NAMES[self.dim]}: there is nothing to write.")
        points = np.pad(self.p, ((0, 0), (0, 3 - self.dim)))
        content = _meshio().Mesh(points, [(CELLS[self.dim], self.t)])
        # Written beside and then renamed: whatever goes wrong, a good file is not lost.
        with TemporaryDirectory(dir=path.parent, prefix=".") as folder:
            beside = Path(folder) / path.name
            file_format.write(beside, content)
            beside.replace(path)

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Mesh:
        """Return the mesh in a file, with the simplices of the highest dimension it holds.

        Parameters
        ----------
        path : str or path
            A file of VTK, ``.vtk`` or ``.vtu``, or of Gmsh, ``.msh``. Points that it lists and no
            simplex uses are kept: see `orphans`.

        Returns
        -------
        Mesh
            In the plane if there are triangles and no tetrahedra.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ImportError
            If meshio is absent.
        ValueError
            If the ending is another, the file is broken, it holds no simplices or cells that are
            not simplices, or its triangles do not lie in the plane z = 0.

        Examples
        --------
        >>> mesh = Mesh.read("mesh.vtu")  # doctest: +SKIP
        """
        path = Path(path)
        file_format = _file_format(path)
        try:
            content = file_format.read(path)
        except OSError:
            raise
        except Exception as error:  # whatever its reader stumbles over
            raise ValueError(
                f"path must name a file in the format its ending promises; meshio cannot read "
                f"{path.name}: {str(error) or type(error).__name__}."
            ) from error
        return cls(*_simplices_in(content, path.name))


def _as_nodes(p: ArrayLike) -> FloatArray:
    nodes = as_numbers("p", p)
    if nodes.ndim == 1 and not nodes.size:
        nodes = nodes.reshape(0, 2)
    if nodes.ndim != 2 or nodes.shape[1] not in NAMES:
        raise ValueError(
            f"p must have the shape (n, 1), (n, 2) or (n, 3), one node a row; got {nodes.shape}."
        )
    return nodes


def _as_simplices(t: ArrayLike, nodes: int, dim: int) -> IntArray:
    wanted = f"t must hold {CORNERS[dim]} node numbers a row, for p has the shape {(nodes, dim)}"
    try:
        rows = np.asarray(t)
    except ValueError as error:
        raise ValueError(f"{wanted}; {error}.") from error
    if rows.size == 0:
        rows = np.empty((0, dim + 1), dtype=np.int64)
    if rows.ndim != 2 or rows.shape[1] != dim + 1 or not np.issubdtype(rows.dtype, np.integer):
        raise ValueError(f"{wanted}; got the shape {rows.shape} of {rows.dtype}.")
    if rows.size and not (rows.min() >= 0 and rows.max() < nodes):
        raise ValueError(
            f"t must name nodes 0 to {nodes - 1}; it holds {rows.min()} to {rows.max()}. "
            "Numbers start at 0."
        )
    twice = np.any([a == b for a, b in combinations(rows.T, 2)], axis=0)
    if twice.any():
        raise ValueError(f"t names a node twice in {rows[int(np.argmax(twice))].tolist()}.")
    return rows.astype(np.int64)


def _meshio() -> Any:
    try:
        import meshio
    except ImportError as error:
        raise ImportError(
            "Mesh.read and Mesh.write need meshio; install it with pip install 'distmesh-edu[io]'."
        ) from error
    return meshio


def _file_format(path: Path) -> Any:
    """Return meshio's reader and writer of a format.

    Its general ones would print and end the program where they fail, and take .msh for Ansys.
    """
    try:
        name = FORMATS[path.suffix.lower()]
    except KeyError:
        endings = ", ".join(FORMATS)
        raise ValueError(f"path must end in one of {endings}; got {path.name!r}.") from None
    return getattr(_meshio(), name)


def _simplices_in(content: Any, name: str) -> tuple[FloatArray, IntArray]:
    kinds = {block.type for block in content.cells}
    others = sorted(kinds - {"vertex", *CELLS.values()})
    dim = max((dim for dim, cell in CELLS.items() if cell in kinds), default=0)
    if others or not dim:
        holds = f"cells of the type {', '.join(others)}" if others else "no simplices"
        raise ValueError(
            f"path must name a mesh of straight intervals, triangles or tetrahedra; {name} holds "
            f"{holds}."
        )
    t = np.concatenate([block.data for block in content.cells if block.type == CELLS[dim]])
    beyond = content.points[:, dim:].any(axis=1)
    if beyond.any():
        raise ValueError(
            f"path must name a mesh of a region, not of a curve or surface; of {name}, made of "
            f"{NAMES[dim]}, {beyond.sum()} points lie off the {AXES[dim]}."
        )
    return content.points[:, :dim], t
