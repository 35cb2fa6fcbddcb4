// Grains at every scale: of millions of turned and scaled copies of one shape, each is drawn as a mesh, an
// impostor, a point or not at all, by the error that this makes on the screen.
//
// Method: Michel and Boubekeur 2020, "Real Time Multiscale Rendering of Dense Dynamic Stackings", sections 6 to
// 9, with lists made by prefix sums in place of atomics (the same lists in every run), thresholds from measured
// errors, and hysteresis. In: Swarm, the stores below, View. Out: external resources kSwarmRoutes and
// kSwarmLists, from which modules draw; meshes are drawn here, the rest by modules/impostors and modules/points.
// Cost: 30.8 bytes a grain on the GPU; a frame reads each grain that may show once or twice, and nothing comes back.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/math.h"
#include "engine/core/result.h"
#include "engine/ecs/component.h"
#include "engine/ecs/entity.h"
#include "engine/ecs/world.h"
#include "engine/gpu/objects.h"
#include "modules/scene/scene.h"
#include "shaders/shared/swarm.h"

namespace scree {

class App;
struct MeshData;

// ---- What a swarm is ---------------------------------------------------------------------------

// How far from the mesh an impostor is at most, at sizes on the screen from that of the entry before to this one.
struct SizeError {
  float size_px = 0;        // outer radius
  float outline = 0;        // how far outlines are off, on the average along one, outer radii
  float small_outline = 0;  // the same of the nearest view alone
  float near = 0, small_near = 0;  // and what is added to these: times outer radius / distance of the eye
  float ssim = 1;           // at this size: structural similarity to the mesh with many samples a pixel
  float mesh_ssim = 1;      // the same of the mesh with one sample a pixel: nothing that is not filtered is better
  float small_ssim = 1;     // as `ssim`, outlined by the nearest view alone
};

// What all grains of a swarm look like. Lengths are those of its mesh.
struct GrainShape {
  std::string name;
  vec3 center{0};
  float outer_radius = 1;  // of the sphere around the whole mesh
  float inner_radius = 0;  // of that within it; both about `center`
  rules::Ellipsoid bound = rules::unitBall();  // the whole mesh lies in it; lengths are outer radii, from `center`
  struct Level {
    uint32_t mesh = 0;  // of the MeshStore; up to rules::kMeshParts parts, the same materials in all levels
    float error = 0;    // largest distance to the finest level / outer radius
  };
  std::vector<Level> levels;             // finest first; 1 to rules::kMeshLevels
  vec3 albedo{1};                        // mean over its surface, linear
  float roughness = 1, metallic = 0;     // likewise
  float cast_share = 1;                  // radius of a ball with the mean shadow of the mesh / outer radius
  float facing = 1;                      // mean cosine between a face and the normals that it is shaded by
  // How far the outline of a disc of that radius is off at most, in outer radii. If nobody knows better: the mean distance
  // of a disc's points from its centre.
  float point_outline = 2.0f / 3;
  std::vector<SizeError> impostor;   // by rising size; empty: it has none
};

// A grain as a program gives it.
struct SwarmGrain {
  vec3 position{0};          // relative to the swarm's origin, m
  float radius = 1;          // outer, m
  quat rotation{1, 0, 0, 0};
  vec3 tint{1};              // of the shape's colour, linear, [0, 1]
  float roughness = 1;       // factor of the shape's, [0, 1]
  uint16_t seed = 0;  // a number of its own; with the tint, it says at which size it becomes a point
};
rules::SwarmRecord packed(const SwarmGrain& grain, float largest_radius);
// Whether it is finite, its axes are perpendicular and have a length, and what it says of itself is so.
bool soundEllipsoid(const rules::Ellipsoid& ellipsoid);

// What a grain may measure; others are left out. Radii are kept as shares of the swarm's largest, in steps of 1/65,535.
inline constexpr float kMostSwarmExtent = 1e9f;  // a coordinate, from the swarm's origin, m
inline constexpr float kMostSwarmRadius = 1e4f;  // m

// Grains of a swarm that lie in one buffer.
inline constexpr uint32_t kSwarmChunk = 1u << 22;  // 96 MiB: below the least storage block of GL, 128 MiB

// Shapes and swarms. World singleton. Handles are never reused; an unknown one ends the program.
class SwarmStore {
 public:
  // Ends the program if the shape has no level or too many, a number that is not finite or below what it can be, or
  // impostor sizes that fall; its meshes must have been added to the MeshStore.
  uint32_t addShape(GrainShape shape);
  const GrainShape& shape(uint32_t handle) const;
  size_t shapeCount() const { return shapes_.size(); }

  // Grains that are not allowed (above) are left out, and counted. They are
  // stored in an order in which neighbours are near each other: runs of them are then hidden, or far, as a whole.
  uint32_t add(std::string name, uint32_t shape, std::span<const SwarmGrain> grains);
  // The same for many: `fill` writes records [first, first + records.size()), whose radii are shares of
  // largest_radius (m, above 0), in several calls. Stored as they come: in an order as above they draw much
  // faster, and from afar, where some stand for all, better.
  using Fill = std::function<void(uint64_t first, std::span<rules::SwarmRecord> records)>;
  uint32_t add(std::string name, uint32_t shape, uint64_t count, float largest_radius, const Fill& fill);
  // New grains in place of the old; as many or not. Grain k keeps what it was drawn as, whatever its place. None: the
  // swarm's memory is given back.
  void replace(uint32_t swarm, std::span<const SwarmGrain> grains);

  struct Stored {
    std::string name;
    uint32_t shape = 0;
    float largest_radius = 1, least_radius = 1;  // m
    float least_roughness = 1, most_roughness = 1;  // factors of the shape's
    uint64_t count = 0;
    uint64_t refused = 0;  // left out
    vec3 min{0}, max{0};   // of the centres, m
    uint64_t version = 0;  // goes up when the grains change
    std::vector<std::vector<rules::SwarmRecord>> chunks;  // kSwarmChunk each, but the last
    std::vector<uint32_t> order;  // of grains as they were given, by place in space; of such swarms alone
    double sorted_step_m = 0;     // mean distance of neighbours in it when it was made
  };
  const Stored& swarm(uint32_t handle) const;
  size_t swarmCount() const { return swarms_.size(); }

 private:
  std::vector<GrainShape> shapes_;
  std::vector<Stored> swarms_;
};

// Draws a swarm of the SwarmStore; its origin is at the entity's Transform, of which only the position counts. With
// CastsShadow beside it, the grains cast shadows.
struct Swarm {
  uint32_t swarm = 0;
};
SCREE_COMPONENT(Swarm, (swarm, ""));

// ---- How it is drawn ---------------------------------------------------------------------------

// What is shown in place of the picture, to see how a swarm is drawn; colours: shaders/shared/swarm_view.h. Ids of
// grains are then numbers of grains, not entities, in Representation and Frozen.
enum class SwarmView : uint32_t {
  Off,
  Representation,  // each in its own colour
  // How many grains were written to a pixel, one over the other, by passes that draw their coverage; of points: how
  // many were added up.
  Overdraw,
  // Grains stay routed and culled for the camera of the last frame before, whatever it does now: what it did not see
  // is missing. Orange was drawn first, blue after the depth pyramid. Swarms that come now, or change their number
  // of grains, are missing too.
  Frozen,
};

// World singleton.
struct LodSettings {
  float tolerance_px = 0.5f;  // how far outlines may be off
  float least_ssim = 0.95f;   // an impostor is used at sizes at which it is this similar, or as the mesh is
  float band = 0.05f;         // share by which a threshold must be passed before a grain changes
  bool cull = true;           // what the depth pyramid hides; false: for tests and pictures of it
  // For benches: draws all as one representation if it is possible; kNotDrawn: chosen by the rest.
  uint32_t only = rules::kNotDrawn;
  SwarmView view = SwarmView::Off;
};

// Sizes (outer radii in pixels) at which one representation follows the other.
struct LodThresholds {
  float point_px = 0, impostor_from_px = 0, impostor_px = 0;
  float small_px = 0;  // below it an impostor of one view is enough
  float mesh_px[rules::kMeshLevels] = {};
};
// `stretch`: 1 + the squared tangents to the picture's corner.
LodThresholds thresholdsOf(const GrainShape& shape, const LodSettings& settings, float pixels_at_1m, float stretch = 1);

// A bound, in pixels at the picture's middle, of how far the outline of a grain drawn so is off: the area between it and
// the mesh's, in the same perspective, over the length of the mesh's. A point is a disc; a mesh level by its largest distance to the finest, which perspective
// enlarges on the side of the eye; impostors and points by the worst that was found, and a margin. Below 0: unknown.
float outlineErrorPx(const GrainShape& shape, uint32_t representation, float size_px, float pixels_at_1m);

// Radius of a disc with the mean shadow of a convex body of this surface (m^2, or any unit's): a quarter of it (Cauchy).
double meanShadowRadius(double surface);

// The levels of a mesh, simplified, in the MeshStore; the parts' materials are handles of the MaterialStore
// (negative: its default). Each level has about a third of the triangles of the one before, as long as it can be
// simplified; the edges of several parts stay as they are. Sets levels; outer_radius must be set. Refuses more than
// rules::kMeshParts parts, and a mesh without a triangle.
Status addLevels(MeshStore& meshes, GrainShape& shape, std::span<const MeshData> parts);
// Sets albedo, roughness, metallic and facing to their means over the mesh, and cast_share: the mean shadow of a
// convex body is a quarter of its surface (Cauchy).
void setMeanLook(const MaterialStore& materials, GrainShape& shape, std::span<const MeshData> parts);

// ---- For modules that draw grains --------------------------------------------------------------

// External resources: what Stage::Route chose; lists of that; lists of what is drawn after the depth pyramid.
inline constexpr std::string_view kSwarmRoutes = "lod.routes";  // representations, of all grains
inline constexpr std::string_view kSwarmLists = "lod.lists";
inline constexpr std::string_view kSwarmLateLists = "lod.late_lists";

// Target: the number of the grain that each pixel shows, over all that is drawn, + 1; 0: none. Passes that draw
// grains of SwarmsDrawn, points excepted, write it.
inline constexpr std::string_view kSwarmVisible = "lod.visible";

// Targets: how often a pixel was written, by passes that write kSwarmVisible; and how many points were added up there.
// Read in SwarmView::Overdraw alone: otherwise not made, and programs are those that do not write it.
inline constexpr std::string_view kSwarmOverdraw = "lod.overdraw";
inline constexpr std::string_view kPointOverdraw = "lod.point_overdraw";

// The grains of one buffer that is drawn in this frame.
struct SwarmPart {
  uint32_t shape = 0;
  uint32_t first = 0, count = 0, runs = 0;  // numbers of its grains, over all that is drawn
  float largest_radius = 0;                 // outer, m
  float least_roughness = 1, most_roughness = 1;  // factors of the shape's
  uint32_t possible = 0;                    // a bit for each representation that some of its grains may have
  const gpu::Buffer* commands = nullptr;
  const gpu::Buffer* list = nullptr;
};
// World singleton; made anew in each Phase::Prepare.
class SwarmsDrawn {
 public:
  size_t size() const;
  uint64_t grainCount() const;
  const SwarmPart& part(size_t index) const;
  void bind(size_t index) const;
  // Whether some grain may be drawn as this representation: by shape, settings, and how far away its swarm is.
  bool mayBe(uint32_t representation) const;

  struct State;
  std::shared_ptr<State> state;
};

// Tiles of the picture that programs mark with lib/mark_tiles.glsl, and that lib/tiles.vert draws: shared/tiles.h. Passes
// declare an external resource of theirs for it: StorageWrite where tiles are marked or emptied, Indirect and StorageRead
// where they are drawn.
class MarkedTiles {
 public:
  explicit MarkedTiles(std::string label) : label_(std::move(label)) {}
  // For a picture of this size; bound for what marks them. None is marked, if the last frame that marked some emptied them.
  void ready(ivec2 size_px);
  void bind() const;
  // Binds them and draws the marked ones, with the program in use.
  void draw() const;
  // Runs the program in use, made of lib/empty_tiles.glsl, a group a tile; not at all if none is marked.
  void empty() const;
  // Whether it takes memory: from the first ready() on, until that is given back.
  bool held() const { return static_cast<bool>(marked_); }
  void giveBack() { marked_ = {}; }

 private:
  std::string label_;
  gpu::Buffer marked_;
};

// Registers lod.upload, lod.give_back (Prepare), lod.classify, lod.list (Route), lod.clear, lod.shadow, lod.meshes (Geometry),
// lod.list_late (RouteLate), lod.meshes_late (GeometryLate), lod.see (Shade), lod.view_* (Present). Needs addScene,
// addDeferred, addOcclusion.
void addLod(App& app);

}  // namespace scree
