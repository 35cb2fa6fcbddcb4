"""Fields of floats turned into PNG images: colour ramps with a palette, normal maps, roughness and metal maps."""
import math
import struct
import zlib

from .vec import clamp


def _chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data) & 0xFFFFFFFF)


def _compressed(rows, bpp, filters):
    """The shortest of: each of PNG's row filters for all rows, and the best filter a row.

    Rows of few different values (quantised normals) pack best unfiltered, smooth ones filtered; the
    usual rule a row, smallest sum of absolute differences, errs on the former.
    """
    tries = [zlib.compress(b"".join(b"\0" + r for r in rows), 9)]
    if filters:
        kinds = [bytearray() for _ in range(4)]
        previous = bytes(len(rows[0]))
        for row in rows:
            left = bytes(bpp) + row[:-bpp]
            corner = bytes(bpp) + previous[:-bpp]
            paeth = bytearray()
            for x, a, b, c in zip(row, left, previous, corner):
                pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
                paeth.append((x - (a if pa <= pb and pa <= pc else b if pb <= pc else c)) & 255)
            rests = [row, bytes((x - a) & 255 for x, a in zip(row, left)),
                     bytes((x - b) & 255 for x, b in zip(row, previous)), bytes(paeth)]
            best = min(range(4), key=lambda k: sum(v if v < 128 else 256 - v for v in rests[k]))
            for out, k in zip(kinds, (1, 2, 3, best)):
                out.append((0, 1, 2, 4)[k])
                out += rests[k]
            previous = row
        tries += [zlib.compress(bytes(out), 9) for out in kinds if out]
    return min(tries, key=len)


def png(width, height, pixels, channels, palette=None):
    """8-bit PNG bytes; pixels: width * height * channels bytes (1 grey or palette index, 3 RGB, 4 RGBA)."""
    stride = width * channels
    rows = [bytes(pixels[y * stride:(y + 1) * stride]) for y in range(height)]
    kind = 3 if palette else {1: 0, 3: 2, 4: 6}[channels]
    out = b"\x89PNG\r\n\x1a\n" + _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0))
    if palette:
        out += _chunk(b"PLTE", bytes(v for rgb in palette for v in rgb))
    return out + _chunk(b"IDAT", _compressed(rows, channels, not palette)) + _chunk(b"IEND", b"")


def to_byte(x):
    return int(clamp(x) * 255.0 + 0.5)


class Ramp:
    """Colours (sRGB, 0 to 255) along [0, 1], as `steps` palette entries."""

    def __init__(self, stops, steps=64):
        self.steps = steps
        self.palette = []
        for k in range(steps):
            t = k / (steps - 1)
            for (t0, a), (t1, b) in zip(stops, stops[1:]):
                if t <= t1 or (t1, b) == stops[-1]:
                    w = clamp((t - t0) / (t1 - t0))
                    self.palette.append(tuple(int(p + (q - p) * w + 0.5) for p, q in zip(a, b)))
                    break

    def index(self, t):
        return int(clamp(t) * (self.steps - 1) + 0.5)


def ramp_png(size, field, ramp):
    return png(size, size, [ramp.index(t) for t in field], 1, ramp.palette)


def ramps_png(size, fields, ramps):
    """Picks a ramp a pixel: fields holds (ramp number, t)."""
    base, palette = [], []
    for r in ramps:
        base.append(len(palette))
        palette += r.palette
    if len(palette) > 256:
        raise ValueError("a PNG palette holds 256 colours, not %d" % len(palette))
    return png(size, size, [base[k] + ramps[k].index(t) for k, t in fields], 1, palette)


def normal_png(size, height_m, texture_m, levels=64):
    """Tangent-space normals of a wrapping height field in metres, that covers texture_m metres.

    Red is the slope to the right, green to the top of the image (glTF's convention). Slopes are
    rounded to `levels` steps, which halves the file and is not visible.
    """
    texel = texture_m / size
    pixels = bytearray()
    half = levels / 2.0
    for y in range(size):
        up, down = ((y - 1) % size) * size, ((y + 1) % size) * size
        row = y * size
        for x in range(size):
            dx = (height_m[row + (x + 1) % size] - height_m[row + (x - 1) % size]) / (2.0 * texel)
            dy = (height_m[up + x] - height_m[down + x]) / (2.0 * texel)
            s = 1.0 / math.sqrt(dx * dx + dy * dy + 1.0)
            nx = math.floor(-dx * s * half + 0.5) / half
            ny = math.floor(-dy * s * half + 0.5) / half
            nz = math.sqrt(max(0.0, 1.0 - nx * nx - ny * ny))
            pixels += bytes((int(nx * 127.0 + 128.5), int(ny * 127.0 + 128.5), int(nz * 127.0 + 128.5)))
    return png(size, size, pixels, 3)


def surface_png(size, pairs, steps=32):
    """A metallic-roughness map as glTF reads it (green roughness, blue metal) from (roughness, metal) pairs.

    One field drives both, so that a palette of `steps` entries is enough.
    """
    indices, palette = [], {}
    for rough, metal in pairs:
        key = (0, int(clamp(rough) * (steps - 1) + 0.5) * 255 // (steps - 1), int(clamp(metal) * 3.0 + 0.5) * 85)
        indices.append(palette.setdefault(key, len(palette)))
    return png(size, size, indices, 1, list(palette))
