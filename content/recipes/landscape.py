"""Makes the desert around the terrace: the ground with its dunes, rocks, palms, and ruins on the horizon."""
import math

from architecture import BODY_BACK_Z, BODY_FRONT_Z, BODY_HALF_WIDTH, GROUND_Y, boxed, quad
from lib import shapes
from lib.mesh import Mesh
from lib.vec import add, lerp, quat, random_between, smoothstep
from materials import metres

# Inside this radius the sand is flat, at GROUND_Y, as the plane collider is.
FLAT_RADIUS = 10.5
FAR_RADIUS = 190.0
# Where the temple gate stands, and the avenue of sphinxes that leads to it.
GATE_Z = 66.0
AVENUE_HALF_WIDTH = 6.4


def _wave(x, z, angle, wavelength, phase, bend):
    """A dune row: a long windward slope and a short lee one, bent so that rows are not parallel lines."""
    a = math.radians(angle)
    u = x * math.cos(a) + z * math.sin(a)
    v = -x * math.sin(a) + z * math.cos(a)
    t = u / wavelength + phase + bend * math.sin(v / wavelength * 1.7 + phase * 5.0)
    t -= math.floor(t)
    return smoothstep(0.0, 0.72, t) if t < 0.72 else 1.0 - smoothstep(0.72, 1.0, t)


def ground_height(x, z):
    r = math.hypot(x, z)
    grow = smoothstep(FLAT_RADIUS, 60.0, r)
    dunes = 5.0 * _wave(x, z, 72.0, 46.0, 0.31, 0.16) + 3.2 * _wave(x, z, 118.0, 27.0, 0.12, 0.20)
    near = smoothstep(FLAT_RADIUS, 20.0, r) * 0.9 * _wave(x, z, 100.0, 11.0, 0.2, 0.3)
    rim = 3.0 * smoothstep(80.0, FAR_RADIUS, r)
    # The avenue is kept clear of dunes.
    clear = (1.0 - smoothstep(8.0, 17.0, abs(x))) * smoothstep(0.0, 12.0, z) * (1.0 - smoothstep(66.0, 90.0, z))
    return GROUND_Y + (grow * dunes + near * (1.0 - 0.5 * grow)) * (1.0 - 0.8 * clear) + rim


def _body_radius(a):
    """From the origin to just inside the terrace's body, in the direction of angle a: nothing sees the ground there."""
    x, z = math.sin(a), math.cos(a)
    inset = 0.1
    across = (BODY_HALF_WIDTH - inset) / max(abs(x), 1e-9)
    along = (BODY_FRONT_Z - inset if z > 0.0 else -BODY_BACK_Z - inset) / max(abs(z), 1e-9)
    return min(across, along)


def ground():
    """An open sheet of rings around the terrace's body, finer nearby, in tiles of which a camera sees a few: tiles
    behind it are culled, and only those at the picture's border have triangles to clip."""
    radii = [0.0, FLAT_RADIUS]
    while radii[-1] < FAR_RADIUS:
        radii.append(radii[-1] * 1.22)
    segments = 42
    m = Mesh()
    rings = []
    for k, r in enumerate(radii):
        ring = []
        for j in range(segments):
            a = 2.0 * math.pi * (j + 0.5 * (k % 2)) / segments
            away = max(r, _body_radius(a))
            x, z = away * math.sin(a), away * math.cos(a)
            ring.append(m.point((x, ground_height(x, z), z)))
        rings.append(ring)
    for k in range(len(radii) - 1):
        inner, outer = rings[k], rings[k + 1]
        shift = k % 2
        for j in range(segments):
            n = (j + 1) % segments
            if shift == 0:
                m.face([inner[j], outer[j], inner[n]])
                m.face([inner[n], outer[j], outer[n]])
            else:
                m.face([inner[j], outer[j], outer[n]])
                m.face([inner[j], outer[n], inner[n]])
    def tile_of(centre):
        x, _, z = centre
        r = math.hypot(x, z)
        if r < 14.0:
            return 0, 0
        return (1 if r < 50.0 else 2), int((math.atan2(x, z) / (2.0 * math.pi) % 1.0) * 6)

    return [{"sand": tile} for tile in m.crease(180.0).uv(metres("sand")).tiles(tile_of).values()]


def rocks():
    """Fallen stones and a column drum in the sand on both sides of the scale."""
    m = Mesh()
    for k, (x, z, s) in enumerate(((-9.2, 7.4, 1.5), (-10.3, 8.9, 0.8), (9.6, 6.2, 1.2), (8.3, 10.0, 0.8))):
        rock = shapes.rock((s * 1.3, s * 0.8, s), 200 + k, 8, 5, 0.3)
        m.extend(rock.moved((x, ground_height(x, z) + 0.18 * s, z)).uv(metres("stone")))
    drum = shapes.lathe([(0.34, -0.8), (0.36, -0.7), (0.36, 0.7), (0.34, 0.8)], 14, metres("stone"), crease_deg=60.0)
    drum.rotated(quat((1, 0, 0.5), 90)).moved((8.6, GROUND_Y + 0.26, 8.4))
    return {"stone": m.require_closed("rocks").extend(drum)}


def palm(seed, height):
    """A date palm: a bent trunk of rings and a crown of folded fronds (their material is two-sided)."""
    lean = random_between(0.4, 1.0, seed)
    path, radii = [], []
    for k in range(6):
        t = k / 5.0
        path.append((lean * t * t, height * t - 0.2, 0.25 * lean * t * (1.0 - t)))
        radii.append(0.20 - 0.07 * t + (0.06 if k == 0 else 0.0))
    trunk = shapes.tube(path, radii, 6, uv_metres=metres("bark"), up=(0.0, 0.0, 1.0))
    top = path[-1]
    leaves = Mesh()
    count = 11
    for k in range(count):
        a = 2.0 * math.pi * (k + 0.35 * random_between(-1, 1, seed, k)) / count
        length = random_between(1.7, 2.3, seed, k, 1)
        rise = random_between(0.25, 0.85, seed, k, 2)
        dx, dz = math.cos(a), math.sin(a)
        rows = []
        for i in range(5):
            t = i / 4.0
            r = length * t
            y = rise * r - 0.62 * r * r * (0.6 + 0.4 * rise)
            w = 0.27 * math.sin(math.pi * (0.12 + 0.86 * t)) if i < 4 else 0.012
            spine = add(top, (dx * r, y, dz * r))
            rows.append((add(spine, (-dz * w, -0.4 * w, dx * w)), spine, add(spine, (dz * w, -0.4 * w, -dx * w))))
        for lower, upper in zip(rows, rows[1:]):
            for c in (0, 1):
                quad(leaves, lower[c], lower[c + 1], upper[c + 1], upper[c])
    return {"bark": trunk, "leaf": leaves.crease(70.0)}


def sphinx():
    """A lying sphinx on a plinth around the origin, looking along +Z, in flat planes: it is seen from afar."""
    m = shapes.box((1.5, 0.9, 3.4), 0.0, (0, 0.25, 0))
    body = shapes.box((0.95, 0.85, 2.1), 0.0, (0, 1.1, -0.35))
    body.mapped(lambda p: (p[0] * (1.0 if p[1] < 1.1 else 0.72), p[1] - (0.28 if p[1] > 1.1 and p[2] > 0.0 else 0.0), p[2]))
    m.extend(body)
    for s in (-1, 1):
        m.extend(shapes.box((0.26, 0.3, 1.3), 0.0, (0.32 * s, 0.83, 0.95)))
        m.extend(shapes.box((0.34, 0.75, 0.9), 0.0, (0.44 * s, 1.02, -0.95)))
    chest = shapes.box((0.8, 1.1, 0.6), 0.0, (0, 1.25, 0.5))
    m.extend(chest.mapped(lambda p: (p[0] * (1.0 if p[1] < 1.3 else 0.7), p[1], p[2])))
    # Headcloth: wide at the shoulders, and the face before it.
    cloth = shapes.box((1.0, 0.9, 0.55), 0.0, (0, 2.15, 0.5))
    m.extend(cloth.mapped(lambda p: (p[0] * (1.0 if p[1] < 2.0 else 0.62), p[1], p[2])))
    m.extend(shapes.box((0.42, 0.55, 0.3), 0.0, (0, 2.25, 0.85)))
    m.require_closed("sphinx").scaled(1.3)
    return {"granite": boxed(m, "granite").crease(20.0)}


def _tower(width, depth, height, lean):
    """A pylon: a battered block with a cavetto cornice, around the origin on y = 0."""
    m = shapes.box((width, height, depth), 0.0, (0, 0.5 * height, 0))
    m.mapped(lambda p: (p[0] * (1.0 - lean * p[1] / height / width), p[1], p[2] * (1.0 - lean * p[1] / height / depth)))
    w, d = width - lean + 0.5, depth - lean + 0.5
    m.extend(shapes.box((w, 0.5, d), 0.0, (0, height + 0.15, 0)))
    return m


def ruins():
    """Far off: a temple gate with obelisks before it, and two stepped pyramids."""
    m = Mesh()
    gate = Mesh()
    for s in (-1, 1):
        gate.extend(_tower(9.0, 4.0, 11.5 if s < 0 else 10.4, 1.6).moved((s * 6.6, 0, 0)))
        gate.extend(shapes.lathe([(0.9, 0.0), (0.62, 9.0), (0.0, 9.9)], 4, turn_deg=45.0, crease_deg=10.0)
                    .moved((s * 3.9, 0, -5.0)))
    gate.extend(shapes.box((4.6, 1.6, 3.0), 0.0, (0, 7.6, 0)))
    m.extend(gate.moved((0.0, ground_height(0.0, GATE_Z) - 1.0, GATE_Z)))
    for x, z, size, steps in ((-58.0, 150.0, 40.0, 7), (-92.0, 128.0, 22.0, 5)):
        y = ground_height(x, z) - 3.0
        for k in range(steps):
            w = size * (1.0 - 0.86 * k / steps)
            h = size * 0.62 / steps
            step = shapes.box((w, h + 1.0, w), 0.0, (0, h * (k + 0.5) - 0.5, 0))
            m.extend(step.rotated(quat((0, 1, 0), 24)).moved((x, y, z)))
    return {"ashlar": boxed(m, "ashlar").uv(6.0)}
