// The check of a whole glTF document: after it, conversion may follow any index and range.
#include <fmt/format.h>

#include <limits>

#include "engine/assets/gltf_check.h"

namespace scree::gltf {
using nlohmann::json;
namespace {

using enum Presence;
constexpr uint64_t kAnyWhole = uint64_t{1} << 53;
constexpr double kAnyNumber = 1e30;
constexpr double kPi = 3.14159265358979323846;

class Checker : CheckBase {
 public:
  using CheckBase::CheckBase;

  // The types of the sections; then storage is checked, then what refers to it.
  bool structure() { return header() && sections(); }
  bool objects() {
    return images() && samplers() && textures() && materials() && meshes() && cameras() &&
           lights() && nodes() && scenes();
  }

 private:
  bool header() {
    Fields root(json_, file_, fault_);
    if (!root.isObject()) return false;
    const json* asset = root.object("asset", Required);
    if (asset == nullptr) return false;
    Fields fields(*asset, file_ + ": asset", fault_);
    std::string version, min_version;
    if (!fields.text("version", Required, &version)) return false;
    if (!version.starts_with("2.")) return fields.refuse("version", "only 2.x is read");
    if (!fields.text("minVersion", Optional, &min_version)) return false;
    if (!min_version.empty() && min_version != "2.0")
      return fields.refuse("minVersion", "only 2.0 is read");
    return extensions(root);
  }

  bool extensions(Fields& root) {
    const json* required = root.find("extensionsRequired");
    if (required == nullptr) return true;
    if (!required->is_array())
      return root.refuse("extensionsRequired", "must be an array of names");
    for (const json& name : *required) {
      if (name == "KHR_lights_punctual" || name == "KHR_materials_emissive_strength" ||
          name == "KHR_mesh_quantization")
        continue;
      return root.refuse("extensionsRequired",
                         "known are KHR_lights_punctual, KHR_materials_emissive_strength and "
                         "KHR_mesh_quantization");
    }
    return true;
  }

  // Every known section is an array of objects of a bearable length.
  bool sections() {
    Fields root(json_, file_, fault_);
    for (const char* name :
         {"buffers", "bufferViews", "accessors", "images", "samplers", "textures", "materials",
          "meshes", "cameras", "nodes", "scenes", "skins", "animations"}) {
      const json* section = root.find(name);
      if (section == nullptr) continue;
      if (!section->is_array()) return root.refuse(name, "must be an array");
      if (section->size() > limits_.max_objects)
        return root.refuse(name, fmt::format("at most {} entries are read", limits_.max_objects));
      for (size_t i = 0; i < section->size(); ++i)
        if (!Fields((*section)[i], fmt::format("{}: {}[{}]", file_, name, i), fault_).isObject())
          return false;
    }
    return root.whole("scene", 0, kAnyWhole, Optional) && lightSection(root);
  }

  bool lightSection(Fields& root) {
    const json* extensions = root.object("extensions", Optional);
    if (extensions == nullptr) return root.sound();
    Fields fields(*extensions, file_ + ": extensions", fault_);
    const json* punctual = fields.object("KHR_lights_punctual", Optional);
    if (punctual == nullptr) return root.sound();
    Fields inner(*punctual, file_ + ": KHR_lights_punctual", fault_);
    lights_ = inner.find("lights");
    if (lights_ == nullptr || !lights_->is_array() || lights_->size() > limits_.max_objects)
      return inner.refuse("lights",
                          fmt::format("must be an array of at most {}", limits_.max_objects));
    return true;
  }

  bool images() {
    return each("images", "image", [&](Fields& image) {
      if (!image.text("uri", Optional) || !image.text("mimeType", Optional) ||
          !image.index("bufferView", "bufferViews", count("bufferViews"), Optional))
        return false;
      const bool has_uri = image.find("uri") != nullptr;
      const bool has_view = image.find("bufferView") != nullptr;
      if (has_uri == has_view)
        return image.refuse("uri", "exactly one of uri and bufferView is needed");
      return true;
    });
  }

  bool samplers() {
    return each("samplers", "sampler", [&](Fields& sampler) {
      return sampler.oneOf("magFilter", {9728, 9729}, Optional) &&
             sampler.oneOf("minFilter", {9728, 9729, 9984, 9985, 9986, 9987}, Optional) &&
             sampler.oneOf("wrapS", {33071, 33648, 10497}, Optional) &&
             sampler.oneOf("wrapT", {33071, 33648, 10497}, Optional);
    });
  }

  bool textures() {
    return each("textures", "texture", [&](Fields& texture) {
      return texture.index("sampler", "samplers", count("samplers"), Optional) &&
             texture.index("source", "images", count("images"), Optional);
    });
  }

  bool textureInfo(Fields& owner, const char* name) {
    const json* info = owner.object(name, Optional);
    if (info == nullptr) return owner.sound();
    Fields fields(*info, fmt::format("{}: {}", owner.where(), name), fault_);
    uint64_t index = 0, set = 0;
    if (!fields.index("index", "textures", count("textures"), Required, &index) ||
        !fields.whole("texCoord", 0, kAnyWhole, Optional, &set) ||
        !fields.number("scale", -kAnyNumber, kAnyNumber, Optional))
      return false;
    if (set != 0) return fields.refuse("texCoord", "only TEXCOORD_0 is read");
    if (!section("textures")[index].contains("source"))
      return fields.refuse("index", "this texture has no source image that can be read");
    return true;
  }

  bool materials() {
    return each("materials", "material", [&](Fields& material) {
      if (const json* pbr = material.object("pbrMetallicRoughness", Optional)) {
        Fields fields(*pbr, material.where(), fault_);
        if (!fields.numbers("baseColorFactor", 4, 0, 1) ||
            !fields.number("metallicFactor", 0, 1, Optional) ||
            !fields.number("roughnessFactor", 0, 1, Optional) ||
            !textureInfo(fields, "baseColorTexture") ||
            !textureInfo(fields, "metallicRoughnessTexture"))
          return false;
      }
      return material.sound() && textureInfo(material, "normalTexture") &&
             textureInfo(material, "emissiveTexture") &&
             material.numbers("emissiveFactor", 3, 0, 1) &&
             material.oneOf("alphaMode", {"OPAQUE", "MASK", "BLEND"}, Optional) &&
             material.number("alphaCutoff", 0, kAnyNumber, Optional) &&
             material.boolean("doubleSided") && emissiveStrength(material);
    });
  }

  bool emissiveStrength(Fields& material) {
    const json* extensions = material.object("extensions", Optional);
    if (extensions == nullptr) return material.sound();
    Fields fields(*extensions, material.where(), fault_);
    const json* strength = fields.object("KHR_materials_emissive_strength", Optional);
    if (strength == nullptr) return material.sound();
    Fields inner(*strength, material.where(), fault_);
    return inner.number("emissiveStrength", 0, kAnyNumber, Optional);
  }

  bool meshes() {
    return each("meshes", "mesh", [&](Fields& mesh) {
      const json* primitives = mesh.find("primitives");
      if (primitives == nullptr || !primitives->is_array() || primitives->empty())
        return mesh.refuse("primitives", "must be an array of at least one");
      for (size_t i = 0; i < primitives->size(); ++i) {
        Fields fields((*primitives)[i], fmt::format("{}: primitive {}", mesh.where(), i), fault_);
        if (!fields.isObject() || !primitive(fields)) return false;
      }
      return true;
    });
  }

  bool primitive(Fields& primitive) {
    uint64_t indices = 0, mode = 4;
    if (!primitive.index("material", "materials", count("materials"), Optional) ||
        !primitive.whole("mode", 0, 6, Optional, &mode) ||
        !primitive.index("indices", "accessors", count("accessors"), Optional, &indices))
      return false;
    if (primitive.find("indices") != nullptr) {
      const json& accessor = section("accessors")[indices];
      const auto component = accessor.at("componentType").get<int64_t>();
      if (accessor.at("type") != "SCALAR" || component % 2 == 0 || component > 5125 ||
          !accessor.contains("bufferView"))
        return primitive.refuse("indices",
                                "its accessor must be SCALAR of an unsigned type, with a "
                                "bufferView");
    }
    const json* attributes = primitive.object("attributes", Required);
    if (attributes == nullptr) return false;
    Fields fields(*attributes, primitive.where(), fault_);
    uint64_t vertices = 0;
    return attribute(fields, "POSITION", {"VEC3"}, Required, vertices) &&
           attribute(fields, "NORMAL", {"VEC3"}, Optional, vertices) &&
           attribute(fields, "TANGENT", {"VEC4"}, Optional, vertices) &&
           attribute(fields, "TEXCOORD_0", {"VEC2"}, Optional, vertices) && otherAttributes(fields);
  }

  bool otherAttributes(Fields& attributes) {
    for (const char* name : {"COLOR_0", "JOINTS_0", "WEIGHTS_0", "TEXCOORD_1"})
      if (!attributes.index(name, "accessors", count("accessors"), Optional)) return false;
    return true;
  }

  // Integers are taken as KHR_mesh_quantization defines them.
  bool attribute(Fields& attributes, const char* name,
                 std::initializer_list<std::string_view> types, Presence presence,
                 uint64_t& vertices) {
    uint64_t index = 0;
    if (!attributes.index(name, "accessors", count("accessors"), presence, &index)) return false;
    if (attributes.find(name) == nullptr) return true;
    const json& accessor = section("accessors")[index];
    if (accessor.at("type") != *types.begin() || accessor.at("componentType") == 5125)
      return attributes.refuse(
          name, fmt::format("its accessor must be {} of float, byte or short", *types.begin()));
    const auto elements = accessor.at("count").get<uint64_t>();
    if (elements > limits_.max_vertices)
      return attributes.refuse(name, fmt::format("its {} vertices pass the limit of {}", elements,
                                                 limits_.max_vertices));
    if (vertices == 0) vertices = elements;
    if (vertices != elements)
      return attributes.refuse(
          name, fmt::format("its accessor has {} elements; POSITION has {}", elements, vertices));
    return true;
  }

  bool cameras() {
    return each("cameras", "camera", [&](Fields& camera) {
      std::string type;
      if (!camera.oneOf("type", {"perspective", "orthographic"}, Required) ||
          !camera.text("type", Required, &type))
        return false;
      if (type == "orthographic") return true;
      const json* perspective = camera.object("perspective", Required);
      if (perspective == nullptr) return false;
      Fields fields(*perspective, camera.where(), fault_);
      return fields.number("yfov", 1e-4, kPi - 1e-4, Required) &&
             fields.number("znear", 1e-6, 1e6, Required);
    });
  }

  bool lights() {
    if (lights_ == nullptr) return true;
    return each(*lights_, "light", [&](Fields& light) {
      std::string type;
      if (!light.oneOf("type", {"directional", "point", "spot"}, Required) ||
          !light.text("type", Required, &type) || !light.numbers("color", 3, 0, kAnyNumber) ||
          !light.number("intensity", 0, kAnyNumber, Optional) ||
          !light.number("range", std::numeric_limits<float>::min(), kAnyNumber, Optional))
        return false;
      if (type != "spot") return true;
      const json* spot = light.object("spot", Required);
      if (spot == nullptr) return false;
      Fields fields(*spot, light.where() + ": spot", fault_);
      double inner = 0, outer = kPi / 4;
      if (!fields.number("innerConeAngle", 0, kPi / 2, Optional, &inner) ||
          !fields.number("outerConeAngle", 0, kPi / 2, Optional, &outer))
        return false;
      return inner < outer || fields.refuse("innerConeAngle", "must be below outerConeAngle");
    });
  }

  bool nodes() {
    return each("nodes", "node", [&](Fields& node) {
      const bool matrix = node.find("matrix") != nullptr;
      if (matrix && (node.find("translation") || node.find("rotation") || node.find("scale")))
        return node.refuse("matrix", "excludes translation, rotation and scale");
      const double far = limits_.max_coordinate;
      return node.index("mesh", "meshes", count("meshes"), Optional) &&
             node.index("camera", "cameras", count("cameras"), Optional) &&
             node.index("skin", "skins", count("skins"), Optional) &&
             node.indices("children", "nodes", count("nodes")) &&
             node.numbers("translation", 3, -far, far) && node.numbers("rotation", 4, -2, 2) &&
             node.numbers("scale", 3, -1e6, 1e6) && node.numbers("matrix", 16, -far, far) &&
             nodeLight(node);
    });
  }

  bool nodeLight(Fields& node) {
    const json* extensions = node.object("extensions", Optional);
    if (extensions == nullptr) return node.sound();
    Fields fields(*extensions, node.where(), fault_);
    const json* punctual = fields.object("KHR_lights_punctual", Optional);
    if (punctual == nullptr) return node.sound();
    Fields inner(*punctual, node.where() + ": KHR_lights_punctual", fault_);
    return inner.index("light", "lights", lights_ == nullptr ? 0 : lights_->size(), Required);
  }

  bool scenes() {
    Fields root(json_, file_, fault_);
    return each("scenes", "scene",
                [&](Fields& scene) { return scene.indices("nodes", "nodes", count("nodes")); }) &&
           root.index("scene", "scenes", count("scenes"), Optional);
  }

  const json* lights_ = nullptr;
};

}  // namespace

Status checkDocument(const Document& document, const GltfLimits& limits) {
  std::string fault;
  Checker checker(document, limits, fault);
  if (checker.structure() && checkStorage(document, limits, fault) && checker.objects())
    return Done{};
  return Error{fault};
}

}  // namespace scree::gltf
