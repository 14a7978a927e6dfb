"""What the library warns of: it has done what was asked, and you may not like the result."""


class ConvergenceWarning(UserWarning):
    """A solver stopped at its cap of steps; the best it found so far is still returned."""


class StabilityWarning(UserWarning):
    """A pair of scheme and time stepping whose errors may grow from step to step."""


class ResolutionWarning(UserWarning):
    """The region has features finer than the mesh."""


__all__ = ["ConvergenceWarning", "ResolutionWarning", "StabilityWarning"]
