// The node tree of a glTF scene, flattened to world placements; cameras and lights.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/assets/gltf_convert.h"
#include "engine/core/log.h"

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

namespace scree::gltf {
using nlohmann::json;
namespace {

// world_from_local of an affine placement, in double precision.
struct Affine {
  glm::dmat3 linear{1.0};
  dvec3 position{0};
};

Affine localOf(const tinygltf::Node& node) {
  Affine local;
  if (node.matrix.size() == 16) {
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row)
        local.linear[column][row] = node.matrix[static_cast<size_t>(column * 4 + row)];
    local.position = {node.matrix[12], node.matrix[13], node.matrix[14]};
    return local;
  }
  if (node.translation.size() == 3)
    local.position = {node.translation[0], node.translation[1], node.translation[2]};
  glm::dquat rotation(1, 0, 0, 0);
  if (node.rotation.size() == 4)
    rotation = glm::normalize(
        glm::dquat(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]));
  local.linear = glm::mat3_cast(rotation);
  if (node.scale.size() == 3)
    for (int axis = 0; axis < 3; ++axis)
      local.linear[axis] *= node.scale[static_cast<size_t>(axis)];
  return local;
}

class Flattener {
 public:
  Flattener(const tinygltf::Model& model, const Document& document, const GltfLimits& limits,
            const std::vector<MeshRange>& ranges, SceneData& scene)
      : model_(model), document_(document), limits_(limits), ranges_(ranges), scene_(scene) {}

  Status run() {
    if (Status tree = findParents(); !tree.ok()) return tree;
    struct Entry {
      int node;
      int parent;  // in scene_.nodes
      int depth;
      Affine parent_affine;
    };
    std::vector<Entry> stack;
    const std::vector<int> roots = this->roots();
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) {
      if (parents_[static_cast<size_t>(*root)] >= 0)
        return fault(*root, "children", "a node of a scene must not be a child");
      stack.push_back({*root, -1, 1, {}});
    }
    while (!stack.empty()) {
      const Entry entry = stack.back();
      stack.pop_back();
      if (entry.depth > limits_.max_node_depth)
        return fault(entry.node, "children",
                     fmt::format("nested deeper than {}", limits_.max_node_depth));
      const tinygltf::Node& node = model_.nodes[static_cast<size_t>(entry.node)];
      const Affine local = localOf(node);
      const Affine world{
          entry.parent_affine.linear * local.linear,
          entry.parent_affine.linear * local.position + entry.parent_affine.position};
      if (Status placed = place(entry.node, entry.parent, world); !placed.ok()) return placed;
      const int self = static_cast<int>(scene_.nodes.size()) - 1;
      for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
        stack.push_back({*child, self, entry.depth + 1, world});
    }
    return Done{};
  }

 private:
  Error fault(int node, std::string_view field, std::string_view what) const {
    const auto index = static_cast<size_t>(node);
    return Error{fmt::format("{}: {}: {}: {}", scene_.path.string(),
                             objectName("node", index, document_.json.at("nodes")[index]), field,
                             what)};
  }

  // One parent at most a node, and no cycles: what cannot be reached from a root goes in a circle.
  Status findParents() {
    parents_.assign(model_.nodes.size(), -1);
    for (size_t i = 0; i < model_.nodes.size(); ++i)
      for (int child : model_.nodes[i].children) {
        int& parent = parents_[static_cast<size_t>(child)];
        if (parent >= 0)
          return fault(static_cast<int>(i), "children",
                       fmt::format("node {} is a child of node {} already", child, parent));
        parent = static_cast<int>(i);
      }
    std::vector<int> reached;
    for (size_t i = 0; i < parents_.size(); ++i)
      if (parents_[i] < 0) reached.push_back(static_cast<int>(i));
    for (size_t at = 0; at < reached.size(); ++at)
      for (int child : model_.nodes[static_cast<size_t>(reached[at])].children)
        reached.push_back(child);
    if (reached.size() == parents_.size()) return Done{};
    std::vector<bool> seen(parents_.size(), false);
    for (int node : reached) seen[static_cast<size_t>(node)] = true;
    const auto lost = std::find(seen.begin(), seen.end(), false) - seen.begin();
    return fault(static_cast<int>(lost), "children", "the node is its own ancestor");
  }

  std::vector<int> roots() const {
    std::vector<int> nodes;
    if (!model_.scenes.empty()) {
      nodes = model_.scenes[static_cast<size_t>(std::max(model_.defaultScene, 0))].nodes;
      std::vector<bool> seen(parents_.size(), false);
      std::erase_if(nodes, [&](int node) {
        const bool again = seen[static_cast<size_t>(node)];
        seen[static_cast<size_t>(node)] = true;
        return again;
      });
      return nodes;
    }
    for (size_t i = 0; i < parents_.size(); ++i)
      if (parents_[i] < 0) nodes.push_back(static_cast<int>(i));
    return nodes;
  }

  Status place(int index, int parent, const Affine& world) {
    const tinygltf::Node& node = model_.nodes[static_cast<size_t>(index)];
    const json& source = document_.json.at("nodes")[static_cast<size_t>(index)];
    NodeData data;
    data.name = node.name;
    data.index = index;
    data.parent = parent;
    data.position = world.position;
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(world.position[axis]) <= limits_.max_coordinate))
        return fault(index, "translation",
                     fmt::format("world position {} = {}; at most {} in size", "xyz"[axis],
                                 world.position[axis], limits_.max_coordinate));
    if (node.rotation.size() == 4 && node.rotation[0] == 0 && node.rotation[1] == 0 &&
        node.rotation[2] == 0 && node.rotation[3] == 0)
      return fault(index, "rotation", "[0, 0, 0, 0] is no rotation");
    if (Status split = decompose(index, world.linear, data); !split.ok()) return split;
    if (node.mesh >= 0) {
      const MeshRange& range = ranges_[static_cast<size_t>(node.mesh)];
      data.first_mesh = range.first;
      data.mesh_count = range.count;
    }
    if (node.camera >= 0) data.camera = camera(node.camera);
    if (const auto extension = node.extensions.find("KHR_lights_punctual");
        extension != node.extensions.end())
      data.light = light(extension->second.Get("light").GetNumberAsInt());
    if (const auto extras = source.find("extras"); extras != source.end()) data.extras = *extras;
    scene_.nodes.push_back(std::move(data));
    return Done{};
  }

  // linear = rotate * scale, if its columns are perpendicular; a mirror goes into scale.x.
  Status decompose(int index, glm::dmat3 linear, NodeData& data) const {
    dvec3 scale;
    for (int axis = 0; axis < 3; ++axis) {
      scale[axis] = glm::length(linear[axis]);
      if (!(scale[axis] > 1e-9) || !(scale[axis] < 1e9))
        return fault(
            index, "scale",
            fmt::format("world scale {} = {}; must be from 1e-9 to 1e9", "xyz"[axis], scale[axis]));
      linear[axis] /= scale[axis];
    }
    for (int axis = 0; axis < 3; ++axis) {
      const double cosine = glm::dot(linear[axis], linear[(axis + 1) % 3]);
      if (std::abs(cosine) > 1e-4)
        return fault(index, "scale",
                     fmt::format("axes {} and {} are not perpendicular (cosine {:.4f}): a rotation "
                                 "under a non-uniform scale shears; apply the scale of the parents",
                                 "xyz"[axis], "xyz"[(axis + 1) % 3], cosine));
    }
    if (glm::determinant(linear) < 0) {
      linear[0] = -linear[0];
      scale.x = -scale.x;
    }
    const glm::dquat rotation = glm::normalize(glm::quat_cast(linear));
    data.rotation = quat(rotation);
    data.scale = vec3(scale);
    return Done{};
  }

  // A camera a node that has one, in the order of the nodes.
  int camera(int index) {
    const tinygltf::Camera& source = model_.cameras[static_cast<size_t>(index)];
    if (source.type != "perspective") {
      logWarning("{}: camera {}: type = {}: only perspective is read", scene_.path.string(), index,
                 printable(source.type));
      return -1;
    }
    CameraData camera;
    camera.name = source.name;
    camera.fov_y_rad = static_cast<float>(source.perspective.yfov);
    camera.near_m = static_cast<float>(source.perspective.znear);
    scene_.cameras.push_back(std::move(camera));
    return static_cast<int>(scene_.cameras.size()) - 1;
  }

  int light(int index) {
    const tinygltf::Light& source = model_.lights[static_cast<size_t>(index)];
    LightData light;
    light.name = source.name;
    light.kind = source.type == "point"  ? LightData::Kind::Point
                 : source.type == "spot" ? LightData::Kind::Spot
                                         : LightData::Kind::Directional;
    if (source.color.size() == 3)
      for (int c = 0; c < 3; ++c)
        light.color[c] = static_cast<float>(source.color[static_cast<size_t>(c)]);
    light.intensity = static_cast<float>(source.intensity);
    light.range_m = static_cast<float>(source.range);
    if (light.kind == LightData::Kind::Spot) {
      light.inner_cone_rad = static_cast<float>(source.spot.innerConeAngle);
      light.outer_cone_rad = static_cast<float>(source.spot.outerConeAngle);
    }
    scene_.lights.push_back(std::move(light));
    return static_cast<int>(scene_.lights.size()) - 1;
  }

  const tinygltf::Model& model_;
  const Document& document_;
  const GltfLimits& limits_;
  const std::vector<MeshRange>& ranges_;
  SceneData& scene_;
  std::vector<int> parents_;
};

}  // namespace

Status convertNodes(const tinygltf::Model& model, const Document& document,
                    const GltfLimits& limits, const std::vector<MeshRange>& ranges,
                    SceneData& scene) {
  return Flattener(model, document, limits, ranges, scene).run();
}

}  // namespace scree::gltf
