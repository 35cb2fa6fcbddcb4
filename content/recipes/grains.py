"""Makes the shapes of grains: a coffee bean, a pebble, a bolt; each about 1 long, for any scale."""
import math

from lib import shapes
from lib.gltf import Gltf
from lib.vec import mul, normalize
from materials import Palette


def bean():
    """{part: Mesh}: the bean along x, its flat side with the groove down."""
    length, width, height = 0.5, 0.34, 0.26
    stations = [-0.985, -0.88, -0.68, -0.42, -0.14, 0.14, 0.42, 0.68, 0.88, 0.985]
    # Across, from one lip of the groove round the back to the other: (side, up) in half widths, and
    # the groove's bottom, which is the last point.
    back = [(math.sin(math.radians(a)), math.cos(math.radians(a))) for a in (78, 50, 25, 0, -25, -50, -78)]
    section = [(0.13, -0.32), (0.55, -0.34), (0.90, -0.16)] + back + [(-0.90, -0.16), (-0.55, -0.34), (-0.13, -0.32)]
    rings = []
    for s in stations:
        round_off = math.sqrt(1.0 - s * s)
        bend = 0.06 * math.sin(2.2 * s)  # the groove is an S
        ring = [(s * length, u * height * round_off, v * width * round_off + (bend * round_off if abs(v) < 0.2 else 0.0))
                for v, u in section]
        ring.append((s * length, -0.14 * height * round_off, bend * round_off))
        rings.append(ring[::-1])
    whole = shapes.loft(rings, crease_deg=70.0).require_closed("bean")
    # The faces at the groove's bottom show the pale skin that is left there.
    bottom = {i * (len(section) + 1) for i in range(len(stations))}
    parts = {"bean": whole.copy(), "chaff": whole.copy()}
    for name, mesh in parts.items():
        for f in mesh.faces:
            f.drawn = (len(f.corners) == 4 and any(c in bottom for c in f.corners)) == (name == "chaff")
    return parts


def pebble():
    """A sphere pushed flat and dented by slow waves."""
    def push(p):
        d = normalize(p)
        wave = (0.09 * math.sin(2.3 * d[0] + 1.1 * d[1] + 0.4) + 0.07 * math.sin(2.9 * d[1] - 1.7 * d[2] + 1.9)
                + 0.05 * math.sin(4.1 * d[2] + 2.2 * d[0] + 2.7))
        q = mul(d, 0.5 * (0.9 + wave))
        return (q[0] * 1.05, q[1] * 0.66, q[2] * 0.84)
    mesh = shapes.sphere(0.5, 14, 9)
    for f in mesh.faces:
        f.uvs = None
    return mesh.mapped(push).crease(180.0).uv(0.8).require_closed("pebble")


def bolt():
    """A hexagon head on a shaft along y, with a collar and a chamfered end."""
    def ring(radius, y, hexagonal):
        out = []
        for k in range(12):
            a = 2.0 * math.pi * k / 12
            r = radius * (math.cos(math.pi / 6.0) if hexagonal and k % 2 else 1.0)
            out.append((r * math.sin(a), y, r * math.cos(a)))
        return out
    head, shaft = 0.30, 0.15
    rings = [ring(shaft * 0.75, -0.5, False), ring(shaft, -0.44, False)]
    for k in range(3):  # grooves of a coarse thread
        y = -0.40 + 0.14 * k
        rings += [ring(shaft, y, False), ring(shaft * 0.82, y + 0.035, False), ring(shaft, y + 0.07, False)]
    rings += [ring(shaft, 0.16, False), ring(head, 0.17, True), ring(head, 0.36, True), ring(head * 0.85, 0.40, False)]
    return shapes.loft(rings, crease_deg=35.0).require_closed("bolt")


def one(name, parts, images):
    gltf = Gltf()
    gltf.node(name, mesh=Palette(gltf, images).mesh(name, parts))
    return {"models/%s.glb" % name: gltf.glb()}


def make(images):
    """{output path below content: bytes}."""
    return {**one("coffee_bean", bean(), images), **one("pebble", {"pebble": pebble()}, images),
            **one("bolt", {"steel": bolt()}, images)}
