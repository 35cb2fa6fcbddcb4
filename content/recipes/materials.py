"""The materials of the content, by name, with the textures that each needs."""
import textures

# name: arguments of Gltf.material; base, surface and normal are texture file stems.
MATERIALS = {
    "paving": {"base": "paving", "normal": "paving_normal", "roughness": 0.82},
    "ashlar": {"base": "ashlar", "normal": "ashlar_normal", "roughness": 0.9},
    "stone": {"base": "stone", "normal": "stone_normal", "roughness": 0.88},
    "pale_stone": {"base": "stone", "normal": "stone_normal", "roughness": 0.85, "color": (0.83, 0.9, 1.0)},
    "sand": {"base": "sand", "normal": "sand_normal", "roughness": 0.95, "normal_scale": 0.8},
    "frieze": {"base": "frieze", "roughness": 0.78},
    "brass": {"base": "brass", "surface": "brass_surface", "normal": "brass_normal", "metallic": 1.0},
    "dial": {"base": "dial", "roughness": 0.45},
    "iron": {"color": (0.05, 0.045, 0.04), "metallic": 0.9, "roughness": 0.42},
    "shell": {"base": "shell", "surface": "shell_surface", "normal": "shell_normal", "metallic": 0.6},
    "skin": {"base": "skin", "normal": "skin_normal", "roughness": 0.62},
    "ember": {"color": (0.35, 0.08, 0.02), "roughness": 0.5, "emissive": (1.0, 0.34, 0.05), "emissive_strength": 1.25},
    "terracotta": {"base": "stone", "normal": "stone_normal", "roughness": 0.8, "color": (0.62, 0.34, 0.26)},
    "granite": {"base": "stone", "normal": "stone_normal", "roughness": 0.7, "color": (0.46, 0.33, 0.33)},
    "bark": {"base": "stone", "normal": "stone_normal", "roughness": 0.95, "color": (0.42, 0.36, 0.32)},
    "bean": {"color": (0.13, 0.052, 0.020), "roughness": 0.42},
    "chaff": {"color": (0.42, 0.27, 0.14), "roughness": 0.8},
    "pebble": {"base": "stone", "normal": "stone_normal", "roughness": 0.6, "color": (0.75, 0.8, 0.9)},
    "steel": {"color": (0.53, 0.53, 0.55), "metallic": 1.0, "roughness": 0.45},
    "leaf": {"color": (0.085, 0.15, 0.035), "roughness": 0.6, "double_sided": True},
}


def add(gltf, name, images):
    """Adds a material to a file; images: {texture file stem: PNG bytes} of all textures."""
    args = dict(MATERIALS[name])
    for slot in ("base", "surface", "normal"):
        if slot in args:
            args[slot] = (args[slot], images[args[slot]])
    return gltf.material(name, **args)


class Palette:
    """Materials of one file, added at their first use."""

    def __init__(self, gltf, images):
        self.gltf, self.images, self._ids = gltf, images, {}

    def __getitem__(self, name):
        if name not in self._ids:
            self._ids[name] = add(self.gltf, name, self.images)
        return self._ids[name]

    def mesh(self, name, parts):
        """Adds a mesh of parts {material name: Mesh}, one primitive a material."""
        return self.gltf.mesh(name, [(m, self[k]) for k, m in parts.items() if m.faces])


def metres(name):
    """Size of one repeat of a material's texture."""
    return textures.METRES.get(MATERIALS[name].get("base"), 1.0)
