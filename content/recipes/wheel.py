"""Makes "The Wheel": a stream turns a paddle wheel on a hinge; its grains fall on a tray with loose boxes on a spring."""
import math

from lib import shapes
from lib.gltf import Gltf
from lib.vec import look_rotation, quat, sub
from materials import Palette, metres

GRAINS = {"rate": 110.0, "radius": 0.035, "radius_jitter": 0.2, "density": 1400.0, "friction": 0.5,
          "rolling_friction": 0.04, "color": [0.60, 0.205, 0.050], "color_jitter": 0.35, "roughness": 0.5}
AXLE_Y, PADDLES, PADDLE_LENGTH, PADDLE_WIDTH, HUB_RADIUS, THICK = 1.55, 6, 0.5, 0.5, 0.09, 0.04
TRAY_X, TRAY_Y, TRAY_HALF = 0.55, 0.5, 0.55


def make(images):
    """{output path below content: bytes}."""
    gltf = Gltf()
    palette = Palette(gltf, images)

    def slab(name, size, at, material, friction, extras=None):
        """A box that is seen and touched."""
        box = shapes.box(size, 0.01).uv(metres(material)).require_closed(name)
        gltf.node(name, at, mesh=palette.mesh(name, {material: box}), extras={
            "BoxCollider": {"half_extent": [round(0.5 * s, 6) for s in size], "friction": friction}, **(extras or {})})
