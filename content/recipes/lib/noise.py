"""Tileable noise on square fields: gradient noise, sums of octaves, and Worley cells (rows of floats, row 0 on top)."""
import math

from .vec import random01

_DIRECTIONS = [(math.cos(2.0 * math.pi * k / 16.0), math.sin(2.0 * math.pi * k / 16.0)) for k in range(16)]


def gradient(size, period, seed, stretch=1):
    """Perlin's gradient noise, about [-1, 1], `period` cells across and period * stretch cells down."""
    rows = period * stretch
    slope = [[_DIRECTIONS[int(16.0 * random01(seed, x, y, 1))] for x in range(period)] for y in range(rows)]
    columns = []
    for px in range(size):
        u = px * period / size
        x = int(u)
        f = u - x
        columns.append((x, (x + 1) % period, f, f * f * f * (f * (f * 6.0 - 15.0) + 10.0)))
    out = []
    for py in range(size):
        v = py * rows / size
        y = int(v)
        g = v - y
        w = g * g * g * (g * (g * 6.0 - 15.0) + 10.0)
        top, low = slope[y], slope[(y + 1) % rows]
        for x, x1, f, s in columns:
            a, b, c, d = top[x], top[x1], low[x], low[x1]
            n0 = a[0] * f + a[1] * g
            n1 = b[0] * (f - 1.0) + b[1] * g
            n2 = c[0] * f + c[1] * (g - 1.0)
            n3 = d[0] * (f - 1.0) + d[1] * (g - 1.0)
            m0 = n0 + (n1 - n0) * s
            m1 = n2 + (n3 - n2) * s
            out.append((m0 + (m1 - m0) * w) * 1.5)
    return out


def octaves(size, period, count, seed, gain=0.5, stretch=1):
    """A sum of `count` gradient noises, each twice as fine and `gain` as strong, scaled to about [-1, 1]."""
    total = [0.0] * (size * size)
    weight, norm = 1.0, 0.0
    for k in range(count):
        layer = gradient(size, period << k, seed + 101 * k, stretch)
        total = [t + weight * n for t, n in zip(total, layer)]
        norm += weight
        weight *= gain
    return [t / norm for t in total]


def white(size, seed):
    """One independent number in [-1, 1] a pixel."""
    return [2.0 * random01(seed, i) - 1.0 for i in range(size * size)]


def worley(size, cells, seed, jitter=0.9):
    """(nearest, second nearest, cell number): distances in cell widths to one jittered point a cell."""
    seeds = {}
    for y in range(cells):
        for x in range(cells):
            seeds[(x, y)] = (0.5 + jitter * (random01(seed, x, y, 2) - 0.5),
                             0.5 + jitter * (random01(seed, x, y, 3) - 0.5))
    first, second, number = [], [], []
    for py in range(size):
        v = (py + 0.5) * cells / size
        cy = int(v)
        for px in range(size):
            u = (px + 0.5) * cells / size
            cx = int(u)
            d1 = d2 = 1e9
            best = 0
            for y in (cy - 1, cy, cy + 1):
                for x in (cx - 1, cx, cx + 1):
                    kx, ky = x % cells, y % cells
                    s = seeds[(kx, ky)]
                    dx, dy = x + s[0] - u, y + s[1] - v
                    d = dx * dx + dy * dy
                    if d < d1:
                        d1, d2, best = d, d1, ky * cells + kx
                    elif d < d2:
                        d2 = d
            first.append(math.sqrt(d1))
            second.append(math.sqrt(d2))
            number.append(best)
    return first, second, number


def blurred(field, size, radius):
    """A box blur that wraps, once in each direction."""
    n = 2 * radius + 1
    out = [0.0] * len(field)
    for y in range(size):
        row = field[y * size:(y + 1) * size]
        acc = sum(row[(k - radius) % size] for k in range(n))
        for x in range(size):
            out[y * size + x] = acc / n
            acc += row[(x + radius + 1) % size] - row[(x - radius) % size]
    done = [0.0] * len(field)
    for x in range(size):
        column = out[x::size]
        acc = sum(column[(k - radius) % size] for k in range(n))
        for y in range(size):
            done[y * size + x] = acc / n
            acc += column[(y + radius + 1) % size] - column[(y - radius) % size]
    return done
