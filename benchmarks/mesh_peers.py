"""Other mesh generators, each as a function of a case and a seed that returns p and t.

None stands for a generator that is not installed; a generator returns None for a case it cannot
do. Those that need a boundary rather than a distance get one: its curves divided into edges of
the wanted length (in space gmsh builds the solids itself).
"""

from itertools import pairwise

import numpy as np

from .measuring import peer

SHARP = np.radians(20)  # a boundary that turns by more has a corner there


def distmeshpy():
    """Return the published algorithm with its loops in C++; at its cap it ends in silence."""
    package = peer("distmeshpy")

    def mesh(case, seed):
        mesher = getattr(package, f"distmesh{case.dim}d")
        config = getattr(package.utils.config, f"default_{case.dim}d_config")()
        config.max_iter = case.cap
        sides = tuple(zip(*case.box(seed).tolist(), strict=True))  # it wants the box side by side
        fixed = case.pfix if len(case.pfix) else None
        # What it does not know it passes on to the fields: so the seed too.
        fields = (lambda p, **_: case.fd(p)), (lambda p, **_: case.edge(p))
        return mesher(*fields, case.h0, sides, fixed, config, seed=seed)

    return package and mesh


def seismic_mesh():
    """Return DistMesh upon CGAL in C++: 50 steps, and in space its removal of slivers.

    Its release 3.6 is older than NumPy 2, and fails with it but for two changed lines.
    """
    try:
        package = peer("SeismicMesh")
    except RuntimeError:  # mpi4py is there, and no MPI
        package = None

    def mesh(case, seed):
        box = tuple(case.box(seed).T.ravel().tolist())
        size = case.h0 if case.fh is None else case.fh
        fixed = case.pfix if len(case.pfix) else None
        options = {"h0": case.h0, "bbox": box, "seed": seed, "verbose": 0}
        p, t = package.generate_mesh(case.fd, size, pfix=fixed, **options)
        if case.dim == 3:
            p, t = package.sliver_removal(p, case.fd, size, **options)
        return p, t

    return package and mesh


def gmsh():
    """Return gmsh with its own choice of algorithms."""
    package = peer("gmsh")

    def mesh(case, seed):
        # interruptible: else it sets a signal handler
        package.initialize(interruptible=False)
        try:
            for name in ("General.Terminal", "Mesh.MeshSizeExtendFromBoundary"):
                package.option.setNumber(name, 0)
            package.option.setNumber("Mesh.RandomSeed", seed + 1)
            _ask_gmsh_for_sizes(package, case)
            if case.dim == 2:
                _outline_for_gmsh(package.model, case)
            elif not _solid_for_gmsh(package.model.occ, case.name):
                return None
            package.model.occ.synchronize()
            package.model.mesh.generate(case.dim)
            return _mesh_of_gmsh(package.model.mesh, case.dim)
        finally:
            package.finalize()

    return package and mesh


def _ask_gmsh_for_sizes(package, case):
    if case.fh is None:
        for name in ("Mesh.MeshSizeMin", "Mesh.MeshSizeMax"):
            package.option.setNumber(name, case.h0)
    else:
        package.model.mesh.setSizeCallback(
            lambda *asked: float(case.fh(np.array([asked[2 : 2 + case.dim]]))[0])
        )


def _outline_for_gmsh(model, case):
    loops = []
    for ring in case.rings:
        nodes = [model.occ.addPoint(x, y, 0) for x, y in divided(ring, case.edge)]
        ends = zip(nodes, [*nodes[1:], nodes[0]], strict=True)
        lines = [model.occ.addLine(a, b) for a, b in ends]
        loops.append((model.occ.addCurveLoop(lines), lines))
    model.occ.addPlaneSurface([loop for loop, _ in loops])
    model.occ.synchronize()
    for _, tag in model.getEntities(1):
        model.mesh.setTransfiniteCurve(tag, 2)  # each line is an edge


def _solid_for_gmsh(occ, name):
    if name.startswith("ball"):
        occ.addSphere(0, 0, 0, 1)
    elif name.startswith("cylinder with spherical hole"):
        tube, hole = occ.addCylinder(0, 0, -1, 0, 0, 2, 1), occ.addSphere(0, 0, 0, 0.5)
        occ.cut([(3, tube)], [(3, hole)])
    else:
        return False
    return True


def _mesh_of_gmsh(mesh, dim):
    tags, coordinates, _ = mesh.getNodes()
    _, corners = mesh.getElementsByType({2: 2, 3: 4}[dim])
    row = np.zeros(int(tags.max()) + 1, dtype=int)
    row[tags] = np.arange(len(tags))
    return coordinates.reshape(-1, 3)[:, :dim], row[corners].reshape(-1, dim + 1)


def triangle():
    """Return Shewchuk's Triangle as meshpy wraps it: Delaunay refinement, angles above 30."""
    package = peer("meshpy.triangle")

    def mesh(case, _):
        if not case.rings:
            return None
        rings = [divided(ring, case.edge) for ring in case.rings]
        starts = np.cumsum([0, *map(len, rings)])
        sides = [start + _closed(len(ring)) for start, ring in zip(starts, rings, strict=False)]
        info = package.MeshInfo()
        info.set_points(np.concatenate(rings).tolist())
        info.set_facets(np.concatenate(sides).tolist())
        info.set_holes([inside(ring).tolist() for ring in rings[1:]])
        if case.fh is None:
            found = package.build(info, max_volume=_area(case.h0), min_angle=30)
        else:

            def too_large(corners, area):
                center = np.mean([tuple(corner) for corner in corners], axis=0)
                return bool(area > _area(case.fh(center[None])[0]))

            found = package.build(info, refinement_func=too_large, min_angle=30)
        return np.array(found.points), np.array(found.elements)

    return package and mesh


def _area(edge):
    """Return the largest area to allow: the average that it makes is about a third smaller."""
    return 1.5 * np.sqrt(3) / 4 * edge**2


def _closed(n):
    return np.stack((np.arange(n), (np.arange(n) + 1) % n), axis=1)


def divided(ring, edge):
    """Return a closed curve divided into edges of about the wanted length, its corners kept."""
    sides = np.roll(ring, -1, axis=0) - ring
    angle = np.arctan2(sides[:, 1], sides[:, 0])
    turn = np.abs((angle - np.roll(angle, 1) + np.pi) % (2 * np.pi) - np.pi)
    corners = np.flatnonzero(turn > SHARP)
    if len(corners):
        ring = np.roll(ring, -corners[0], axis=0)
        ends = [*(corners - corners[0]), len(ring)]
    else:
        ends = [0, len(ring)]
    ring = np.concatenate((ring, ring[:1]))
    pieces = [_divide(ring[a : b + 1], edge) for a, b in pairwise(ends)]
    return np.concatenate(pieces)


def _divide(curve, edge, fine=50):
    """Return points along an open curve, one edge apart, without the last."""
    s = np.concatenate(([0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))))

    def at(length):
        return np.stack([np.interp(length, s, x) for x in curve.T], axis=1)

    samples = np.linspace(0, s[-1], 1 + fine * max(1, round(s[-1] / edge(curve).min())))
    density = 1 / edge(at((samples[1:] + samples[:-1]) / 2))
    edges = np.concatenate(([0], np.cumsum(density * np.diff(samples))))
    count = max(1, round(edges[-1]))
    return at(np.interp(np.arange(count) * edges[-1] / count, edges, samples))


def inside(ring):
    """Return a point inside a ring: next to the middle of its longest side."""
    after = np.roll(ring, -1, axis=0)
    area = (ring[:, 0] * after[:, 1] - ring[:, 1] * after[:, 0]).sum() / 2
    longest = np.linalg.norm(after - ring, axis=1).argmax()
    a, b = ring[longest], after[longest]
    return (a + b) / 2 + 1e-3 * np.sign(area) * np.array([a[1] - b[1], b[0] - a[0]])


def all_of_them():
    """Return every peer's function, or None, by its name."""
    return {
        "distmeshpy": distmeshpy(),
        "SeismicMesh": seismic_mesh(),
        "gmsh": gmsh(),
        "Triangle": triangle(),
    }
