// grains.visible, grains.draw, grains.shadow: spheres, exact to the pixel, three vertices each.
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "modules/deferred/deferred.h"
#include "modules/grains/state.h"

namespace scree::grains {
namespace {

constexpr int kFirst = 0;  // uniform location

void bind(const DrawState& draw) {
  draw.records.bindStorage(rules::kGrainsBinding);
  draw.frame.bindUniform(rules::kPassBinding);
}

}  // namespace

PassDesc visiblePass(const SharedState& state) {
  struct Programs {
    gpu::Program free{{.name = "grains.visible",
                       .vertex = "grains/visible.vert",
                       .fragment = "grains/visible.frag"}};
    gpu::Program near{{.name = "grains.visible_near",
                       .vertex = "grains/visible.vert",
                       .fragment = "grains/visible.frag",
                       .defines = {"NEAR_PLANE"}}};
  };
  const auto programs = std::make_shared<Programs>();
  return {.name = "grains.visible",
          .stage = Stage::Geometry,
          .needs_text = "a grain in view",
          .needs = [state] {
            return !state->draw.drawn.empty() && state->draw.visible_count > 0;
          },
          .uses = {{kVisibleTarget, Access::Color}, {std::string(kGbufferDepth), Access::Depth}},
          .run = [state, programs](PassContext& context) {
            context.framebuffer->clearColor(0, uvec4(0));
            const DrawState& draw = state->draw;
            bind(draw);
            draw.visible.bindStorage(rules::kVisibleBinding);
            gpu::apply({.cull = gpu::Cull::None});
            const auto part = [](gpu::Program& program, uint32_t first, uint32_t count) {
              if (count == 0 || !program.use()) return;
              program.set(kFirst, first);
              gpu::drawVertexless(GL_TRIANGLES, 3 * static_cast<int>(count));
            };
            const uint32_t free_count = draw.visible_count - draw.near_count;
            part(programs->near, free_count, draw.near_count);
            part(programs->free, 0, free_count);
          }};
}

PassDesc drawPass(const SharedState& state) {
  struct Programs {
    gpu::Program still{{.name = "grains.draw",
                        .vertex = "grains/draw.vert",
                        .fragment = "grains/draw.frag"}};
    gpu::Program moving{{.name = "grains.draw_motion",
                         .vertex = "grains/draw.vert",
                         .fragment = "grains/draw.frag",
                         .defines = {"MOTION"}}};
  };
  const auto programs = std::make_shared<Programs>();
  return {.name = "grains.draw",
          .stage = Stage::Geometry,
          .needs_text = "a grain in view",
          .needs = [state] {
            return !state->draw.drawn.empty() && state->draw.visible_count > 0;
          },
          .needs_content = {kVisibleTarget},
          .uses = gbufferUses({{kVisibleTarget, Access::Sampled}}),
          .run = [state, programs](PassContext& context) {
            const bool motion = context.frame.isRead(kGbufferMotion);
            if (!(motion ? programs->moving : programs->still).use()) return;
            const DrawState& draw = state->draw;
            bind(draw);
            draw.spans.bindStorage(rules::kVisibleBinding);
            context.frame.texture(kVisibleTarget).bind(rules::kPassTextureUnit);
            gpu::apply({.depth_func = gpu::Compare::Always, .cull = gpu::Cull::None});
            gpu::drawVertexless(GL_TRIANGLES, 6 * static_cast<int>(draw.covered_spans.size()));
          }};
}

PassDesc shadowPass(const SharedState& state) {
  const auto program = std::make_shared<gpu::Program>(gpu::ProgramDesc{
      .name = "grains.shadow", .vertex = "grains/shadow.vert", .fragment = "grains/shadow.frag"});
  return {.name = "grains.shadow",
          .stage = Stage::Geometry,
          .needs_text = "a grain, and a shadow that has changed",
          .needs = [state] {
            return !state->draw.drawn.empty() && state->draw.count > 0 &&
                   shadowsWanted(state->world);
          },
          .uses = shadowUses(),
          .run = [state, program](PassContext&) {
            if (!program->use()) return;
            bind(state->draw);
            gpu::apply(shadowDrawState());
            gpu::drawVertexless(GL_TRIANGLES, 3 * static_cast<int>(state->draw.count));
          }};
}

}  // namespace scree::grains
