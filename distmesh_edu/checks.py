"""Checks of what a student writes: by properties, on random data, and answered in a sentence.

Each returns nothing when all is well, and raises `CheckFailed` otherwise, which says what was
expected, what was found, where, and what may be the cause.
"""

import hashlib
from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import Any

import numpy as np

from ._checking import (
    UNANSWERED,
    CheckFailed,
    asked,
    described,
    exercise,
    field_values,
    node,
    number,
    numbers,
    point,
    refuse,
)
from ._diagnosis import diagnosis
from ._types import ArrayLike, Field, FloatArray
from .mesh_checks import expect_limited, expect_mesh

__all__ = [
    "CheckFailed",
    "choice_key",
    "exercise",
    "expect_arguments_kept",
    "expect_choice",
    "expect_interface_kept",
    "expect_limited",
    "expect_mesh",
    "expect_order",
    "expect_signed_distance",
    "expect_unit_slope",
    "expect_upwind",
    "expect_values",
    "expect_variation_kept",
]

POINTS = 400  # random points at which a field is asked


def expect_values(
    found: Any,
    expected: ArrayLike,
    *,
    what: str = "your answer",
    at: ArrayLike | None = None,
    within: float = 1e-8,
    mistakes: Sequence[tuple[ArrayLike, str]] = (),
) -> None:
    """Expect |found - expected| <= within * max |expected|, everywhere.

    Parameters
    ----------
    found : array_like or number
        What the student has.
    expected : array_like or number
        What is right.
    what : str
        What these are values of, as the sentence shall name them.
    at : array_like of shape (n, dim) or (n,), optional
        Where: the points that belong to the values, one for each. Their numbers if None.
    within : float, dimensionless
        How far they may be apart, as a share of the largest value expected.
    mistakes : sequence of (array_like, str)
        Values that come out of a known mistake, and what to say of it.

    Raises
    ------
    CheckFailed
        If they are not numbers, have another shape, are not finite or do not agree.

    Examples
    --------
    >>> expect_values([1.0, 2.0], [1, 2])
    >>> expect_values(-2.0, 2.0, what="the slope")
    Traceback (most recent call last):
    distmesh_edu._checking.CheckFailed: Not yet: the slope should be 2, but is -2. Hint: ...
    """
    right = np.asarray(expected, dtype=float)
    values = numbers(found, what, right.shape)
    scale = float(np.abs(right).max(initial=0.0)) or 1.0
    off = np.abs(values - right)
    if np.all(off <= within * scale):
        return
    worst = np.unravel_index(np.argmax(off), off.shape)
    known = (said for wrong, said in mistakes if _same(values, wrong, within * scale))
    where = node(worst) if at is None else point(np.asarray(at)[worst])
    hint = next(known, "") or diagnosis(values, right, within * scale)
    refuse(what, number(right[worst]), number(values[worst]), where=where, hint=hint)


def expect_choice(answer: Any, key: str, *, of: str = "abcd", hint: str = "") -> None:
    """Expect the letter that belongs to the key, which does not give it away.

    Parameters
    ----------
    answer : str
        The letter that the student has chosen.
    key : str
        What `choice_key` returns for the right one.
    of : str
        The letters there are.
    hint : str
        What to read or try, if it was another one.

    Raises
    ------
    CheckFailed
        If it is none of the letters, or a wrong one.

    Examples
    --------
    >>> expect_choice("b", choice_key("b", "which side"), of="abc")
    """
    if answer is None or answer is ...:
        refuse("your choice", f"one of the letters {', '.join(of)}", "empty", hint=UNANSWERED)
    letter = str(answer).strip().lower()
    if len(letter) != 1 or letter not in of:
        refuse("your choice", f"one of the letters {', '.join(of)}", described(answer))
    salt = key.partition(":")[0]
    if choice_key(letter, salt) != key:
        raise CheckFailed(f"({letter}) is not the one", hint=hint)


def choice_key(letter: str, question: str) -> str:
    """Return the key of a right letter: the question's name, and a digest of both.

    Parameters
    ----------
    letter : str
        The right answer.
    question : str
        A name for the question, so that equal letters have different keys.

    Returns
    -------
    str
        For `expect_choice`.

    Examples
    --------
    >>> choice_key("b", "which side")
    'which side:5d8b0395'
    """
    return f"{question}:{hashlib.sha256(f'{question}:{letter}'.encode()).hexdigest()[:8]}"


def expect_arguments_kept(function: Callable[..., Any], *arguments: Any) -> None:
    """Expect a function to leave the arrays that it is given as they are.

    Parameters
    ----------
    function : callable
        The student's.
    *arguments
        What it is called with.

    Raises
    ------
    CheckFailed
        If one of them is changed.

    Examples
    --------
    >>> expect_arguments_kept(np.sort, np.array([2.0, 1.0]))
    """
    before = deepcopy(arguments)
    asked(function, *arguments)
    for place, (old, new) in enumerate(zip(before, arguments, strict=True), start=1):
        if isinstance(old, np.ndarray) and not np.array_equal(old, new, equal_nan=True):
            what = f"argument {place} of `{getattr(function, '__name__', 'your function')}`"
            hint = (
                "To assign to elements, or by `-=`, changes the caller's array: begin with a copy."
            )
            refuse(what, "what it was", "changed after the call", hint=hint)


def expect_upwind(
    step: Callable[[FloatArray, float, float, float], FloatArray],
    *,
    rng: int | np.random.Generator = 0,
) -> None:
    """Expect phi_i - u dt (phi_i - phi_(i-1)) / dx for u > 0, and the mirror image for u < 0.

    Parameters
    ----------
    step : callable
        ``step(phi, u, dx, dt)`` returns phi, of shape (n,), one step of Euler later. What it does
        at the two ends is not looked at.
    rng : int or numpy.random.Generator
        The seed of the data.

    Raises
    ------
    CheckFailed
        If values between the ends are others; it recognises downwind and central differences,
        one side for both signs, and steps that forget dx, dt or u.

    Notes
    -----
    Thesis eqs. (3.5) and (3.6).

    Examples
    --------
    >>> def step(phi, u, dx, dt):
    ...     left, right = np.diff(phi, prepend=0) / dx, np.diff(phi, append=0) / dx
    ...     return phi - dt * u * (left if u > 0 else right)
    >>> expect_upwind(step, rng=1)
    """
    draw = np.random.default_rng(rng)
    dx, dt = draw.uniform(0.05, 0.2), draw.uniform(0.005, 0.02)
    for u in (draw.uniform(0.5, 2), -draw.uniform(0.5, 2)):
        phi = draw.normal(size=12)
        found = numbers(asked(step, phi.copy(), u, dx, dt), "the values after a step", phi.shape)
        left, right = np.diff(phi)[:-1] / dx, np.diff(phi)[1:] / dx
        old, (side, other) = phi[1:-1], (left, right) if u > 0 else (right, left)
        name = "right-hand" if u > 0 else "left-hand"
        sign = "u > 0" if u > 0 else "u < 0"
        mistakes = [
            (old - dt * u * other, f"It looks downwind: it takes the {name} difference at {sign}."),
            (old - dt * u * (left + right) / 2, f"It takes the central difference at {sign}."),
            (old - dt * u * (left + right), "It takes both differences, and adds them."),
            (old + dt * u * side, "The sign is wrong: phi_t = -u phi_x."),
            (old - dt * abs(u) * side, "It forgets the sign of u."),
            (old - dt * u * side * dx, "It forgets to divide by dx."),
            (old - dt * side, "It forgets the speed u."),
            (old - u * side, "It forgets the time step dt."),
            (old, "Nothing has moved."),
        ]
        what = f"phi after a step with u = {u:.3g}"
        expect_values(found[1:-1], old - dt * u * side, what=what, mistakes=mistakes)


def expect_order(
    error: Callable[[int], float],
    order: float,
    *,
    counts: Sequence[int] = (20, 40, 80),
    slack: float = 0.25,
    hint: str = "",
) -> None:
    """Expect an error that falls as n^(-order), at least, with the number n of cells.

    Parameters
    ----------
    error : callable
        ``error(n)`` returns the error with n cells.
    order : float, dimensionless
        The order expected.
    counts : sequence of int
        The numbers of cells; the last two are compared.
    slack : float, dimensionless
        By how much the observed order may be less.
    hint : str
        What to say if it is.

    Raises
    ------
    CheckFailed
        If the observed order is lower. Errors of less than 1e-12 are rounding, and pass.

    Examples
    --------
    >>> expect_order(lambda n: 3 / n**2, 2)
    """
    errors = [float(numbers(asked(error, n), f"the error with {n} cells", ())) for n in counts]
    if abs(errors[-1]) < 1e-12:
        return
    fine, coarse = counts[-1], counts[-2]
    observed = np.log(abs(errors[-2] / errors[-1])) / np.log(fine / coarse)
    if not observed >= order - slack:
        table = ", ".join(f"{e:.2g} (n = {n})" for n, e in zip(counts, errors, strict=True))
        found = f"{observed:.2f}: the errors are {table}"
        refuse("the observed order", f"{order:g} or more", found, hint=hint)


def expect_variation_kept(
    step: Callable[[FloatArray], FloatArray], phi: FloatArray, *, steps: int = 50
) -> None:
    """Expect sum |phi_(i+1) - phi_i|, around a period, to be no larger after each step.

    Parameters
    ----------
    step : callable
        ``step(phi)`` returns the values one step later, of phi's shape (n,).
    phi : ndarray of shape (n,)
        Where to begin.
    steps : int
        How many to make.

    Raises
    ------
    CheckFailed
        At the first step after which it has grown.

    Examples
    --------
    >>> expect_variation_kept(lambda phi: (phi + np.roll(phi, 1)) / 2, np.array([0.0, 1, 0, 2]))
    """
    before = _variation(phi)
    for count in range(1, steps + 1):
        phi = numbers(asked(step, phi), f"phi after step {count}", phi.shape)
        after = _variation(phi)
        if after > before + 1e-9 * (1 + before):
            hint = (
                "New wiggles have come. Is each new value a mean of old ones, with no weight < 0?"
            )
            expected, found = f"at most {before:.6g}", f"{after:.6g}"
            refuse("the total variation", expected, found, where=f"after step {count}", hint=hint)
        before = after


def expect_signed_distance(
    fd: Field,
    bbox: ArrayLike,
    *,
    inside: ArrayLike | None = None,
    outside: ArrayLike | None = None,
    within: float = 1e-4,
    rng: int | np.random.Generator = 0,
) -> None:
    """Expect a signed distance: negative inside, no steeper than 1, and zero one distance away.

    Parameters
    ----------
    fd : callable
        The field: takes points of shape (n, dim), returns values of shape (n,), length.
    bbox : array_like of shape (2, dim), length
        Two opposite corners of the box of the random points.
    inside, outside : array_like of shape (k, dim), length, optional
        Points that are known to be inside or outside.
    within : float, length
        How far from zero the value may be at what should be a closest point.
    rng : int or numpy.random.Generator
        The seed of the points.

    Raises
    ------
    CheckFailed
        If signs are wrong, values differ by more than points are apart, the slope is not 1 where
        there is one, or x - d grad d is not on the interface.

    Notes
    -----
    No right answer is needed. That a function is nowhere steeper than 1 makes it at most the
    distance to its zeros; that going by d against the gradient ends on a zero makes it no less.

    Examples
    --------
    >>> expect_signed_distance(lambda p: np.hypot(*p.T) - 1, ((-2, -2), (2, 2)), inside=[(0, 0)])
    """
    for known, sign, word in ((inside, -1, "negative"), (outside, 1, "positive")):
        _expect_sign(fd, known, sign, word)
    points = _random_points(bbox, rng)
    d = field_values(fd, points)
    apart = np.linalg.norm(points[1:] - points[:-1], axis=1)
    steep = np.abs(np.diff(d)) - apart
    if (worst := int(np.argmax(steep))) >= 0 and steep[worst] > within:
        what = f"the difference between the values at two points {apart[worst]:.4g} apart"
        hint = "A distance never changes faster than you walk. Is it a square, or a multiple?"
        found = number(abs(d[worst + 1] - d[worst]))
        refuse(what, "no more than that", found, where=point(points[worst]), hint=hint)
    gradient, smooth = _slopes(fd, points)
    _expect_slope_one(points[smooth], gradient[smooth])
    feet = points - d[:, None] * gradient
    rest = np.where(smooth, np.abs(field_values(fd, feet)), 0)
    if rest[worst := int(np.argmax(rest))] > within:
        what = f"the value one distance, {abs(d[worst]):.4g}, from a point, straight towards zero,"
        hint = "There the interface should be. Are corners measured to their vertex?"
        refuse(what, "0", number(rest[worst]), where=point(points[worst]), hint=hint)


def expect_unit_slope(
    fd: Field,
    bbox: ArrayLike,
    *,
    within: float = 1e-3,
    rng: int | np.random.Generator = 0,
) -> None:
    """Expect |grad fd| = 1 wherever there is a gradient, which leaves out the medial axis.

    Parameters
    ----------
    fd : callable
        The field: takes points of shape (n, dim), returns values of shape (n,), length.
    bbox : array_like of shape (2, dim), length
        Two opposite corners of the box of the random points.
    within : float, dimensionless
        By how much the slope may be off.
    rng : int or numpy.random.Generator
        The seed of the points.

    Raises
    ------
    CheckFailed
        At the point where it is off most.

    Examples
    --------
    >>> expect_unit_slope(lambda p: np.abs(p).max(axis=-1) - 1, ((-2, -2), (2, 2)))
    """
    points = _random_points(bbox, rng)
    gradient, smooth = _slopes(fd, points)
    _expect_slope_one(points[smooth], gradient[smooth], within)


def expect_interface_kept(
    before: ArrayLike, after: ArrayLike, *, within: float = 0.1, hint: str = ""
) -> None:
    """Expect the zeros of an array, on the lines between nodes, to stay where they are.

    Parameters
    ----------
    before, after : array_like of one shape, length
        A level set on a grid, before and after what was done to it.
    within : float, cells
        By how much a zero may move.
    hint : str
        What to say if one does.

    Raises
    ------
    CheckFailed
        If a node has changed sides, or a zero between two nodes has moved too far.

    Examples
    --------
    >>> expect_interface_kept([-1.0, 1.0, 3.0], [-0.5, 0.5, 1.5])
    """
    old = np.asarray(before, dtype=float)
    new = numbers(after, "phi", old.shape)
    turned = (old < 0) != (new < 0)
    small = np.abs(old) < within * np.max(np.abs(np.gradient(old)), initial=0)
    if (turned & ~small).any():
        first = np.unravel_index(np.argmax(turned & ~small), old.shape)
        hint = hint or "The interface has run past a node. Which sign has S(phi_0) there?"
        refuse(
            "phi",
            f"of the sign of {number(old[first])}",
            number(new[first]),
            where=node(first),
            hint=hint,
        )
    for axis in range(old.ndim):
        _expect_crossings_kept(np.moveaxis(old, axis, 0), np.moveaxis(new, axis, 0), within, hint)


def _same(found: FloatArray, wrong: ArrayLike, tolerance: float) -> bool:
    other = np.asarray(wrong, dtype=float)
    return other.shape == found.shape and bool(np.all(np.abs(found - other) <= tolerance))


def _variation(phi: FloatArray) -> float:
    return float(np.abs(np.roll(phi, -1) - phi).sum())


def _random_points(bbox: ArrayLike, rng: int | np.random.Generator) -> FloatArray:
    low, high = np.asarray(bbox, dtype=float)
    return np.random.default_rng(rng).uniform(low, high, size=(POINTS, len(low)))


def _expect_sign(fd: Field, known: ArrayLike | None, sign: int, word: str) -> None:
    """Expect the sign that points of one side have."""
    if known is None:
        return
    points = np.atleast_2d(np.asarray(known, dtype=float))
    values = field_values(fd, points)
    if (worst := int(np.argmin(sign * values))) >= 0 and sign * values[worst] <= 0:
        hint = "Negative inside, positive outside: has the sign been turned round?"
        refuse("the value", word, number(values[worst]), where=point(points[worst]), hint=hint)


def _slopes(fd: Field, points: FloatArray) -> tuple[FloatArray, np.ndarray[Any, Any]]:
    """Return the gradients by central differences, and where the two sides agree on them."""
    step = 1e-5 * max(1.0, float(np.ptp(points)))
    gradient, smooth = np.empty_like(points), np.ones(len(points), dtype=bool)
    here = field_values(fd, points)
    for axis, away in enumerate(step * np.eye(points.shape[1])):
        back, ahead = field_values(fd, points - away), field_values(fd, points + away)
        gradient[:, axis] = (ahead - back) / (2 * step)
        smooth &= np.abs(ahead - 2 * here + back) < 1e-2 * step
    return gradient, smooth


def _expect_slope_one(points: FloatArray, gradient: FloatArray, within: float = 1e-3) -> None:
    slope = np.linalg.norm(gradient, axis=1)
    if not len(slope):
        refuse("the field", "smooth at most points", "nowhere smooth")
    if abs(slope[worst := int(np.argmax(np.abs(slope - 1)))] - 1) > within:
        hint = "A distance has slope 1: is it a square, a multiple, or not a distance at all?"
        refuse("the slope", "1", number(slope[worst]), where=point(points[worst]), hint=hint)


def _expect_crossings_kept(old: FloatArray, new: FloatArray, within: float, hint: str) -> None:
    """Compare where the straight lines between neighbours along the first axis cross zero."""
    crossed = ((old[1:] < 0) != (old[:-1] < 0)) & ((new[1:] < 0) != (new[:-1] < 0))
    starts = [a[:-1][crossed] / (a[:-1] - a[1:])[crossed] for a in (old, new)]
    moved = np.abs(starts[1] - starts[0])
    if moved.size and moved.max() > within:
        place = np.argwhere(crossed)[moved.argmax()]
        expected, found = f"at most {within:g} cells", f"{moved.max():.3f} cells"
        hint = hint or "What do the nodes next to the interface take their slopes from?"
        refuse("the move of a zero", expected, found, where=f"after node {place}", hint=hint)
