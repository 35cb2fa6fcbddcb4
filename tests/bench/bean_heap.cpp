// The heap, the sun and the camera.
#include "tests/bench/bean_heap.h"

#include <stdlib.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "engine/core/file.h"
#include "engine/core/log.h"
#include "engine/core/random.h"
#include "engine/gpu/gl.h"
#include "modules/deferred/deferred.h"
#include "modules/impostors/impostors.h"
#include "modules/occlusion/occlusion.h"
#include "modules/points/points.h"

namespace scree::bench {
namespace {

constexpr uint64_t kSeed = 9;
constexpr float kShake = 0.3f;  // of places, outer radii

quat lookAlong(dvec3 direction) {
  const dvec3 z = -glm::normalize(direction), x = glm::normalize(glm::cross(dvec3(0, 1, 0), z));
  return quat(glm::quat_cast(glm::dmat3(x, glm::cross(z, x), z)));
}

SwarmGrain beanAt(vec3 place, float radius, uint64_t number) {
  const auto around0 = [&](uint32_t what) { return randomUnit(kSeed, number, 0, what) - 0.5f; };
  SwarmGrain bean;
  bean.position = place + vec3(around0(0), around0(1), around0(2)) * (kShake * radius);
  bean.radius = radius;
  bean.rotation = glm::normalize(quat(around0(3), around0(4), around0(5), around0(6)));
  const float light = 0.75f + 0.4f * around0(7), hue = around0(8);
  bean.tint = light * vec3(1, 0.95f + 0.1f * hue, 0.9f + 0.2f * hue);
  return bean;
}

}  // namespace

Heap makeHeap(size_t about, float swell) {
  Heap heap;
  const float volume = std::numbers::pi_v<float> / 3 * kHeapRadius * kHeapRadius * kHeapHeight;
  // Dense packing: a sphere in sqrt(32) r^3; every other place of a cubic lattice.
  const float touching = std::cbrt(volume / (std::sqrt(32.0f) * static_cast<float>(about)));
  heap.bean_radius = swell * touching;
  const float step = std::sqrt(2.0f) * touching;
  const int across = static_cast<int>(kHeapRadius / step) + 1, up = static_cast<int>(kHeapHeight / step) + 1;
  uint64_t number = 0;
  for (int y = 0; y <= up; ++y)
    for (int z = -across; z <= across; ++z)
      for (int x = -across; x <= across; ++x) {
        if (((x + y + z) & 1) != 0) continue;
        SwarmGrain bean = beanAt(vec3(x, y, z) * step, touching, number++);
        bean.radius = heap.bean_radius;
        const vec3 p = bean.position;
        if (p.y < 0 || std::hypot(p.x, p.z) >= kHeapRadius * (1 - p.y / kHeapHeight)) continue;
        heap.beans.push_back(bean);
      }
  return heap;
}

HeapScene::HeapScene(const Heap& beans, const std::filesystem::path& atlas, Kind kind)
    : HeapScene(beans, [&](World& made) {
        return loadGrainShape(made, contentRoot() / "models/coffee_bean.glb", {}, atlas);
      }, kind) {}

HeapScene::HeapScene(const Heap& beans, const AddShape& addShape, Kind kind) {
  addScene(app);
  addDeferred(app);
  if (kind == Kind::Swarm) {
    addOcclusion(app);
    addLod(app);
    addImpostors(app);
    addPoints(app);
  }
  Result<uint32_t> loaded = addShape(world);
  if (!loaded.ok()) fail(loaded.error());
  shape = *loaded;
  if (kind == Kind::Swarm) {
    heap = world.spawn(Transform{}, Swarm{world.singleton<SwarmStore>().add("heap", shape, beans.beans)});
    castShadows(true);
  }
  const Transform sun{dvec3(0), lookAlong({-1, -2, -1.5}), vec3(1)};
  Light light;
  light.intensity = 3;
  world.spawn(sun, previousOf(sun), light);
  camera = world.spawn(Transform{}, PreviousTransform{}, Camera{});
  world.singleton<ActiveCamera>().entity = camera;
  look(kHeapSize);
}

const GrainShape& HeapScene::bean() const { return world.singleton<const SwarmStore>().shape(shape); }

void HeapScene::look(double distance_m, float fov_y_rad) {
  const dvec3 at(0, 0.5 * static_cast<double>(kHeapHeight), 0.5 * static_cast<double>(kHeapRadius));
  lookFrom(at + glm::normalize(dvec3(0, kHeapRadius, kHeapHeight)) * distance_m, at, fov_y_rad);
}

void HeapScene::lookFrom(dvec3 from, dvec3 at, float fov_y_rad) {
  const Transform eye{from, lookAlong(at - from), vec3(1)};
  *world.find<Transform>(camera) = eye;
  *world.find<PreviousTransform>(camera) = previousOf(eye);
  *world.find<Camera>(camera) = {fov_y_rad, 0.01f};
}

void HeapScene::castShadows(bool cast) {
  if (cast) world.add(heap, CastsShadow{});
  if (!cast) world.remove<CastsShadow>(heap);
}

void HeapScene::render() {
  app.render(size);
  glFinish();
}

WorkFolder::WorkFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "scree_bench_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) fail("no temporary folder: " + name);
  path_ = name;
}

WorkFolder::~WorkFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

double beanPx(const Heap& heap, double distance_m, int rows) {
  const double pixels_at_1m = rows / (2 * std::tan(0.5 * static_cast<double>(kHeapFovY)));
  return static_cast<double>(heap.bean_radius) * pixels_at_1m / distance_m;
}

}  // namespace scree::bench
