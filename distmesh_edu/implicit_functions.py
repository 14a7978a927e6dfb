"""Shapes as fields: functions that are negative inside, zero on the boundary, positive outside."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from ._polygon import Sides, check_nesting, oriented, signed_area
from ._types import ArrayLike, Field, FloatArray
from ._validation import as_bbox, as_field, as_numbers, as_points, as_positive

_ELLIPSE_STEPS = 100  # five or ten are enough but for points that touch the axes or the rim


def circle(center: ArrayLike = (0.0, 0.0), radius: float = 1.0) -> Field:
    """Return the signed distance |x - center| - radius to a circle.

    Parameters
    ----------
    center : array_like of shape (2,), length
        The circle's center.
    radius : float, length
        Its radius.

    Returns
    -------
    Field
        Exact everywhere; it has no gradient at the center.

    Raises
    ------
    ValueError
        If `radius` is not positive or `center` is not one point.

    Examples
    --------
    >>> circle()(np.array([[0.0, 0.0], [2.0, 0.0]]))
    array([-1.,  1.])
    """
    middle, r = as_numbers("center", center), as_positive("radius", radius)
    if middle.shape != (2,):
        raise ValueError(f"center must be one point (x, y); got the shape {middle.shape}.")

    def distance(p: FloatArray) -> FloatArray:
        return np.asarray(np.hypot(p[..., 0] - middle[0], p[..., 1] - middle[1]) - r)

    return distance


def sphere(center: ArrayLike = (0.0, 0.0, 0.0), radius: float = 1.0) -> Field:
    """Return the signed distance |x - center| - radius to a sphere.

    Parameters
    ----------
    center : array_like of shape (dim,), length
        Its center. The dimension is that of the center: on a line the sphere is two points, in
        the plane a circle.
    radius : float, length
        Its radius.

    Returns
    -------
    Field
        Exact everywhere; it has no gradient at the center.

    Raises
    ------
    ValueError
        If `radius` is not positive or `center` is not one point.

    Examples
    --------
    >>> sphere()(np.array([[0.0, 0.0, 0.0], [2.0, 3.0, 6.0]]))
    array([-1.,  6.])
    """
    middle, r = _vector("center", center), as_positive("radius", radius)
    return lambda p: np.asarray(np.linalg.norm(p - middle, axis=-1) - r)


def rectangle(bbox: ArrayLike) -> Field:
    """Return the signed distance to an axis-parallel rectangle: a `box` of the plane.

    Parameters
    ----------
    bbox : array_like of shape (2, 2), length
        The corners ((xmin, ymin), (xmax, ymax)).

    Returns
    -------
    Field
        Exact everywhere, beyond the corners too, where max(|x| - a, |y| - b) is too small.

    Raises
    ------
    ValueError
        If the lower corner is not below and left of the upper one.

    Examples
    --------
    >>> rectangle(((-1, -1), (1, 1)))(np.array([[0.0, 0.0], [4.0, 5.0]]))
    array([-1.,  5.])
    """
    return box(as_bbox(bbox, dim=2))


def box(bbox: ArrayLike) -> Field:
    """Return the signed distance to an axis-parallel box, in any dimension.

    Parameters
    ----------
    bbox : array_like of shape (2, dim), length
        The lower corner and the upper one. On a line, a box is an interval: ((a,), (b,)).

    Returns
    -------
    Field
        Exact everywhere, beyond edges and corners too, where the largest of |x| - a, |y| - b and
        |z| - c is too small.

    Raises
    ------
    ValueError
        If the lower corner is not below the upper one along each axis.

    Notes
    -----
    With q = |x - center| - half widths, the distance is |max(q, 0)| + min(max(q_x, q_y, q_z), 0):
    the first term acts outside, the second inside.

    Examples
    --------
    >>> box(((-1, -1, -1), (1, 1, 1)))(np.array([[0.0, 0.0, 0.0], [2.0, 3.0, 3.0]]))
    array([-1.,  3.])
    """
    lower, upper = as_bbox(bbox)
    center, half = (lower + upper) / 2, (upper - lower) / 2
    return lambda p: _beyond(np.abs(p - center) - half)


def half_plane(normal: ArrayLike, point: ArrayLike | None = None) -> Field:
    """Return the signed distance (x - point) . normal / |normal| to a straight boundary.

    Parameters
    ----------
    normal : array_like of shape (dim,), dimensionless
        Points out of the region; its length does not matter. In the plane the region is a half
        plane, in space a half space, on a line a ray.
    point : array_like of shape (dim,), length, optional
        A point of the boundary; the origin where none is given.

    Returns
    -------
    Field
        Exact everywhere.

    Raises
    ------
    ValueError
        If `normal` is zero, or `point` has another dimension.

    Examples
    --------
    >>> half_plane((0, 2), point=(0, 1))(np.array([[5.0, 0.0], [5.0, 4.0]]))
    array([-1.,  3.])
    """
    n = _direction("normal", normal)
    origin = np.zeros(len(n)) if point is None else _vector("point", point, dim=len(n))
    return lambda p: np.asarray((p - origin) @ n)


def ellipse(center: ArrayLike = (0.0, 0.0), half_axes: ArrayLike = (2.0, 1.0)) -> Field:
    """Return the signed distance to the ellipse (x/a)**2 + (y/b)**2 = 1.

    Parameters
    ----------
    center : array_like of shape (2,), length
        Its center.
    half_axes : array_like of shape (2,), length
        The half axes along x and y. Turn it with `rotation`.

    Returns
    -------
    Field
        Exact everywhere, up to rounding of the larger half axis. It has no gradient on the part
        of the longer axis between the centers of curvature of its two ends.

    Raises
    ------
    ValueError
        If a half axis is not positive or `center` is not one point.

    Notes
    -----
    There is no formula for the distance. The point c of the ellipse closest to p, with p in the
    first quadrant and a >= b, has p - c parallel to the normal there: c_x = a**2 p_x / (s + a**2
    - b**2) and c_y = b**2 p_y / s with one unknown, s > 0. That c lies on the ellipse,
    (c_x / a)**2 + (c_y / b)**2 = Q(s) = 1, is solved for s by Newton's method on
    1 / sqrt(Q) = 1, which is nearly linear, and concave, so that from a start with Q >= 1 no
    step goes too far.

    Examples
    --------
    >>> ellipse()(np.array([[0.0, 0.0], [3.0, 0.0], [0.0, -4.0]]))
    array([-1.,  1.,  3.])
    """
    middle, axes = _vector("center", center, dim=2), _vector("half_axes", half_axes, dim=2)
    if not (axes > 0).all():
        raise ValueError(f"half_axes must be positive; got {axes.tolist()}.")
    order = np.argsort(-axes, kind="stable")
    a, b = axes[order]

    def distance(p: FloatArray) -> FloatArray:
        q = np.abs(p - middle)[..., order]
        offset = q - _closest_on_ellipse(q, a, b)
        outside = (q[..., 0] / a) ** 2 + (q[..., 1] / b) ** 2 - 1
        return np.asarray(np.copysign(np.hypot(offset[..., 0], offset[..., 1]), outside))

    return distance


def cylinder(
    center: ArrayLike = (0.0, 0.0, 0.0),
    radius: float = 1.0,
    height: float = 2.0,
    axis: ArrayLike = (0.0, 0.0, 1.0),
) -> Field:
    """Return the signed distance to a cylinder with its two lids.

    Parameters
    ----------
    center : array_like of shape (3,), length
        The middle of its axis.
    radius, height : float, length
        Its radius, and the distance between the lids.
    axis : array_like of shape (3,), dimensionless
        The direction of its axis.

    Returns
    -------
    Field
        Exact everywhere, beyond the rims too. It has no gradient where two parts of the surface
        are equally near.

    Raises
    ------
    ValueError
        If a size is not positive, `axis` is zero, or a vector does not have three components.

    Notes
    -----
    A `rectangle` in the half plane of radius and height.

    Examples
    --------
    >>> cylinder()(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 5.0]]))
    array([-1.,  2.,  5.])
    """
    frame = _about_axis(center, axis)
    half = np.array([as_positive("radius", radius), as_positive("height", height) / 2])
    return lambda p: _beyond(np.abs(frame(p)) - half)


def torus(
    center: ArrayLike = (0.0, 0.0, 0.0),
    major_radius: float = 1.0,
    minor_radius: float = 0.25,
    axis: ArrayLike = (0.0, 0.0, 1.0),
) -> Field:
    """Return the signed distance to a torus, a tube around a circle.

    Parameters
    ----------
    center : array_like of shape (3,), length
        Its center.
    major_radius : float, length
        The radius of the circle in the middle of the tube.
    minor_radius : float, length
        The radius of the tube, smaller than the other one.
    axis : array_like of shape (3,), dimensionless
        The direction about which it is round.

    Returns
    -------
    Field
        Exact everywhere. It has no gradient on the circle and on the axis.

    Raises
    ------
    ValueError
        If a radius is not positive, the minor one is not the smaller, `axis` is zero, or a
        vector does not have three components.

    Examples
    --------
    >>> torus()(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 2.0]]))
    array([-0.25,  0.75,  1.75])
    """
    frame = _about_axis(center, axis)
    major, minor = (
        as_positive("major_radius", major_radius),
        as_positive("minor_radius", minor_radius),
    )
    if minor >= major:
        raise ValueError(
            f"minor_radius must be less than major_radius, or the tube runs into itself; got "
            f"{minor:g} and {major:g}."
        )
    return lambda p: np.asarray(np.linalg.norm(frame(p) - (major, 0.0), axis=-1) - minor)


def segment(a: ArrayLike, b: ArrayLike, radius: float = 0.0) -> Field:
    """Return the distance to the straight piece from a to b, less a radius.

    Parameters
    ----------
    a, b : array_like of shape (dim,), length
        Its ends. Where they are equal, the region is a ball.
    radius : float, length
        The region holds the points within this distance of the piece: in the plane a stadium, in
        space a capsule. With 0, nothing is inside, and the field is the unsigned distance.

    Returns
    -------
    Field
        Exact everywhere in the plane and in space; it has no gradient on the piece itself. On a
        line it is exact outside only: take a `box` there.

    Raises
    ------
    ValueError
        If `radius` is negative, or `a` and `b` do not have the same dimension.

    Examples
    --------
    >>> segment((0, 0), (2, 0), radius=0.5)(np.array([[1.0, 0.0], [1.0, 3.0], [5.0, 4.0]]))
    array([-0.5,  2.5,  4.5])
    """
    start = _vector("a", a)
    along = _vector("b", b, dim=len(start)) - start
    r = as_numbers("radius", radius)
    if r.ndim or r < 0:
        raise ValueError(f"radius must be one number, 0 or positive; got {radius!r}.")
    square = float(along @ along)

    def distance(p: FloatArray) -> FloatArray:
        offset = p - start
        t = np.clip(offset @ along / square, 0, 1) if square else np.zeros(offset.shape[:-1])
        return np.asarray(np.linalg.norm(offset - t[..., None] * along, axis=-1) - r)

    return distance


def polygon(vertices: ArrayLike, holes: Sequence[ArrayLike] = ()) -> Field:
    """Return the signed distance to a polygon, which may have holes.

    Parameters
    ----------
    vertices : array_like of shape (n, 2), length
        The corners in order, either way round. A last corner equal to the first is dropped.
    holes : sequence of array_like of shape (m, 2), length
        The corners of each hole.

    Returns
    -------
    Field
        Exact everywhere. Memory grows with the number of points, not with points times corners.

    Raises
    ------
    ValueError
        If a ring has fewer than three corners, a corner twice in a row, or a NaN; if rings cross
        or (up to rounding) touch themselves or one another; or if a hole lies outside, or in
        another hole.

    Notes
    -----
    The distance is the least over all sides, found with a k-d tree. The sign at a point whose
    closest point lies within a side is that of the side's normal; where it is a corner, that of
    the sum of the two unit normals there [BaerentzenAanaes2005]_, which holds at corners however
    sharp.

    Examples
    --------
    >>> square = polygon([(0, 0), (4, 0), (4, 4), (0, 4)], holes=[[(1, 1), (2, 1), (2, 2)]])
    >>> square(np.array([[3.0, 3.0], [7.0, 8.0], [1.75, 1.25]]))
    array([-1.  ,  5.  ,  0.25])
    """
    rings = _rings(vertices, holes)
    sides = Sides(rings)
    sides.check_crossing()
    check_nesting(rings)
    return sides.distance


def polygon_area(vertices: ArrayLike, holes: Sequence[ArrayLike] = ()) -> float:
    """Return the area of a polygon less that of its holes, by the shoelace formula.

    Parameters
    ----------
    vertices : array_like of shape (n, 2), length
        The corners in order, either way round.
    holes : sequence of array_like of shape (m, 2), length
        The corners of each hole.

    Returns
    -------
    float
        The area, length squared.

    Raises
    ------
    ValueError
        If a ring has fewer than three corners, a corner twice in a row, or a NaN.

    Examples
    --------
    >>> polygon_area([(0, 0), (4, 0), (4, 4), (0, 4)], holes=[[(1, 1), (2, 1), (2, 2)]])
    15.5
    """
    return sum(signed_area(ring) for ring in _rings(vertices, holes))


def union(*fields: Field) -> Field:
    """Return min(d1, d2, ...): the points that lie in one of the regions at least.

    Parameters
    ----------
    *fields : Field
        Signed distances, or other functions that are negative inside.

    Returns
    -------
    Field
        The right sign everywhere. Of exact distances it is exact outside; inside, its size is
        only a lower bound of the distance.

    Raises
    ------
    TypeError
        If one of `fields` cannot be called, or there is none.

    Examples
    --------
    >>> union(circle(), circle((3, 0)))(np.array([[1.5, 0.0]]))
    array([0.5])
    """
    parts = _parts("union", fields)
    return lambda p: np.minimum.reduce([part(p) for part in parts])


def intersection(*fields: Field) -> Field:
    """Return max(d1, d2, ...): the points that lie in every region.

    Parameters
    ----------
    *fields : Field
        Signed distances, or other functions that are negative inside.

    Returns
    -------
    Field
        The right sign everywhere. Of exact distances it is exact inside; outside, it is only a
        lower bound of the distance.

    Raises
    ------
    TypeError
        If one of `fields` cannot be called, or there is none.

    Examples
    --------
    >>> intersection(circle(), circle((1, 0)))(np.array([[0.5, 0.0]]))
    array([-0.5])
    """
    parts = _parts("intersection", fields)
    return lambda p: np.maximum.reduce([part(p) for part in parts])


def difference(region: Field, *holes: Field) -> Field:
    """Return max(d, -d1, -d2, ...): the points of a region that lie in none of the holes.

    Parameters
    ----------
    region : Field
        Negative inside the region.
    *holes : Field
        Negative inside what is taken away.

    Returns
    -------
    Field
        The right sign everywhere. Of exact distances it is exact inside; outside (in a hole,
        too) it is only a lower bound of the distance.

    Raises
    ------
    TypeError
        If an argument cannot be called, or there is no hole.

    Examples
    --------
    >>> difference(circle(), circle(radius=0.5))(np.array([[0.6, 0.0], [0.0, 0.0]]))
    array([-0.1,  0.5])
    """
    first, *rest = _parts("difference", (region, *holes), least=2)
    return intersection(first, *(complement(hole) for hole in rest))


def complement(field: Field) -> Field:
    """Return -d: inside and outside change places.

    Parameters
    ----------
    field : Field
        Negative inside.

    Returns
    -------
    Field
        As exact as `field`.

    Raises
    ------
    TypeError
        If `field` cannot be called.

    Examples
    --------
    >>> complement(circle())(np.array([[0.0, 0.0]]))
    array([1.])
    """
    part = as_field("field", field)
    return lambda p: -part(p)


def blend(a: Field, b: Field, width: float, operation: Callable[..., Field] | None = None) -> Field:
    """Return min(a, b) with its edge rounded off, or another operation smoothed so.

    Parameters
    ----------
    a, b : Field
        Signed distances, or other functions that are negative inside.
    width : float, length
        Where a and b differ by this much or more, nothing is changed.
    operation : function, optional
        `union`, `intersection` or `difference`; the union where none is given.

    Returns
    -------
    Field
        As smooth as a and b where these differ by less than `width`; once differentiable where
        they differ by just as much. It is the value of the sharp operation less
        at most width / 4 for the union, and plus at most as much for the others: fillets are
        added to a union, and edges taken off an intersection or a difference. Where neither a
        nor b rises more steeply than a distance, |grad| <= 1, nor does the blend, and so its
        size is at most the distance to its own boundary.

    Raises
    ------
    TypeError, ValueError
        If a field cannot be called, `width` is not positive, or `operation` is none of the three.

    Notes
    -----
    min(a, b) - width h**2 / 4 with h = max(1 - |a - b| / width, 0). Its gradient is a weighted
    mean of those of a and b, with the weights 1 - h/2 (of the lesser) and h/2.

    Examples
    --------
    >>> fd = blend(circle((-1, 0)), circle((1, 0)), width=0.4)
    >>> fd(np.array([[0.0, 0.0], [3.0, 0.0]]))
    array([-0.1,  1. ])
    """
    first, second = _parts("blend", (a, b))
    w = as_positive("width", width)

    def smooth_union(one: Field, other: Field) -> Field:
        def least(p: FloatArray) -> FloatArray:
            u, v = one(p), other(p)
            h = np.maximum(1 - np.abs(u - v) / w, 0)
            return np.asarray(np.minimum(u, v) - w / 4 * h**2)

        return least

    if operation in (None, union):
        return smooth_union(first, second)
    if operation not in (intersection, difference):
        raise ValueError(
            f"operation must be union, intersection or difference; got {operation!r}. Pass the "
            "function itself."
        )
    # Whatever lies in both lies outside neither: max(a, b) = -min(-a, -b).
    outside = second if operation is difference else complement(second)
    return complement(smooth_union(complement(first), outside))


def rotation(
    field: Field, angle: float, center: ArrayLike | None = None, axis: ArrayLike | None = None
) -> Field:
    """Return a field turned by an angle: d(R^-1 (x - center) + center).

    Parameters
    ----------
    field : Field
        What to turn, in the plane or in space.
    angle : float, radians
        Anticlockwise in the plane; in space as seen with `axis` pointing at you.
    center : array_like of shape (2,) or (3,), length, optional
        What stays where it is; the origin where none is given.
    axis : array_like of shape (3,), dimensionless, optional
        In space, the direction to turn about; the z-axis where none is given.

    Returns
    -------
    Field
        As exact as `field`.

    Raises
    ------
    TypeError, ValueError
        If `field` cannot be called, `angle` is not a number, or `axis` is zero. When it is
        evaluated: if the points lie on a line, or in the plane although there is an `axis`.

    Examples
    --------
    >>> tall = rotation(rectangle(((-2, -1), (2, 1))), np.pi / 2)
    >>> tall(np.array([[0.0, 3.0], [3.0, 0.0]]))
    array([1., 2.])
    """
    part, turn = as_field("field", field), _number("angle", angle)
    about = _direction("axis", (0.0, 0.0, 1.0) if axis is None else axis, dim=3)
    fixed = 0.0 if center is None else _vector("center", center)
    matrix = Rotation.from_rotvec(turn * about).as_matrix()

    def turned(p: FloatArray) -> FloatArray:
        dim = p.shape[-1]
        if dim not in (2, 3) or (dim == 2 and axis is not None):
            raise ValueError(
                f"rotation with axis={axis!r} got points of shape {p.shape}. It turns points "
                "(..., 3) about an axis, and points (..., 2) without one."
            )
        # The plane is z = 0: what the matrix does to x and y stands in its first two rows. Times
        # a row from the left, it turns back.
        return np.asarray(part((p - fixed) @ matrix[:dim, :dim] + fixed))

    return turned


def translation(field: Field, shift: ArrayLike) -> Field:
    """Return a field that is moved: d(x - shift).

    Parameters
    ----------
    field : Field
        What to move.
    shift : array_like of shape (dim,), length
        How far.

    Returns
    -------
    Field
        As exact as `field`.

    Raises
    ------
    TypeError, ValueError
        If `field` cannot be called, or `shift` is not one vector.

    Examples
    --------
    >>> translation(circle(), (3, 0))(np.array([[3.0, 0.0], [0.0, 0.0]]))
    array([-1.,  2.])
    """
    part, way = as_field("field", field), _vector("shift", shift)
    return lambda p: np.asarray(part(p - way))


def scaling(field: Field, factor: float, center: ArrayLike | None = None) -> Field:
    """Return a field enlarged: factor * d((x - center) / factor + center).

    Parameters
    ----------
    field : Field
        What to enlarge.
    factor : float, dimensionless
        By how much; below 1, it shrinks.
    center : array_like of shape (dim,), length, optional
        What stays where it is; the origin where none is given.

    Returns
    -------
    Field
        As exact as `field`: distances grow as the lengths do. (Enlarged along one axis alone, a
        distance would be none any more.)

    Raises
    ------
    TypeError, ValueError
        If `field` cannot be called, or `factor` is not one positive number.

    Examples
    --------
    >>> scaling(circle(), 2)(np.array([[0.0, 0.0], [5.0, 0.0]]))
    array([-2.,  3.])
    """
    part, times = as_field("field", field), as_positive("factor", factor)
    fixed = 0.0 if center is None else _vector("center", center)
    return lambda p: np.asarray(times * part((p - fixed) / times + fixed))


def _parts(name: str, fields: Sequence[Field], least: int = 1) -> list[Field]:
    if len(fields) < least:
        raise TypeError(f"{name} takes {least} or more fields; got {len(fields)}.")
    return [as_field(f"argument {number} of {name}", f) for number, f in enumerate(fields, 1)]


def _rings(vertices: ArrayLike, holes: Sequence[ArrayLike]) -> list[FloatArray]:
    """Return the rings with the region on their left: outer one anticlockwise, holes clockwise."""
    if len(holes) and np.ndim(holes[0]) == 1:
        raise ValueError("holes must be a list of rings; got one ring. Write holes=[ring].")
    named = {"vertices": vertices, **{f"holes[{k}]": hole for k, hole in enumerate(holes)}}
    return [oriented(name, as_points(name, ring, dim=2)) for name, ring in named.items()]


def _number(name: str, value: ArrayLike) -> float:
    number = as_numbers(name, value)
    if number.ndim:
        raise ValueError(f"{name} must be one number; got the shape {number.shape}.")
    return float(number)


def _vector(name: str, value: ArrayLike, dim: int | None = None) -> FloatArray:
    vector = as_numbers(name, value)
    if vector.ndim != 1 or not vector.size or dim not in (None, len(vector)):
        wanted = f"{dim}" if dim else "one for each axis"
        raise ValueError(f"{name} must be one vector, of length {wanted}; got {value!r}.")
    return vector


def _direction(name: str, value: ArrayLike, dim: int | None = None) -> FloatArray:
    vector = _vector(name, value, dim)
    length = np.linalg.norm(vector)
    if length == 0:
        raise ValueError(f"{name} must not be zero: it gives a direction; got {value!r}.")
    return np.asarray(vector / length)


def _beyond(q: FloatArray) -> FloatArray:
    """Return the distance from a box, given by how far beyond each pair of sides a point is."""
    outside = np.linalg.norm(np.maximum(q, 0), axis=-1)
    return np.asarray(outside + np.minimum(q.max(axis=-1), 0))


def _about_axis(center: ArrayLike, axis: ArrayLike) -> Callable[[FloatArray], FloatArray]:
    """Return the map from points of space to (distance from the axis, height along it)."""
    middle, up = _vector("center", center, dim=3), _direction("axis", axis, dim=3)

    def frame(p: FloatArray) -> FloatArray:
        offset = p - middle
        height = offset @ up
        across = np.linalg.norm(offset - height[..., None] * up, axis=-1)
        return np.stack((across, height), axis=-1)

    return frame


def _closest_on_ellipse(p: FloatArray, a: float, b: float) -> FloatArray:
    """Return the points of an ellipse closest to points of the first quadrant; a >= b."""
    x, y = a * p[..., 0], b * p[..., 1]
    focal = (a - b) * (a + b)
    # One of the two terms of Q alone is 1 here, so that Q >= 1, but on the longer axis.
    floor = 1e-30 * b**2  # below it, y is as good as 0
    s = np.maximum(np.maximum(y, x - focal), floor)
    between = s == floor
    for _ in range(_ELLIPSE_STEPS):
        u, v = x / (s + focal), y / s
        Q = u**2 + v**2
        # The Newton step of 1 / sqrt(Q) = 1, with Q' = -2 (u**2 / (s + focal) + v**2 / s).
        slope = u**2 / (s + focal) + v**2 / s
        step = np.where(Q > 1, Q * (np.sqrt(Q) - 1) / np.where(Q > 1, slope, 1), 0)
        s = s + step
        if (step <= 4 * np.finfo(float).eps * s).all():
            break
    # Between the centers of curvature, y = 0 has two closest points: take the upper one.
    v = np.where(between, np.sqrt(np.maximum(1 - u**2, 0)), v)
    length = np.hypot(u, v)
    return np.stack((a * u / length, b * v / length), axis=-1)
