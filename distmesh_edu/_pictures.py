"""A figure becomes a picture: PNG while a reader slides, WebP for the page."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TypeAlias

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

FigureFunction: TypeAlias = Callable[..., Figure]

PAGE_DPI = 100
"""Pixels of the page to an inch of a figure."""

FRAME_DPI = 150
"""Pixels of a frame to an inch of a figure: 1.5 for one of the page, sharp on a phone."""

PNG_EFFORT = 3
"""Of 9: half the time of the usual 6, for a fifth more bytes."""

EDGE_SHADES = 8
"""Shades of each colour along an edge. They blur its stairs; eight do it as well as 256."""

LOSSY_QUALITY = 85
"""WebP's own scale. At 85 no halo is seen around text."""


@contextmanager
def drawn(figure: FigureFunction, values: Mapping[str, object]) -> Iterator[Figure]:
    """Lend the figure made from `values`; close what was opened, even after an exception.

    Parameters
    ----------
    figure : callable
        A function that returns a Matplotlib figure.
    values : mapping
        Its arguments by name.

    Yields
    ------
    matplotlib.figure.Figure
        The figure, open until the block ends.

    Raises
    ------
    TypeError
        If the function returns something else.
    """
    open_before = set(plt.get_fignums())
    try:
        made = figure(**values)
        if not isinstance(made, Figure):
            name = getattr(figure, "__name__", "figure")
            raise TypeError(
                f"{name} must return a Matplotlib Figure, found {type(made).__name__}; "
                f"end it with `return fig`"
            )
        yield made
    finally:
        # A figure left open would be shown a second time at the end of the cell.
        for number in set(plt.get_fignums()) - open_before:
            plt.close(number)


def size_on_page(figure: Figure) -> tuple[int, int]:
    """Return the width and height of a figure on the page.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.

    Returns
    -------
    tuple of int, pixels of the page
        Width and height.
    """
    width, height = figure.get_size_inches()
    return round(width * PAGE_DPI), round(height * PAGE_DPI)


def quick_png(figure: Figure, dpi: int = FRAME_DPI) -> bytes:
    """Return a figure as PNG, made quickly rather than small: for a reader who slides.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    dpi : int, 1/inch
        Resolution.

    Returns
    -------
    bytes
        The file.
    """
    buffer = io.BytesIO()
    # A "tight" box would make frames of different sizes, and the picture would jump.
    with plt.rc_context({"savefig.bbox": "standard"}):
        figure.savefig(buffer, format="png", dpi=dpi, pil_kwargs={"compress_level": PNG_EFFORT})
    return buffer.getvalue()


def png(figure: Figure, dpi: int = PAGE_DPI) -> bytes:
    """Return a figure as PNG, small rather than made quickly: for the file of a notebook.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    dpi : int, 1/inch
        Resolution.

    Returns
    -------
    bytes
        The file, a few tens of kB: edges have `EDGE_SHADES`.
    """
    image = Image.fromarray(_with_fewer_shades(_pixels(figure, dpi)))
    colours = image.getcolors(256)
    if colours is not None:
        image = image.quantize(len(colours), dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    image.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def webp(figure: Figure, dpi: int = FRAME_DPI) -> bytes:
    """Return a figure as WebP: the smaller one of lossless with fewer shades, and lossy.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    dpi : int, 1/inch
        Resolution.

    Returns
    -------
    bytes
        The file.

    Notes
    -----
    A drawing of lines is half as heavy with `EDGE_SHADES` as without loss, and has no halos; a
    smooth image is lighter with loss.
    """
    pixels = _pixels(figure, dpi)
    lines = _encoded(_with_fewer_shades(pixels), lossless=True, quality=75)
    smooth = _encoded(pixels, lossless=False, quality=LOSSY_QUALITY)
    return min(lines, smooth, key=len)


def _encoded(pixels: NDArray[np.uint8], *, lossless: bool, quality: int) -> bytes:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "WEBP", lossless=lossless, quality=quality, method=4)
    return buffer.getvalue()


def _pixels(figure: Figure, dpi: int) -> NDArray[np.uint8]:
    return np.asarray(Image.open(io.BytesIO(quick_png(figure, dpi))).convert("RGB"))


def _with_fewer_shades(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Round the pixels where the colour jumps; leave flat areas and gradients as they are."""
    step = 255 / (EDGE_SHADES - 1)
    at_edge = np.zeros(pixels.shape[:2], dtype=bool)
    down = _jumps(pixels[:-1], pixels[1:], step)
    across = _jumps(pixels[:, :-1], pixels[:, 1:], step)
    at_edge[:-1] |= down
    at_edge[1:] |= down
    at_edge[:, :-1] |= across
    at_edge[:, 1:] |= across
    nearest = np.round(np.round(np.arange(256) / step) * step).astype(np.uint8)
    rounded = pixels.copy()
    rounded[at_edge] = nearest[pixels[at_edge]]
    return rounded


def _jumps(a: NDArray[np.uint8], b: NDArray[np.uint8], step: float) -> NDArray[np.bool_]:
    far = np.maximum(a, b) - np.minimum(a, b) > step
    return far[..., 0] | far[..., 1] | far[..., 2]
