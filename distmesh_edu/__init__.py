"""Mesh generation with signed distance functions: the library behind the book."""

from typing import TYPE_CHECKING

from . import examples
from ._types import Field
from .distmesh import distmesh2d, distmesh2d_steps
from .grid import Grid
from .implicit_functions import (
    circle,
    complement,
    difference,
    intersection,
    polygon,
    polygon_area,
    rectangle,
    union,
)
from .mesh import ConvergenceWarning, Mesh

if TYPE_CHECKING:
    from .interactive import explore
    from .plotting import plot_field, plot_mesh, plot_quality
else:
    # Pictures are for readers: whoever only computes never pays for importing them.
    _LAZY = {
        "explore": "interactive",
        "plot_field": "plotting",
        "plot_mesh": "plotting",
        "plot_quality": "plotting",
    }

    def __getattr__(name):
        if name not in _LAZY:
            raise AttributeError(f"module 'distmesh_edu' has no attribute {name!r}")
        from importlib import import_module

        return getattr(import_module(f".{_LAZY[name]}", __name__), name)

    def __dir__():
        return sorted([*globals(), *_LAZY])


__all__ = [
    "ConvergenceWarning",
    "Field",
    "Grid",
    "Mesh",
    "circle",
    "complement",
    "difference",
    "distmesh2d",
    "distmesh2d_steps",
    "examples",
    "explore",
    "intersection",
    "plot_field",
    "plot_mesh",
    "plot_quality",
    "polygon",
    "polygon_area",
    "rectangle",
    "union",
]
