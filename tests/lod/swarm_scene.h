// A scene of a swarm for the tests of what draws grains, and the router's rules run on the CPU.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "engine/core/random.h"
#include "engine/gpu/readback.h"
#include "modules/lod/lod.h"
#include "modules/lod/state.h"
#include "modules/occlusion/occlusion.h"
#include "shaders/shared/candidate.h"
#include "tests/deferred/studio.h"

namespace scree::test {

struct SwarmScene : Studio {
  explicit SwarmScene(ivec2 output = {320, 240}) : Studio(output) {
    addOcclusion(app);
    addLod(app);
    app.frame().keep(kSwarmLateLists, true);
  }

  // A sphere of radius 1, without impostors.
  GrainShape ballShape() {
    GrainShape shape;
    shape.name = "ball";
    shape.inner_radius = 0.99f;
    const MeshData mesh = sphereMesh(20, 40);
    EXPECT_TRUE(addLevels(world.singleton<MeshStore>(), shape, std::span(&mesh, 1)).ok());
    return shape;
  }
  uint32_t addShape() { return world.singleton<SwarmStore>().addShape(ballShape()); }
  Entity show(uint32_t shape, std::span<const SwarmGrain> grains, dvec3 origin = dvec3(0)) {
    const uint32_t swarm = world.singleton<SwarmStore>().add("grains", shape, grains);
    return world.spawn(Transform{.position = origin}, Swarm{swarm});
  }
  SwarmsDrawn& drawn() { return world.singleton<SwarmsDrawn>(); }
  // How each grain of the first part was drawn; what is hidden was not.
  std::vector<uint32_t> routes() {
    const auto& part = static_cast<const lod::Part&>(drawn().part(0));
    const std::vector<uint32_t> words = gpu::readBuffer<uint32_t>(part.routes->representations, (part.count + 7) / 8);
    std::vector<uint32_t> all(part.count);
    for (uint32_t k = 0; k < part.count; ++k) all[k] = words[k / 8] >> 4 * (k % 8) & 15;
    std::replace(all.begin(), all.end(), rules::kHidden, rules::kNotDrawn);
    return all;
  }
};

inline std::vector<SwarmGrain> cloud(size_t count, float half_extent, float least, float most, uint64_t seed = 1) {
  std::vector<SwarmGrain> grains(count);
  for (size_t k = 0; k < count; ++k) {
    const auto unit = [&](uint32_t at) { return randomUnit(seed, k, 0, at); };
    grains[k].position = (vec3(unit(0), unit(1), unit(2)) * 2.0f - 1.0f) * half_extent;
    grains[k].radius = least * std::pow(most / least, unit(3));
    grains[k].rotation = glm::normalize(quat(unit(4) - 0.5f, unit(5) - 0.5f, unit(6) - 0.5f, unit(7) - 0.5f));
    grains[k].tint = vec3(unit(8), unit(9), unit(10));
    grains[k].seed = static_cast<uint16_t>(k);
  }
  return grains;
}

}  // namespace scree::test
