// The scene without a GPU: view, interpolation, frustum, stores, and loading of files.
#include "modules/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "engine/app/app.h"
#include "engine/core/random.h"

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace scree::test {

struct SceneProbe {
  float value = 1;
  Entity target = Entity::kNone;
};
std::string faultIn(World& world, Entity entity, const SceneProbe& probe);
SCREE_COMPONENT(SceneProbe, (value, ""), (target, ""));

std::string faultIn(World& world, Entity entity, const SceneProbe& probe) {
  if (world.peek<SceneProbe>(entity) != &probe) return "asked of another entity";
  return probe.value != 7 || world.has<Camera>(probe.target) ? std::string() : "its target must look";
}

namespace {

using glm::dmat4;
using glm::dvec4;
using nlohmann::json;

double unit(uint64_t seed, uint64_t i, uint64_t draw) {
  return 2.0 * static_cast<double>(randomUnit(seed, i, 0, draw)) - 1.0;
}

quat someRotation(uint64_t i) {
  return glm::normalize(quat(static_cast<float>(unit(1, i, 0)), static_cast<float>(unit(1, i, 1)),
                             static_cast<float>(unit(1, i, 2)), static_cast<float>(unit(1, i, 3))));
}

FrameInput frameOf(ivec2 size) {
  FrameInput input;
  input.size = size;
  input.frame = 9;
  return input;
}

View viewAt(const Transform& transform, const Camera& camera, ivec2 size) {
  return computeView(previousOf(transform), transform, camera, frameOf(size));
}

// Pixel (origin bottom left) and distance along the axis of a point, by trigonometry.
dvec3 pixelOf(const dvec3& relative, const quat& rotation, const Camera& camera, ivec2 size) {
  const dvec3 v = glm::conjugate(glm::dquat(rotation)) * relative;
  const double focal = 0.5 * size.y / std::tan(0.5 * static_cast<double>(camera.fov_y_rad));
  return {0.5 * size.x + focal * v.x / -v.z, 0.5 * size.y + focal * v.y / -v.z, -v.z};
}

vec4 project(const mat4& clip_from_relative, const dvec3& relative) {
  return clip_from_relative * vec4(vec3(relative), 1);
}

vec2 toPixel(const vec4& clip, ivec2 size) {
  return (vec2(clip) / clip.w * 0.5f + 0.5f) * vec2(size);
}

TEST(View, ProjectsLikeAPinhole) {
  for (const ivec2 size : {ivec2(640, 360), ivec2(100, 300), ivec2(1, 1)})
    for (uint64_t i = 0; i < 200; ++i) {
      const Transform at{dvec3(5, -3, 2), someRotation(i), vec3(1)};
      const Camera camera{0.2f + 0.01f * static_cast<float>(i), 0.1f};
      const View view = viewAt(at, camera, size);
      const dvec3 local(unit(2, i, 0), unit(2, i, 1), -1.5 + unit(2, i, 2));
      const dvec3 relative = glm::dquat(at.rotation) * local * 7.0;
      const dvec3 expected = pixelOf(relative, at.rotation, camera, size);
      const vec4 clip = project(view.block.clip_from_relative, relative);
      const vec2 pixel = toPixel(clip, size);
      const double scale = size.y / std::tan(0.5 * static_cast<double>(camera.fov_y_rad));
      EXPECT_NEAR(pixel.x, expected.x, 1e-5 * scale);
      EXPECT_NEAR(pixel.y, expected.y, 1e-5 * scale);
      // reversed depth: near / distance
      EXPECT_NEAR(clip.z / clip.w, 0.1 / expected.z, 1e-6);
      EXPECT_NEAR(rules::distanceFromDepth(view.block.near_m, clip.z / clip.w), expected.z, 1e-4);
      // and back
      const vec3 back =
          rules::relativeFromDepth(view.block.relative_from_clip,
                                   rules::ndcFromPixel(view.block.size_px, pixel), clip.z / clip.w);
      EXPECT_LT(glm::length(dvec3(back) - relative), 2e-4 * glm::length(relative));
      const vec3 ray = rules::rayFromNdc(view.block.relative_from_clip,
                                         rules::ndcFromPixel(view.block.size_px, pixel));
      EXPECT_GT(glm::dot(glm::normalize(dvec3(ray)), glm::normalize(relative)), 1 - 1e-8);
      EXPECT_FLOAT_EQ(view.block.pixels_at_1m, static_cast<float>(0.5 * scale));
    }
}

TEST(View, FarFromTheOriginLooksLikeTheOrigin) {
  const Camera camera;
  const auto sequence = [&](const dvec3& offset) {
    const Transform from{offset + dvec3(0.25, 1.5, -2), someRotation(1), vec3(1)};
    const Transform to{offset + dvec3(0.375, 1.25, -2.5), someRotation(2), vec3(1)};
    FrameInput input = frameOf({640, 360});
    input.alpha = 0.3f;
    input.motion_scale = 0.7f;
    return computeView(previousOf(from), to, camera, input);
  };
  const View near = sequence(dvec3(0));
  for (const dvec3 offset : {dvec3(1e6, -1e6, 1e6), dvec3(-1e7, 1e3, 3e6)}) {
    const View far = sequence(offset);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) {
        EXPECT_EQ(far.block.clip_from_relative[c][r], near.block.clip_from_relative[c][r]);
        EXPECT_EQ(far.block.previous_clip_from_relative[c][r],
                  near.block.previous_clip_from_relative[c][r]);
      }
    EXPECT_LT(glm::length(vec3(far.block.camera_delta) - vec3(near.block.camera_delta)), 1e-6f);
    EXPECT_LT(glm::length(far.position - offset - near.position), 1e-8);
    // What stands beside the far camera keeps its place to a micrometre.
    const Transform thing{offset + dvec3(1, 2, -7), someRotation(5), vec3(2, 3, 4)};
    const Transform same{dvec3(1, 2, -7), someRotation(5), vec3(2, 3, 4)};
    const mat4 a = relativeFromLocal(thing, far.position);
    const mat4 b = relativeFromLocal(same, near.position);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 4; ++r) EXPECT_NEAR(a[c][r], b[c][r], 1e-6);
  }
}

TEST(View, JitterShiftsThePictureButNotItsMotion) {
  const Transform at{dvec3(0), someRotation(3), vec3(1)};
  const Camera camera;
  const ivec2 size(64, 48);
  FrameInput input = frameOf(size);
  const View steady = computeView(previousOf(at), at, camera, input);
  input.jitter_px = vec2(0.25f, -0.375f);
  input.sample = 3;
  const View jittered = computeView(previousOf(at), at, camera, input);
  const dvec3 point = glm::dquat(at.rotation) * dvec3(0.3, -0.2, -2);
  const vec2 a = toPixel(project(steady.block.clip_from_relative, point), size);
  const vec2 b = toPixel(project(jittered.block.clip_from_relative, point), size);
  EXPECT_NEAR(b.x - a.x, -0.25, 1e-4) << "what is at centre + jitter is drawn at the centre";
  EXPECT_NEAR(b.y - a.y, 0.375, 1e-4);
  EXPECT_EQ(jittered.block.steady_clip_from_relative, steady.block.clip_from_relative);
  EXPECT_EQ(jittered.block.previous_clip_from_relative, steady.block.previous_clip_from_relative);
  EXPECT_EQ(steady.block.previous_clip_from_relative, steady.block.clip_from_relative);
  EXPECT_EQ(jittered.block.sample_index, 3u);
  // The ray of a pixel's centre is that of its sample.
  const vec3 ray = rules::rayFromNdc(jittered.block.relative_from_clip,
                                     rules::ndcFromPixel(vec2(size), vec2(10.5f, 20.5f)));
  const vec2 seen = toPixel(project(steady.block.clip_from_relative, dvec3(ray)), size);
  EXPECT_NEAR(seen.x, 10.75, 1e-3);
  EXPECT_NEAR(seen.y, 20.125, 1e-3);
}

TEST(View, PreviousFrameIsWhereTheCameraWas) {
  const Transform from{dvec3(0, 1, 0), quat(1, 0, 0, 0), vec3(1)};
  Transform to = from;
  to.position += dvec3(0.6, 0, 0);
  to.rotation = glm::angleAxis(0.2f, vec3(0, 1, 0));
  const Camera camera;
  const ivec2 size(640, 360);
  FrameInput input = frameOf(size);
  input.alpha = 0.75f;
  input.motion_scale = 0.5f;
  const View view = computeView(previousOf(from), to, camera, input);
  EXPECT_NEAR(view.position.x, 0.45, 1e-6);
  EXPECT_NEAR(view.previous_position.x, 0.15, 1e-6);
  EXPECT_NEAR(view.block.camera_delta.x, 0.3, 1e-6);
  // A point that stands still, seen by the camera of then.
  const dvec3 point(0.5, 1.3, -4);
  const quat then = glm::angleAxis(0.05f, vec3(0, 1, 0));
  const dvec3 expected = pixelOf(point - dvec3(0.15, 1, 0), then, camera, size);
  const dvec3 relative = point - view.position;
  const vec2 seen = toPixel(project(view.block.previous_clip_from_relative,
                                    relative + dvec3(vec3(view.block.camera_delta))),
                            size);
  EXPECT_NEAR(seen.x, expected.x, 1e-3);
  EXPECT_NEAR(seen.y, expected.y, 1e-3);
}

TEST(View, FrameBeforeTheFirstTickExtrapolates) {
  const Transform from{dvec3(1, 0, 0), quat(1, 0, 0, 0), vec3(1)};
  Transform to = from;
  to.position = dvec3(2, 0, 0);
  to.rotation = glm::angleAxis(0.3f, vec3(0, 0, 1));
  FrameInput input = frameOf({64, 64});
  input.alpha = 0;
  input.motion_scale = 1;
  const View view = computeView(previousOf(from), to, Camera{}, input);
  EXPECT_NEAR(view.position.x, 1, 1e-12);
  EXPECT_NEAR(view.previous_position.x, 0, 1e-12);
  const Transform before = interpolate(previousOf(from), to, -1);
  EXPECT_NEAR(before.rotation.z, std::sin(-0.15), 1e-6);
}

TEST(View, HostileCamerasStayFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              inf = std::numeric_limits<float>::infinity();
  for (const Camera camera : {Camera{0, 0}, Camera{nan, nan}, Camera{inf, -inf}, Camera{7, 1e30f},
                              Camera{-1, 1e-30f}, Camera{1e-9f, 0.1f}, Camera{3.14159f, 0.1f}})
    for (const ivec2 size : {ivec2(0, 0), ivec2(1, 1), ivec2(16384, 1), ivec2(1, 16384)}) {
      const View view = viewAt(Transform{}, camera, size);
      for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) {
          EXPECT_TRUE(std::isfinite(view.block.clip_from_relative[c][r]));
          EXPECT_TRUE(std::isfinite(view.block.relative_from_clip[c][r]));
        }
      for (const vec4& plane : view.block.frustum_planes)
        EXPECT_NEAR(glm::length(vec3(plane)), 1, 1e-5);
    }
}

TEST(Interpolate, EndsAreExactAndTheMiddleIsTheArc) {
  for (uint64_t i = 0; i < 100; ++i) {
    const PreviousTransform from{dvec3(1, 2, 3) * unit(3, i, 0), someRotation(i), vec3(1, 2, 3)};
    const Transform to{dvec3(-3, 5, 1), someRotation(i + 1000), vec3(3, 2, 1)};
    const Transform end = interpolate(from, to, 1);
    EXPECT_EQ(end.position, to.position);
    EXPECT_EQ(end.rotation, to.rotation);
    EXPECT_EQ(interpolate(from, to, 0).position, from.position);
    const Transform middle = interpolate(from, to, 0.5);
    EXPECT_NEAR(glm::length(middle.rotation), 1, 1e-6);
    // Equally far, in angle, from both ends.
    const auto angle = [&](const quat& a, const quat& b) {
      return 2 * std::acos(std::min(1.0, std::abs(glm::dot(glm::dquat(a), glm::dquat(b)))));
    };
    const double whole = angle(from.rotation, to.rotation);
    EXPECT_NEAR(angle(from.rotation, middle.rotation), whole / 2, 1e-3);
    EXPECT_NEAR(angle(middle.rotation, to.rotation), whole / 2, 1e-3);
    const Transform third = interpolate(from, to, 1.0 / 3);
    EXPECT_NEAR(angle(from.rotation, third.rotation), whole / 3, 1e-3);
    EXPECT_LT(glm::length(third.position - (from.position * 2.0 + to.position) / 3.0), 1e-12);
    EXPECT_NEAR(third.scale.x, 1 + 2.0 / 3, 1e-6);
  }
}

TEST(Interpolate, TheShorterWayRoundAndTinyTurns) {
  const quat turn = glm::angleAxis(0.3f, vec3(0, 1, 0));
  const PreviousTransform from{dvec3(0), turn, vec3(1)};
  const Transform same = interpolate(from, {dvec3(0), -turn, vec3(1)}, 0.5);
  EXPECT_NEAR(std::abs(glm::dot(same.rotation, turn)), 1, 1e-6);
  const quat tiny = glm::angleAxis(1e-5f, vec3(0, 1, 0));
  const Transform between =
      interpolate({dvec3(0), quat(1, 0, 0, 0), vec3(1)}, {dvec3(0), tiny, vec3(1)}, 0.5);
  EXPECT_NEAR(between.rotation.y, tiny.y / 2, 1e-8);
}

// Whether a sphere touches the view, by its distance to the pyramid's side planes from geometry.
bool touches(const dvec3& v, double radius, double tan_x, double tan_y, double near) {
  const double cx = 1 / std::sqrt(1 + tan_x * tan_x), cy = 1 / std::sqrt(1 + tan_y * tan_y);
  return (std::abs(v.x) + v.z * tan_x) * cx <= radius &&
         (std::abs(v.y) + v.z * tan_y) * cy <= radius && -v.z + radius >= near;
}

TEST(Frustum, AgreesWithGeometryAtEveryFieldOfView) {
  size_t seen = 0, unseen = 0;
  for (uint64_t i = 0; i < 20000; ++i) {
    const double fovs[] = {0.001, 0.02, 0.8, 2.0, 3.0};
    const Camera camera{static_cast<float>(fovs[i % 5]), 0.1f};
    const ivec2 size = i % 2 == 0 ? ivec2(640, 360) : ivec2(90, 300);
    const Transform at{dvec3(unit(4, i, 5) * 1e6, 0, 0), someRotation(i), vec3(1)};
    const View view = viewAt(at, camera, size);
    const double tan_y = std::tan(0.5 * static_cast<double>(camera.fov_y_rad));
    const double tan_x = tan_y * size.x / size.y;
    const double distance = std::pow(10.0, 3 * unit(4, i, 0));
    const dvec3 v(unit(4, i, 1) * distance * tan_x * 2, unit(4, i, 2) * distance * tan_y * 2,
                  -distance);
    const double radius = distance * tan_y * 0.5 * std::abs(unit(4, i, 3));
    const bool in =
        sphereInView(view, vec3(glm::dquat(at.rotation) * v), static_cast<float>(radius));
    const double slack = 3e-6 * glm::length(v);
    if (touches(v, radius - slack, tan_x, tan_y, 0.1)) {
      ASSERT_TRUE(in) << "a visible sphere was culled, i = " << i;
      ++seen;
    } else if (!touches(v, radius + slack, tan_x, tan_y, 0.1)) {
      ASSERT_FALSE(in) << "i = " << i;
      ++unseen;
    }
  }
  EXPECT_GT(seen, 3000u);
  EXPECT_GT(unseen, 3000u);
}

MeshData quad(const std::string& name, float size) {
  MeshData mesh;
  mesh.name = name;
  for (const vec2 corner : {vec2(0, 0), vec2(1, 0), vec2(1, 1), vec2(0, 1)})
    mesh.vertices.push_back({vec3(corner * size, 0), vec3(0, 0, 1), vec4(1, 0, 0, 1), corner});
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

TEST(MeshStore, KeepsPartsAndBounds) {
  MeshStore store;
  EXPECT_EQ(store.size(), 0u);
  EXPECT_EQ(store.add(quad("a", 1)), 0u);
  MeshData parts[2] = {quad("b", 2), quad("b", 4)};
  parts[1].material = 3;
  for (Vertex& v : parts[1].vertices) v.position += vec3(0, 0, 10);
  EXPECT_EQ(store.add("b", parts), 1u);
  EXPECT_EQ(store.size(), 2u);
  const StoredMesh& mesh = store.mesh(1);
  ASSERT_EQ(mesh.parts.size(), 2u);
  EXPECT_EQ(mesh.parts[1].base_vertex, 8);
  EXPECT_EQ(mesh.parts[1].first_index, 12u);
  EXPECT_EQ(mesh.parts[1].index_count, 6u);
  EXPECT_EQ(mesh.parts[0].material, 0u);
  EXPECT_EQ(mesh.parts[1].material, 3u);
  EXPECT_EQ(store.vertices(mesh.parts[1])[2].position, vec3(4, 4, 10));
  EXPECT_EQ(store.indices(mesh.parts[1])[5], 3u);
  EXPECT_EQ(mesh.bounds.min, vec3(0, 0, 0));
  EXPECT_EQ(mesh.bounds.max, vec3(4, 4, 10));
  for (const MeshPart& part : mesh.parts)
    for (const Vertex& v : store.vertices(part))
      EXPECT_LE(glm::distance(v.position, mesh.bounds.center), mesh.bounds.radius);
  EXPECT_FALSE(store.onGpu());
  MeshData empty;
  EXPECT_EQ(store.mesh(store.add(empty)).bounds.radius, 0);
}

TEST(MeshStore, BrokenMeshesEndTheProgram) {
  MeshStore store;
  MeshData mesh = quad("broken", 1);
  mesh.indices[4] = 4;
  EXPECT_DEATH(store.add(mesh), "MeshStore::add: mesh \"broken\": index 4 of 4");
  EXPECT_DEATH(store.mesh(7), "MeshStore: mesh 7; there are 0");
}

TEST(MaterialStore, Handles) {
  MaterialStore store;
  EXPECT_EQ(store.size(), 1u);
  EXPECT_EQ(store.material(0).metallic, 0);
  EXPECT_EQ(store.material(0).base_color, vec4(1));
  ImageData image;
  image.width = image.height = 1;
  image.channels = 3;
  image.bytes = {1, 2, 3};
  MaterialData material;
  material.base_color_map.image = store.addImage(image);
  EXPECT_EQ(store.add(material), 1u);
  EXPECT_EQ(store.image(0).bytes[2], 3);
  material.base_color_map.image = 5;
  EXPECT_DEATH(store.add(material), "image 5 of 1");
  image.channels = 4;
  EXPECT_DEATH(store.addImage(image), "1x1 with 4 channels and 3 values");
}

// A file with two nodes on one mesh of two parts, a camera, a sun, a sky, and a component.
class SceneFile : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "scree_scene_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    path_ = folder_ / "level.gltf";
    doc_ = json::parse(R"({"asset": {"version": "2.0"},
      "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
      "materials": [{"name": "sand", "pbrMetallicRoughness": {"roughnessFactor": 0.5}}],
      "meshes": [{"name": "ramp", "primitives": [{"attributes": {"POSITION": 0}, "material": 0},
                                                 {"attributes": {"POSITION": 0}}]}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.25}}],
      "extensions": {"KHR_lights_punctual": {"lights": [{"type": "directional", "intensity": 3}]}},
      "nodes": [{"name": "a", "mesh": 0, "translation": [1, 2, 3],
                 "extras": {"SceneProbe": {"value": 5, "target": "sun"}}},
                {"name": "b", "mesh": 0, "extras": {"CastsShadow": false}},
                {"name": "eye", "camera": 0},
                {"name": "sun", "extensions": {"KHR_lights_punctual": {"light": 0}},
                 "extras": {"Sky": {"zenith": [1, 2, 3]}}}]})");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  Status load(std::vector<Entity>* spawned = nullptr) {
    std::ofstream(path_) << doc_.dump();
    return loadScene(world_, path_, spawned);
  }

  std::filesystem::path folder_, path_;
  json doc_;
  World world_;
};

TEST_F(SceneFile, SpawnsWhatItDescribes) {
  std::vector<Entity> entities;
  const Status status = load(&entities);
  ASSERT_TRUE(status.ok()) << status.error();
  ASSERT_EQ(entities.size(), 4u);
  EXPECT_EQ(world_.entityCount(), 4u);
  EXPECT_STREQ(world_.peek<Name>(entities[0])->text, "a");
  EXPECT_EQ(world_.peek<Transform>(entities[0])->position, dvec3(1, 2, 3));
  EXPECT_EQ(world_.peek<PreviousTransform>(entities[0])->position, dvec3(1, 2, 3));
  const MeshInstance* instance = world_.peek<MeshInstance>(entities[0]);
  ASSERT_NE(instance, nullptr);
  EXPECT_EQ(instance->material, MeshInstance::kOwnMaterials);
  EXPECT_EQ(world_.peek<MeshInstance>(entities[1])->mesh, instance->mesh)
      << "one mesh, two instances";
  EXPECT_TRUE(world_.has<CastsShadow>(entities[0]));
  EXPECT_FALSE(world_.has<CastsShadow>(entities[1]));
  const StoredMesh& mesh = world_.singleton<MeshStore>().mesh(instance->mesh);
  ASSERT_EQ(mesh.parts.size(), 2u);
  EXPECT_EQ(world_.singleton<MaterialStore>().material(mesh.parts[0].material).name, "sand");
  EXPECT_EQ(mesh.parts[1].material, 0u);
  EXPECT_EQ(world_.peek<Camera>(entities[2])->near_m, 0.25f);
  EXPECT_EQ(world_.singleton<ActiveCamera>().entity, entities[2]);
  EXPECT_EQ(world_.peek<Light>(entities[3])->kind, LightKind::Directional);
  EXPECT_EQ(world_.peek<Light>(entities[3])->intensity, 3);
  EXPECT_EQ(world_.peek<SceneProbe>(entities[0])->value, 5);
  EXPECT_EQ(world_.peek<SceneProbe>(entities[0])->target, entities[3]);
  EXPECT_EQ(world_.singleton<Sky>().zenith, vec3(1, 2, 3));
  EXPECT_EQ(world_.singleton<Sky>().horizon, Sky{}.horizon);
}

TEST_F(SceneFile, SecondLoadSharesMeshesAndStartsAlike) {
  ASSERT_TRUE(load().ok());
  const uint64_t hash = world_.stateHash();
  const size_t meshes = world_.singleton<MeshStore>().size();
  const size_t materials = world_.singleton<MaterialStore>().size();
  world_.clear();
  std::vector<Entity> entities;
  ASSERT_TRUE(loadScene(world_, path_, &entities).ok());
  EXPECT_EQ(world_.singleton<MeshStore>().size(), meshes);
  EXPECT_EQ(world_.singleton<MaterialStore>().size(), materials);
  EXPECT_EQ(world_.peek<SceneProbe>(entities[0])->target, entities[3]);
  EXPECT_EQ(world_.singleton<ActiveCamera>().entity, entities[2]) << "the old camera is gone";
  (void)hash;  // differs by the handles' generations, which are state
  doc_["nodes"][0]["name"] = "another name";
  ASSERT_TRUE(load(&entities).ok());
  EXPECT_STREQ(world_.peek<Name>(entities[0])->text, "another name")
      << "a changed file is read again";
}

TEST_F(SceneFile, ErrorsLeaveNothingBehind) {
  const auto refused = [&](const json& doc, const std::string& expected) {
    doc_ = doc;
    World& world = world_;
    world.spawn(SceneProbe{});
    const uint64_t before = world.stateHash();
    const Status status = load();
    ASSERT_FALSE(status.ok()) << expected;
    EXPECT_NE(status.error().find("level.gltf"), std::string::npos) << status.error();
    EXPECT_NE(status.error().find(expected), std::string::npos) << status.error();
    EXPECT_EQ(status.error().find('\n'), std::string::npos);
    EXPECT_EQ(world.stateHash(), before);
    EXPECT_EQ(world.singleton<MeshStore>().size(), 0u);
    EXPECT_EQ(world.singleton<MaterialStore>().size(), 1u);
    EXPECT_EQ(world.singleton<ActiveCamera>().entity, Entity::kNone);
  };
  const json good = doc_;
  json doc = good;
  doc["nodes"][3]["extras"] = {{"SceneProbe", {{"value", "x"}}}};
  refused(doc, "node 3 \"sun\": extras: SceneProbe: value = \"x\": must be a finite number");
  doc = good;
  doc["nodes"][0]["extras"]["SceneProbe"]["target"] = "moon";
  refused(doc, "target = \"moon\": 0 nodes have that name");
  doc = good;
  doc["nodes"][1]["name"] = "sun";
  refused(doc, "target = \"sun\": 2 nodes have that name");
  doc = good;
  doc["nodes"][1]["extras"] = {{"Transform", {{"position", {1, 2, 3}}}}};
  refused(doc, "node 1 \"b\": extras: Transform: is set by the node itself");
  doc = good;
  doc["nodes"][1]["extras"] = {{"MeshInstance", {{"mesh", 99}}}};
  refused(doc, "MeshInstance: is set by the node itself");
  doc = good;
  doc["accessors"][0]["count"] = 4;
  refused(doc, "accessor 0: count = 4");
}

TEST_F(SceneFile, WhatComponentsSayOfWhereTheyStandIsAskedOfTheWholeFile) {
  doc_["nodes"][0]["extras"]["SceneProbe"] = {{"value", 7}, {"target", "eye"}};
  ASSERT_TRUE(load().ok());
  world_.clear();
  world_.singleton<Sky>() = {};
  doc_["nodes"][0]["extras"]["SceneProbe"]["target"] = "sun";
  const Status status = load();
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().find("level.gltf: node 0 \"a\": extras: SceneProbe: its target must look"),
            std::string::npos) << status.error();
  EXPECT_EQ(world_.entityCount(), 0u);
  EXPECT_FALSE(world_.alive(world_.singleton<ActiveCamera>().entity));
  EXPECT_EQ(world_.singleton<Sky>().zenith, Sky{}.zenith);
}

TEST_F(SceneFile, MissingFileIsOneLine) {
  const Status status = loadScene(world_, folder_ / "none.glb");
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().find("none.glb: no such file"), std::string::npos) << status.error();
}

TEST(KeepPrevious, CopiesWhatMovedBeforeTheRulesRun) {
  AppOptions options;
  options.threads = 1;
  App app(options);
  addScene(app);
  World& world = app.world();
  const Entity mover = world.spawn(Transform{}, PreviousTransform{});
  const Entity still = world.spawn(Transform{}, PreviousTransform{}, makeName("still"));
  const Entity bare = world.spawn(Transform{});
  app.addSystem({.name = "test.move", .phase = Phase::Simulate, .run = [&](World& w) {
                   w.find<Transform>(mover)->position.x += 1;
                 }});
  app.tick();
  EXPECT_EQ(world.peek<Transform>(mover)->position.x, 1);
  EXPECT_EQ(world.peek<PreviousTransform>(mover)->position.x, 0);
  const auto previous = world.query<const PreviousTransform, With<Name>>();
  const auto version = previous.version<PreviousTransform>();
  app.tick();
  app.tick();
  EXPECT_EQ(world.peek<PreviousTransform>(mover)->position.x, 2);
  EXPECT_EQ(world.peek<Transform>(mover)->position.x, 3);
  EXPECT_EQ(previous.version<PreviousTransform>(), version) << "what stands still is not written";
  EXPECT_EQ(world.peek<PreviousTransform>(still)->position.x, 0);
  EXPECT_FALSE(world.has<PreviousTransform>(bare));
}

TEST(NameOf, LongNamesAreCut) {
  EXPECT_STREQ(makeName("abc").text, "abc");
  EXPECT_EQ(std::string(makeName(std::string(100, 'x')).text).size(), 63u);
  EXPECT_STREQ(makeName("").text, "");
}

}  // namespace
}  // namespace scree::test
