"""Makes every texture of the content: stone, paint, sand, brass, the beast's shell and skin, the scale's dial."""
import math

from lib import image, noise
from lib.vec import clamp, random01, random_between, smoothstep

LIMESTONE = [(0.0, (96, 70, 48)), (0.25, (158, 124, 88)), (0.6, (206, 174, 131)), (1.0, (236, 213, 174))]
SANDSTONE = [(0.0, (92, 60, 38)), (0.3, (160, 112, 70)), (0.65, (206, 160, 107)), (1.0, (233, 198, 147))]
SAND = [(0.0, (176, 122, 70)), (0.5, (218, 166, 104)), (1.0, (243, 203, 144))]
BRASS = [(0.0, (92, 60, 24)), (0.35, (176, 122, 48)), (0.7, (226, 176, 88)), (1.0, (250, 216, 138))]
VERDIGRIS = [(0.0, (52, 78, 62)), (1.0, (112, 158, 136))]
SHELL = [(0.0, (6, 10, 13)), (0.45, (12, 30, 36)), (0.8, (22, 66, 68)), (1.0, (64, 104, 84))]
SKIN = [(0.0, (74, 34, 24)), (0.5, (146, 82, 56)), (1.0, (202, 138, 98))]
LAPIS = [(0.0, (18, 36, 72)), (1.0, (44, 88, 150))]
TURQUOISE = [(0.0, (32, 92, 92)), (1.0, (92, 172, 160))]
RED = [(0.0, (104, 36, 22)), (1.0, (178, 78, 48))]
GOLD = [(0.0, (146, 98, 34)), (1.0, (228, 180, 86))]
CREAM = [(0.0, (176, 148, 106)), (1.0, (238, 220, 184))]


def _masonry(size, metres, courses, blocks, seed, wobble):
    """(distance to the nearest joint in m, block number) of courses of stones that wrap both ways."""
    course = metres / courses
    joints = []
    for r in range(courses):
        width = metres / blocks
        start = width * (0.5 * (r % 2) + random_between(-0.15, 0.15, seed, r, 1))
        joints.append([start + k * width + width * random_between(-0.18, 0.18, seed, r, k, 2) for k in range(blocks)])
    distance, number = [], []
    for py in range(size):
        v = (py + 0.5) * metres / size
        r = min(courses - 1, int(v / course))
        dv = min(v - r * course, (r + 1) * course - v)
        for px in range(size):
            u = (px + 0.5) * metres / size
            du, block = 1e9, 0
            for k, x in enumerate(joints[r]):
                d = (u - x) % metres
                if d <= min((u - y) % metres for y in joints[r]):
                    block = k
                du = min(du, d, metres - d)
            distance.append(min(du, dv) + wobble[py * size + px])
            number.append(r * blocks + block)
    return distance, number


def _stone(size, metres, courses, blocks, seed, stops, joint_m, depth_m):
    """(albedo, normals) of dressed, worn stones: a tint a stone, pits, stains below the joints."""
    broad = noise.octaves(size, 4, 4, seed)
    fine = noise.octaves(size, 32, 3, seed + 7, gain=0.7)
    pits = noise.worley(size, 40, seed + 9)[0]
    wobble = [0.012 * metres / 4.0 * b for b in noise.octaves(size, 16, 2, seed + 5)]
    distance, number = _masonry(size, metres, courses, blocks, seed, wobble)
    tone, height = [], []
    for i, d in enumerate(distance):
        face = smoothstep(0.2 * joint_m, 1.6 * joint_m, d)
        worn = smoothstep(joint_m, 7.0 * joint_m, d)
        tint = random01(seed, number[i], 11)
        pitted = random01(seed, number[i], 3)
        pit = pitted * (1.0 - smoothstep(0.10, 0.28, pits[i]))
        t = 0.44 + 0.20 * (tint - 0.5) + 0.24 * broad[i] + 0.16 * fine[i] + 0.16 * worn - 0.10 * pit
        tone.append((0.10 + 0.2 * broad[i]) * (1.0 - face) + t * face)
        height.append(depth_m * (face * 0.8 + 0.2 * worn) + 0.004 * broad[i] + 0.003 * fine[i] - 0.003 * pit)
    return image.ramp_png(size, tone, image.Ramp(stops, 48)), image.normal_png(size, height, metres, 32)


def _plain_stone(size, metres, seed, stops):
    """Undivided weathered stone with faint strata, for columns and single blocks."""
    broad = noise.octaves(size, 3, 4, seed)
    fine = noise.octaves(size, 24, 3, seed + 3, gain=0.7)
    strata = noise.octaves(size, 2, 3, seed + 5, stretch=6)
    pits = noise.worley(size, 28, seed + 9)[0]
    tone, height = [], []
    for b, f, s, p in zip(broad, fine, strata, pits):
        pit = 1.0 - smoothstep(0.08, 0.3, p)
        tone.append(0.58 + 0.26 * b + 0.14 * f + 0.14 * s - 0.12 * pit)
        height.append(0.006 * b + 0.003 * f + 0.004 * s - 0.004 * pit)
    return image.ramp_png(size, tone, image.Ramp(stops, 48)), image.normal_png(size, height, metres, 32)


def _sand(size, metres, seed):
    """Wind ripples, running along u, that split and join."""
    bend = noise.octaves(size, 3, 3, seed)
    grit = noise.octaves(size, 48, 2, seed + 3, gain=0.9)
    tone, height = [], []
    for i, b in enumerate(bend):
        y = i // size
        phase = y * 14.0 / size + 0.9 * b
        phase -= math.floor(phase)
        # A ripple's slope to windward is long, the one to leeward short.
        wave = phase / 0.7 if phase < 0.7 else (1.0 - phase) / 0.3
        wave = smoothstep(0.0, 1.0, wave)
        tone.append(0.42 + 0.16 * wave + 0.22 * grit[i] + 0.16 * b)
        height.append(0.022 * metres / 4.0 * wave + 0.004 * grit[i])
    return image.ramp_png(size, tone, image.Ramp(SAND, 48)), image.normal_png(size, height, metres, 32)


def _brass(size, metres, seed):
    """(albedo, surface, normals) of hammered brass with tarnish and verdigris in the hollows."""
    dents, _, _ = noise.worley(size, 9, seed)
    broad = noise.octaves(size, 3, 4, seed + 1)
    fine = noise.octaves(size, 24, 3, seed + 2)
    colours, pairs, height = [], [], []
    for i, d in enumerate(dents):
        hollow = 1.0 - smoothstep(0.0, 0.55, d)
        green = smoothstep(0.30, 0.62, broad[i] + 0.35 * fine[i])
        if green > 0.5:
            colours.append((1, 0.5 + 0.5 * fine[i] + 0.3 * (green - 0.5)))
        else:
            colours.append((0, 0.60 + 0.22 * (1.0 - hollow) + 0.22 * fine[i] - 0.45 * green + 0.12 * broad[i]))
        pairs.append((0.30 + 0.14 * fine[i] + 0.12 * broad[i] + 0.45 * green, 1.0 - smoothstep(0.35, 0.75, green)))
        height.append(-0.003 * metres * hollow + 0.0006 * metres * fine[i])
    return (image.ramps_png(size, colours, [image.Ramp(BRASS), image.Ramp(VERDIGRIS, 16)]),
            image.surface_png(size, pairs), image.normal_png(size, height, metres))


def _shell(size, metres, seed):
    """(albedo, surface, normals) of a beetle's wing case: pitted in rows, iridescent towards green and bronze."""
    sheen = noise.octaves(size, 2, 3, seed)
    fine = noise.octaves(size, 32, 2, seed + 1)
    scratch = noise.octaves(size, 3, 3, seed + 2, stretch=16)
    colours, pairs, height = [], [], []
    n = 10
    for i in range(size * size):
        x, y = (i % size) / size * n, (i // size) / size * n
        row = int(x)
        a, b = x - row - 0.5, (y + 0.37 * row) % 1.0 - 0.5
        pit = 1.0 - smoothstep(0.10, 0.24, math.sqrt(a * a * 2.0 + b * b))
        rib = smoothstep(0.32, 0.5, abs(a))
        colours.append((0, 0.44 + 0.40 * sheen[i] + 0.10 * fine[i] - 0.35 * pit + 0.14 * rib))
        pairs.append((0.24 + 0.10 * fine[i] + 0.22 * max(0.0, scratch[i]) + 0.25 * pit, 1.0))
        height.append(metres * (-0.010 * pit + 0.006 * rib + 0.001 * fine[i]))
    return (image.ramps_png(size, colours, [image.Ramp(SHELL)]), image.surface_png(size, pairs),
            image.normal_png(size, height, metres, 40))


def _skin(size, metres, seed):
    """(albedo, normals) of leathery scales."""
    first, second, number = noise.worley(size, 14, seed)
    broad = noise.octaves(size, 2, 4, seed + 1)
    tone, height = [], []
    for i in range(size * size):
        gap = smoothstep(0.03, 0.22, second[i] - first[i])
        dome = 1.0 - first[i]
        tone.append((0.35 + 0.65 * gap) * (0.42 + 0.22 * (random01(seed, number[i]) - 0.5) + 0.18 * dome) + 0.26 * broad[i])
        height.append(metres * (0.008 * gap + 0.010 * dome * gap))
    return image.ramp_png(size, tone, image.Ramp(SKIN)), image.normal_png(size, height, metres)


def _frieze(size):
    """Painted bands, one repeat wide: lotus petals over chevrons between lines, chipped to the stone."""
    chips = noise.octaves(size, 6, 4, 71)
    fine = noise.octaves(size, 24, 2, 73)
    lapis, turquoise, red, gold, cream = range(5)
    ramps = [image.Ramp(c, 24) for c in (LAPIS, TURQUOISE, RED, GOLD, CREAM)] + [image.Ramp(SANDSTONE, 48)]
    out = []
    for py in range(size):
        v = py / size
        for px in range(size):
            u = px / size
            i = py * size + px
            if v < 0.06 or 0.94 <= v:
                colour = gold
            elif v < 0.10 or 0.90 <= v:
                colour = lapis
            elif v < 0.52:
                # Petals stand side by side, pointed at the top.
                x = (u * 4.0) % 1.0 - 0.5
                y = (v - 0.10) / 0.42
                half = 0.46 * math.sqrt(y) * (1.0 - 0.35 * y * y)
                d = abs(x) / max(half, 1e-6)
                colour = red if d < 0.30 else cream if d < 0.62 else turquoise if d < 0.95 else lapis
            elif v < 0.58:
                colour = gold
            elif v < 0.84:
                y = (v - 0.58) / 0.26
                k = int(((abs((u * 8.0) % 1.0 - 0.5) * 2.0 + y * 2.0) % 2.0) * 2.0)
                colour = (turquoise, cream, red, cream)[k]
            else:
                colour = gold
            if chips[i] + 0.3 * fine[i] > 0.34:
                out.append((5, 0.55 + 0.3 * fine[i]))
            else:
                out.append((colour, 0.62 + 0.35 * fine[i] - 0.4 * max(0.0, chips[i])))
    return image.ramps_png(size, out, ramps)


def _dial(size):
    """The scale's face: an ivory disc with an hourglass in the middle, ticks over 270 degrees, a green last third.

    Zero is at the lower left (225 degrees from the top, counted clockwise 0 at the top), full at the
    lower right; the needle of the level turns over the same 270 degrees.
    """
    fine = noise.octaves(size, 12, 4, 81)
    ivory, ink, green, red = 0, 1, 2, 3
    ramps = [image.Ramp([(0.0, (176, 146, 100)), (1.0, (244, 228, 192))], 48), image.Ramp([(0.0, (30, 22, 18)),
             (1.0, (74, 56, 42))], 16), image.Ramp(TURQUOISE, 16), image.Ramp(RED, 16)]
    out = []
    for py in range(size):
        y = 1.0 - 2.0 * (py + 0.5) / size
        for px in range(size):
            x = 2.0 * (px + 0.5) / size - 1.0
            i = py * size + px
            r = math.hypot(x, y)
            # Clockwise turn from the zero mark, in degrees.
            turn = (math.degrees(math.atan2(x, y)) + 135.0) % 360.0
            kind = ivory
            if turn <= 271.0:
                minor = abs((turn + 2.7) % 5.4 - 2.7) * math.pi / 180.0 * r
                major = abs((turn + 13.5) % 27.0 - 13.5) * math.pi / 180.0 * r
                if 0.80 < r < 0.90:
                    kind = green if turn > 180.0 else red if turn < 60.0 else ivory
                if 0.74 < r < 0.90 and minor < 0.007 or 0.64 < r < 0.92 and major < 0.014:
                    kind = ink
                if abs(r - 0.92) < 0.010 or abs(r - 0.79) < 0.006:
                    kind = ink
            # An hourglass: two triangles, point to point, between two bars, sand in the lower one.
            if abs(x) < 0.20 and abs(abs(y) - 0.40) < 0.022:
                kind = ink
            elif abs(y) < 0.38 and abs(abs(x) - (0.025 + 0.40 * abs(y))) < 0.014:
                kind = ink
            elif -0.38 < y < -0.17 and abs(x) < 0.025 + 0.40 * abs(y) - 0.03:
                kind = red
            out.append((kind, 0.72 + 0.4 * fine[i] - 0.5 * smoothstep(0.86, 1.05, r)))
    return image.ramps_png(size, out, ramps)


def _checker(size):
    """Eight by eight fields, light and dark, linear 0.8 and 0.05."""
    pixels = [(x * 8 // size + y * 8 // size) % 2 for y in range(size) for x in range(size)]
    return image.png(size, size, pixels, 1, [(231, 231, 231), (63, 63, 63)])


def _pair(names, values):
    return dict(zip(names, values))


# Group name -> function that makes {file stem: PNG bytes}. Metres a repeat are in METRES.
GROUPS = {
    "paving": lambda: _pair(("paving", "paving_normal"), _stone(256, 3.0, 4, 3, 11, LIMESTONE, 0.018, 0.012)),
    "ashlar": lambda: _pair(("ashlar", "ashlar_normal"), _stone(256, 2.4, 5, 3, 23, SANDSTONE, 0.016, 0.014)),
    "stone": lambda: _pair(("stone", "stone_normal"), _plain_stone(256, 1.6, 37, SANDSTONE)),
    "sand": lambda: _pair(("sand", "sand_normal"), _sand(256, 4.0, 41)),
    "brass": lambda: _pair(("brass", "brass_surface", "brass_normal"), _brass(256, 1.2, 53)),
    "shell": lambda: _pair(("shell", "shell_surface", "shell_normal"), _shell(256, 0.8, 61)),
    "skin": lambda: _pair(("skin", "skin_normal"), _skin(128, 0.4, 67)),
    "frieze": lambda: {"frieze": _frieze(256)},
    "dial": lambda: {"dial": _dial(256)},
    "checker": lambda: {"checker": _checker(64)},
}

# Metres that one repeat of a texture covers.
METRES = {"paving": 3.0, "ashlar": 2.4, "stone": 1.6, "sand": 4.0, "brass": 1.2, "shell": 0.8, "skin": 0.4}
