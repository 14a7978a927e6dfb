"""Slices along one axis of an array of any dimension."""

from collections.abc import Callable

Index = tuple[slice, ...]


def along(axis: int) -> Callable[..., Index]:
    """Return `at`, such that `phi[at(start, stop)]` is phi[start:stop] along the axis."""
    before = (slice(None),) * axis

    def at(start: int | None, stop: int | None = None) -> Index:
        return (*before, slice(start, stop))

    return at
