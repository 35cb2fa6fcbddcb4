"""Makes level 1, "The Terrace": a temple terrace, five thousand grains, the beast, and the great scale below."""
import math

import architecture as arch
import beast
import landscape
import scale
from lib.gltf import Gltf
from lib.vec import look_rotation, quat, quat_mul, sub
from materials import Palette

STONE_FRICTION = 0.6
BRASS_FRICTION = 0.35

# The heap: 40 x 5 x 25 grains. Mass of all: 5000 * 4/3 pi r^3 * density * (1 + jitter^2) = 2.68 t.
GRAINS = {"count": [40, 5, 25], "radius": 0.05, "radius_jitter": 0.15, "seed": 7, "density": 1000.0,
          "friction": 0.55, "rolling_friction": 0.06, "restitution": 0.0, "color": [0.60, 0.205, 0.050],
          "color_jitter": 0.35, "roughness": 0.5}
HEAP_Z = 0.8
TARGET_KG = 1500.0

CREATURE = {"walk_speed_m_s": 2.2, "turn_speed_rad_s": 2.4, "plough_width_m": beast.WIDTH, "height_m": 0.9}
CREATURE_START = (0.0, 0.0, -2.4)

# Towards the sun: late afternoon, from the left of the player, a little from behind.
SUN_FROM = (0.76, 0.50, -0.42)
SKY = {"zenith": [0.10, 0.24, 0.58], "horizon": [0.56, 0.56, 0.56], "ground": [0.32, 0.23, 0.14]}

# The needle's turn: 0 kg at 135 degrees left of upright; the green third of the face begins at TARGET_KG.
NEEDLE_ZERO_DEG = -135.0


def _box(gltf, name, low, high, friction, more=None):
    """An invisible box collider from corner to corner."""
    centre = tuple(0.5 * (a + b) for a, b in zip(low, high))
    half = [round(0.5 * (b - a), 6) for a, b in zip(low, high)]
    extras = {"BoxCollider": {"half_extent": half, "friction": friction}}
    extras.update(more or {})
    return gltf.node(name, centre, extras=extras)


def _colliders(gltf):
    w, y = arch.HALF_WIDTH, arch.PARAPET_HEIGHT
    _box(gltf, "terrace_floor", (-arch.BODY_HALF_WIDTH, -arch.SLAB, arch.BODY_BACK_Z),
         (arch.BODY_HALF_WIDTH, 0.0, arch.EDGE_Z), STONE_FRICTION)
    thick = arch.PARAPET_THICKNESS + 0.1
    for s, name in ((1, "parapet_left"), (-1, "parapet_right")):
        x = sorted((s * w, s * (w + thick)))
        _box(gltf, name + "_box", (x[0], 0.0, arch.BACK_Z - thick), (x[1], y, arch.EDGE_Z - arch.PILLAR), STONE_FRICTION)
        x = sorted((s * w, s * (w + arch.PILLAR)))
        _box(gltf, name.replace("parapet", "pillar") + "_box", (x[0], 0.0, arch.EDGE_Z - arch.PILLAR),
             (x[1], arch.PILLAR_HEIGHT, arch.EDGE_Z), STONE_FRICTION)
    _box(gltf, "parapet_back_box", (-w - thick, 0.0, arch.BACK_Z - thick), (w + thick, arch.BACK_HEIGHT, arch.BACK_Z), STONE_FRICTION)
    for name, (centre, rotation, half) in scale.tray_boxes().items():
        gltf.node(name, centre, rotation, extras={
            "BoxCollider": {"half_extent": [round(h, 6) for h in half], "friction": BRASS_FRICTION},
            "LoadSensor": {}})
    gltf.node("ground_plane", (0.0, arch.GROUND_Y, 0.0), extras={"PlaneCollider": {"friction": 0.9}})


def _scenery(gltf, palette):
    no_shadow = {"CastsShadow": False}
    gltf.node("terrace_body", mesh=palette.mesh("terrace_body", arch.body()))
    gltf.node("terrace_edge", mesh=palette.mesh("terrace_edge", arch.edge()))
    gltf.node("parapet_left", mesh=palette.mesh("parapet_left", arch.side_parapet(1)))
    gltf.node("parapet_right", mesh=palette.mesh("parapet_right", arch.side_parapet(-1)))
    gltf.node("parapet_back", mesh=palette.mesh("parapet_back", arch.back_parapet()))
    pillar = palette.mesh("pillar", arch.pillar())
    for s, name in ((1, "pillar_left"), (-1, "pillar_right")):
        gltf.node(name, (s * (arch.HALF_WIDTH + 0.5 * arch.PILLAR), 0.0, arch.EDGE_Z - 0.5 * arch.PILLAR), mesh=pillar)
    column = palette.mesh("column", arch.column())
    broken = palette.mesh("broken_column", arch.column(2.3, whole=False))
    for k, z in enumerate((-3.6, -0.6, 2.4)):
        gltf.node("column_left_%d" % k, (6.2, 0.0, z), mesh=column)
        gltf.node("column_right_%d" % k, (-6.2, 0.0, z), quat((0, 1, 0), 70.0 * k), mesh=broken if k == 2 else column)
    gltf.node("lintel_left", (6.2, 4.825, -0.6), mesh=palette.mesh("lintel", {"pale_stone": arch.arch_lintel(7.0)}))
    gltf.node("lintel_right", (-6.2, 4.825, -2.1),
              mesh=palette.mesh("lintel_short", {"pale_stone": arch.arch_lintel(3.9)}))
    pot = palette.mesh("pot", arch.pot())
    for k, (x, z, size) in enumerate(((5.62, 0.7, 1.0), (5.75, 1.35, 0.8), (-5.6, 0.9, 1.1))):
        gltf.node("pot_%d" % k, (x, 0.0, z), quat((0, 1, 0), 50.0 * k), (size, size, size), mesh=pot)

    gltf.node("tray", mesh=palette.mesh("tray", scale.tray()),
              extras={"Scale": {"target_kg": TARGET_KG, "hold_s": 2.0}})
    gltf.node("scale_gate", mesh=palette.mesh("scale_gate", scale.gate()))
    gltf.node("scale_rods", mesh=palette.mesh("scale_rods", scale.rods()))
    dial_at = (0.0, scale.DIAL_Y, scale.GATE_Z)
    gltf.node("scale_dial", dial_at, mesh=palette.mesh("scale_dial", scale.dial()))
    gltf.node("scale_needle", (dial_at[0], dial_at[1], dial_at[2] - 0.335), quat((0, 0, 1), NEEDLE_ZERO_DEG),
              mesh=palette.mesh("scale_needle", scale.needle()), extras={"Needle": {
                  "turn_at_target_rad": round(math.pi, 6), "most_turn_rad": round(1.5 * math.pi, 6)}})

    for k, tile in enumerate(landscape.ground()):
        gltf.node("ground_%d" % k, mesh=palette.mesh("ground_%d" % k, tile), extras=no_shadow)
    gltf.node("ruins", mesh=palette.mesh("ruins", landscape.ruins()), extras=no_shadow)
    gltf.node("rocks", mesh=palette.mesh("rocks", landscape.rocks()), extras=no_shadow)
    sphinx = palette.mesh("sphinx", landscape.sphinx())
    for k in range(6):
        s, z = (1, -1)[k % 2], 16.0 + 13.0 * (k // 2)
        x = s * landscape.AVENUE_HALF_WIDTH
        gltf.node("sphinx_%d" % k, (x, landscape.ground_height(x, z), z), quat((0, 1, 0), 180.0 + 25.0 * s), mesh=sphinx,
                  extras=no_shadow)
    palms = [palette.mesh("palm_%d" % k, landscape.palm(300 + k, h)) for k, h in enumerate((5.2, 6.4))]
    for k, (x, z, turn) in enumerate(((11.5, 8.5, 20), (13.6, 10.0, 200), (-12.2, 11.5, 120), (15.0, 22.0, 300),
                                      (-16.5, 21.0, 60))):
        gltf.node("palm_%d" % k, (x, landscape.ground_height(x, z) - 0.05, z), quat((0, 1, 0), turn), mesh=palms[k % 2],
                  extras=no_shadow)


def make(images):
    """{output path below content: bytes}."""
    gltf = Gltf()
    palette = Palette(gltf, images)
    gltf.node("level", extras={"LevelRules": {"time_limit_s": 75.0}, "Sky": SKY})
    eye, target = (0.0, 3.4, -8.6), (0.0, 0.4, 0.8)
    gltf.node("camera", eye, look_rotation(sub(target, eye)), camera=gltf.camera("camera", math.radians(52.0), 0.1))
    gltf.node("sun", (12.0, 8.0, -6.0), look_rotation(tuple(-c for c in SUN_FROM)),
              light=gltf.sun("sun", (1.0, 0.76, 0.50), 3.9))
    gltf.node("beast", CREATURE_START, mesh=palette.mesh("beast", beast.build()), extras={"Creature": CREATURE})
    gltf.node("heap", (0.0, 0.30, HEAP_Z), extras={"GrainBlock": GRAINS})
    # Where the dunes rise the plane collider goes on flat: a grain that rolls so far is lost in the sand.
    reach, origin_z = landscape.FLAT_RADIUS, round(HEAP_Z)
    gltf.node("grain_field", extras={"GrainField": {
        "origin": [0.0, 0.0, float(origin_z)], "placed": True,
        "bounds_min": [-reach, arch.GROUND_Y - 1.0, -reach - origin_z], "bounds_max": [reach, 10.0, reach - origin_z]}})
    _colliders(gltf)
    _scenery(gltf, palette)
    return {"levels/level1.glb": gltf.glb()}
