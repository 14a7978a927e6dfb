"""The packages that make signed distances, each as a function of phi and dx; None if absent."""

import numpy as np
from scipy import ndimage

from .measuring import peer


def scipy_edt(phi, dx):
    """Return the distance to the nearest node of the other sign, less half a cell."""
    outside = ndimage.distance_transform_edt(phi >= 0, sampling=dx) - dx / 2
    inside = ndimage.distance_transform_edt(phi < 0, sampling=dx) - dx / 2
    return np.where(phi < 0, -inside, outside)


def scikit_fmm():
    """Return fast marching of second order."""
    package = peer("skfmm")
    return package and (lambda phi, dx: np.asarray(package.distance(phi, dx=dx, order=2)))


def itk():
    """Return ITK's fast marching."""
    package = peer("SimpleITK")

    def redistance(phi, dx):
        image = package.GetImageFromArray(phi)
        image.SetSpacing([dx] * phi.ndim)
        return package.GetArrayFromImage(package.ReinitializeLevelSet(image))

    return package and redistance


def edt():
    """Return the distance transform of the package edt, less half a cell, on one core."""
    package = peer("edt")

    def redistance(phi, dx):
        sides = (dx,) * phi.ndim
        outside = package.edt(phi >= 0, anisotropy=sides) - dx / 2
        inside = package.edt(phi < 0, anisotropy=sides) - dx / 2
        return np.where(phi < 0, -inside, outside)

    return package and redistance


def all_of_them():
    """Return every peer's function, or None, by its name."""
    return {
        "scikit-fmm, order 2": scikit_fmm(),
        "SimpleITK": itk(),
        "scipy EDT, half a cell": scipy_edt,
        "edt, half a cell": edt(),
    }
