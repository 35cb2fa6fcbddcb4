// The shared vocabulary of a scene: placement, camera, lights, meshes, materials, sky, view.
//
// Components are placed in the world in double precision; what the GPU sees is relative to the
// camera. addScene keeps the previous tick's placement (motion vectors, interpolation) and computes
// the frame's View. Meshes and textures reach the GPU when somebody first draws them.
// Cost: one comparison of each Transform with the last tick's, one copy of the tables that moved;
// one upload of the view block (416 bytes) a rendered sample.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/assets/gltf.h"
#include "engine/assets/mesh_data.h"
#include "engine/core/math.h"
#include "engine/core/result.h"
#include "engine/ecs/component.h"
#include "engine/ecs/world.h"
#include "shaders/shared/bindings.h"
#include "shaders/shared/view.h"

namespace scree {

class App;
struct FrameInput;
namespace gpu {
class Buffer;
class Texture;
class VertexArray;
}  // namespace gpu

// ---- Components -----------------------------------------------------------------------------

// world_from_local = translate(position) * rotate(rotation) * scale(scale).
struct Transform {
  dvec3 position{0};
  quat rotation{1, 0, 0, 0};
  vec3 scale{1};
};

// Transform as it was at the previous tick; equal to Transform when spawned.
struct PreviousTransform {
  dvec3 position{0};
  quat rotation{1, 0, 0, 0};
  vec3 scale{1};
};

struct Name {
  char text[64] = {};  // zero-terminated; longer names are cut
};

// Looks along -Z of its Transform, +Y up. No far plane.
struct Camera {
  float fov_y_rad = 0.8f;
  float near_m = 0.1f;
};

enum class LightKind : uint32_t { Directional, Point, Spot };

// Shines along -Z of its Transform.
struct Light {
  LightKind kind = LightKind::Directional;
  vec3 color{1};             // linear
  float intensity = 1;       // lux (directional), candela (point, spot)
  float range_m = 0;         // 0: unlimited
  float inner_cone_rad = 0;  // half-angles of a spot
  float outer_cone_rad = 0.785398163f;
};

// Draw a mesh of the MeshStore at the entity's Transform.
struct MeshInstance {
  static constexpr uint32_t kOwnMaterials = 0xffffffffu;
  uint32_t mesh = 0;
  uint32_t material = kOwnMaterials;  // for all parts; kOwnMaterials: each part's own
};

// The entity's mesh or grain is drawn into shadow maps. Mesh instances of a file get it unless the
// node's extras say {"CastsShadow": false}.
struct CastsShadow {};

// Radiance of the sky by direction: zenith (+Y), horizon, ground (-Y); between them
// L(d) = a + b d.y + c d.y^2 a channel, with a = horizon, b = (zenith - ground) / 2,
// c = (zenith + ground) / 2 - horizon. World singleton; {"Sky": {...}} in the extras of a file's
// node sets it. Neither hashed nor saved: no rule depends on it.
struct Sky {
  vec3 zenith{0.18f, 0.32f, 0.65f};
  vec3 horizon{0.60f, 0.68f, 0.75f};
  vec3 ground{0.16f, 0.14f, 0.12f};
};

// ---- World singletons -----------------------------------------------------------------------

// The camera that View is computed from; loadScene sets it to the file's first camera unless it
// already names a living one. None: at the origin, looking along -Z.
struct ActiveCamera {
  Entity entity = Entity::kNone;
};

// The camera of the frame; written by scene.view in Phase::Prepare. On the GPU: the uniform block
// of shaders/shared/view.h, bound to kViewBinding.
struct View {
  rules::ViewBlock block{};
  dvec3 position{0};           // camera, world, interpolated
  dvec3 previous_position{0};  // at the previous rendered frame
  quat rotation{1, 0, 0, 0};   // world from view
};

// A sphere around a mesh, local space.
struct LocalBounds {
  vec3 min{0}, max{0};
  vec3 center{0};
  float radius = 0;
};

// Triangles of a mesh that share a material: indices [first_index, first_index + index_count) of
// the pool's index buffer (32 bit), to which base_vertex is added.
struct MeshPart {
  uint32_t first_index = 0;
  uint32_t index_count = 0;
  int32_t base_vertex = 0;
  uint32_t vertex_count = 0;
  uint32_t material = 0;  // of the MaterialStore
};

struct StoredMesh {
  std::string name;
  std::vector<MeshPart> parts;
  LocalBounds bounds;
};

// All static meshes: one vertex pool and one index pool, on the CPU and, once drawn, on the GPU.
class MeshStore {
 public:
  MeshStore();
  ~MeshStore();
  MeshStore(MeshStore&&) noexcept;
  MeshStore& operator=(MeshStore&&) noexcept;

  // Appends a mesh and returns its handle; the parts' `material` fields are handles of the
  // MaterialStore (negative: its default). Ends the program if an index is out of range or the pool
  // would pass 2^31 vertices or 2^32 indices.
  uint32_t add(std::string name, std::span<const MeshData> parts);
  uint32_t add(const MeshData& mesh);

  size_t size() const;
  // Handles are never reused; an unknown one ends the program.
  const StoredMesh& mesh(uint32_t handle) const;
  std::span<const Vertex> vertices(const MeshPart& part) const;
  std::span<const uint32_t> indices(const MeshPart& part) const;  // relative to base_vertex

  // Vertex array over both pools: attributes kPositionAttribute to kUvAttribute of slot 0, index
  // buffer bound. Creates the buffers at the first call, uploads what was added since the last.
  // Ends the program if the store is empty.
  gpu::VertexArray& vertexArray();
  // Gives an array of a module's own the same vertices and indices; to be done again when
  // poolVersion() has changed. Attributes from kFirstFreeAttribute up and buffer slots from 1 up are
  // the module's.
  void attach(gpu::VertexArray& array);
  // The buffers behind it, for a module with its own vertex array, uploaded likewise. They are
  // replaced when the pool grows: look again when poolVersion() has changed.
  const gpu::Buffer& vertexBuffer();
  const gpu::Buffer& indexBuffer();
  uint64_t poolVersion() const;
  // False until somebody drew.
  bool onGpu() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

enum class MaterialMap : uint32_t { BaseColor, MetallicRoughness, Normal, Emissive };
inline constexpr uint32_t kMaterialMaps = 4;

// All materials and their images; handle 0 is the default material (white, metallic 0, roughness
// 1).
class MaterialStore {
 public:
  MaterialStore();
  ~MaterialStore();
  MaterialStore(MaterialStore&&) noexcept;
  MaterialStore& operator=(MaterialStore&&) noexcept;

  // Appends an image and returns its index, for the image fields of materials.
  int addImage(ImageData image);
  // Appends a material whose image fields are indices returned by addImage, or -1.
  uint32_t add(MaterialData material);

  size_t size() const;
  size_t imageCount() const;
  const MaterialData& material(uint32_t handle) const;
  const ImageData& image(int index) const;

  // The texture of a map, with the sampling that the material asks for, or the neutral 1x1 texture
  // of that map (white; for normals +Z); uploaded with mipmaps at the first call. An image larger
  // than the GPU takes is replaced by the neutral one, with one error in the log.
  const gpu::Texture& texture(uint32_t material, MaterialMap map);
  // Binds the four maps to kBaseColorUnit ... kEmissiveMapUnit.
  void bind(uint32_t material);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// ---- Functions ------------------------------------------------------------------------------

// Registers scene.keep_previous (Simulate: before systems registered later) and scene.view
// (Prepare).
void addScene(App& app);

// Spawns a glTF file's nodes: Name, Transform, PreviousTransform, and what they have of
// MeshInstance, CastsShadow, Camera, Light, and the components of their extras; meshes, materials
// and images are appended to the stores. On an error no entity has been spawned. `spawned` receives the
// entities in the order of SceneData::nodes. A file that was loaded before and has the same size
// and time of change is not read again, and its meshes and materials keep their handles.
Status loadScene(World& world, const std::filesystem::path& path,
                 std::vector<Entity>* spawned = nullptr);
Status loadScene(App& app, const std::filesystem::path& path,
                 std::vector<Entity>* spawned = nullptr);

PreviousTransform previousOf(const Transform& transform);
// Placement at a time between the previous tick (0) and the current one (1); t < 0 extrapolates.
// Rotation takes the shorter way round.
Transform interpolate(const PreviousTransform& previous, const Transform& current, double t);

// Placement for the GPU: relative_from_local = translate(position - camera) * rotate * scale; the
// difference is taken in double precision.
mat4 relativeFromLocal(const Transform& transform, const dvec3& camera_position);

// The frame's view from a camera's placement at the previous and current tick. Pure; the matrices
// are computed in double precision and rounded once. The frame is at input.alpha between the ticks,
// the previous frame at input.alpha - input.motion_scale.
View computeView(const PreviousTransform& previous, const Transform& current, const Camera& camera,
                 const FrameInput& input);

// True if a sphere (relative space, m) may touch the view; never false for one that does.
bool sphereInView(const View& view, const vec3& center_relative, float radius);

Name makeName(std::string_view text);

SCREE_COMPONENT(Transform, (position, "m"), (rotation, ""), (scale, ""));
SCREE_COMPONENT(PreviousTransform, (position, "m"), (rotation, ""), (scale, ""));
SCREE_COMPONENT(Name, (text, ""));
SCREE_COMPONENT(Camera, (fov_y_rad, "rad"), (near_m, "m"));
SCREE_COMPONENT(Light, (kind, ""), (color, ""), (intensity, "lx or cd"), (range_m, "m"),
                (inner_cone_rad, "rad"), (outer_cone_rad, "rad"));
SCREE_COMPONENT(MeshInstance, (mesh, ""), (material, ""));
SCREE_COMPONENT(CastsShadow);
SCREE_COMPONENT_TRANSIENT(Sky, (zenith, "W/(m2 sr)"), (horizon, "W/(m2 sr)"),
                          (ground, "W/(m2 sr)"));

}  // namespace scree
