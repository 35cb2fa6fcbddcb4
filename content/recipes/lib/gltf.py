"""A writer of binary glTF 2.0: meshes, metallic-roughness materials with embedded PNG, camera, sun, extras."""
import json
import struct

from .mesh import bake

_FLOAT, _USHORT, _UINT = 5126, 5123, 5125
_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963


def _round(values, digits=6):
    return [round(float(v), digits) + 0.0 for v in values]


class Gltf:
    def __init__(self, generator="Scree content recipes"):
        self.doc = {"asset": {"version": "2.0", "generator": generator}, "scene": 0, "scenes": [{"nodes": []}],
                    "nodes": [], "meshes": [], "materials": [], "accessors": [], "bufferViews": []}
        self.blob = bytearray()
        self._textures = {}
        self.triangles = {}

    def _view(self, data, target=None):
        while len(self.blob) % 4:
            self.blob.append(0)
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data)}
        if target:
            view["target"] = target
        self.blob += data
        self.doc["bufferViews"].append(view)
        return len(self.doc["bufferViews"]) - 1

    def _accessor(self, rows, kind, component, target, bounds=False):
        flat = [v for r in rows for v in r] if kind != "SCALAR" else rows
        code = {_FLOAT: "f", _USHORT: "H", _UINT: "I"}[component]
        a = {"bufferView": self._view(struct.pack("<%d%s" % (len(flat), code), *flat), target),
             "componentType": component, "count": len(rows), "type": kind}
        if bounds:
            a["min"] = [min(c) for c in zip(*rows)]
            a["max"] = [max(c) for c in zip(*rows)]
        self.doc["accessors"].append(a)
        return len(self.doc["accessors"]) - 1

    def texture(self, name, png_bytes):
        """Embeds an image once; returns the texture's index."""
        if name not in self._textures:
            d = self.doc
            d.setdefault("samplers", [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}])
            d.setdefault("images", []).append(
                {"name": name, "mimeType": "image/png", "bufferView": self._view(png_bytes)})
            d.setdefault("textures", []).append({"name": name, "sampler": 0, "source": len(d["images"]) - 1})
            self._textures[name] = len(d["textures"]) - 1
        return self._textures[name]

    def material(self, name, color=(1.0, 1.0, 1.0), metallic=0.0, roughness=1.0, base=None, surface=None,
                 normal=None, normal_scale=1.0, emissive=None, emissive_strength=1.0, double_sided=False):
        """base, surface and normal are (name, png bytes); color is linear; returns the material's index."""
        pbr = {"baseColorFactor": _round(list(color) + [1.0]), "metallicFactor": metallic,
               "roughnessFactor": roughness}
        m = {"name": name, "pbrMetallicRoughness": pbr}
        if base:
            pbr["baseColorTexture"] = {"index": self.texture(*base)}
        if surface:
            pbr["metallicRoughnessTexture"] = {"index": self.texture(*surface)}
        if normal:
            m["normalTexture"] = {"index": self.texture(*normal)}
            if normal_scale != 1.0:
                m["normalTexture"]["scale"] = normal_scale
        if emissive:
            m["emissiveFactor"] = _round(emissive)
            if emissive_strength != 1.0:
                m["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": emissive_strength}}
                self._use("KHR_materials_emissive_strength")
        if double_sided:
            m["doubleSided"] = True
        self.doc["materials"].append(m)
        return len(self.doc["materials"]) - 1

    def _use(self, extension):
        used = self.doc.setdefault("extensionsUsed", [])
        if extension not in used:
            used.append(extension)

    def mesh(self, name, parts):
        """One primitive for each (Mesh, material index) of parts; returns the mesh's index."""
        primitives, triangles = [], 0
        for mesh, material in parts:
            positions, normals, uvs, indices = bake(mesh)
            small = len(positions) < 65535
            primitives.append({
                "attributes": {"POSITION": self._accessor(positions, "VEC3", _FLOAT, _ARRAY_BUFFER, True),
                               "NORMAL": self._accessor(normals, "VEC3", _FLOAT, _ARRAY_BUFFER),
                               "TEXCOORD_0": self._accessor(uvs, "VEC2", _FLOAT, _ARRAY_BUFFER)},
                "indices": self._accessor(indices, "SCALAR", _USHORT if small else _UINT, _ELEMENT_BUFFER),
                "material": material})
            triangles += len(indices) // 3
        self.doc["meshes"].append({"name": name, "primitives": primitives})
        self.triangles[len(self.doc["meshes"]) - 1] = triangles
        return len(self.doc["meshes"]) - 1

    def node(self, name, position=None, rotation=None, scale=None, mesh=None, camera=None, light=None, extras=None,
             parent=None):
        """Adds a node to the scene, or below another node; rotation is a quaternion (x, y, z, w)."""
        n = {"name": name}
        if position:
            n["translation"] = _round(position)
        if rotation:
            n["rotation"] = _round(rotation, 9)
        if scale:
            n["scale"] = _round(scale)
        if mesh is not None:
            n["mesh"] = mesh
        if camera is not None:
            n["camera"] = camera
        if light is not None:
            n["extensions"] = {"KHR_lights_punctual": {"light": light}}
        if extras:
            n["extras"] = extras
        self.doc["nodes"].append(n)
        index = len(self.doc["nodes"]) - 1
        if parent is None:
            self.doc["scenes"][0]["nodes"].append(index)
        else:
            self.doc["nodes"][parent].setdefault("children", []).append(index)
        return index

    def camera(self, name, fov_y_rad, near_m):
        """A perspective camera without a far plane; aspect is the viewer's."""
        self.doc.setdefault("cameras", []).append(
            {"name": name, "type": "perspective", "perspective": {"yfov": round(fov_y_rad, 6), "znear": near_m}})
        return len(self.doc["cameras"]) - 1

    def sun(self, name, color, lux):
        """A directional light, shining along its node's -Z."""
        self._use("KHR_lights_punctual")
        lights = self.doc.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append({"name": name, "type": "directional", "color": _round(color), "intensity": lux})
        return len(lights) - 1

    def drawn_triangles(self):
        """Triangles of all nodes together: a mesh used twice counts twice."""
        return sum(self.triangles[n["mesh"]] for n in self.doc["nodes"] if "mesh" in n)

    def glb(self):
        doc = {k: v for k, v in self.doc.items() if v != []}
        doc["buffers"] = [{"byteLength": len(self.blob)}]
        text = json.dumps(doc, separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        blob = bytes(self.blob) + b"\0" * (-len(self.blob) % 4)
        total = 12 + 8 + len(text) + 8 + len(blob)
        return (struct.pack("<4sII", b"glTF", 2, total) + struct.pack("<I4s", len(text), b"JSON") + text +
                struct.pack("<I4s", len(blob), b"BIN\0") + blob)
