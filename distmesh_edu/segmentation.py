"""Which pixels of a picture belong together: a phase field that smooths noise and sees shores.

The model is that of Allen and Cahn, drawn towards the picture. It is solved as phase-field
methods of segmentation usually are: each step is split into three that are each solved exactly.
"""

from collections.abc import Callable

import numpy as np
from scipy.fft import dctn, idctn

from ._types import ArrayLike, FloatArray
from ._validation import as_count, as_positive, as_values

__all__ = ["segment_picture"]

#: From a phase field, the light and the length of a step to both a step later.
Step = Callable[[FloatArray, FloatArray, float], tuple[FloatArray, FloatArray]]

#: Steps, of length 1, from each of two starts until the better one is chosen.
TRIAL = 5


def segment_picture(
    picture: ArrayLike,
    steps: int = 30,
    *,
    fidelity: float = 0.7,
    width: float = 1.5,
    dt: float = 1.0,
    callback: Callable[[FloatArray], object] | None = None,
) -> FloatArray:
    """Return a phase field: about -1 where a picture is dark, 1 where it is bright, light aside.

    Parameters
    ----------
    picture : array_like of shape (nx, ny), brightness
        Two kinds of surface in a light that may change evenly across the picture, with noise.
        In one or three dimensions it works as well.
    steps : int
        How many; some 30 until nothing changes.
    fidelity : float, 1 / time
        How strongly the field is drawn to the picture. Small values lose islands, large ones
        keep specks of noise.
    width : float, pixels
        About half the width of the layer between the two phases.
    dt : float, time
        The step; any positive one is stable. The unit is that in which a field spreads over a
        pixel.
    callback : callable, optional
        Called with a copy of the field before the first step and after each.

    Returns
    -------
    ndarray of the picture's shape, dimensionless
        Its zeros are the shore; `redistance` makes a signed distance of it.

    Raises
    ------
    TypeError, ValueError
        If the picture holds other than finite numbers, has fewer than three pixels along an axis,
        is one shade throughout, falls into one phase, or its light is nowhere in a corner; if
        `steps` is not a whole number of 1 at least, or another number not positive.

    Notes
    -----
    With phi the field, f the picture, and c1 and c0 the brightness expected in the two phases,
    the equation is

        d phi/dt = lap phi + (phi - phi**3) / width**2
                   + fidelity * ((1 - phi) (f - c0)**2 - (1 + phi) (f - c1)**2) / gap,

    Allen and Cahn's with the fidelity term of [LiKim2011]_; the gap is the mean of (c1 - c0)**2.
    Here c1 and c0 are numbers times the light, a plane; all are fitted anew in each step.

    Examples
    --------
    >>> f = np.ones((40, 40))
    >>> f[10:30, 10:30] = 0
    >>> f += 0.2 * np.random.default_rng(0).normal(size=f.shape)
    >>> int((segment_picture(f) < 0).sum())
    400
    """
    f = as_values("picture", picture, least=3)
    steps, lam = as_count("steps", steps), as_positive("fidelity", fidelity)
    width, dt = as_positive("width", width), as_positive("dt", dt)

    def step(phi: FloatArray, light: FloatArray, dt: float) -> tuple[FloatArray, FloatArray]:
        dark, bright, light = _expected(f, phi, light)
        phi = _spread(phi, dt)
        phi = _drawn(phi, (f - dark) ** 2, (f - bright) ** 2, lam * dt, bright - dark)
        return _parted(phi, dt / width**2), light

    if abs(f.mean()) < 0.1 * f.std():
        raise ValueError(
            f"picture must be brightness, 0 where it is black: its mean is {f.mean():.2g}, and its "
            f"standard deviation {f.std():.2g}. Do not take the mean off."
        )
    phi, light = _start(f, step)
    for _ in range(steps):
        if callback is not None:
            callback(phi.copy())
        phi, light = step(phi, light, dt)
    if callback is not None:
        callback(phi.copy())
    return np.asarray(phi)


def _start(f: FloatArray, step: Step) -> tuple[FloatArray, FloatArray]:
    """Return a first phase field and light: bright is what is brighter than a plane, or the mean.

    Of a lake, uneven light leaves the plane alone right; a coast from rim to rim looks like a
    slope of the light, and leaves the mean. A few steps from either tell which explains more.
    """
    starts, misfits, refused = [], [], None
    for light in (_light(f, np.ones_like(f)), np.full_like(f, f.mean())):
        spread = (f - light).std()
        if spread <= 1e-9 * np.abs(f).max():
            raise ValueError(
                f"picture must have two shades; it is {f.flat[0]:g} throughout, or nothing but a "
                "slope of the light."
            )
        starts.append((np.clip((f - light) / spread, -1, 1), light))
        try:
            misfits.append(_misfit(f, *starts[-1], step))
        except ValueError as error:
            misfits.append(np.inf)
            refused = error
    if refused is not None and np.isinf(misfits).all():
        raise refused
    return starts[int(np.argmin(misfits))]


def _misfit(f: FloatArray, phi: FloatArray, light: FloatArray, step: Step) -> float:
    """Return how far from the picture is what is expected, squared, after a few steps."""
    for _ in range(TRIAL):
        phi, light = step(phi, light, 1.0)
    dark, bright, _ = _expected(f, phi, light)
    return float(((f - dark - (1 + phi) / 2 * (bright - dark)) ** 2).mean())


def _light(f: FloatArray, shade: FloatArray) -> FloatArray:
    """Return the plane that, times the shade of each pixel, is nearest to the picture."""
    axes = np.meshgrid(*(np.linspace(-1, 1, n) for n in f.shape), indexing="ij", sparse=True)
    planes = np.stack([np.ones_like(f), *(np.broadcast_to(axis, f.shape) for axis in axes)])
    shaded = (planes * shade).reshape(len(planes), -1)
    factors = np.linalg.solve(shaded @ shaded.T, shaded @ f.ravel())
    return np.asarray(np.tensordot(factors, planes, 1))


def _expected(
    f: FloatArray, phi: FloatArray, light: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the picture to expect where it is dark, where it is bright, and the light."""
    share = np.clip((1 + phi) / 2, 0, 1)
    weights = (1 - share) * light**2, share * light**2
    if min(weight.sum() for weight in weights) < light.mean() ** 2:  # less than a pixel
        raise ValueError(
            "picture falls into one phase: no second shade stands out of its noise. Raise "
            "fidelity, or take fewer steps."
        )
    c0, c1 = (float((weight * f / light).sum() / weight.sum()) for weight in weights)
    light = _light(f, c0 + (c1 - c0) * share)
    if light.min() <= 0 <= light.max():
        raise ValueError(
            "picture must be brightness in a light that is nowhere dark: the plane of light fitted "
            f"to it runs from {light.min():.2g} to {light.max():.2g}. Leave its mean in, or cut "
            "the dark corner off."
        )
    return c0 * light, c1 * light, light


def _spread(phi: FloatArray, time: float) -> FloatArray:
    """Return phi after d phi/dt = lap phi: cosines, which have no slope at the rim, decay."""
    rate = np.zeros(())
    for axis, n in enumerate(phi.shape):
        waves = 2 - 2 * np.cos(np.pi * np.arange(n) / n)
        rate = rate + np.expand_dims(waves, [k for k in range(phi.ndim) if k != axis])
    return np.asarray(idctn(np.exp(-time * rate) * dctn(phi)))


def _drawn(
    phi: FloatArray, from_dark: FloatArray, from_bright: FloatArray, pull: float, gap: FloatArray
) -> FloatArray:
    """Return phi after its pull to the picture, which is linear in phi: it decays to a target."""
    both = from_dark + from_bright
    target = (from_dark - from_bright) / both
    return np.asarray(target + (phi - target) * np.exp(-pull * both / (gap**2).mean()))


def _parted(phi: FloatArray, time: float) -> FloatArray:
    """Return phi after d phi/dt = phi - phi**3: it falls apart towards -1 and 1."""
    decay = np.exp(-2 * time)
    return np.asarray(phi / np.sqrt(decay + (1 - decay) * phi**2))
