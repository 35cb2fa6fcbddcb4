"""Three-component vectors as tuples, rotations, and a counter-based random number in [0, 1)."""
import math


def add(a, b):
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def mul(a, s):
    return (a[0] * s, a[1] * s, a[2] * s)


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def length(a):
    return math.sqrt(dot(a, a))


def normalize(a):
    l = length(a)
    return mul(a, 1.0 / l) if l > 0.0 else (0.0, 0.0, 0.0)


def lerp(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def clamp(x, lo=0.0, hi=1.0):
    return lo if x < lo else hi if x > hi else x


def smoothstep(lo, hi, x):
    t = clamp((x - lo) / (hi - lo))
    return t * t * (3.0 - 2.0 * t)


def quat(axis, degrees):
    """Quaternion (x, y, z, w), as glTF orders it, of a rotation about axis."""
    h = math.radians(degrees) * 0.5
    a = mul(normalize(axis), math.sin(h))
    return (a[0], a[1], a[2], math.cos(h))


def quat_mul(a, b):
    """The rotation b, then a."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def rotate(q, v):
    u = (q[0], q[1], q[2])
    t = mul(cross(u, v), 2.0)
    return add(add(v, mul(t, q[3])), cross(u, t))


def quat_from_axes(x, y, z):
    """The rotation whose matrix has the orthonormal columns x, y, z (Shepperd's method)."""
    m00, m10, m20 = x
    m01, m11, m21 = y
    m02, m12, m22 = z
    trace = m00 + m11 + m22
    if trace > 0.0:
        s = math.sqrt(trace + 1.0) * 2.0
        return ((m21 - m12) / s, (m02 - m20) / s, (m10 - m01) / s, 0.25 * s)
    if m00 > m11 and m00 > m22:
        s = math.sqrt(1.0 + m00 - m11 - m22) * 2.0
        return (0.25 * s, (m01 + m10) / s, (m02 + m20) / s, (m21 - m12) / s)
    if m11 > m22:
        s = math.sqrt(1.0 + m11 - m00 - m22) * 2.0
        return ((m01 + m10) / s, 0.25 * s, (m12 + m21) / s, (m02 - m20) / s)
    s = math.sqrt(1.0 + m22 - m00 - m11) * 2.0
    return ((m02 + m20) / s, (m12 + m21) / s, 0.25 * s, (m10 - m01) / s)


def look_rotation(forward, up=(0.0, 1.0, 0.0)):
    """Rotation that takes -Z to forward: cameras and lights of glTF look along -Z."""
    z = mul(normalize(forward), -1.0)
    x = normalize(cross(up, z))
    return quat_from_axes(x, cross(z, x), z)


def _mix(h):
    h &= 0xFFFFFFFF
    h ^= h >> 16
    h = (h * 0x7FEB352D) & 0xFFFFFFFF
    h ^= h >> 15
    h = (h * 0x846CA68B) & 0xFFFFFFFF
    return h ^ (h >> 16)


def random01(*key):
    """A number in [0, 1) that depends on the integers of key only (lowbias32 mixing)."""
    h = 0x9E3779B9
    for k in key:
        h = _mix(h ^ (int(k) & 0xFFFFFFFF))
        h = (h + 0x9E3779B9) & 0xFFFFFFFF
    return _mix(h) / 4294967296.0


def random_between(lo, hi, *key):
    return lo + (hi - lo) * random01(*key)
