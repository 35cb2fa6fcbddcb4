"""Makes a scene for renderer checks: spheres over roughness and metal, one sphere a textured material, a checker plane."""
import math

from lib import shapes
from lib.gltf import Gltf
from lib.mesh import Mesh
from lib.vec import look_rotation, sub
from materials import Palette, metres

ROUGHNESS = (0.05, 0.25, 0.5, 0.75, 1.0)
METAL = (0.0, 0.5, 1.0)
TEXTURED = ("brass", "shell", "skin", "stone", "ember")


def make(images):
    """{output path below content: bytes}."""
    gltf = Gltf()
    palette = Palette(gltf, images)
    gltf.node("sky", extras={"Sky": {"zenith": [0.2, 0.35, 0.7], "horizon": [0.6, 0.65, 0.7], "ground": [0.2, 0.18, 0.16]}})
    eye, target = (0.0, 4.6, 6.2), (0.0, 0.2, -0.5)
    gltf.node("camera", eye, look_rotation(sub(target, eye)), camera=gltf.camera("camera", math.radians(38.0), 0.1))
    gltf.node("sun", (4.0, 6.0, 3.0), look_rotation((-0.6, -0.7, -0.5)), light=gltf.sun("sun", (1.0, 0.95, 0.9), 3.0))

    plane = Mesh()
    plane.face([plane.point(p) for p in ((-20, 0, 20), (20, 0, 20), (20, 0, -20), (-20, 0, -20))])
    checker = gltf.material("checker", roughness=0.9, base=("checker", images["checker"]))
    gltf.node("checker_plane", mesh=gltf.mesh("checker_plane", [(plane.uv(4.0), checker)]), extras={"CastsShadow": False})

    ball = shapes.sphere(0.42, 24, 12).require_closed("ball")
    for row, metal in enumerate(METAL):
        for column, rough in enumerate(ROUGHNESS):
            name = "ball_metal_%d_rough_%d" % (round(100 * metal), round(100 * rough))
            material = gltf.material(name, (0.83, 0.42, 0.20), metal, rough)
            gltf.node(name, (1.1 * (column - 2), 0.42, 1.1 * (1 - row)), mesh=gltf.mesh(name, [(ball, material)]))
    for column, material in enumerate(TEXTURED):
        textured = shapes.sphere(0.42, 24, 12, uv_metres=metres(material))
        name = "ball_" + material
        gltf.node(name, (1.1 * (column - 2), 0.42, -2.2), mesh=palette.mesh(name, {material: textured}))
    return {"levels/test_materials.glb": gltf.glb()}
