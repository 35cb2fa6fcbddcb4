// Registration: the pass that builds the pyramid, and its binding for passes that read it.
#include "modules/occlusion/occlusion.h"

#include "engine/app/app.h"
#include "modules/deferred/deferred.h"
#include "modules/occlusion/pyramid.h"
#include "shaders/shared/bindings.h"

namespace scree {

using occlusion::Pyramid;

void addOcclusion(App& app) {
  World& world = app.world();
  world.singleton<Pyramid>();
  app.frame().addExternal(std::string(kOcclusionPyramid));
  app.addPass({.name = "occlusion.pyramid",
               .stage = Stage::DepthPyramid,
               .needs_content = {std::string(kGbufferDepth)},
               .uses = {{std::string(kGbufferDepth), Access::Sampled},
                        {std::string(kOcclusionPyramid), Access::StorageWrite}},
               .run = [&world](PassContext& context) {
                 world.singleton<Pyramid>().build(context.frame.texture(kGbufferDepth));
               }});
}

const gpu::Texture& bindPyramid(World& world, const PassContext& context) {
  Pyramid& pyramid = world.singleton<Pyramid>();
  if (!context.frame.hasContent(kOcclusionPyramid)) pyramid.clear(context.input.size);
  pyramid.texture().bind(rules::kPyramidUnit);
  return pyramid.texture();
}

}  // namespace scree
