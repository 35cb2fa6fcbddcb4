"""Checks a finished .glb byte by byte, without the writer's code: references, bounds, normals, winding, images."""
import json
import math
import struct
import zlib

_SIZES = {5121: 1, 5123: 2, 5125: 4, 5126: 4}
_CODES = {5121: "B", 5123: "H", 5125: "I", 5126: "f"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_REFERENCES = (  # (list, key, the list it points into)
    ("textures", "source", "images"), ("textures", "sampler", "samplers"), ("images", "bufferView", "bufferViews"),
    ("accessors", "bufferView", "bufferViews"), ("bufferViews", "buffer", "buffers"), ("nodes", "mesh", "meshes"),
    ("nodes", "camera", "cameras"))


class Report:
    """Faults found in one file, and its figures."""

    def __init__(self, name):
        self.name, self.faults = name, []
        self.nodes = self.triangles = self.vertices = self.image_bytes = self.open_edges = 0

    def fault(self, text):
        if len(self.faults) < 20:
            self.faults.append("%s: %s" % (self.name, text))


def check_png(data, where, report, largest=512):
    """Signature, chunk sums, size and amount of pixels."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        report.fault("%s: not a PNG" % where)
        return
    at, pixels, header = 8, b"", None
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        if struct.unpack_from(">I", data, at + 8 + size)[0] != zlib.crc32(kind + body) & 0xFFFFFFFF:
            report.fault("%s: chunk %s has a wrong checksum" % (where, kind.decode("ascii", "replace")))
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            pixels += body
        at += 12 + size
    width, height, depth, colour = header[:4]
    if width != height or width & (width - 1) or width > largest:
        report.fault("%s: %d x %d is not a square power of two up to %d" % (where, width, height, largest))
    channels = {0: 1, 2: 3, 3: 1, 6: 4}[colour]
    if depth != 8 or len(zlib.decompress(pixels)) != height * (1 + width * channels):
        report.fault("%s: wrong amount of pixels" % where)


def _read(doc, blob, index, report):
    """Rows of an accessor, or [] after a fault."""
    a = doc["accessors"][index]
    view = doc["bufferViews"][a["bufferView"]]
    width, size = _WIDTHS[a["type"]], _SIZES[a["componentType"]]
    start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
    length = a["count"] * width * size
    if length > view["byteLength"] or start + length > len(blob):
        report.fault("accessor %d: %d bytes do not fit its buffer view" % (index, length))
        return []
    if start % size:
        report.fault("accessor %d: offset %d is not aligned to %d" % (index, start, size))
    flat = struct.unpack_from("<%d%s" % (a["count"] * width, _CODES[a["componentType"]]), blob, start)
    if a["componentType"] == 5126 and not all(map(math.isfinite, flat)):
        report.fault("accessor %d: a number is not finite" % index)
        return []
    rows = [flat[k:k + width] for k in range(0, len(flat), width)] if width > 1 else list(flat)
    if "min" in a and rows and width > 1:
        low, high = [min(c) for c in zip(*rows)], [max(c) for c in zip(*rows)]
        if low != a["min"] or high != a["max"]:
            report.fault("accessor %d: min and max are not those of the data" % index)
    return rows


def _sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _primitive(doc, blob, where, p, report):
    """(triangles, open edges) of one primitive."""
    attributes = p["attributes"]
    positions, normals, uvs = (_read(doc, blob, attributes[k], report) for k in ("POSITION", "NORMAL", "TEXCOORD_0"))
    indices = _read(doc, blob, p["indices"], report)
    if "min" not in doc["accessors"][attributes["POSITION"]]:
        report.fault("%s: POSITION has no bounds" % where)
    if not len(positions) == len(normals) == len(uvs) or len(indices) % 3:
        report.fault("%s: attribute counts differ, or indices are not triangles" % where)
        return 0, 0
    if indices and max(indices) >= len(positions):
        report.fault("%s: index %d of %d vertices" % (where, max(indices), len(positions)))
        return 0, 0
    if len(set(indices)) != len(positions):
        report.fault("%s: %d vertices are in no triangle" % (where, len(positions) - len(set(indices))))
    for k, n in enumerate(normals):
        if abs(_dot(n, n) - 1.0) > 1e-3:
            report.fault("%s: normal %d has length %g" % (where, k, math.sqrt(_dot(n, n))))
    if any(abs(c) > 1024.0 for t in uvs for c in t):
        report.fault("%s: a texture coordinate is beyond 1024 repeats" % where)
    edges = {}
    for k in range(0, len(indices), 3):
        tri = indices[k:k + 3]
        a, b, c = (positions[i] for i in tri)
        flat = _cross(_sub(b, a), _sub(c, a))
        if _dot(flat, flat) == 0.0:
            report.fault("%s: triangle %d has no area" % (where, k // 3))
        for i in tri:
            if _dot(flat, normals[i]) <= 0.0:
                report.fault("%s: triangle %d looks away from the normal of vertex %d" % (where, k // 3, i))
                break
        for x, y in ((a, b), (b, c), (c, a)):
            edges[(x, y)] = edges.get((x, y), 0) + 1
    opened = sum(max(0, n - edges.get((y, x), 0)) for (x, y), n in edges.items())
    report.vertices += len(positions)
    return len(indices) // 3, opened


def check_glb(data, name):
    """Returns the Report of a binary glTF file's bytes."""
    report = Report(name)
    magic, version, total = struct.unpack_from("<4sII", data)
    size, kind = struct.unpack_from("<I4s", data, 12)
    if magic != b"glTF" or version != 2 or total != len(data) or kind != b"JSON" or size % 4:
        report.fault("the header is not that of a glTF 2.0 file of %d bytes" % len(data))
        return report
    doc = json.loads(data[20:20 + size])
    at = 20 + size
    blob_size, kind = struct.unpack_from("<I4s", data, at)
    blob = data[at + 8:at + 8 + blob_size]
    if kind != b"BIN\0" or len(blob) != blob_size or at + 8 + blob_size != len(data):
        report.fault("the binary chunk is cut off")
        return report
    for source, key, target in _REFERENCES:
        for k, item in enumerate(doc.get(source, ())):
            if key in item and not 0 <= item[key] < len(doc.get(target, ())):
                report.fault("%s %d: %s %d of %d" % (source, k, key, item[key], len(doc.get(target, ()))))
    for k, view in enumerate(doc["bufferViews"]):
        if view["byteOffset"] + view["byteLength"] > doc["buffers"][0]["byteLength"]:
            report.fault("buffer view %d leaves the buffer" % k)
    if report.faults:
        return report
    for m in doc.get("materials", ()):
        pbr = m["pbrMetallicRoughness"]
        factors = pbr["baseColorFactor"] + [pbr["metallicFactor"], pbr["roughnessFactor"]] + m.get("emissiveFactor", [])
        if not all(0.0 <= f <= 1.0 for f in factors):
            report.fault("material \"%s\": a factor is outside 0 to 1" % m["name"])
    for image in doc.get("images", ()):
        view = doc["bufferViews"][image["bufferView"]]
        png = blob[view["byteOffset"]:view["byteOffset"] + view["byteLength"]]
        report.image_bytes += len(png)
        check_png(png, "image \"%s\"" % image["name"], report)
    figures = []
    for mesh in doc.get("meshes", ()):
        triangles = 0
        for k, p in enumerate(mesh["primitives"]):
            where = "mesh \"%s\" part %d" % (mesh["name"], k)
            if not 0 <= p["material"] < len(doc["materials"]):
                report.fault("%s: material %d of %d" % (where, p["material"], len(doc["materials"])))
            t, opened = _primitive(doc, blob, where, p, report)
            triangles += t
            report.open_edges += opened
        figures.append(triangles)
    _nodes(doc, figures, report)
    return report


def _nodes(doc, triangles, report):
    """Every node once in the tree, names unique, rotations of length 1, extras plain."""
    seen, names = [0] * len(doc["nodes"]), set()
    stack = list(doc["scenes"][doc["scene"]]["nodes"])
    while stack:
        k = stack.pop()
        seen[k] += 1
        if seen[k] == 1:
            stack += doc["nodes"][k].get("children", [])
    for k, node in enumerate(doc["nodes"]):
        where = "node \"%s\"" % node.get("name")
        if seen[k] != 1:
            report.fault("%s is reached %d times" % (where, seen[k]))
        if node["name"] in names or len(node["name"]) > 63:
            report.fault("%s: the name is used twice or longer than 63 letters" % where)
        names.add(node["name"])
        q = node.get("rotation")
        if q and abs(sum(c * c for c in q) - 1.0) > 1e-6:
            report.fault("%s: the rotation has length %g" % (where, math.sqrt(sum(c * c for c in q))))
        if any(s <= 0.0 for s in node.get("scale", ())):
            report.fault("%s: the scale is not positive" % where)
        if "mesh" in node:
            report.triangles += triangles[node["mesh"]]
    report.nodes = len(doc["nodes"])
