// An App with the grains module and without GL.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "engine/app/app.h"
#include "engine/core/parallel.h"
#include "modules/deferred/deferred.h"
#include "modules/grains/grains.h"
#include "modules/scene/scene.h"

namespace scree::grains::test {

inline std::unique_ptr<App> makeApp(int threads = 1) {
  AppOptions options;
  options.threads = threads;
  auto app = std::make_unique<App>(options);
  setThreadCount(threads);
  addScene(*app);
  addDeferred(*app);
  addGrains(*app);
  return app;
}

inline Transform at(dvec3 position) {
  Transform transform;
  transform.position = position;
  return transform;
}

// Triangles, three corners each, as a mesh of the world's store.
inline uint32_t addMesh(World& world, std::span<const vec3> corners, std::string name = "mesh") {
  MeshData mesh;
  mesh.name = std::move(name);
  for (const vec3 corner : corners) {
    mesh.indices.push_back(static_cast<uint32_t>(mesh.vertices.size()));
    mesh.vertices.push_back({.position = corner});
  }
  return world.singleton<MeshStore>().add(mesh);
}

}  // namespace scree::grains::test
