"""Makes "The Hopper": grains stream into a funnel, fill a bowl, run over its rim and are taken away."""
import math

from lib import shapes
from lib.gltf import Gltf
from lib.vec import look_rotation, quat, quat_mul, sub
from materials import Palette, metres

GRAINS = {"rate": 160.0, "radius": 0.035, "radius_jitter": 0.25, "density": 1200.0, "friction": 0.5,
          "rolling_friction": 0.04, "color": [0.60, 0.205, 0.050], "color_jitter": 0.35, "roughness": 0.5}
# The funnel: four plates around a square mouth, and the bowl: eight around a square floor.
MOUTH_HALF, FUNNEL_Y, FUNNEL_TILT_DEG, FUNNEL_LENGTH = 0.13, 1.75, 52.0, 0.9
BOWL_FLOOR_HALF, BOWL_TILT_DEG, BOWL_LENGTH = 0.42, 55.0, 0.62
THICK = 0.08


def make(images):
    """{output path below content: bytes}."""
    gltf = Gltf()
    palette = Palette(gltf, images)

    def slab(name, size, at, material, friction, rotation=None):
        """A box that is seen and touched."""
        box = shapes.box(size, 0.01).uv(metres(material)).require_closed(name)
        gltf.node(name, at, rotation, mesh=palette.mesh(name, {material: box}), extras={
            "BoxCollider": {"half_extent": [round(0.5 * s, 6) for s in size], "friction": friction}})

    def plates(name, count, inner_half, y, tilt_deg, length, width, material, friction):
        """Plates around the y axis whose inner faces rise outwards from (inner_half, y)."""
        tilt = math.radians(tilt_deg)
        # Middle of a plate of side +x: half its length up the slope, half its thickness behind it.
        out = inner_half + 0.5 * length * math.cos(tilt) + 0.5 * THICK * math.sin(tilt)
        up = y + 0.5 * length * math.sin(tilt) - 0.5 * THICK * math.cos(tilt)
        for k in range(count):
            turn = 360.0 * k / count
            at = (out * math.cos(math.radians(turn)), up, -out * math.sin(math.radians(turn)))
            slab("%s_%d" % (name, k), (length, THICK, width), at, material, friction,
                 quat_mul(quat((0, 1, 0), turn), quat((0, 0, 1), tilt_deg)))

    gltf.node("level", extras={"Sky": {"zenith": [0.10, 0.24, 0.58], "horizon": [0.56, 0.56, 0.56],
                                       "ground": [0.32, 0.23, 0.14]}})
    eye, target = (2.6, 2.6, 3.6), (0.0, 1.15, 0.0)
    gltf.node("camera", eye, look_rotation(sub(target, eye)), camera=gltf.camera("camera", math.radians(45.0), 0.1))
    gltf.node("sun", (4.0, 6.0, 3.0), look_rotation((-0.55, -0.75, -0.42)), light=gltf.sun("sun", (1.0, 0.85, 0.66), 3.6))
    gltf.node("grain_field", extras={"GrainField": {"placed": True, "bounds_min": [-9.0, -2.0, -9.0],
                                                    "bounds_max": [9.0, 9.0, 9.0]}})
    slab("floor", (7.0, 0.3, 7.0), (0.0, -0.15, 0.0), "paving", 0.7)
    plates("funnel", 4, MOUTH_HALF, FUNNEL_Y, FUNNEL_TILT_DEG, FUNNEL_LENGTH, 1.5, "brass", 0.3)
    slab("bowl_floor", (2 * BOWL_FLOOR_HALF + 0.3, THICK, 2 * BOWL_FLOOR_HALF + 0.3), (0.0, 0.36, 0.0), "stone", 0.6)
    plates("bowl", 8, BOWL_FLOOR_HALF, 0.4, BOWL_TILT_DEG, BOWL_LENGTH, 0.72, "stone", 0.6)
    gltf.node("hopper", (0.0, 2.95, 0.0), extras={"GrainEmitter": {
        **GRAINS, "mouth": 0.45, "velocity": [0.0, -1.5, 0.0], "spread": 0.3, "seed": 7}})
    # What has rolled off the bowl: taken away at the edge of the floor.
    gltf.node("drain", (0.0, -0.7, 0.0), extras={"GrainSink": {"half_extent": [8.0, 0.6, 8.0]}})
    return {"levels/hopper.glb": gltf.glb()}
