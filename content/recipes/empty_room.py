"""Makes a room without grains, colliders or a creature: floor, two walls, boxes, a ball, sun, camera."""
import math

from lib import shapes
from lib.gltf import Gltf
from lib.mesh import Mesh
from lib.vec import look_rotation, quat, sub
from materials import Palette, metres


def make(images):
    """{output path below content: bytes}."""
    gltf = Gltf()
    palette = Palette(gltf, images)
    eye, target = (4.6, 3.4, 7.2), (0.0, 0.8, 0.0)
    gltf.node("camera", eye, look_rotation(sub(target, eye)), camera=gltf.camera("camera", math.radians(45.0), 0.1))
    gltf.node("sun", (4.0, 6.0, 3.0), look_rotation((-0.55, -0.75, -0.42)), light=gltf.sun("sun", (1.0, 0.9, 0.78), 3.0))

    def box_node(name, size, at, material, turn=0.0, bevel=0.03):
        box = shapes.box(size, bevel).uv(metres(material)).require_closed(name)
        gltf.node(name, at, quat((0, 1, 0), turn) if turn else None, mesh=palette.mesh(name, {material: box}))

    box_node("floor", (9.0, 0.3, 9.0), (0.0, -0.15, 0.0), "paving")
    box_node("wall_back", (9.0, 3.0, 0.4), (0.0, 1.5, -4.3), "ashlar")
    box_node("wall_left", (0.4, 3.0, 8.6), (-4.3, 1.5, 0.2), "ashlar")
    box_node("crate_large", (1.6, 1.6, 1.6), (-1.6, 0.8, -1.4), "stone", 20.0)
    box_node("crate_small", (0.9, 0.9, 0.9), (-1.4, 2.05, -1.3), "brass", 48.0)
    box_node("step", (2.4, 0.4, 1.2), (1.8, 0.2, -2.2), "pale_stone")
    ball = shapes.sphere(0.6, 24, 12, uv_metres=metres("shell")).require_closed("ball")
    gltf.node("ball", (1.5, 0.6, 0.8), mesh=palette.mesh("ball", {"shell": ball}))
    return {"levels/empty_room.glb": gltf.glb()}
