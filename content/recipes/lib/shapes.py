"""Solids to build with: bevelled boxes, lathes, tubes, lofts, patches and spheres; all closed unless said otherwise."""
import math

from .mesh import Mesh
from .vec import add, cross, dot, length, mul, normalize, sub


def box(size, bevel=0.0, center=(0.0, 0.0, 0.0), uv_scale=1.0, uv_offset=(0.0, 0.0)):
    """A box of the full sizes given; bevel is the width cut off each edge (44 triangles instead of 12)."""
    hx, hy, hz = (s * 0.5 for s in size)
    m = Mesh()
    signs = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    quads = {0: ((0, 4, 7, 3), (1, 2, 6, 5)), 1: ((0, 1, 5, 4), (3, 7, 6, 2)), 2: ((0, 3, 2, 1), (4, 5, 6, 7))}
    ids = {}
    for c, s in enumerate(signs):
        for axis in range(3):
            cut = [bevel if a != axis else 0.0 for a in range(3)]
            p = (s[0] * (hx - cut[0]), s[1] * (hy - cut[1]), s[2] * (hz - cut[2]))
            if bevel > 0.0 or axis == 0:
                ids[(c, axis)] = m.point(add(p, center))
            else:
                ids[(c, axis)] = ids[(c, 0)]
    for axis, pair in quads.items():
        for ring in pair:
            m.face([ids[(c, axis)] for c in ring])
    if bevel > 0.0:
        def outward(ring):
            pts = [m.points[i] for i in ring]
            mid = mul(tuple(map(sum, zip(*pts))), 1.0 / len(pts))
            n = cross(sub(pts[1], pts[0]), sub(pts[2], pts[0]))
            return ring if dot(n, sub(mid, center)) > 0.0 else ring[::-1]
        for a in range(8):
            for b in range(a + 1, 8):
                differ = [k for k in range(3) if signs[a][k] != signs[b][k]]
                if len(differ) == 1:
                    p, q = [k for k in range(3) if k != differ[0]]
                    m.face(outward([ids[(a, p)], ids[(b, p)], ids[(b, q)], ids[(a, q)]]))
            m.face(outward([ids[(a, k)] for k in range(3)]))
    return m.crease(70.0 if bevel > 0.0 else 10.0).uv(uv_scale, uv_offset)


def loft(rings, cap_start=True, cap_end=True, uvs=None, closed=True, crease_deg=40.0):
    """Skin over rings of equally many points, counter-clockwise seen from the end they grow towards.

    uvs(i, j) gives the texture coordinate of point j of ring i (j runs to n inclusive on closed rings).
    """
    m = Mesh()
    n = len(rings[0])
    ids = [[m.point(p) for p in ring] for ring in rings]
    for i in range(len(rings) - 1):
        for j in range(n if closed else n - 1):
            k = (j + 1) % n
            uv = [uvs(i, j), uvs(i, j + 1), uvs(i + 1, j + 1), uvs(i + 1, j)] if uvs else None
            m.face([ids[i][j], ids[i][k], ids[i + 1][k], ids[i + 1][j]], uv)
    if cap_start:
        m.face(ids[0][::-1])
    if cap_end:
        m.face(ids[-1])
    return m.crease(crease_deg)


def lathe(profile, segments, uv_metres=1.0, crease_deg=40.0, repeats=None, turn_deg=0.0, v_scale=None):
    """Turns a profile of (radius, y), bottom to top, about +Y; radius 0 at an end makes a pole.

    The texture goes `repeats` whole times round (by default the circumference over uv_metres), and
    v runs with the profile's arc length over uv_metres (or to v_scale repeats in all).
    """
    m = Mesh()
    top_radius = max(r for r, _ in profile)
    if repeats is None:
        repeats = max(1, int(2.0 * math.pi * top_radius / uv_metres + 0.5))
    arc = [0.0]
    for (r0, y0), (r1, y1) in zip(profile, profile[1:]):
        arc.append(arc[-1] + math.hypot(r1 - r0, y1 - y0))
    scale = v_scale / arc[-1] if v_scale else 1.0 / uv_metres
    turn = math.radians(turn_deg)
    ids = []
    for r, y in profile:
        if r == 0.0:
            ids.append([m.point((0.0, y, 0.0))] * segments)
        else:
            # Angles run so that counter-clockwise rings, seen from +Y, are in order.
            ids.append([m.point((r * math.sin(turn + 2.0 * math.pi * j / segments), y,
                                 r * math.cos(turn + 2.0 * math.pi * j / segments))) for j in range(segments)])
    for i in range(len(profile) - 1):
        for j in range(segments):
            k = (j + 1) % segments
            u0, u1 = repeats * j / segments, repeats * (j + 1) / segments
            v0, v1 = -arc[i] * scale, -arc[i + 1] * scale
            corners = [ids[i][j], ids[i][k], ids[i + 1][k], ids[i + 1][j]]
            uv = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)]
            if profile[i][0] == 0.0:
                corners, uv = corners[1:], [(0.5 * (u0 + u1), v0)] + uv[2:]
                corners = [ids[i][j], ids[i + 1][k], ids[i + 1][j]]
            elif profile[i + 1][0] == 0.0:
                corners, uv = corners[:2] + [ids[i + 1][j]], uv[:2] + [(0.5 * (u0 + u1), v1)]
            m.face(corners, uv)
    if profile[0][0] > 0.0:
        m.face(ids[0][::-1])
    if profile[-1][0] > 0.0:
        m.face(ids[-1])
    return m.crease(crease_deg)


def tube(path, radii, segments, uv_metres=1.0, crease_deg=60.0, squash=(1.0, 1.0), up=(0.0, 1.0, 0.0)):
    """A tube along a path, one radius a point; the frame is carried along so that it does not twist."""
    if isinstance(radii, (int, float)):
        radii = [radii] * len(path)
    rings, arc = [], [0.0]
    side = None
    for i, p in enumerate(path):
        a, b = path[max(0, i - 1)], path[min(len(path) - 1, i + 1)]
        t = normalize(sub(b, a))
        if side is None:
            side = cross(up, t)
            side = normalize(side) if length(side) > 1e-3 else normalize(cross((1.0, 0.0, 0.0), t))
        side = normalize(sub(side, mul(t, dot(side, t))))
        other = cross(t, side)
        ring = []
        for j in range(segments):
            w = 2.0 * math.pi * j / segments
            ring.append(add(p, add(mul(side, math.cos(w) * radii[i] * squash[0]),
                                   mul(other, math.sin(w) * radii[i] * squash[1]))))
        rings.append(ring)
        if i:
            arc.append(arc[-1] + length(sub(p, path[i - 1])))
    repeats = max(1, int(2.0 * math.pi * max(radii) / uv_metres + 0.5))
    return loft(rings, uvs=lambda i, j: (repeats * j / segments, -arc[i] / uv_metres), crease_deg=crease_deg)


def patch(fn, nu, nv, crease_deg=60.0, uv_repeats=(1.0, 1.0)):
    """An open sheet of points fn(u, v), u and v in [0, 1]; front side where du x dv looks."""
    m = Mesh()
    ids = [[m.point(fn(i / nu, j / nv)) for i in range(nu + 1)] for j in range(nv + 1)]
    for j in range(nv):
        for i in range(nu):
            corners = [ids[j][i], ids[j][i + 1], ids[j + 1][i + 1], ids[j + 1][i]]
            uv = [((i + a) / nu * uv_repeats[0], -(j + b) / nv * uv_repeats[1]) for a, b in
                  ((0, 0), (1, 0), (1, 1), (0, 1))]
            m.face(corners, uv)
    return m.crease(crease_deg)


def sphere(radius, segments=16, rings=8, **lathe_options):
    profile = []
    for i in range(rings + 1):
        w = math.pi * i / rings
        profile.append((0.0 if i in (0, rings) else radius * math.sin(w), -radius * math.cos(w)))
    return lathe(profile, segments, crease_deg=180.0, **lathe_options)


def capsule(a, b, radius, segments=12, cap_rings=3):
    """A round-ended tube from a to b."""
    path, radii = [], []
    axis = normalize(sub(b, a))
    for i in range(cap_rings + 1):
        w = 0.5 * math.pi * (i / cap_rings * 0.92 + 0.08)
        path.append(add(a, mul(axis, -radius * math.cos(w))))
        radii.append(radius * math.sin(w))
    back = [(add(b, mul(axis, dot(sub(a, p), axis))), r) for p, r in zip(path, radii)]
    path += [p for p, _ in reversed(back)]
    radii += [r for _, r in reversed(back)]
    return tube(path, radii, segments, uv_metres=max(0.05, 2.0 * math.pi * radius), crease_deg=80.0)


def prism(outline, height):
    """An outline of (x, z), counter-clockwise seen from +Y, raised from y = 0 to height."""
    bottom = [(x, 0.0, z) for x, z in outline]
    top = [(x, height, z) for x, z in outline]
    return loft([bottom, top], crease_deg=20.0)


def rock(size, seed, segments=10, rings=6, roughness=0.25):
    """A boulder: a sphere with radii pushed in and out, flattened to size."""
    from .vec import random01
    m = sphere(0.5, segments, rings)
    ids = {}

    def push(p):
        key = tuple(int(c * 4096.0 + (0.5 if c >= 0.0 else -0.5)) for c in p)
        k = ids.setdefault(key, len(ids))
        s = 1.0 - roughness * random01(seed, k)
        return (p[0] * s * size[0], p[1] * s * size[1], p[2] * s * size[2])

    for f in m.faces:
        f.uvs = None
    return m.mapped(push).crease(35.0)
