"""What level sets cost, and how far from the truth they end."""

from functools import cache, partial

import numpy as np

import distmesh_edu as de
from distmesh_edu.geometry import volume

from . import level_set_peers
from . import level_set_transcription as plain
from .measuring import absent, seconds, side_by_side

CELLS = 3  # the band about the interface, on either side
LOOPS = "node by node, on 51^2"  # as the thesis's listings do it
SCHEMES = {"upwind": de.upwind, "ENO2": de.eno2, "ENO3": de.eno3, "WENO5": de.weno5}


def report():
    """Print every table, then what was to be reached and what was."""
    step = one_step()
    flower = redistancing("Flower with five petals, phi distorted", petals, (101, 201, 401, 801))
    circle = redistancing("Circle, phi distorted", partial(ball, 2), (101, 201, 401, 801))
    sphere = redistancing("Sphere, phi distorted", partial(ball, 3), (51, 101))
    robustness()
    convection()
    arrivals()
    reach(step, flower, circle, sphere)


# ---- one step ----


def one_step(sizes=((801, 801), (101, 101, 101))):
    """Print what one step of motion along the normal costs; return the table."""
    print("\nOne step of phi_t + |grad phi| = 0, ENO2 and forward Euler: ns a node, and ratio")
    fused = plain.fused_step()
    if not fused:
        print(absent("numba"))
    table = {size: _one_step(size, fused) for size in sizes}
    print(f"  {'':34}" + "".join(f"{_size_name(size):>18}" for size in sizes))
    for name in table[sizes[0]]:
        row = [table[size].get(name) for size in sizes]
        ours = [table[size]["distmesh_edu"] for size in sizes]
        pairs = zip(row, ours, strict=True)
        text = (f"{ns:10.4g} {ns / one:7.3g}" if ns else f"{'-':>10} {'-':>7}" for ns, one in pairs)
        print(f"  {name:34}" + "".join(text))
    return table


def _one_step(shape, fused):
    dx = 4 / (shape[0] - 1)
    dt = 0.3 * dx
    phi, _ = ball(len(shape), shape[0])
    padded, out = np.pad(phi, 2), np.pad(phi, 2)
    works = {
        "distmesh_edu": lambda: phi - dt * de.godunov_norm(phi, 1.0, dx),
        "plain NumPy, on whole arrays": lambda: plain.step(phi, dx, dt),
    }
    if len(shape) == 2:
        works[LOOPS] = partial(plain.evolve_normal_eno2, ball(2, 51)[0], np.ones((51, 51)), 4 / 50)
    if fused:
        works["one loop, compiled by numba"] = lambda: fused(padded, out, dx, dt)
    works["one pass, reading and writing"] = lambda: np.copyto(out, padded)
    for work in works.values():
        work()  # numba compiles, memory is fetched
    nodes = {name: 51**2 if name == LOOPS else phi.size for name in works}
    found = side_by_side(works, repeats=9)
    return {name: 1e9 * time / nodes[name] for name, (_, time) in found.items()}


def _size_name(shape):
    return f"{shape[0]}^{len(shape)}"


# ---- redistancing ----


def ball(dim, n):
    """Return a level set function of the unit circle or sphere on n nodes a side, and a field."""
    p = box(dim, n).points
    square = (p**2).sum(axis=-1)
    return (square - 1) * (1 + np.sin(2 * p[..., 0]) / 2), distance_to_ball


def distance_to_ball(p):
    """Return the distance to the unit circle or sphere."""
    return np.linalg.norm(p, axis=-1) - 1


def petals(n):
    """Return the values of `five_petals`, and the field that is its distance."""
    return de.examples.five_petals()(box(2, n).points), de.examples.five_petals_distance()


@cache
def box(dim, n):
    """Return the grid of n nodes a side on [-2, 2] to the power of dim."""
    return de.Grid((np.full(dim, -2.0), np.full(dim, 2.0)), 4 / (n - 1))


def methods():
    """Return each way to redistance, by name: a function of phi and dx."""
    ours = {
        "redistance": de.redistance,
        "reinitialize, band": lambda phi, dx: de.reinitialize(phi, dx, band=CELLS * dx),
        "  plain, same steps": lambda phi, dx: plain.reinitialize(phi, dx, CELLS * dx),
        "  without the fix": lambda phi, dx: de.reinitialize(
            phi, dx, band=CELLS * dx, subcell=False
        ),
    }
    found = level_set_peers.all_of_them()
    return ours | {name: work for name, work in found.items() if work}


def report_absent():
    """Print a line for each peer that is not installed."""
    for name, work in level_set_peers.all_of_them().items():
        if not work:
            print(absent(name))


def redistancing(title, case, sizes):
    """Print times and errors of every method; return them by method and size."""
    found = {n: _redistanced(case, n) for n in sizes}
    print(f"\n{title}: redistancing")
    report_absent()
    print(f"  {'seconds':24}" + "".join(f"{n:>9}" for n in sizes) + "     ratio at the last")
    for name in found[sizes[0]]:
        if "seconds" not in found[sizes[0]][name]:
            continue
        times = [found[n][name]["seconds"] for n in sizes]
        ratio = times[-1] / found[sizes[-1]]["redistance"]["seconds"]
        print(f"  {name:24}" + "".join(f"{time:9.4f}" for time in times) + f"{ratio:10.2f}")
    _print_errors(found, sizes, "band", f"error in a band of {CELLS} cells")
    _print_errors(found, sizes, "moved", "interface moved by")
    _print_errors(found, sizes[-1:], "everywhere", "error everywhere")
    return found


def _print_errors(found, sizes, measure, title):
    last = " order" if len(sizes) > 1 else ""
    print(f"  {title:24}" + "".join(f"{n:>9}" for n in sizes) + last)
    for name, rows in found[sizes[0]].items():
        if measure not in rows:
            continue
        errors = [found[n][name][measure] for n in sizes]
        text = "".join(f"{error:9.1e}" for error in errors)
        if last:
            text += f"{order(errors, sizes):6.1f}"
        print(f"  {name:24}" + text)


def order(errors, sizes):
    """Return the power of dx with which the error falls, from the coarsest grid to the finest."""
    return np.log(errors[0] / errors[-1]) / np.log((sizes[-1] - 1) / (sizes[0] - 1))


def _redistanced(case, n):
    phi, field = case(n)
    grid = box(phi.ndim, n)
    dx = float(grid.dx[0])
    exact = field(grid.points)
    band = np.abs(exact) <= CELLS * dx
    works = {name: partial(work, phi, dx) for name, work in methods().items()}
    table = {}
    for name, (d, time) in side_by_side(works).items():
        error = np.abs(d - exact)
        table[name] = {"seconds": time, "band": error[band].max(), "moved": moved(d, grid, field)}
        if "band" not in name and not name.startswith(" "):
            table[name]["everywhere"] = error.max()
    # What straight lines between the nodes make of the truth: no method can be seen to do better.
    table["(the truth itself)"] = {"moved": moved(exact, grid, field)}
    return table


def moved(phi, grid, field):
    """Return how far from the true interface the zeros of phi on the grid's lines lie, at most."""
    return np.abs(field(crossings(phi, grid))).max()


def crossings(phi, grid):
    """Return the points where phi, taken as linear between neighbouring nodes, is zero."""
    found = []
    for axis in range(phi.ndim):
        a, b = np.moveaxis(phi, axis, 0)[:-1], np.moveaxis(phi, axis, 0)[1:]
        change = (a < 0) != (b < 0)
        start = np.moveaxis(grid.points, axis, 0)[:-1][change]
        way = a[change] / (a[change] - b[change]) * grid.dx[axis]
        found.append(start + way[:, None] * np.eye(phi.ndim)[axis])
    return np.concatenate(found)


# ---- what happens in the long run, and to thin things ----


def robustness(n=201, times=20):
    """Print what many redistancings in a row do to the interface, and to a thin bar."""
    print(f"\n{times} redistancings in a row on {n}^2, each of the result of the one before")
    report_absent()
    phi, field = petals(n)
    grid = box(2, n)
    dx = float(grid.dx[0])
    bars = [bar(grid.points, angle) for angle in (0.0, 0.4)]
    print(f"  {'':24}  flower: moved by, cells      bar of two cells: area kept")
    print(f"  {'':24}  {'once':>8} {times:>7} times      {'straight':>9} {'tilted':>9}")
    for name, work in methods().items():
        if "plain" in name:
            continue
        far = []
        d = phi
        for _ in range(times):
            d = work(d, dx)
            far.append(moved(d, grid, field) / dx)
        kept = [_area_kept(one, work, dx, times) for one in bars]
        print(f"  {name:24}  {far[0]:8.3f} {far[-1]:13.3f}      {kept[0]:9.3f} {kept[1]:9.3f}")


def bar(p, angle):
    """Return a level set function of a bar of 2 by 0.04, two cells of 201^2, at some angle."""
    c, s = np.cos(angle), np.sin(angle)
    turned = (p - (0.003, 0.007)) @ np.array([[c, -s], [s, c]])
    d = de.rectangle(((-1, -0.02), (1, 0.02)))(turned)
    return d * (1 + np.sin(2 * p[..., 0]) / 2)


def _area_kept(phi, work, dx, times):
    before = volume(phi, dx)
    for _ in range(times):
        if (phi < 0).any():
            phi = work(phi, dx)
    return volume(phi, dx) / before


# ---- convection ----


def convection(n=201):
    """Print the area that each scheme loses: Zalesak's disc, once around, and the vortex, T = 8."""
    grid = de.Grid(((0, 0), (1, 1)), 1 / (n - 1))
    x, y = np.moveaxis(grid.points, -1, 0)
    sin, pi = np.sin, np.pi
    swirl = (-(sin(pi * x) ** 2) * sin(2 * pi * y), sin(pi * y) ** 2 * sin(2 * pi * x))
    disc = de.circle((0.5, 0.75), 0.15)(grid.points)
    cases = {
        "Zalesak's disc": (de.examples.zalesak()(grid.points), (0.5 - y, x - 0.5), 2 * pi),
        "vortex, T = 8": (disc, lambda t: [np.cos(pi * t / 8) * u for u in swirl], 8.0),
    }
    print(f"\nConvection on {n}^2: how the area changes, and seconds; CFL 0.9, semi-Lagrangian 4")
    print(f"  {'':34}" + "".join(f"{name:>26}" for name in cases))
    for name, work in _transports().items():
        text = ""
        for phi, velocity, time in cases.values():
            after, taken = seconds(partial(work, phi, velocity, grid.dx, time), repeats=1)
            change = volume(after, grid.dx) / volume(phi, grid.dx) - 1
            text += f"{100 * change:+15.2f} % {taken:7.1f} s"
        print(f"  {name:34}" + text)


def _transports():
    found = {}
    for name, scheme in SCHEMES.items():
        stages = "forward Euler" if scheme.stages == 1 else f"Runge-Kutta {scheme.stages}"
        found[f"{name}, {stages}"] = partial(de.advect, differences=scheme, cfl=0.9)
    return found | {"semi-Lagrangian, cubic spline": de.advect_semi_lagrangian}


# ---- crossing times ----


def arrivals(sizes=(51, 101)):
    """Print how exactly fronts are timed, by straight lines and by cubics between the steps."""
    print("\nCrossing times of the fronts of phi = x^2 + y^2 - 1, at 0 < d < 0.75: largest error")
    print(f"  {'':24}" + "".join(f"{n:>12}^2" for n in sizes))
    for name, scheme in SCHEMES.items():
        for how in ("linear", "hermite"):
            text = "".join(f"{_arrival_error(n, scheme, how):14.1e}" for n in sizes)
            print(f"  {name + ', ' + how:24}" + text)


def _arrival_error(n, scheme, how):
    grid = box(2, n)
    exact = distance_to_ball(grid.points)
    phi = (grid.points**2).sum(axis=-1) - 1
    timed = de.crossing_times(phi, grid.dx, 0.8, differences=scheme, interpolation=how)
    return np.abs(timed - exact)[(exact > 0) & (exact < 0.75)].max()


# ---- what was to be reached ----


FMM = "scikit-fmm, order 2"


def reach(step, flower, circle, sphere):
    """Print each aim of the level sets with what was measured here, and whether it is met."""
    print("\nAims, with what was asked for in brackets")
    ours, slow = (step[801, 801][k] for k in ("distmesh_edu", "plain NumPy, on whole arrays"))
    _say(ours <= 25, f"ENO2 step on 801^2: {ours:.0f} ns a node (25); plain takes {slow:.0f}")
    _reach("flower on 801^2", flower, time=1, better=50)
    _reach("circle on 801^2", circle, time=1, better=50)
    _reach("sphere on 101^3", sphere, time=0.5, better=1000)


def _reach(case, found, time, better):
    sizes = list(found)
    last = found[sizes[-1]]

    def ratio(measure, one, other):
        return last[one][measure] / last[other][measure]

    def rate(name):
        return order([found[n][name]["band"] for n in sizes], sizes)

    power = rate("reinitialize, band")
    _say(power >= 1.8, f"{case}: reinitialize, order {power:.1f} in the band (2)")
    quick = ratio("seconds", "  plain, same steps", "reinitialize, band")
    _say(quick >= 3, f"{case}: reinitialize, {quick:.1f} times as fast as plain (3)")
    if len(sizes) > 2:  # two grids make no order for an error of a millionth
        power = rate("redistance")
        _say(power >= 2.8, f"{case}: redistance, order {power:.1f} in the band (2.8)")
    if FMM not in last:
        print(f"  unknown {case}: redistance beside scikit-fmm, which is not installed")
        return
    share = ratio("seconds", "redistance", FMM)
    _say(share <= time, f"{case}: redistance, {share:.2f} of the time of scikit-fmm ({time})")
    small = ratio("band", FMM, "redistance")
    _say(small >= better, f"{case}: redistance, band error {small:,.0f} times smaller ({better:,})")


def _say(met, text):
    print(f"  {'met    ' if met else 'NOT met'} {text}")
