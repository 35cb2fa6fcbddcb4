// A scene of discs for the GPU tests of occlusion: some are drawn first, the rest may be culled.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/app/app.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "engine/core/file.h"
#include "engine/gpu/state.h"
#include "modules/deferred/deferred.h"
#include "modules/occlusion/occlusion.h"
#include "modules/scene/scene.h"
#include "tests/support/exact_sphere.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/gl_shader_folder.h"

namespace scree::test {

// Sphere k: center relative to the world's origin, radius. The first `first_count` are drawn before the
// pyramid is built, the others after it unless `cull` is on and they are hidden. Drawn as
// modules/grains does: triangles around silhouette discs, index + 1 to a target.
struct Discs {
  static constexpr const char* kIds = "test.ids";
  enum class Test : int { None, Disc, Sphere };

  App app{AppOptions{}};
  World& world = app.world();
  Entity camera;
  ShaderFolder shaders;
  gpu::Buffer spheres, flags;  // vec4 each; 1: hidden
  int count = 0, first_count = 0;
  Test test = Test::Disc;
  bool cull = true;
  const gpu::Texture* pyramid = nullptr;  // as bound by test.cull

  Discs() {
    writeSources();
    addScene(app);
    addDeferred(app);
    addOcclusion(app);
    camera = world.spawn(Transform{}, PreviousTransform{}, Camera{});
    world.singleton<ActiveCamera>().entity = camera;
    app.addTarget(kIds, {.format = GL_R32UI});
    app.frame().addExternal("test.flags");
    app.frame().keep(kIds, true);
    const auto draw = std::make_shared<gpu::Program>(gpu::ProgramDesc{
        .name = "test.discs", .vertex = "test/discs.vert", .fragment = "test/discs.frag", .root = shaders.path()});
    const auto run = [this, draw](int first, int end, bool drop_hidden) {
      if (!draw->use() || end == first) return;
      spheres.bindStorage(4);
      flags.bindStorage(5);
      draw->set(0, first);
      draw->set(1, drop_hidden ? 1 : 0);
      draw->set(3, origin());
      gpu::apply({.cull = gpu::Cull::None});
      gpu::drawVertexless(GL_TRIANGLES, 3 * (end - first));
    };
    app.addPass({.name = "test.first",
                 .stage = Stage::Geometry,
                 .uses = {{kIds, Access::Color}, {std::string(kGbufferDepth), Access::Depth}},
                 .run = [this, run](PassContext& context) {
                   context.framebuffer->clearColor(0, uvec4(0));
                   run(0, first_count, false);
                 }});
    const auto find = std::make_shared<gpu::Program>(
        gpu::ProgramDesc{.name = "test.cull", .compute = "test/cull.comp", .root = shaders.path()});
    app.addPass({.name = "test.cull",
                 .stage = Stage::RouteLate,
                 .needs = [this] { return cull; },
                 .uses = {{std::string(kOcclusionPyramid), Access::Sampled}, {"test.flags", Access::StorageWrite}},
                 .run = [this, find](PassContext& context) {
                   if (!find->use()) return;
                   pyramid = &bindPyramid(world, context);
                   spheres.bindStorage(4);
                   flags.bindStorage(5);
                   find->set(0, static_cast<int>(test));
                   find->set(1, count);
                   find->set(3, origin());
                   gpu::dispatchItems(static_cast<uint64_t>(count), 64);
                 }});
    app.addPass({.name = "test.rest",
                 .stage = Stage::GeometryLate,
                 .uses = {{kIds, Access::Color},
                          {std::string(kGbufferDepth), Access::Depth},
                          {"test.flags", Access::StorageRead}},
                 .run = [this, run](PassContext&) { run(first_count, count, cull); }});
  }

  void setSpheres(const std::vector<vec4>& all, int first) {
    count = static_cast<int>(all.size());
    first_count = first;
    spheres = gpu::Buffer("test.spheres", std::span<const vec4>(all));
    flags = gpu::Buffer("test.flags", all.size() * sizeof(uint32_t));
    flags.fill(0);
  }
  void look(dvec3 position, dvec3 direction, float fov_y, float near_m, double roll = 0) {
    Transform& transform = *world.find<Transform>(camera);
    transform.position = position;
    transform.rotation = lookingAlong(direction, roll);
    *world.find<PreviousTransform>(camera) = previousOf(transform);
    *world.find<Camera>(camera) = {fov_y, near_m};
  }
  std::vector<uint32_t> ids(ivec2 size) {
    app.render(size);
    return gpu::readUints(app.frame().texture(kIds), 1);
  }
  std::vector<uint32_t> hidden() { return gpu::readBuffer<uint32_t>(flags, static_cast<size_t>(count)); }

  // The world's origin from the camera.
  vec3 origin() { return vec3(-world.singleton<const View>().position); }

  void writeSources() {
    for (const char* folder : {"shared", "lib"})
      std::filesystem::create_directory_symlink(shaderRoot() / folder, shaders.path() / folder);
    const auto include = [](const char* file) { return fmt::format("#include \"{}\"\n", file); };
    const std::string head =
        "// Of this test.\n"
        "layout(std430, binding = 4) readonly buffer Spheres { vec4 spheres[]; };\n"
        "layout(location = 3) uniform vec3 origin;\n";
    shaders.write("test/discs.vert", head + include("shared/sphere.h") + include("shared/view.h") + R"(
layout(std430, binding = 5) readonly buffer Flags { uint flags[]; };
layout(location = 0) uniform int first;
layout(location = 1) uniform int drop_hidden;
out vec2 on_disc;
out vec3 relative;
flat out uint index;
flat out vec4 sphere;
void main() {
  int k = first + gl_VertexID / 3;
  index = uint(k);
  on_disc = discCorner(uint(gl_VertexID % 3));
  sphere = vec4(origin + spheres[k].xyz, spheres[k].w);
  SphereDisc disc = sphereDisc(sphere.xyz, sphere.w);
  relative = disc.center + disc.radius * (disc.axis_u * on_disc.x + disc.axis_v * on_disc.y);
  gl_Position = view.clip_from_relative * vec4(relative, 1.0);
  if (disc.radius == 0.0 || (drop_hidden == 1 && flags[k] == 1u)) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
})");
    shaders.write("test/discs.frag", R"(// Of this test.
in vec2 on_disc;
in vec3 relative;
flat in uint index;
flat in vec4 sphere;
layout(location = 0) out uint id;
void main() {
  if (dot(on_disc, on_disc) > 1.0) discard;
  id = index + 1u;
})");
    shaders.write("test/cull.comp", head + include("lib/occlusion.glsl") + R"(
layout(local_size_x = 64) in;
layout(std430, binding = 5) buffer Flags { uint flags[]; };
layout(location = 0) uniform int test;
layout(location = 1) uniform int count;
void main() {
  int k = int(gl_GlobalInvocationID.x);
  if (k >= count) return;
  vec3 center = origin + spheres[k].xyz;
  bool hidden = test == 1 ? discOccludedByPyramid(center, spheres[k].w)
              : test == 2 ? occludedByPyramid(center, spheres[k].w) : false;
  flags[k] = hidden ? 1u : 0u;
})");
  }
};

}  // namespace scree::test
