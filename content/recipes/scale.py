"""Makes the great scale: a brass tray hung from a stone gate, with a dial and its needle above."""
import math

from architecture import EDGE_Z, GROUND_Y, SLAB, boxed
from lib import shapes
from lib.mesh import Mesh
from lib.vec import add, cross, lerp, mul, normalize, quat, quat_from_axes, sub
from materials import metres

# The tray's inside, metres. Its back rim lies under the overhang of the terrace's edge, closer to it
# than the smallest grain is wide, so that what leaves the edge falls in.
RIM_HALF_WIDTH = 4.75
FLOOR_HALF_WIDTH = 4.40
RIM_BACK_Z, RIM_FRONT_Z = EDGE_Z - 0.12, 6.75
FLOOR_BACK_Z, FLOOR_FRONT_Z = EDGE_Z + 0.10, 6.40
RIM_Y = -SLAB - 0.06
RIM_FRONT_Y = -0.10
FLOOR_Y = -1.68
SHEET = 0.07

GATE_Z = 5.3
GATE_X = 6.05
GATE_TOP_Y = 3.1
BEAM_Y = 2.5
DIAL_Y = 2.6
DIAL_RADIUS = 0.92
DIAL_FACE_Z = GATE_Z - 0.36


def _rim_y(z):
    """The rim climbs to the front, so that a throw cannot leave the tray."""
    t = (z - RIM_BACK_Z) / (RIM_FRONT_Z - RIM_BACK_Z)
    t = min(1.0, max(0.0, t))
    return RIM_Y + (RIM_FRONT_Y - RIM_Y) * t * t


def _side_x(y):
    """Where the plane of a side wall's inside is at height y."""
    return FLOOR_HALF_WIDTH + (RIM_HALF_WIDTH - FLOOR_HALF_WIDTH) * (y - FLOOR_Y) / (RIM_FRONT_Y - FLOOR_Y)


def _loop(grow, t, drop):
    """A rectangle with cut corners around the tray: t = 0 at the floor, 1 at the rim; grow widens it, m."""
    z0 = FLOOR_BACK_Z + (RIM_BACK_Z - FLOOR_BACK_Z) * t - grow
    z1 = FLOOR_FRONT_Z + (RIM_FRONT_Z - FLOOR_FRONT_Z) * t + grow
    c = 0.10 + max(0.0, grow)
    zs = [z1, z1 - c] + [z1 - c + (z0 + c - z1 + c) * k / 4.0 for k in (1, 2, 3)] + [z0 + c, z0]
    side = []
    for k, z in enumerate(zs):
        y = FLOOR_Y + (_rim_y(z) - FLOOR_Y) * t
        side.append((_side_x(y) + grow - (c if k in (0, len(zs) - 1) else 0.0), y + drop, z))
    return side + [(-x, y, z) for x, y, z in reversed(side)]


def tray():
    """One closed sheet: outside up to a rolled rim, inside down to the floor, with a band of enamel; ribs below."""
    rings = [_loop(SHEET, -0.05, -SHEET), _loop(SHEET, 0.5, 0.0), _loop(SHEET, 1.0, -0.08),
             _loop(SHEET + 0.05, 1.0, -0.05), _loop(SHEET + 0.05, 1.0, 0.01), _loop(0.5 * SHEET, 1.0, 0.035),
             _loop(0.0, 1.0, 0.0), _loop(0.0, 0.90, 0.0), _loop(0.0, 0.62, 0.0), _loop(0.0, 0.04, 0.0),
             _loop(-0.10, 0.0, 0.0)]
    m = boxed(shapes.loft(rings, crease_deg=35.0), "brass").require_closed("tray")
    n, first = len(rings[0]), len(rings) - 4
    enamel = Mesh()
    enamel.points = list(m.points)
    band = m.faces[first * n:(first + 1) * n]
    m.faces = m.faces[:first * n] + m.faces[(first + 1) * n:]
    along = [0.0]
    for a, b in zip(rings[first], rings[first][1:] + rings[first][:1]):
        along.append(along[-1] + math.hypot(b[0] - a[0], b[2] - a[2]))
    repeats = math.floor(along[-1] / 0.75 + 0.5)
    for j, f in enumerate(band):
        # The rings run counter-clockwise from above; seen from inside, that is to the left.
        u0, u1 = -along[j] / along[-1] * repeats, -along[j + 1] / along[-1] * repeats
        enamel.face(f.corners, [(u0, 0), (u1, 0), (u1, 1), (u0, 1)], 35.0)
    # What the rods hang from.
    for x in (-1, 1):
        for z in (4.75, 6.05):
            m.extend(shapes.box((0.16, 0.24, 0.2), 0.03, (x * (_side_x(_rim_y(z)) + 0.18), _rim_y(z) - 0.04, z),
                                metres("brass")))
    for x in (-3.0, 0.0, 3.0):
        m.extend(boxed(shapes.box((0.3, 0.22, 2.5), 0.05, (x, FLOOR_Y - SHEET - 0.1, 5.25)), "brass"))
    return {"brass": m, "frieze": enamel}


def tray_boxes():
    """{name: (centre, rotation, half extent)} of the colliders: floor and four leaning walls.

    Walls are 0.4 m thick, outwards, so that a grain cannot pass one in a step; they overlap at the
    corners and below the floor.
    """
    thick = 0.2
    boxes = {"tray_floor": ((0.0, FLOOR_Y - thick, 0.5 * (FLOOR_BACK_Z + FLOOR_FRONT_Z)), (0.0, 0.0, 0.0, 1.0),
                            (FLOOR_HALF_WIDTH + 0.1, thick, 0.5 * (FLOOR_FRONT_Z - FLOOR_BACK_Z) + 0.1))}

    def wall(name, low, high, inward, half_length):
        # Local y runs up the wall's inner face, local z looks inwards.
        up = normalize(sub(high, low))
        side = normalize(cross(up, inward))
        facing = cross(side, up)
        # A little below the floor, to close the joint.
        low = add(low, mul(up, -0.1))
        centre = add(lerp(low, high, 0.5), mul(facing, -thick))
        height = math.sqrt(sum((a - b) ** 2 for a, b in zip(low, high)))
        boxes[name] = (centre, quat_from_axes(side, up, facing), (half_length, 0.5 * height, thick))

    wall("tray_back", (0, FLOOR_Y, FLOOR_BACK_Z), (0, RIM_Y, RIM_BACK_Z), (0, 0, 1), RIM_HALF_WIDTH)
    wall("tray_front", (0, FLOOR_Y, FLOOR_FRONT_Z), (0, RIM_FRONT_Y, RIM_FRONT_Z), (0, 0, -1), RIM_HALF_WIDTH + 0.1)
    middle = 0.5 * (RIM_BACK_Z + RIM_FRONT_Z)
    half = 0.5 * (RIM_FRONT_Z - RIM_BACK_Z)
    for name, s in (("tray_left", 1), ("tray_right", -1)):
        wall(name, (s * FLOOR_HALF_WIDTH, FLOOR_Y, middle), (s * RIM_HALF_WIDTH, RIM_FRONT_Y, middle), (-s, 0, 0),
             half)
    return boxes


def _frustum(low, high, y0, y1, bevel, name):
    m = shapes.box((1.0, y1 - y0, 1.0), bevel / low, (0, 0.5 * (y0 + y1), 0))

    def taper(p):
        w = low + (high - low) * (p[1] - y0) / (y1 - y0)
        return (p[0] * w, p[1], p[2] * w)
    return boxed(m.mapped(taper), name)


def gate():
    """Two battered towers on plinths with painted heads, and the beam between them."""
    ashlar, pale, frieze, brass = Mesh(), Mesh(), Mesh(), Mesh()
    for x in (-GATE_X, GATE_X):
        at = (x, 0.0, GATE_Z)
        base = shapes.box((1.75, 0.55, 1.75), 0.06, (0, GROUND_Y + 0.25, 0))
        pale.extend(boxed(base, "pale_stone").moved(at))
        ashlar.extend(_frustum(1.32, 0.92, GROUND_Y + 0.5, GATE_TOP_Y - 0.7, 0.04, "ashlar").moved(at))
        band = shapes.lathe([(0.67, GATE_TOP_Y - 0.7), (0.65, GATE_TOP_Y - 0.25)], 4, repeats=4, v_scale=1.0,
                            turn_deg=45.0, crease_deg=10.0)
        frieze.extend(band.moved(at))
        cornice = shapes.lathe([(0.65, GATE_TOP_Y - 0.25), (0.68, GATE_TOP_Y - 0.12), (0.82, GATE_TOP_Y + 0.02),
                                (0.82, GATE_TOP_Y + 0.14)], 4, turn_deg=45.0, crease_deg=30.0)
        pale.extend(boxed(cornice, "pale_stone").moved(at))
        top = shapes.lathe([(0.34, GATE_TOP_Y + 0.14), (0.0, GATE_TOP_Y + 0.62)], 4, turn_deg=45.0, crease_deg=10.0)
        brass.extend(boxed(top, "brass").moved(at))
    span = 2.0 * (GATE_X - 0.2)
    brass.extend(boxed(shapes.box((span, 0.30, 0.26), 0.05, (0, BEAM_Y, GATE_Z)), "brass"))
    for x in (-3.4, -1.9, 1.9, 3.4):
        brass.extend(boxed(shapes.box((0.22, 0.40, 0.36), 0.05, (x, BEAM_Y, GATE_Z)), "brass"))
    return {"ashlar": ashlar, "pale_stone": pale, "frieze": frieze, "brass": brass}


def rods():
    """The rods from the beam's ends to the tray's four corners, with a hook block at each end of the beam."""
    m = Mesh()
    for s in (-1, 1):
        top = (s * (RIM_HALF_WIDTH + 0.17), BEAM_Y - 0.32, GATE_Z)
        m.extend(shapes.box((0.26, 0.44, 0.40), 0.06, (top[0], BEAM_Y - 0.05, GATE_Z), metres("brass")))
        knob = shapes.lathe([(0.0, -0.10), (0.09, -0.05), (0.09, 0.05), (0.0, 0.10)], 10, crease_deg=60.0)
        m.extend(knob.moved((top[0], BEAM_Y - 0.36, GATE_Z)))
        for z in (4.75, 6.05):
            low = (s * (_side_x(_rim_y(z)) + 0.18), _rim_y(z), z)
            m.extend(shapes.tube([top, low], 0.035, 6, uv_metres=metres("brass")))
            for t in (0.25, 0.5, 0.75):
                bead = shapes.lathe([(0.0, -0.07), (0.062, 0.0), (0.0, 0.07)], 6, crease_deg=120.0)
                m.extend(bead.moved(lerp(top, low, t)))
    return {"brass": m}


def dial():
    """The dial's case and face around the origin; the face looks along -Z, to the player."""
    r = DIAL_RADIUS
    case = shapes.lathe([(r * 0.55, -0.36), (r * 0.95, -0.30), (r + 0.10, -0.10), (r + 0.10, 0.30), (r + 0.02, 0.38),
                         (r - 0.02, 0.32)], 24, metres("brass"), crease_deg=40.0)
    case.rotated(quat((1, 0, 0), -90)).moved((0, 0, 0.0))
    face = Mesh()
    n = 24
    ring = [face.point((-r * math.sin(2 * math.pi * k / n), r * math.cos(2 * math.pi * k / n), -0.325)) for k in range(n)]
    middle = face.point((0, 0, -0.325))
    for k in range(n):
        a, b = 2 * math.pi * k / n, 2 * math.pi * (k + 1) / n
        # Seen from the front, +X is to the left; the texture's centre is the disc's.
        face.face([middle, ring[(k + 1) % n], ring[k]],
                  [(0.5, 0.5), (0.5 + 0.5 * math.sin(b), 0.5 - 0.5 * math.cos(b)),
                   (0.5 + 0.5 * math.sin(a), 0.5 - 0.5 * math.cos(a))])
    # A sun over the case.
    for k in range(-4, 5):
        a = math.radians(k * 19.0)
        ray = shapes.lathe([(0.075, 0.0), (0.0, 0.32 if k % 2 == 0 else 0.2)], 4, crease_deg=20.0)
        ray.scaled((1.0, 1.0, 0.6)).rotated(quat((0, 0, 1), -k * 19.0))
        case.extend(ray.moved(((r + 0.08) * math.sin(a), (r + 0.08) * math.cos(a), 0.0)))
    return {"brass": case.require_closed("dial case"), "dial": face}


def needle():
    """The needle around its pivot, pointing to +Y; a positive turn about +Z is clockwise to the player."""
    m = shapes.prism([(-0.045, -0.22), (-0.060, 0.0), (-0.010, 0.74), (0.010, 0.74), (0.060, 0.0), (0.045, -0.22)], 0.03)
    # The prism stands on its outline of (x, z): laid down, z becomes y and it is thick along -z.
    m.rotated(quat((1, 0, 0), -90))
    hub = shapes.lathe([(0.10, 0.0), (0.09, 0.05), (0.0, 0.07)], 12, crease_deg=50.0)
    return {"iron": m.require_closed("needle"), "brass": hub.rotated(quat((1, 0, 0), -90)).require_closed("hub")}
