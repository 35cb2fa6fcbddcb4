// A heap of coffee beans before a camera that moves away from it: the scene of the benches of grains at every scale.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "engine/app/app.h"
#include "modules/lod/lod.h"
#include "modules/scene/scene.h"

namespace scree::bench {

// A cone on the plane y = 0, m.
inline constexpr float kHeapRadius = 1, kHeapHeight = 0.6f, kHeapSize = 2 * kHeapRadius;
inline constexpr float kHeapFovY = 0.8f;

// Beans at the places of densely packed spheres, shaken, turned and tinted at random.
struct Heap {
  std::vector<SwarmGrain> beans;
  float bean_radius = 0;  // outer, m
};
// `swell`: outer radii / those at which the spheres around the grains would touch.
Heap makeHeap(size_t about, float swell = 1);

// The heap in an app of its own, with what draws swarms, or `bare`: with the shape alone.
struct HeapScene {
  App app{AppOptions{}};
  World& world = app.world();
  ivec2 size{640, 360};
  uint32_t shape = 0;
  Entity heap, camera;

  enum class Kind { Swarm, Bare };
  // `atlas`: the file that keeps the bean's impostor.
  HeapScene(const Heap& beans, const std::filesystem::path& atlas, Kind kind = Kind::Swarm);
  // Of other grains than beans. `addShape` makes their shape.
  using AddShape = std::function<Result<uint32_t>(World&)>;
  HeapScene(const Heap& grains, const AddShape& addShape, Kind kind = Kind::Swarm);

  const GrainShape& bean() const;
  // From straight above a point half way up the heap's side, which no bean is nearer than.
  void look(double distance_m, float fov_y_rad = kHeapFovY);
  void lookFrom(dvec3 from, dvec3 at, float fov_y_rad = kHeapFovY);
  void castShadows(bool cast);
  // Waits for the picture.
  void render();
};

// An empty folder below the system's temporary one, removed at the end.
class WorkFolder {
 public:
  WorkFolder();
  ~WorkFolder();
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// Outer radius in pixels of a bean at a distance, in a picture of so many rows with the heap's field of view.
double beanPx(const Heap& heap, double distance_m, int rows);

}  // namespace scree::bench
