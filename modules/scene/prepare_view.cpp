// scene.view: the active camera becomes the frame's View, on the CPU and on the GPU.
#include "engine/frame/frame.h"
#include "engine/gpu/objects.h"
#include "modules/scene/scene.h"
#include "modules/scene/view.h"

namespace scree {
namespace {

// World singleton: the uniform block behind kViewBinding.
struct ViewUniforms {
  gpu::Buffer buffer;
};

}  // namespace

void prepareView(World& world) {
  const Entity entity = world.singleton<const ActiveCamera>().entity;
  Camera camera;
  Transform current;
  PreviousTransform previous;
  if (const Camera* found = world.peek<Camera>(entity)) {
    camera = *found;
    if (const Transform* placed = world.peek<Transform>(entity)) {
      current = *placed;
      const PreviousTransform* before = world.peek<PreviousTransform>(entity);
      previous = before != nullptr ? *before : previousOf(current);
    }
  }
  View& view = world.singleton<View>();
  view = computeView(previous, current, camera, world.singleton<const FrameInput>());

  ViewUniforms& uniforms = world.singleton<ViewUniforms>();
  if (!uniforms.buffer) uniforms.buffer = gpu::Buffer("scene.view", sizeof(view.block));
  uniforms.buffer.upload(&view.block, sizeof(view.block));
  uniforms.buffer.bindUniform(static_cast<unsigned>(rules::kViewBinding));
}

}  // namespace scree
