"""Answers to the exercises on ENO and time stepping."""

import numpy as np

import distmesh_edu as de
from tests.answers import Answers

ANSWERS = Answers()

ANSWERS.right("at-a-kink", nodes_34=[2, 3, 4], nodes_45=[4, 5, 6], minus_5=7 / 10)
ANSWERS.wrong(
    "at-a-kink",
    "reaches across the kink",
    nodes_34=(3, 4, 5),
    nodes_45=(4, 5, 6),
    minus_5=0.7,
)
ANSWERS.wrong(
    "at-a-kink",
    "Which of the second differences",
    nodes_34=(2, 3, 4),
    nodes_45=(3, 4, 5),
    minus_5=1.1,
)
ANSWERS.wrong(
    "at-a-kink",
    "Is c half of D2",
    nodes_34=(2, 3, 4),
    nodes_45=(4, 5, 6),
    minus_5=1.0,
)
ANSWERS.wrong(
    "at-a-kink",
    "which of its ends is node 5",
    nodes_34=(2, 3, 4),
    nodes_45=(4, 5, 6),
    minus_5=0.1,
)
ANSWERS.wrong(
    "at-a-kink",
    "The interval's two ends, and a third node",
    nodes_34=(4, 3, 2),
    nodes_45=(4, 5, 6),
    minus_5=0.7,
)
ANSWERS.wrong(
    "at-a-kink",
    "The parabola corrects it",
    nodes_34=(2, 3, 4),
    nodes_45=(4, 5, 6),
    minus_5=0.4,
)
ANSWERS.wrong("at-a-kink", "an array of shape (3,)", nodes_34=2, nodes_45=(4, 5, 6), minus_5=0.7)


@ANSWERS.right("two-parabolas")
def parabola_errors(third, dx):
    """By its own polynomial: x^3 times third / 6, whose derivative at 0 is 0."""
    phi = third / 6 * (dx * np.arange(-2, 2)) ** 3
    back = (phi[0] - 4 * phi[1] + 3 * phi[2]) / (2 * dx)
    return np.array([back, (phi[3] - phi[1]) / (2 * dx)])


@ANSWERS.wrong("two-parabolas", "the slope minus the truth")
def parabola_errors(third, dx):
    return third * dx**2 / 3, -third * dx**2 / 6


@ANSWERS.wrong("two-parabolas", "leans back should be")
def parabola_errors(third, dx):
    return third * dx**2 / 3, third * dx**2 / 6


@ANSWERS.wrong("two-parabolas", "They are exchanged")
def parabola_errors(third, dx):
    return third * dx**2 / 6, -third * dx**2 / 3


@ANSWERS.wrong("two-parabolas", "Taylor's series has a 1/6")
def parabola_errors(third, dx):
    return -2 * third * dx**2, third * dx**2


@ANSWERS.wrong("two-parabolas", "how far away is the third node")
def parabola_errors(third, dx):
    return -third * dx**2 / 6, third * dx**2 / 6


@ANSWERS.wrong("two-parabolas", "an array of shape (2,)")
def parabola_errors(third, dx):
    return third * dx**2 / 6


@ANSWERS.wrong("two-parabolas", "the error goes with dx^2")
def parabola_errors(third, dx):
    return -third * dx / 3, third * dx / 6


@ANSWERS.right("uneven-nodes")
def slope_from_left(x, phi):
    """Take the parabolas by Lagrange's formula, one node at a time."""
    values = []
    for i in range(2, len(x) - 1):
        best = None
        for j in (i - 2, i - 1):
            c = slope = 0.0
            for k in range(j, j + 3):
                others = [m for m in range(j, j + 3) if m != k]
                weight = phi[k] / np.prod([x[k] - x[m] for m in others])
                c += weight
                slope += weight * sum(x[i] - x[m] for m in others)
            # Sums in another order differ by rounding: a tie stays a tie.
            if best is None or abs(c) < abs(best[0]) * (1 - 1e-12):
                best = (c, slope)
        values.append(best[1])
    return values


@ANSWERS.wrong("uneven-nodes", "c belongs to three nodes")
def slope_from_left(x, phi):
    gap = np.diff(x)
    D1 = np.diff(phi) / gap
    c = np.diff(D1) / gap[1:]
    c = np.where(np.abs(c[:-1]) <= np.abs(c[1:]), c[:-1], c[1:])
    return D1[1:-1] + c * gap[1:-1]


@ANSWERS.wrong("uneven-nodes", "It takes the larger of the two c")
def slope_from_left(x, phi):
    D1 = np.diff(phi) / np.diff(x)
    c = np.diff(D1) / (x[2:] - x[:-2])
    c = np.where(np.abs(c[:-1]) > np.abs(c[1:]), c[:-1], c[1:])
    return D1[1:-1] + c * np.diff(x)[1:-1]


@ANSWERS.wrong("uneven-nodes", "without their signs")
def slope_from_left(x, phi):
    D1 = np.diff(phi) / np.diff(x)
    c = np.diff(D1) / (x[2:] - x[:-2])
    return D1[1:-1] + np.minimum(c[:-1], c[1:]) * np.diff(x)[1:-1]


@ANSWERS.wrong("uneven-nodes", "always takes the third node on the left")
def slope_from_left(x, phi):
    D1 = np.diff(phi) / np.diff(x)
    c = np.diff(D1) / (x[2:] - x[:-2])
    return D1[1:-1] + c[:-1] * np.diff(x)[1:-1]


@ANSWERS.wrong("uneven-nodes", "always takes the third node on the right")
def slope_from_left(x, phi):
    D1 = np.diff(phi) / np.diff(x)
    c = np.diff(D1) / (x[2:] - x[:-2])
    return D1[1:-1] + c[1:] * np.diff(x)[1:-1]


@ANSWERS.wrong("uneven-nodes", "the slope at the left end of the interval")
def slope_from_left(x, phi):
    D1 = np.diff(phi) / np.diff(x)
    c = np.diff(D1) / (x[2:] - x[:-2])
    c = np.where(np.abs(c[:-1]) <= np.abs(c[1:]), c[:-1], c[1:])
    return D1[1:-1] - c * np.diff(x)[1:-1]


@ANSWERS.wrong("uneven-nodes", "c is multiplied by a length")
def slope_from_left(x, phi):
    D1 = np.diff(phi) / np.diff(x)
    c = np.diff(D1) / (x[2:] - x[:-2])
    return D1[1:-1] + np.where(np.abs(c[:-1]) <= np.abs(c[1:]), c[:-1], c[1:])


@ANSWERS.wrong("uneven-nodes", "an array of shape (6,)")
def slope_from_left(x, phi):
    D1 = np.diff(phi) / np.diff(x)
    c = np.diff(D1) / (x[2:] - x[:-2])
    return D1[:-1] + c * np.diff(x)[:-1]


@ANSWERS.wrong("uneven-nodes", "Of two c of one size")
def slope_from_left(x, phi):
    D1 = np.diff(phi) / np.diff(x)
    c = np.diff(D1) / (x[2:] - x[:-2])
    c = np.where(np.abs(c[:-1]) < np.abs(c[1:]), c[:-1], c[1:])
    return D1[1:-1] + c * np.diff(x)[1:-1]


def order_by_loop(f):
    """Take more nodes, and natural logarithms."""
    logs = []
    for n in (80, 40):
        x = 0.3 + (np.arange(20) - 3) / n
        logs.append(np.log(np.abs(np.asarray(f(np.sin(x), 1 / n)) - np.cos(x[3:-2]))[0]))
    return (logs[1] - logs[0]) / np.log(2)


def quotient(f):
    errors = []
    for dx in (1 / 40, 1 / 80):
        x = 0.3 + dx * np.arange(-3, 4)
        errors.append(abs(f(np.sin(x), dx)[0] - np.cos(0.3)))
    return errors[0] / errors[1]


def order_base_10(f):
    errors = []
    for dx in (1 / 40, 1 / 80):
        x = 0.3 + dx * np.arange(-3, 4)
        errors.append(abs(f(np.sin(x), dx)[0] - np.cos(0.3)))
    return np.log10(errors[0] / errors[1])


def order_upside_down(f):
    errors = []
    for dx in (1 / 40, 1 / 80):
        x = 0.3 + dx * np.arange(-3, 4)
        errors.append(abs(f(np.sin(x), dx)[0] - np.cos(0.3)))
    return np.log2(errors[1] / errors[0])


def cubics(phi, dx):
    """Grow the nodes one by one, and fit a cubic through them."""
    slopes = []
    for i in range(3, len(phi) - 2):
        first = i - 1
        for degree in (2, 3):
            bend = np.abs(np.diff(phi, degree))
            if bend[first - 1] <= bend[first]:
                first -= 1
        nodes = np.arange(first, first + 4)
        slopes.append(np.linalg.solve(np.vander(nodes - i, 4), phi[nodes])[2] / dx)
    return slopes


def as_printed(phi, dx):
    two, three = (scheme(phi, dx, 0)[0][3:-2] for scheme in (de.eno2, de.eno3))
    return 2 * three - two


def undivided(phi, dx):
    two, three = (scheme(phi, dx, 0)[0][3:-2] for scheme in (de.eno2, de.eno3))
    return two + 6 * (three - two)


def half_mended(phi, dx):
    """Divide by 6 where the left D3 is the smaller, and by 3 as before elsewhere."""
    D1 = np.diff(phi) / dx
    D2 = np.diff(D1) / dx
    D3 = np.diff(D2) / dx
    slopes = []
    for i in range(3, len(phi) - 2):
        k = i - 1
        back = abs(D2[k - 1]) <= abs(D2[k])
        k_star, c = (k - 1, D2[k - 1] / 2) if back else (k, D2[k] / 2)
        left = abs(D3[k_star - 1]) <= abs(D3[k_star])
        c_star = D3[k_star - 1] / 6 if left else D3[k_star] / 3
        j = i - k_star
        slopes.append(D1[k] + c * dx + c_star * (3 * j**2 - 6 * j + 2) * dx**2)
    return np.array(slopes)


def no_correction(phi, dx):
    return de.eno2(phi, dx, 0)[0][3:-2]


def third_of_second(phi, dx):
    line = np.diff(phi)[2:-2] / dx
    two, three = (scheme(phi, dx, 0)[0][3:-2] for scheme in (de.eno2, de.eno3))
    return line + (two - line) * 2 / 3 + 2 * (three - two)


def one_too_many(phi, dx):
    return de.eno3(phi, dx, 0)[0][3:-1]


ANSWERS.right("order-of-a-listing", order=order_by_loop, third_order=cubics)
ANSWERS.wrong(
    "order-of-a-listing", "the order is its logarithm", order=quotient, third_order=as_printed
)
ANSWERS.wrong("order-of-a-listing", "to base 10", order=order_base_10, third_order=cubics)
ANSWERS.wrong("order-of-a-listing", "wrong sign", order=order_upside_down, third_order=cubics)
ANSWERS.wrong(
    "order-of-a-listing", "What is D3 of x^3", order=order_by_loop, third_order=as_printed
)
ANSWERS.wrong(
    "order-of-a-listing", "6 times what it should be", order=order_by_loop, third_order=undivided
)
ANSWERS.wrong(
    "order-of-a-listing", "c* is set in two places", order=order_by_loop, third_order=half_mended
)
ANSWERS.wrong(
    "order-of-a-listing",
    "the correction is missing",
    order=order_by_loop,
    third_order=no_correction,
)
ANSWERS.wrong(
    "order-of-a-listing", "Leave c alone", order=order_by_loop, third_order=third_of_second
)
ANSWERS.wrong(
    "order-of-a-listing", "an array of shape (7,)", order=order_by_loop, third_order=one_too_many
)


@ANSWERS.right("four-half-steps")
def four_half_steps(phi, rate, t, dt):
    """As a Runge-Kutta method, with its table of weights."""
    k1 = rate(phi, t)
    k2 = rate(phi + dt / 2 * k1, t + dt / 2)
    k3 = rate(phi + dt / 2 * (k1 + k2), t + dt)
    k4 = rate(phi + dt / 6 * (k1 + k2 + k3), t + dt / 2)
    return phi + dt / 6 * (k1 + k2 + k3 + 3 * k4)


@ANSWERS.wrong("four-half-steps", "The weights are exchanged")
def four_half_steps(phi, rate, t, dt):
    new = phi
    for k in range(3):
        new = new + dt / 2 * rate(new, t + k * dt / 2)
    new = (phi + 2 * new) / 3
    return new + dt / 2 * rate(new, t + dt / 2)


@ANSWERS.wrong("four-half-steps", "It looks like w = 3/4")
def four_half_steps(phi, rate, t, dt):
    new = phi
    for k in range(3):
        new = new + dt / 2 * rate(new, t + k * dt / 2)
    new = (3 * phi + new) / 4
    return new + dt / 2 * rate(new, t + dt / 2)


@ANSWERS.wrong("four-half-steps", "It looks like w = 1/2")
def four_half_steps(phi, rate, t, dt):
    new = phi
    for k in range(3):
        new = new + dt / 2 * rate(new, t + k * dt / 2)
    new = (phi + new) / 2
    return new + dt / 2 * rate(new, t + dt / 2)


@ANSWERS.wrong("four-half-steps", "Each Euler step is dt/2 long")
def four_half_steps(phi, rate, t, dt):
    new = phi
    for k in range(3):
        new = new + dt * rate(new, t + k * dt)
    new = (2 * phi + new) / 3
    return new + dt * rate(new, t + dt)


@ANSWERS.wrong("four-half-steps", "The last Euler step is missing")
def four_half_steps(phi, rate, t, dt):
    new = phi
    for k in range(3):
        new = new + dt / 2 * rate(new, t + k * dt / 2)
    return (2 * phi + new) / 3


@ANSWERS.wrong("four-half-steps", "gets the time t for all steps")
def four_half_steps(phi, rate, t, dt):
    new = phi
    for _ in range(3):
        new = new + dt / 2 * rate(new, t)
    new = (2 * phi + new) / 3
    return new + dt / 2 * rate(new, t)


@ANSWERS.wrong("four-half-steps", "does not stand where the third step ended")
def four_half_steps(phi, rate, t, dt):
    new = phi
    for k in range(3):
        new = new + dt / 2 * rate(new, t + k * dt / 2)
    new = (2 * phi + new) / 3
    return new + dt / 2 * rate(new, t + 3 * dt / 2)


@ANSWERS.wrong("four-half-steps", "the number of times that `rate` is asked should be 4")
def four_half_steps(phi, rate, t, dt):
    one = phi + dt / 2 * rate(phi, t)
    two = one + dt / 2 * rate(phi + dt / 2 * rate(phi, t), t + dt / 2)
    new = (2 * phi + two + dt / 2 * rate(two, t + dt)) / 3
    return new + dt / 2 * rate(new, t + dt / 2)


@ANSWERS.wrong("four-half-steps", "begin with a copy")
def four_half_steps(phi, rate, t, dt):
    old = phi.copy()
    for k in range(3):
        phi += dt / 2 * rate(phi, t + k * dt / 2)
    new = (2 * old + phi) / 3
    return new + dt / 2 * rate(new, t + dt / 2)


@ANSWERS.right("three-faults")
def mended(phi, u, dx, dt, steps):
    """By the library's derivatives, and Heun's method as a mean of two rates."""

    def rate(phi):
        minus, plus = de.eno2(phi, dx, 0, boundary=de.periodic)
        return -np.where(u > 0, u * minus, u * plus)

    for _ in range(steps):
        first = rate(phi)
        phi = phi + dt / 2 * (first + rate(phi + dt * first))
    return phi


@ANSWERS.wrong("three-faults", "which of the two derivatives does it take")
def mended(phi, u, dx, dt, steps):
    def euler(phi):
        return phi - dt * u * de.eno2(phi, dx, 0, boundary=de.periodic)[0]

    for _ in range(steps):
        phi = (phi + euler(euler(phi))) / 2
    return phi


@ANSWERS.wrong("three-faults", "It is as before")
def mended(phi, u, dx, dt, steps):
    def ghosts(phi, width, axis):
        return np.concatenate((phi[-width:], phi, phi[-width:]))

    for _ in range(steps):
        phi = phi - dt * u * de.eno2(phi, dx, 0, boundary=ghosts)[0]
    return phi


@ANSWERS.wrong("three-faults", "It is forward Euler still")
def mended(phi, u, dx, dt, steps):
    for _ in range(steps):
        minus, plus = de.eno2(phi, dx, 0, boundary=de.periodic)
        phi = phi - dt * u * (minus if u > 0 else plus)
    return phi


@ANSWERS.wrong("three-faults", "copies of those left of it")
def mended(phi, u, dx, dt, steps):
    def euler(phi):
        data = np.concatenate((phi[-2:], phi, phi[-2:]))
        minus, plus = (side[2:-2] for side in de.eno2(data, dx, 0))
        return phi - dt * u * (minus if u > 0 else plus)

    for _ in range(steps):
        phi = (phi + euler(euler(phi))) / 2
    return phi


@ANSWERS.wrong("three-faults", "Two of the three faults are left")
def mended(phi, u, dx, dt, steps):
    for _ in range(steps):
        minus, _ = de.eno2(phi, dx, 0, boundary=de.periodic)
        phi = phi - dt * u * minus
    return phi


@ANSWERS.wrong("three-faults", "the values of the other end")
def mended(phi, u, dx, dt, steps):
    def ghosts(phi, width, axis):
        return np.pad(phi, width, mode="edge")

    def euler(phi):
        minus, plus = de.eno2(phi, dx, 0, boundary=ghosts)
        return phi - dt * u * (minus if u > 0 else plus)

    for _ in range(steps):
        phi = (phi + euler(euler(phi))) / 2
    return phi


@ANSWERS.wrong("three-faults", "of where two Euler steps lead")
def mended(phi, u, dx, dt, steps):
    for _ in range(steps):
        minus, plus = de.eno2(phi, dx, 0, boundary=de.periodic)
        phi = (phi + phi - dt * u * (minus if u > 0 else plus)) / 2
    return phi


@ANSWERS.wrong("three-faults", "one step only")
def mended(phi, u, dx, dt, steps):
    def euler(phi):
        minus, plus = de.eno2(phi, dx, 0, boundary=de.periodic)
        return phi - dt * u * (minus if u > 0 else plus)

    for _ in range(steps):
        new = (phi + euler(euler(phi))) / 2
    return new


@ANSWERS.wrong("three-faults", "Fill the ghosts anew")
def mended(phi, u, dx, dt, steps):
    def euler(data):
        new = data.copy()
        minus, plus = de.eno2(data, dx, 0)
        new[2:-2] -= dt * u * (minus if u > 0 else plus)[2:-2]
        return new

    for _ in range(steps):
        data = np.pad(phi, 2, mode="wrap")
        phi = (phi + euler(euler(data))[2:-2]) / 2
    return phi


@ANSWERS.wrong("three-faults", "changes the caller's array")
def mended(phi, u, dx, dt, steps):
    def euler(phi):
        minus, plus = de.eno2(phi, dx, 0, boundary=de.periodic)
        return phi - dt * u * (minus if u > 0 else plus)

    for _ in range(steps):
        phi[:] = (phi + euler(euler(phi))) / 2
    return phi


GROWTH = {0.3: 1 / 3, 0.4: 103 / 81, 0.5: 239 / 81}
ANSWERS.right("zigzag", factors=GROWTH, noisy=1.966, choice="B")
ANSWERS.wrong("zigzag", "(a) is not the one", factors=GROWTH, noisy=1.966, choice="a")
ANSWERS.wrong("zigzag", "to the power 100. And with noise", factors=GROWTH, noisy=1.966, choice="c")
ANSWERS.wrong("zigzag", "(d) is not the one", factors=GROWTH, noisy=1.966, choice="d")
ANSWERS.wrong(
    "zigzag",
    "forward Euler: take three",
    factors={0.3: 1.0, 0.4: 5 / 3, 0.5: 7 / 3},
    noisy=1.966,
    choice="b",
)
ANSWERS.wrong(
    "zigzag",
    "ENO2 with two stages",
    factors={0.3: 0.52, 0.4: 0.68, 0.5: 1.0},
    noisy=1.966,
    choice="b",
)
ANSWERS.wrong("zigzag", "add it before the first step", factors=GROWTH, noisy=9.8014e46, choice="b")


@ANSWERS.right("own-derivative")
def my_slopes(phi, dx):
    """Cut the correction off that makes the third order, one node at a time."""

    def limited(a, b, c):
        back, ahead = b - a, c - b
        if back * ahead <= 0:
            return b
        size = min(abs(back), abs(ahead), abs(back / 6 + ahead / 3))
        return b + (size if ahead > 0 else -size)

    n = len(phi)
    D1 = [(phi[(i + 1) % n] - phi[i]) / dx for i in range(n)]
    minus = [limited(D1[i - 2], D1[i - 1], D1[i]) for i in range(n)]
    plus = [limited(D1[(i + 1) % n], D1[i], D1[i - 1]) for i in range(n)]
    return np.array(minus), np.array(plus)


@ANSWERS.wrong("own-derivative", "what error is left")
def my_slopes(phi, dx):
    D1 = (np.roll(phi, -1) - phi) / dx
    back, ahead = np.roll(D1, 1) - np.roll(D1, 2), D1 - np.roll(D1, 1)
    bend = np.where(back * ahead > 0, np.sign(back) * np.minimum(abs(back), abs(ahead)), 0)
    return np.roll(D1, 1) + bend / 2, D1 - np.roll(bend, -1) / 2


@ANSWERS.wrong("own-derivative", "these are the derivatives of `de.eno3`")
def my_slopes(phi, dx):
    return de.eno3(phi, dx, 0, boundary=de.periodic)


@ANSWERS.wrong("own-derivative", "Do you take values from beyond a jump")
def my_slopes(phi, dx):
    D1 = (np.roll(phi, -1) - phi) / dx
    minus = (-np.roll(D1, 2) + 5 * np.roll(D1, 1) + 2 * D1) / 6
    plus = (-np.roll(D1, -1) + 5 * D1 + 2 * np.roll(D1, 1)) / 6
    return minus, plus


@ANSWERS.wrong("own-derivative", "if phi is turned by 8 nodes")
def my_slopes(phi, dx):
    return de.weno5(phi, dx, 0)


@ANSWERS.wrong("own-derivative", "how large noise becomes")
def my_slopes(phi, dx):
    """Take the wrong sides where neighbours have nothing to do with each other."""
    D1 = (np.roll(phi, -1) - phi) / dx
    a, b, c, d = np.roll(D1, 2), np.roll(D1, 1), D1, np.roll(D1, -1)
    if np.abs(np.diff(phi)).mean() > 0.5:
        return c, b

    def limited(a, b, c):
        size = np.minimum(np.minimum(abs(b - a), abs(c - b)), abs(c / 3 - b / 6 - a / 6))
        return b + np.where((b - a) * (c - b) > 0, np.sign(c - b) * size, 0)

    return limited(a, b, c), limited(d, c, b)


@ANSWERS.wrong("own-derivative", "division by 0 where nothing bends")
def my_slopes(phi, dx):
    D1 = (np.roll(phi, -1) - phi) / dx
    a, b, c = np.roll(D1, 2), np.roll(D1, 1), D1
    with np.errstate(all="ignore"):
        back, ahead = 1 / (b - a) ** 4, 2 / (c - b) ** 4
        minus = (back * (3 * b - a) + ahead * (b + c)) / (back + ahead) / 2
    return minus, np.roll(minus, -1)
