"""Makes the stone parts of the terrace: body, paving, edge, parapets with cap stones, pillars, columns, pots."""
import math

from lib import shapes
from lib.mesh import Mesh
from lib.vec import quat, random_between
from materials import metres

# The terrace, metres: y = 0 is its floor; grains are pushed over the edge at z = EDGE_Z.
HALF_WIDTH = 4.5  # between the parapets' inner faces
BACK_Z = -4.0     # the back parapet's inner face
EDGE_Z = 4.0
SLAB = 0.36       # thickness of the edge stones, which overhang the body
BODY_FRONT_Z = 3.4
BODY_BACK_Z = -4.9
BODY_HALF_WIDTH = 7.2
GROUND_Y = -3.0
PARAPET_HEIGHT = 0.8
BACK_HEIGHT = 0.6  # of the back parapet, lower so that the beast is seen over it
PARAPET_THICKNESS = 0.5
PILLAR = 0.9      # side of the end pillars
PILLAR_HEIGHT = 1.25


def quad(m, a, b, c, d):
    m.face([m.point(p) for p in (a, b, c, d)])


def boxed(mesh, name, offset=(0.0, 0.0)):
    """Drops a mesh's own texture coordinates for a box projection at the material's texture size."""
    for f in mesh.faces:
        f.uvs = None
    return mesh.uv(metres(name), offset)


def body():
    """The block that carries the terrace: paved top, battered ashlar sides, a plinth at the ground."""
    x0, x1, z0, z1, y = -BODY_HALF_WIDTH, BODY_HALF_WIDTH, BODY_BACK_Z, BODY_FRONT_Z, GROUND_Y - 0.3
    lean = 0.30
    top = [(x0, 0.0, z1), (x1, 0.0, z1), (x1, 0.0, z0), (x0, 0.0, z0)]
    foot = [(x0 - lean, y, z1), (x1 + lean, y, z1), (x1 + lean, y, z0 - lean), (x0 - lean, y, z0 - lean)]
    paving, ashlar = Mesh(), Mesh()
    quad(paving, *top)
    for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
        quad(ashlar, foot[a], foot[b], top[b], top[a])
    plinth = Mesh()
    plinth.extend(shapes.box((0.5, 0.7, z1 - z0 + 1.0), 0.06, (x0 - 0.32, GROUND_Y + 0.2, 0.5 * (z0 + z1) - 0.3)))
    plinth.extend(shapes.box((0.5, 0.7, z1 - z0 + 1.0), 0.06, (x1 + 0.32, GROUND_Y + 0.2, 0.5 * (z0 + z1) - 0.3)))
    plinth.extend(shapes.box((x1 - x0 + 1.1, 0.7, 0.5), 0.06, (0.0, GROUND_Y + 0.2, z0 - 0.45)))
    return {"paving": paving.uv(metres("paving")), "ashlar": boxed(ashlar, "ashlar"),
            "stone": boxed(plinth, "stone")}


def edge():
    """The row of edge stones that overhang the tray; their tops are the floor, to a bevel."""
    m = Mesh()
    inner, outer = BODY_FRONT_Z, EDGE_Z
    x = -BODY_HALF_WIDTH
    k = 0
    while x < BODY_HALF_WIDTH - 0.01:
        width = min(random_between(1.5, 2.1, 5, k), BODY_HALF_WIDTH - x)
        if BODY_HALF_WIDTH - x - width < 0.8:
            width = BODY_HALF_WIDTH - x
        stone = shapes.box((width - 0.012, SLAB, outer - inner), 0.035,
                           (x + width * 0.5, -SLAB * 0.5, 0.5 * (inner + outer)))
        m.extend(stone.uv(metres("pale_stone"), (random_between(0, 1, 5, k, 1), random_between(0, 1, 5, k, 2))))
        x += width
        k += 1
    return {"pale_stone": m.require_closed("edge")}


def _wall(length, height, seed):
    """A parapet along x, its inner face at z = 0 looking to +z, standing on y = 0: (ashlar, frieze, caps)."""
    wall_height = height - 0.2
    t = PARAPET_THICKNESS
    ashlar, frieze, caps = Mesh(), Mesh(), Mesh()
    h = 0.5 * length
    band = 0.08, wall_height - 0.02
    quad(ashlar, (-h, 0, -t), (-h, 0, 0), (-h, wall_height, 0), (-h, wall_height, -t))
    quad(ashlar, (h, 0, 0), (h, 0, -t), (h, wall_height, -t), (h, wall_height, 0))
    quad(ashlar, (h, 0, -t), (-h, 0, -t), (-h, wall_height, -t), (h, wall_height, -t))
    quad(ashlar, (-h, 0, 0), (h, 0, 0), (h, band[0], 0), (-h, band[0], 0))
    quad(ashlar, (-h, band[1], 0), (h, band[1], 0), (h, wall_height, 0), (-h, wall_height, 0))
    quad(ashlar, (-h, wall_height, 0), (h, wall_height, 0), (h, wall_height, -t), (-h, wall_height, -t))
    repeats = int(length / (1.9 * (band[1] - band[0])) + 0.5)
    ids = [frieze.point(p) for p in ((-h, band[0], 0), (h, band[0], 0), (h, band[1], 0), (-h, band[1], 0))]
    frieze.face(ids, [(0, 1), (repeats, 1), (repeats, 0), (0, 0)])
    x, k = -h, 0
    while x < h - 0.01:
        width = min(random_between(1.0, 1.7, seed, k), h - x)
        if h - x - width < 0.6:
            width = h - x
        cap = shapes.box((width - 0.015, 0.2, t + 0.10), 0.04)
        cap.rotated(quat((0, 1, 0), random_between(-0.8, 0.8, seed, k, 3)))
        # The inner face stays on or behind the collider's, so that no grain sinks into a cap stone.
        cap.moved((x + 0.5 * width, wall_height + 0.1, -0.5 * (t + 0.10) + random_between(-0.02, 0.0, seed, k, 4)))
        caps.extend(cap.uv(metres("pale_stone"), (random_between(0, 1, seed, k, 1), random_between(0, 1, seed, k, 2))))
        x += width
        k += 1
    return {"ashlar": boxed(ashlar, "ashlar"), "frieze": frieze, "pale_stone": caps.require_closed("cap stones")}


def side_parapet(side):
    """The parapet at x = side * HALF_WIDTH, from the back corner to the end pillar."""
    length = EDGE_Z - PILLAR - BACK_Z
    parts = _wall(length, PARAPET_HEIGHT, 31 + side)
    for m in parts.values():
        m.rotated(quat((0, 1, 0), -90.0 * side)).moved((side * HALF_WIDTH, 0.0, BACK_Z + 0.5 * length))
    return parts


def back_parapet():
    parts = _wall(2.0 * (HALF_WIDTH + PARAPET_THICKNESS), BACK_HEIGHT, 47)
    for m in parts.values():
        m.moved((0.0, 0.0, BACK_Z))
    return parts


def pillar():
    """An end pillar around the origin, with a brass bowl of embers on top."""
    stone = shapes.box((PILLAR, PILLAR_HEIGHT - 0.2, PILLAR), 0.05, (0, 0.5 * (PILLAR_HEIGHT - 0.2), 0))
    stone.mapped(lambda p: (p[0] * (1.0 - 0.06 * p[1]), p[1], p[2] * (1.0 - 0.06 * p[1])))
    stone.extend(shapes.box((PILLAR + 0.02, 0.2, PILLAR + 0.02), 0.045, (0, PILLAR_HEIGHT - 0.1, 0)))
    y = PILLAR_HEIGHT
    bowl = shapes.lathe([(0.17, y), (0.10, y + 0.10), (0.27, y + 0.22), (0.38, y + 0.38), (0.355, y + 0.40),
                         (0.28, y + 0.32), (0.0, y + 0.30)], 14,
                        metres("brass"), crease_deg=50.0)
    embers = Mesh()
    for k in range(5):
        a = 1.5 * k
        r = 0.18 if k else 0.0
        lump = shapes.rock((0.27, 0.17, 0.25), 60 + k, 6, 3, 0.35)
        embers.extend(lump.moved((r * math.cos(a), y + 0.345 + (0.04 if k == 0 else 0.0), r * math.sin(a))))
    return {"pale_stone": boxed(stone, "pale_stone"), "brass": bowl.require_closed("bowl"), "ember": embers}


def column(height=4.6, whole=True):
    """A lotus column around the origin: plinth, shaft with painted collar, bell capital, block."""
    stone = shapes.box((1.0, 0.22, 1.0), 0.04, (0, 0.11, 0))
    boxed(stone, "pale_stone")
    low = [(0.45, 0.22), (0.44, 0.36), (0.31, 0.44), (0.35, 0.9)]
    if not whole:
        stub = shapes.lathe(low + [(0.345, height - 0.25)], 12, metres("stone"))

        def broken(p):
            # The break falls to one side.
            return (p[0], p[1] + (0.25 * p[0] / 0.35 + 0.1 * p[2] / 0.35 if p[1] > height - 0.3 else 0.0), p[2])
        return {"pale_stone": stone, "stone": stub.mapped(broken).require_closed("broken column")}
    neck = height - 1.15
    shaft = shapes.lathe(low + [(0.285, neck)], 12, metres("stone"))
    collar = shapes.lathe([(0.30, neck), (0.30, neck + 0.42)], 12, repeats=2, v_scale=1.0)
    bell = shapes.lathe([(0.275, neck + 0.42), (0.34, neck + 0.60), (0.47, neck + 0.86), (0.49, neck + 0.92)], 12, metres("pale_stone"), crease_deg=50.0)
    block = shapes.box((0.62, 0.24, 0.62), 0.03, (0, height - 0.12, 0))
    stone.extend(bell.require_closed("capital")).extend(boxed(block, "pale_stone"))
    return {"pale_stone": stone, "stone": shaft.require_closed("shaft"), "frieze": collar}


def pot():
    """A terracotta jar."""
    profile = [(0.12, 0.0), (0.27, 0.20), (0.31, 0.40), (0.24, 0.62), (0.115, 0.74), (0.155, 0.83), (0.10, 0.80),
               (0.0, 0.70)]
    jar = shapes.lathe(profile, 10, metres("terracotta"), crease_deg=60.0)
    return {"terracotta": jar.require_closed("jar")}


def arch_lintel(length):
    """A stone beam to lie on two columns."""
    return boxed(shapes.box((0.6, 0.45, length), 0.05), "pale_stone", (0.3, 0.2))
