"""Answers to the exercises on convection."""

import numpy as np

from tests.answers import Answers

ANSWERS = Answers()

ANSWERS.wrong("inflow", "(a) is not the one", choice="a")
ANSWERS.wrong("inflow", "one of the letters a, b, c, d", choice="at x = 2")
ANSWERS.wrong("inflow", "where was the value that is now at x = 1.5", choice="d")
ANSWERS.right("inflow", choice=" B ")


@ANSWERS.right("diffusivity")
def diffusivity(u, dx, dt):
    speed = np.sqrt(u**2)
    return (speed * dx - speed**2 * dt) / 2


@ANSWERS.wrong("diffusivity", "The time step smears less, the longer it is")
def diffusivity(u, dx, dt):
    return abs(u) * dx / 2


@ANSWERS.wrong("diffusivity", "its sign changes")
def diffusivity(u, dx, dt):
    return abs(u) * dx / 2 * (1 + abs(u) * dt / dx)


@ANSWERS.wrong("diffusivity", "twice too large")
def diffusivity(u, dx, dt):
    return abs(u) * dx - u**2 * dt


@ANSWERS.wrong("diffusivity", "the diffusivity should be")
def diffusivity(u, dx, dt):
    return u * dx / 2 * (1 - u * dt / dx)


@ANSWERS.right("upwind-step")
def upwind_step(phi, u, dx, dt):
    n = len(phi)
    new = [0.0] * n
    for i in range(n):
        slope = (phi[i] - phi[i - 1]) / dx if u > 0 else (phi[(i + 1) % n] - phi[i]) / dx
        new[i] = phi[i] - dt * u * slope
    return new


@ANSWERS.wrong("upwind-step", "looks downwind: it takes the right-hand difference at u > 0")
def upwind_step(phi, u, dx, dt):
    minus = (phi - np.roll(phi, 1)) / dx
    plus = (np.roll(phi, -1) - phi) / dx
    return phi - dt * u * (plus if u > 0 else minus)


@ANSWERS.wrong("upwind-step", "looks downwind: it takes the left-hand difference at u < 0")
def upwind_step(phi, u, dx, dt):
    return phi - dt * u * (phi - np.roll(phi, 1)) / dx


@ANSWERS.wrong("upwind-step", "the central difference")
def upwind_step(phi, u, dx, dt):
    return phi - dt * u * (np.roll(phi, -1) - np.roll(phi, 1)) / (2 * dx)


@ANSWERS.wrong("upwind-step", "The sign is wrong")
def upwind_step(phi, u, dx, dt):
    minus = (phi - np.roll(phi, 1)) / dx
    plus = (np.roll(phi, -1) - phi) / dx
    return phi + dt * u * (minus if u > 0 else plus)


@ANSWERS.wrong("upwind-step", "forgets to divide by dx")
def upwind_step(phi, u, dx, dt):
    minus = phi - np.roll(phi, 1)
    plus = np.roll(phi, -1) - phi
    return phi - dt * u * (minus if u > 0 else plus)


@ANSWERS.wrong("upwind-step", "Only the values at the ends are wrong")
def upwind_step(phi, u, dx, dt):
    new = np.array(phi, dtype=float)
    if u > 0:
        new[1:] -= dt * u * np.diff(phi) / dx
    else:
        new[:-1] -= dt * u * np.diff(phi) / dx
    return new


@ANSWERS.wrong("upwind-step", "changes the caller's array")
def upwind_step(phi, u, dx, dt):
    phi -= dt / dx * u * (phi - np.roll(phi, 1) if u > 0 else np.roll(phi, -1) - phi)
    return phi


@ANSWERS.right("periodic-ghosts")
def with_ghosts(phi, width):
    return [phi[i % len(phi)] for i in range(-width, len(phi) + width)]


@ANSWERS.wrong("periodic-ghosts", "not stored twice here: your ghosts are one off")
def with_ghosts(phi, width):
    return np.concatenate([phi[-width - 1 : -1], phi, phi[1 : width + 1]])


@ANSWERS.wrong("periodic-ghosts", "copies of the end values")
def with_ghosts(phi, width):
    return np.pad(phi, width, mode="edge")


@ANSWERS.wrong("periodic-ghosts", "a mirror at each end")
def with_ghosts(phi, width):
    return np.pad(phi, width, mode="symmetric")


@ANSWERS.wrong("periodic-ghosts", "exchange them")
def with_ghosts(phi, width):
    return np.concatenate([phi[:width], phi, phi[-width:]])


@ANSWERS.wrong("periodic-ghosts", "an array of shape (10,)")
def with_ghosts(phi, width):
    return np.concatenate([phi[-width:], phi])


@ANSWERS.right("find-the-fault")
def mended(phi, u, dx, dt, steps):
    old = list(phi)
    for _ in range(steps):
        new = list(old)
        for i in range(1, len(old) - 1):
            side = (old[i] - old[i - 1]) if u[i] > 0 else (old[i + 1] - old[i])
            new[i] = old[i] - dt / dx * u[i] * side
        old = new
    return np.array(old)


@ANSWERS.wrong("find-the-fault", "It is as before")
def mended(phi, u, dx, dt, steps):
    phi = phi.copy()
    for _ in range(steps):
        phi[1:-1] -= dt / dx * u[1:-1] * np.diff(phi[:-1])
    return phi


@ANSWERS.wrong("find-the-fault", "phi after three steps should be")
def mended(phi, u, dx, dt, steps):
    phi = phi.copy()
    for _ in range(steps):
        minus, plus = np.diff(phi[:-1]) / dx, np.diff(phi[1:]) / dx
        phi[1:-1] -= dt * u[1:-1] * (minus if u.mean() > 0 else plus)
    return phi


@ANSWERS.wrong("find-the-fault", "changes the caller's array")
def mended(phi, u, dx, dt, steps):
    for _ in range(steps):
        minus, plus = np.diff(phi[:-1]) / dx, np.diff(phi[1:]) / dx
        phi[1:-1] -= dt * np.where(u[1:-1] > 0, u[1:-1] * minus, u[1:-1] * plus)
    return phi


@ANSWERS.wrong("find-the-fault", "stopped with")
def mended(phi, u, dx, dt, steps):
    phi = phi.copy()
    for _ in range(steps):
        phi -= dt * np.where(u > 0, u * np.diff(phi) / dx, u * np.diff(phi) / dx)
    return phi


@ANSWERS.right("longest-step")
def longest_step(u, v, dx, dy):
    pairs = zip(np.ravel(u), np.ravel(v), strict=True)
    return min(dx * dy / (abs(a) * dy + abs(b) * dx) for a, b in pairs)


@ANSWERS.wrong("longest-step", "That is (3.10)")
def longest_step(u, v, dx, dy):
    return 1 / np.max(np.sqrt((u / dx) ** 2 + (v / dy) ** 2))


@ANSWERS.wrong("longest-step", "both do not")
def longest_step(u, v, dx, dy):
    return min(dx / np.abs(u).max(), dy / np.abs(v).max())


@ANSWERS.wrong("longest-step", "Speeds to the left count as well")
def longest_step(u, v, dx, dy):
    return 1 / np.max(u / dx + v / dy)


@ANSWERS.wrong("longest-step", "at different nodes")
def longest_step(u, v, dx, dy):
    return 1 / (np.abs(u).max() / dx + np.abs(v).max() / dy)


@ANSWERS.wrong("longest-step", "one number")
def longest_step(u, v, dx, dy):
    return 1 / (np.abs(u) / dx + np.abs(v) / dy)


ANSWERS.right("is-upwind-exact", peaks={1.0: 1.0, 0.5: 0.4463, 0.1: 0.3488}, claim="n")
ANSWERS.wrong("is-upwind-exact", "the peak at CFL 0.5", peaks={1.0: 1.0, 0.5: 1, 0.1: 1}, claim="y")


@ANSWERS.right("better-step")
def better_step(phi, u, dx, dt):
    """Fromm's slope, no steeper than twice either difference, and a flux for each border."""
    n, c = len(phi), abs(u) * dt / dx
    at = (lambda i: phi[i % n]) if u > 0 else (lambda i: phi[-i % n])
    flux = []
    for i in range(n):
        back, ahead = at(i) - at(i - 1), at(i + 1) - at(i)
        slope = 0.0
        if back * ahead > 0:
            size = min(2 * abs(back), 2 * abs(ahead), abs(back + ahead) / 2)
            slope = size if ahead > 0 else -size
        flux.append(at(i) + (1 - c) / 2 * slope)
    new = np.array([at(i) - c * (flux[i] - flux[i - 1]) for i in range(n)])
    return new if u > 0 else new[-np.arange(n) % n]


@ANSWERS.wrong("better-step", "over upwind's")
def better_step(phi, u, dx, dt):
    return phi - dt * u / dx * (phi - np.roll(phi, 1) if u > 0 else np.roll(phi, -1) - phi)


@ANSWERS.wrong("better-step", "New wiggles have come")
def better_step(phi, u, dx, dt):
    c, ahead, back = u * dt / dx, np.roll(phi, -1), np.roll(phi, 1)
    return phi - c / 2 * (ahead - back) + c**2 / 2 * (ahead - 2 * phi + back)
