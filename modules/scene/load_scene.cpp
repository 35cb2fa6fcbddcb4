// loadScene: a glTF file to entities, all or nothing.
#include <fmt/format.h>

#include <map>
#include <optional>
#include <unordered_map>

#include "engine/assets/extras.h"
#include "modules/scene/scene.h"

namespace scree {
namespace fs = std::filesystem;
namespace {

// A file whose meshes and materials are in the stores, ready to be spawned any number of times.
struct LoadedFile {
  uintmax_t bytes = 0;
  fs::file_time_type changed;
  std::vector<NodeData> nodes;
  std::vector<CameraData> cameras;
  std::vector<LightData> lights;
  std::vector<ParsedExtras> extras;             // one a node
  std::vector<std::optional<uint32_t>> meshes;  // of the MeshStore, one a node
};

// World singleton: what loadScene has read, by path.
struct LoadedFiles {
  std::map<fs::path, LoadedFile> files;
};

std::string nodeText(const fs::path& path, const NodeData& node) {
  return node.name.empty()
             ? fmt::format("{}: node {}", path.string(), node.index)
             : fmt::format("{}: node {} \"{}\"", path.string(), node.index, node.name);
}

// What the node itself says may not be said again by its extras.
Status checkExtras(const ParsedExtras& extras, const std::string& where) {
  for (const ParsedExtras::Value& value : extras.values)
    for (const char* reserved : {"Transform", "PreviousTransform", "Name", "MeshInstance"})
      if (value.component->name == reserved)
        return Error{fmt::format("{}: extras: {}: is set by the node itself; must be left out",
                                 where, reserved)};
  return Done{};
}

Status parseAllExtras(const SceneData& scene, std::vector<ParsedExtras>& extras) {
  std::unordered_map<std::string_view, size_t> names;
  for (const NodeData& node : scene.nodes) ++names[node.name];
  const CountNodes count = [&](std::string_view name) {
    const auto found = names.find(name);
    return found == names.end() ? size_t{0} : found->second;
  };
  for (const NodeData& node : scene.nodes) {
    const std::string where = nodeText(scene.path, node);
    Result<ParsedExtras> parsed = parseExtras(node.extras, where, count);
    if (!parsed.ok()) return parsed.takeError();
    if (Status checked = checkExtras(*parsed, where); !checked.ok()) return checked;
    extras.push_back(std::move(*parsed));
  }
  return Done{};
}

// Moves images, materials and meshes into the stores. Cannot fail: loadGltf has checked the
// indices.
void store(World& world, SceneData& scene, LoadedFile& file) {
  auto& materials = world.singleton<MaterialStore>();
  auto& meshes = world.singleton<MeshStore>();
  std::vector<int> images;
  for (ImageData& image : scene.images) images.push_back(materials.addImage(std::move(image)));
  std::vector<uint32_t> handles;
  for (MaterialData& material : scene.materials) {
    for (TextureUse* use : {&material.base_color_map, &material.metallic_roughness_map,
                            &material.normal_map, &material.emissive_map})
      if (use->image >= 0) use->image = images[static_cast<size_t>(use->image)];
    handles.push_back(materials.add(std::move(material)));
  }
  for (MeshData& mesh : scene.meshes)
    mesh.material =
        mesh.material < 0 ? 0 : static_cast<int>(handles[static_cast<size_t>(mesh.material)]);
  std::map<int, uint32_t> stored;
  for (const NodeData& node : scene.nodes) {
    file.meshes.emplace_back();
    if (node.first_mesh < 0) continue;
    const auto [entry, is_new] = stored.try_emplace(node.first_mesh, 0);
    if (is_new) {
      const auto first = static_cast<size_t>(node.first_mesh);
      const std::span<const MeshData> parts(scene.meshes.data() + first,
                                            static_cast<size_t>(node.mesh_count));
      entry->second = meshes.add(parts.front().name, parts);
    }
    file.meshes.back() = entry->second;
  }
}

Result<LoadedFile> read(World& world, const fs::path& path) {
  Result<SceneData> scene = loadGltf(path);
  if (!scene.ok()) return scene.takeError();
  LoadedFile file;
  if (Status parsed = parseAllExtras(*scene, file.extras); !parsed.ok()) return parsed.takeError();
  store(world, *scene, file);
  file.nodes = std::move(scene->nodes);
  file.cameras = std::move(scene->cameras);
  file.lights = std::move(scene->lights);
  return file;
}

Light lightOf(const LightData& data) {
  Light light;
  light.kind = static_cast<LightKind>(data.kind);
  light.color = data.color;
  light.intensity = data.intensity;
  light.range_m = data.range_m;
  light.inner_cone_rad = data.inner_cone_rad;
  light.outer_cone_rad = data.outer_cone_rad;
  return light;
}
static_assert(static_cast<int>(LightKind::Spot) == static_cast<int>(LightData::Kind::Spot));

Entity spawnNode(World& world, const LoadedFile& file, size_t index) {
  const NodeData& node = file.nodes[index];
  const Transform transform{node.position, node.rotation, node.scale};
  const Entity entity = world.spawn(makeName(node.name), transform, previousOf(transform));
  if (file.meshes[index]) {
    world.add(entity, MeshInstance{*file.meshes[index]});
    world.add(entity, CastsShadow{});
  }
  if (node.camera >= 0) {
    const CameraData& camera = file.cameras[static_cast<size_t>(node.camera)];
    world.add(entity, Camera{camera.fov_y_rad, camera.near_m});
  }
  if (node.light >= 0) world.add(entity, lightOf(file.lights[static_cast<size_t>(node.light)]));
  return entity;
}

std::vector<Entity> spawn(World& world, const LoadedFile& file) {
  std::vector<Entity> entities;
  std::unordered_map<std::string_view, Entity> named;
  for (size_t i = 0; i < file.nodes.size(); ++i) {
    entities.push_back(spawnNode(world, file, i));
    named[file.nodes[i].name] = entities.back();
  }
  const FindNode find = [&](std::string_view name) { return named.at(name); };
  for (size_t i = 0; i < entities.size(); ++i) attach(world, entities[i], file.extras[i], find);
  return entities;
}

// What components say of where they stand.
Status checkInWorld(World& world, const fs::path& path, const LoadedFile& file, std::span<const Entity> entities) {
  for (size_t i = 0; i < entities.size(); ++i)
    for (const ParsedExtras::Value& value : file.extras[i].values) {
      const ComponentInfo& info = *value.component;
      if (!value.present || info.fault_in == nullptr) continue;
      const std::string wrong = info.fault_in(world, entities[i], world.peek(entities[i], info.id));
      if (!wrong.empty())
        return Error{fmt::format("{}: extras: {}: {}", nodeText(path, file.nodes[i]), info.name, wrong)};
    }
  return Done{};
}

void setSkyAndCamera(World& world, std::span<const Entity> entities) {
  Entity& active = world.singleton<ActiveCamera>().entity;
  for (const Entity entity : entities) {
    if (const Sky* sky = world.peek<Sky>(entity)) world.singleton<Sky>() = *sky;
    if (!world.alive(active) && world.has<Camera>(entity)) active = entity;
  }
}

}  // namespace

Status loadScene(World& world, const fs::path& path, std::vector<Entity>* spawned) {
  std::error_code code;
  const uintmax_t bytes = fs::file_size(path, code);
  const fs::file_time_type changed = code ? fs::file_time_type{} : fs::last_write_time(path, code);
  auto& files = world.singleton<LoadedFiles>().files;
  auto known = files.find(path);
  if (code || known == files.end() || known->second.bytes != bytes ||
      known->second.changed != changed) {
    Result<LoadedFile> file = read(world, path);
    if (!file.ok()) return file.takeError();
    file->bytes = bytes;
    file->changed = changed;
    known = files.insert_or_assign(path, std::move(*file)).first;
  }
  std::vector<Entity> entities = spawn(world, known->second);
  if (Status checked = checkInWorld(world, path, known->second, entities); !checked.ok()) {
    world.destroyMany(entities);
    return checked;
  }
  setSkyAndCamera(world, entities);
  if (spawned != nullptr) *spawned = std::move(entities);
  return Done{};
}

}  // namespace scree
