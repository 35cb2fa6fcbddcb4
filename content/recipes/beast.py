"""Makes the beast: a stout horned beetle with a shovel across its shoulders, facing +Z, feet on y = 0."""
import math

from lib import shapes
from lib.gltf import Gltf
from lib.mesh import Mesh
from lib.vec import add, lerp, mul, normalize, quat, random_between, smoothstep, sub
from materials import Palette, metres

# Metres: the shovel's width, and where the shell's rim and top lie.
WIDTH = 1.64
RIM_Y = 0.36
TOP_Y = 0.90
SHELL_HALF_WIDTH = 0.60
SHELL_BACK, SHELL_FRONT = -0.66, 0.42
# The groove between the wing cases (behind) and the neck shield (in front).
COLLAR_Z = 0.14


def _shell_point(z, angle, lift=0.0):
    """A point of the shell at z; angle 0 is the top, +-90 degrees the rim; lift moves it outwards, m."""
    t = (z - SHELL_BACK) / (SHELL_FRONT - SHELL_BACK)
    s = 2.0 * t - 1.0
    round_off = max(0.0, 1.0 - abs(s) ** 2.6) ** 0.5
    # Highest behind the middle, so that the back falls steeply and the front slopes to the neck.
    high = (TOP_Y - RIM_Y) * round_off * (1.0 - 0.10 * smoothstep(0.4, 1.0, t))
    wide = SHELL_HALF_WIDTH * round_off ** 0.8
    a = math.radians(angle)
    n = (math.sin(a) / max(wide, 0.05), math.cos(a) / max(high, 0.05), 0.25 * s / 0.5)
    p = (wide * math.sin(a), RIM_Y + high * max(0.0, math.cos(a)) ** 0.85, z)
    return add(p, mul(normalize(n), lift))


def _shell():
    """Wing cases with a seam, the collar groove and the neck shield; closed by a floor under the rim."""
    stations = [(SHELL_BACK + 0.004, 0.0), (-0.62, 0.0), (-0.54, 0.0), (-0.42, 0.0), (-0.28, 0.0), (-0.13, 0.0),
                (0.02, 0.0), (COLLAR_Z - 0.025, 0.0), (COLLAR_Z, -0.035), (COLLAR_Z + 0.025, 0.012), (0.25, 0.012),
                (0.34, 0.010), (0.40, 0.006), (SHELL_FRONT - 0.002, 0.0)]
    angles = [-90, -78, -64, -48, -32, -17, -5, 0, 5, 17, 32, 48, 64, 78, 90]
    rings = []
    for k, (z, lift) in enumerate(stations):
        ring = []
        for a in angles:
            seam = -0.034 if a == 0 and z < COLLAR_Z and 0 < k else 0.0
            # The rim flares out like a hat's brim.
            flare = 0.035 * smoothstep(70.0, 90.0, abs(a))
            ring.append(_shell_point(z, a, lift + seam + flare))
        under = [(p[0] * 0.86, p[1] - 0.05, p[2] * 0.97) for p in (ring[-1], ring[0])]
        rings.append((ring + under)[::-1])
    n = len(rings[0])

    def uvs(i, j):
        # Rows of pits run along z on the wing cases.
        return (j * 2.0 / (n - 3), -stations[i][0] / metres("shell"))
    return shapes.loft(rings, uvs=uvs, crease_deg=50.0).require_closed("shell")


def _shovel_section(x):
    """(top height, forward shift, thickness) of the shovel at x."""
    u = abs(x) / (WIDTH * 0.5)
    shoulder = math.exp(-((u - 0.62) / 0.26) ** 2)
    top = 0.47 + 0.18 * shoulder - 0.14 * smoothstep(0.82, 1.0, u)
    return top, 0.56 + 0.22 * smoothstep(0.35, 1.1, u), 0.050 + 0.030 * shoulder


def _shovel_profile(x, bottom):
    """Ring of one section, counter-clockwise seen from +X: up the front, down the back."""
    top, forward, thick = _shovel_section(x)
    front, back = [], []
    for t in (0.0, 0.2, 0.45, 0.7, 0.9, 1.0):
        y = bottom + (top - bottom) * t
        bow = 0.13 * (2.0 * t - 0.9) ** 2
        front.append((x, y, forward + bow))
        if t in (0.0, 0.45, 0.9):
            back.append((x, y, forward + bow * 0.6 - thick * (0.55 if t == 0.0 else 1.0)))
    return front[::-1] + back


def _shovel():
    xs = [WIDTH * (k / 18.0 - 0.5) for k in range(19)]
    rings = [_shovel_profile(x, 0.055) for x in xs]
    blade = shapes.loft(rings, False, False, lambda i, j: (j * 0.12, xs[i] / metres("shell")), crease_deg=45.0)
    # The ends are crescents: cut into convex pieces between the front and the back edge.
    last = len(blade.points) - 9
    for piece in ((0, 1, 8), (1, 2, 8), (2, 7, 8), (2, 3, 7), (3, 4, 6, 7), (4, 5, 6)):
        blade.face(piece[::-1])
        blade.face([last + k for k in piece])
    edge = []
    for x in xs:
        _, forward, _ = _shovel_section(x)
        z = forward + 0.105
        edge.append([(x, 0.012, z + 0.035), (x, 0.018, z - 0.05), (x, 0.10, z - 0.085), (x, 0.10, z)])
    brass = shapes.loft(edge, crease_deg=30.0)
    for f in brass.faces:
        f.uvs = None
    for k in (-2, -1, 1, 2):
        x = 0.19 + 0.30 * (abs(k) - 1)
        x = x if k > 0 else -x
        top, forward, _ = _shovel_section(x)
        stud = shapes.lathe([(0.052, 0.0), (0.044, 0.028), (0.0, 0.05)], 6, crease_deg=60.0)
        brass.extend(stud.rotated(quat((1, 0, 0), 90)).moved((x, 0.10 + (top - 0.1) * 0.52, forward + 0.0)))
    return blade.require_closed("shovel"), brass.require_closed("shovel edge")


def _leg(side, z, reach, spread):
    """Skin of one leg, and its brass anklet: out of the body, over a knee, down to a flared foot."""
    hip = (0.36 * side, 0.40, z * 0.9)
    knee = ((0.56 + reach) * side, 0.41, z + spread * 0.6)
    ankle = ((0.63 + reach) * side, 0.15, z + spread)
    foot = ((0.64 + reach) * side, 0.0, z + spread + 0.02)
    path = [hip, lerp(hip, knee, 0.65), knee, lerp(knee, ankle, 0.45), ankle, lerp(ankle, foot, 0.62), foot]
    leg = shapes.tube(path, [0.13, 0.135, 0.115, 0.105, 0.088, 0.118, 0.124], 7, uv_metres=metres("skin"),
                      crease_deg=75.0, up=(0.0, 0.0, 1.0))
    ring = shapes.lathe([(0.104, -0.03), (0.124, 0.0), (0.104, 0.03)], 8, crease_deg=70.0)
    tilt = normalize(sub(knee, ankle))
    angle = math.degrees(math.asin(tilt[0]))
    return leg, ring.rotated(quat((0, 0, 1), -angle)).moved(lerp(ankle, knee, 0.06))


def _head():
    """Skin of neck and head, horn, brow ring and eyes: (skin, shell, brass, ember)."""
    skin = shapes.tube([(0, 0.48, 0.26), (0, 0.59, 0.42), (0, 0.675, 0.55), (0, 0.71, 0.67), (0, 0.69, 0.78),
                        (0, 0.645, 0.85)], [0.21, 0.20, 0.185, 0.185, 0.125, 0.05], 12, uv_metres=metres("skin"),
                       crease_deg=75.0, squash=(1.12, 0.86))
    horn_path = [(0, 0.78, 0.66), (0, 0.88, 0.74), (0, 0.98, 0.77), (0, 1.07, 0.745), (0, 1.13, 0.70)]
    horn = shapes.tube(horn_path, [0.085, 0.062, 0.044, 0.026, 0.006], 8, uv_metres=0.4)
    for side in (-1, 1):
        horn.extend(shapes.tube([(0.10 * side, 0.68, 0.75), (0.15 * side, 0.665, 0.86), (0.11 * side, 0.65, 0.95)],
                                [0.045, 0.035, 0.006], 6, uv_metres=0.4))
    brass = shapes.lathe([(0.078, -0.03), (0.094, -0.016), (0.094, 0.016), (0.074, 0.03)], 10, crease_deg=50.0)
    brass.rotated(quat((1, 0, 0), 34)).moved((0, 0.835, 0.705))
    ember = Mesh()
    for side in (-1, 1):
        eye = shapes.sphere(0.042, 7, 4).moved((0.150 * side, 0.755, 0.715))
        ember.extend(eye)
    return skin, horn, brass, ember


def _belt(z_of_angle, lift, radius, angles, segments=5):
    """A brass rod laid on the shell along given angles."""
    path = [_shell_point(z_of_angle(a), a, lift) for a in angles]
    return shapes.tube(path, radius, segments, uv_metres=0.6, up=(0.0, 0.0, 1.0))


def build():
    """{material name: Mesh} of the whole beast."""
    parts = {"shell": _shell(), "skin": Mesh(), "brass": Mesh(), "ember": Mesh()}
    belly = shapes.sphere(0.5, 12, 6, uv_metres=metres("skin"))
    parts["skin"].extend(belly.scaled((0.94, 0.46, 1.02)).moved((0.0, 0.36, -0.10)))
    blade, edge = _shovel()
    parts["shell"].extend(blade)
    parts["brass"].extend(edge)
    for side in (-1, 1):
        for z, reach, spread in ((0.22, 0.02, 0.07), (-0.12, 0.06, -0.02), (-0.44, 0.0, -0.10)):
            leg, ring = _leg(side, z, reach, spread)
            parts["skin"].extend(leg)
            parts["brass"].extend(ring)
        # Arms that carry the shovel.
        parts["skin"].extend(shapes.tube([(0.34 * side, 0.42, 0.20), (0.42 * side, 0.42, 0.40),
                                          (0.44 * side, 0.36, 0.56)], [0.12, 0.10, 0.07], 7,
                                         uv_metres=metres("skin"), crease_deg=75.0))
    for target, extra in zip(("skin", "shell", "brass", "ember"), _head()):
        parts[target].extend(extra)
    angles = [-86, -66, -44, -22, 0, 22, 44, 66, 86]
    parts["brass"].extend(_belt(lambda a: COLLAR_Z, -0.012, 0.026, angles))
    parts["brass"].extend(_belt(lambda a: -0.50 + 0.06 * math.cos(math.radians(a)), 0.004, 0.016, angles))
    # A rod round the rim.
    brim = [_shell_point(z, side * 88.0, 0.03) for side, row in
            ((1, (-0.64, -0.58, -0.45, -0.25, 0.0, 0.22, 0.35, 0.41)), (-1, (0.41, 0.35, 0.22, 0.0, -0.25, -0.45, -0.58, -0.64)))
            for z in row]
    parts["brass"].extend(shapes.tube(brim + brim[:1], 0.02, 5, uv_metres=0.6))
    # The sun disc on the back, with a glowing stone.
    disc = shapes.lathe([(0.125, 0.0), (0.125, 0.03), (0.10, 0.045), (0.085, 0.03), (0.0, 0.03)], 14, crease_deg=40.0)
    gem = shapes.lathe([(0.07, 0.0), (0.058, 0.04), (0.0, 0.065)], 10, crease_deg=80.0)
    top = _shell_point(-0.16, 0.0, -0.025)
    tilt = quat((1, 0, 0), -4)
    parts["brass"].extend(disc.rotated(tilt).moved(top))
    parts["ember"].extend(gem.moved((0, 0.02, 0)).rotated(tilt).moved(top))
    return parts


def make(images):
    """{output path below content: bytes}."""
    gltf = Gltf()
    palette = Palette(gltf, images)
    gltf.node("beast", mesh=palette.mesh("beast", build()))
    return {"models/beast.glb": gltf.glb()}
