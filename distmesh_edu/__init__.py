"""Mesh generation with signed distance functions: the library behind the book."""

from typing import TYPE_CHECKING

from . import checks, examples
from ._types import Field
from ._warnings import ConvergenceWarning, ResolutionWarning, StabilityWarning
from .boundaries import extrapolated, neumann, periodic
from .convection import (
    advect,
    advect_semi_lagrangian,
    convection_rate,
    runge_kutta_step,
    time_step_limit,
    upwind,
)
from .distmesh import distmesh2d, distmesh2d_steps, distmesh3d, distmesh3d_steps
from .eno import eno2, eno3, weno5
from .geometry import (
    closest_point,
    closest_points,
    curvature,
    curvature_at,
    gradient,
    gradient_at,
    interface_area,
    mean_curvature,
    mean_curvature_at,
    unit_normal,
    unit_normal_at,
    volume,
)
from .gradient_limiting import limit_gradient, limit_gradient_pde
from .grid import Grid
from .implicit_functions import (
    blend,
    box,
    circle,
    complement,
    cylinder,
    difference,
    ellipse,
    half_plane,
    intersection,
    polygon,
    polygon_area,
    rectangle,
    rotation,
    scaling,
    segment,
    sphere,
    torus,
    translation,
    union,
)
from .mesh import Mesh
from .mesh_generation import generate_mesh, unresolved
from .normal_motion import crossing_times, godunov_norm, move_in_normal_direction
from .redistancing import redistance
from .reinitialization import reinitialize, smeared_sign, subcell_distance
from .segmentation import segment_picture
from .size_functions import (
    feature_size,
    medial_axis,
    size_from_curvature,
    size_from_data,
    size_from_distance,
    size_function,
)

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
    "ResolutionWarning",
    "StabilityWarning",
    "advect",
    "advect_semi_lagrangian",
    "blend",
    "box",
    "checks",
    "circle",
    "closest_point",
    "closest_points",
    "complement",
    "convection_rate",
    "crossing_times",
    "curvature",
    "curvature_at",
    "cylinder",
    "difference",
    "distmesh2d",
    "distmesh2d_steps",
    "distmesh3d",
    "distmesh3d_steps",
    "ellipse",
    "eno2",
    "eno3",
    "examples",
    "explore",
    "extrapolated",
    "feature_size",
    "generate_mesh",
    "godunov_norm",
    "gradient",
    "gradient_at",
    "half_plane",
    "interface_area",
    "intersection",
    "limit_gradient",
    "limit_gradient_pde",
    "mean_curvature",
    "mean_curvature_at",
    "medial_axis",
    "move_in_normal_direction",
    "neumann",
    "periodic",
    "plot_field",
    "plot_mesh",
    "plot_quality",
    "polygon",
    "polygon_area",
    "rectangle",
    "redistance",
    "reinitialize",
    "rotation",
    "runge_kutta_step",
    "scaling",
    "segment",
    "segment_picture",
    "size_from_curvature",
    "size_from_data",
    "size_from_distance",
    "size_function",
    "smeared_sign",
    "sphere",
    "subcell_distance",
    "time_step_limit",
    "torus",
    "translation",
    "union",
    "unit_normal",
    "unit_normal_at",
    "unresolved",
    "upwind",
    "volume",
    "weno5",
]
