"""Makes "The Wheel": a stream turns a paddle wheel on a hinge; its grains fall on a tray on a spring, with loose boxes."""
import math

from lib import shapes
from lib.gltf import Gltf
from lib.mesh import Mesh
from lib.vec import look_rotation, quat, sub
from materials import Palette, metres

GRAINS = {"rate": 110.0, "radius": 0.035, "radius_jitter": 0.2, "density": 1400.0, "friction": 0.5,
          "rolling_friction": 0.04, "color": [0.60, 0.205, 0.050], "color_jitter": 0.35, "roughness": 0.5}
AXLE, PADDLES, PADDLE_LENGTH, PADDLE_WIDTH, THICK = (0.0, 1.6, 0.0), 8, 0.55, 0.5, 0.04
TRAY, TRAY_HALF = (0.5, 0.55, 0.0), 0.6


def make(images):
    """{output path below content: bytes}."""
    gltf = Gltf()
    palette = Palette(gltf, images)

    def slab(name, size, at, material, friction, extras=None):
        """A box that is seen and touched."""
        box = shapes.box(size, 0.01).uv(metres(material)).require_closed(name)
        gltf.node(name, at, mesh=palette.mesh(name, {material: box}), extras={
            "BoxCollider": {"half_extent": [round(0.5 * s, 6) for s in size], "friction": friction}, **(extras or {})})

    gltf.node("level", extras={"Sky": {"zenith": [0.10, 0.24, 0.58], "horizon": [0.56, 0.56, 0.56],
                                       "ground": [0.32, 0.23, 0.14]}})
    eye, target = (2.2, 2.3, 3.6), (0.15, 1.0, 0.0)
    gltf.node("camera", eye, look_rotation(sub(target, eye)), camera=gltf.camera("camera", math.radians(45.0), 0.1))
    gltf.node("sun", (4.0, 6.0, 3.0), look_rotation((-0.55, -0.75, -0.42)), light=gltf.sun("sun", (1.0, 0.85, 0.66), 3.6))
    gltf.node("grain_field", extras={"GrainField": {"placed": True, "bounds_min": [-9.0, -2.0, -9.0],
                                                    "bounds_max": [9.0, 9.0, 9.0]}})
    slab("floor", (7.0, 0.3, 7.0), (0.0, -0.15, 0.0), "paving", 0.7)

    # Paddles that cross at the axle: one solid mesh of boxes, each closed.
    wheel = Mesh()
    for k in range(PADDLES):
        paddle = shapes.box((PADDLE_LENGTH - 0.07, THICK, PADDLE_WIDTH), 0.0,
                            center=(0.07 + 0.5 * (PADDLE_LENGTH - 0.07), 0.0, 0.0))
        wheel.extend(paddle.rotated(quat((0, 0, 1), 360.0 * k / PADDLES)))
    wheel.uv(metres("brass")).require_closed("wheel")
    gltf.node("wheel", AXLE, mesh=palette.mesh("wheel", {"brass": wheel}), extras={
        "MeshCollider": {"solid": True, "friction": 0.4}, "RigidBody": {"density": 700.0, "damping": 0.05},
        "BodyHinge": {"axis": [0.0, 0.0, 1.0], "resistance": 0.6}})
    gltf.node("hopper", (0.36, 2.75, 0.0), extras={"GrainEmitter": {
        **GRAINS, "mouth": 0.1, "velocity": [0.0, -1.5, 0.0], "spread": 0.05, "seed": 7}})

    # A plate on a spring, the loose boxes on it; what runs over its edge falls on the floor.
    slab("scale", (2 * TRAY_HALF, 0.08, 2 * TRAY_HALF), TRAY, "stone", 0.7, {
        "RigidBody": {"density": 300.0}, "BodySlider": {"stiffness": 6000.0, "resistance": 250.0, "low": -0.45, "high": 0.1}})
    for k, (x, z) in enumerate(((-0.35, 0.3), (0.3, 0.35), (0.3, -0.35))):
        slab("box_%d" % k, (0.2, 0.2, 0.2), (TRAY[0] + x, TRAY[1] + 0.15, TRAY[2] + z), "brass", 0.5,
             {"RigidBody": {"density": 400.0}})
    gltf.node("drain", (0.0, -0.7, 0.0), extras={"GrainSink": {"half_extent": [8.0, 0.6, 8.0]}})
    return {"levels/wheel.glb": gltf.glb()}
