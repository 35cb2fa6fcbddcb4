"""Mesh: convex polygons over shared points, with smooth or flat shading, box or own UVs, and closedness checks."""
from .vec import add, clamp, cross, dot, length, mul, normalize, rotate, sub
import math

# Points lie on a grid of 2^-12 m (0.24 mm): exact in a 32-bit float, and welding needs no tolerance.
POSITION_GRID = 4096.0
NORMAL_GRID = 16384.0
UV_GRID = 4096.0


def snap(value, grid):
    return math.floor(value * grid + 0.5) / grid + 0.0


class Face:
    __slots__ = ("corners", "uvs", "crease_deg", "uv_scale", "uv_offset", "drawn")

    def __init__(self, corners, uvs, crease_deg, uv_scale, uv_offset):
        self.corners, self.uvs, self.crease_deg = corners, uvs, crease_deg
        self.uv_scale, self.uv_offset = uv_scale, uv_offset
        self.drawn = True


class Mesh:
    """Polygons, counter-clockwise seen from outside (the front side of glTF)."""

    def __init__(self):
        self.points = []
        self.faces = []

    def point(self, p):
        self.points.append(tuple(float(c) for c in p))
        return len(self.points) - 1

    def face(self, corners, uvs=None, crease_deg=40.0):
        """One convex polygon; without uvs it gets a box projection in metres when baked."""
        self.faces.append(Face(tuple(corners), tuple(uvs) if uvs else None, crease_deg, 1.0, (0.0, 0.0)))

    def extend(self, other):
        base = len(self.points)
        self.points.extend(other.points)
        for f in other.faces:
            g = Face(tuple(c + base for c in f.corners), f.uvs, f.crease_deg, f.uv_scale, f.uv_offset)
            g.drawn = f.drawn
            self.faces.append(g)
        return self

    def moved(self, by):
        self.points = [add(p, by) for p in self.points]
        return self

    def rotated(self, q):
        self.points = [rotate(q, p) for p in self.points]
        return self

    def scaled(self, s):
        """Scales by a factor or by one a axis; a mirroring scale also turns the faces round."""
        s = (s, s, s) if isinstance(s, (int, float)) else s
        self.points = [(p[0] * s[0], p[1] * s[1], p[2] * s[2]) for p in self.points]
        if s[0] * s[1] * s[2] < 0.0:
            self.flipped()
        return self

    def flipped(self):
        for f in self.faces:
            f.corners = f.corners[::-1]
            f.uvs = f.uvs[::-1] if f.uvs else None
        return self

    def mapped(self, fn):
        """Moves every point by fn(point) -> point."""
        self.points = [tuple(fn(p)) for p in self.points]
        return self

    def crease(self, degrees):
        """Edges that bend by less than this angle are shaded smooth."""
        for f in self.faces:
            f.crease_deg = degrees
        return self

    def uv(self, metres_a_repeat, offset=(0.0, 0.0)):
        """Size of one texture repeat for box-projected faces, and a shift in repeats."""
        for f in self.faces:
            f.uv_scale, f.uv_offset = 1.0 / metres_a_repeat, offset
        return self

    def copy(self):
        return Mesh().extend(self)

    def tiles(self, tile_of):
        """{tile: mesh of the faces with tile_of(centre) == tile}. What a tile does not draw still rounds its
        shading, so that no seam shows."""
        centres = []
        for f in self.faces:
            total = (0.0, 0.0, 0.0)
            for c in f.corners:
                total = add(total, self.points[c])
            centres.append(mul(total, 1.0 / len(f.corners)))
        of_face = [tile_of(c) for c in centres]
        tiles = {}
        for tile in sorted(set(of_face)):
            tiles[tile] = self.copy()
            for f, own in zip(tiles[tile].faces, of_face):
                f.drawn = own == tile
        return tiles

    def triangle_count(self):
        return sum(len(f.corners) - 2 for f in self.faces if f.drawn)

    def open_edges(self):
        """Directed edges without an opposite one, on welded points: 0 for a closed, oriented surface."""
        weld, ids = {}, []
        for p in self.points:
            ids.append(weld.setdefault(tuple(snap(c, POSITION_GRID) for c in p), len(weld)))
        edges = {}
        for f in self.faces:
            ring = [ids[c] for c in f.corners]
            for a, b in zip(ring, ring[1:] + ring[:1]):
                if a != b:
                    edges[(a, b)] = edges.get((a, b), 0) + 1
        return sum(max(0, n - edges.get((b, a), 0)) for (a, b), n in edges.items())

    def volume(self):
        """Signed volume in m^3: positive when the faces of a closed mesh look outwards."""
        total = 0.0
        for f in self.faces:
            a = self.points[f.corners[0]]
            for i in range(1, len(f.corners) - 1):
                total += dot(a, cross(self.points[f.corners[i]], self.points[f.corners[i + 1]]))
        return total / 6.0

    def require_closed(self, name):
        n = self.open_edges()
        if n:
            raise ValueError("%s: %d open edges" % (name, n))
        if self.volume() <= 0.0:
            raise ValueError("%s: faces look inwards" % name)
        return self


def _face_normal(points):
    """Newell's sum: twice the area times the unit normal, for any planar polygon."""
    n = (0.0, 0.0, 0.0)
    for a, b in zip(points, points[1:] + points[:1]):
        n = add(n, cross(a, b))
    return n


def _box_uv(p, normal, scale, offset):
    """Metres along the face's main plane, never mirrored: u to the right and v down, seen from outside."""
    ax, ay, az = abs(normal[0]), abs(normal[1]), abs(normal[2])
    # The bias keeps 45 degree bevels on the texture of the side, not flickering between two.
    if ay > ax * 1.02 and ay > az * 1.02:
        u, v = p[0], (p[2] if normal[1] > 0.0 else -p[2])
    elif ax > az:
        u, v = (-p[2] if normal[0] > 0.0 else p[2]), -p[1]
    else:
        u, v = (p[0] if normal[2] > 0.0 else -p[0]), -p[1]
    return (u * scale + offset[0], v * scale + offset[1])


def bake(mesh):
    """(positions, normals, uvs, indices): shaded, triangulated, welded vertices of a mesh.

    A corner's normal is the mean of the normals of the faces around its point that bend from its own
    face by less than the crease angle, weighted by area times corner angle, so that large flats stay
    flat and bevels become round.
    """
    points = [tuple(snap(c, POSITION_GRID) for c in p) for p in mesh.points]
    raw = [_face_normal([points[c] for c in f.corners]) for f in mesh.faces]
    unit = [normalize(n) for n in raw]
    around = {}
    for i, f in enumerate(mesh.faces):
        ring = [points[c] for c in f.corners]
        area = length(raw[i])
        for k, p in enumerate(ring):
            a, b = sub(ring[k - 1], p), sub(ring[(k + 1) % len(ring)], p)
            la, lb = length(a), length(b)
            if la == 0.0 or lb == 0.0 or area == 0.0:
                continue
            angle = math.acos(clamp(dot(a, b) / (la * lb), -1.0, 1.0))
            around.setdefault(p, []).append((i, area * angle))
    out, vertex_of, indices = [], {}, []
    for i, f in enumerate(mesh.faces):
        if unit[i] == (0.0, 0.0, 0.0) or not f.drawn:
            continue
        limit = math.cos(math.radians(f.crease_deg))
        corners = []
        for k, c in enumerate(f.corners):
            p = points[c]
            n = (0.0, 0.0, 0.0)
            for j, w in around.get(p, ()):
                if dot(unit[i], unit[j]) >= limit:
                    n = add(n, mul(unit[j], w))
            t = f.uvs[k] if f.uvs else _box_uv(p, unit[i], f.uv_scale, f.uv_offset)
            corners.append((p, normalize(n) if length(n) > 0.0 else unit[i], tuple(snap(x, UV_GRID) for x in t)))
        for k in range(1, len(corners) - 1):
            tri = (corners[0], corners[k], corners[k + 1])
            a, b, c = (t[0] for t in tri)
            flat = cross(sub(b, a), sub(c, a))
            if length(flat) == 0.0:
                continue
            flat = normalize(flat)
            for p, n, t in tri:
                # In a fold the mean can turn away from a triangle: such a corner is shaded flat.
                n = n if dot(n, flat) > 0.02 else flat
                key = (p, tuple(snap(x, NORMAL_GRID) for x in n), t)
                if key not in vertex_of:
                    vertex_of[key] = len(out)
                    out.append(key)
                indices.append(vertex_of[key])
    return [v[0] for v in out], [v[1] for v in out], [v[2] for v in out], indices
