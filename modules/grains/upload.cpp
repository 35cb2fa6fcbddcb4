// grains.upload: what the grain passes read: records, when a grain changed; each frame, the frame's
// constants, the grains in view from near to far, and the shadow casters.
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "engine/app/app.h"
#include "modules/deferred/deferred.h"
#include "modules/grains/state.h"
#include "shaders/shared/grain.h"
#include "shaders/shared/swarm.h"

namespace scree::grains {
namespace {

static_assert(sizeof(rules::GrainRecord) == 64 && sizeof(rules::GrainFrame) == 48);

void uploadRecords(DrawState& draw) {
  const Version version = draw.drawn.version();
  const size_t count = draw.drawn.count();
  if (version == draw.uploaded && count == draw.count) return;
  draw.uploaded = version;
  draw.count = static_cast<uint32_t>(count);
  draw.record_stream.beginFrame();
  draw.records = draw.record_stream.allocate(count * sizeof(rules::GrainRecord));
  rules::GrainRecord* out = static_cast<rules::GrainRecord*>(draw.records.data);
  draw.drawn.each([&](Entity entity, const Grain& grain, const GrainPrevious& previous,
                      const GrainOrientation& orientation, const GrainSpin& spin,
                      const GrainLook& look) {
    rules::GrainRecord record;
    record.position = grain.position;
    record.radius = grain.radius;
    record.previous = previous.position;
    record.look = rules::packGrainLook(look.color, look.roughness);
    const quat& q = orientation.rotation;
    record.rotation = vec4(q.x, q.y, q.z, q.w);
    record.spin = spin.angular;
    record.id = entity.index + 1;
    *out++ = record;  // whole: this memory is slow to read
  });
}

// Buckets by distance, so that what is near hides what is far before that is shaded; within a
// bucket by row, so that the order is the same in every run.
void sortByDistance(DrawState& draw) {
  constexpr size_t kBuckets = 1024;
  const size_t n = draw.in_view.size();
  draw.ordered.resize(n);
  if (n == 0) return;
  float nearest = draw.distance[0], farthest = draw.distance[0];
  for (const float d : draw.distance) {
    nearest = std::min(nearest, d);
    farthest = std::max(farthest, d);
  }
  const float scale = static_cast<float>(kBuckets - 1) / std::max(farthest - nearest, 1e-6f);
  const auto bucketOf = [&](size_t k) {
    return static_cast<size_t>((draw.distance[k] - nearest) * scale);
  };
  draw.bucket.assign(kBuckets + 1, 0);
  for (size_t k = 0; k < n; ++k) ++draw.bucket[bucketOf(k) + 1];
  for (size_t b = 1; b <= kBuckets; ++b) draw.bucket[b] += draw.bucket[b - 1];
  for (size_t k = 0; k < n; ++k) draw.ordered[draw.bucket[bucketOf(k)]++] = draw.in_view[k];
}

void gatherVisible(DrawState& draw, const View& view, vec3 origin, float alpha) {
  draw.in_view.clear();
  draw.at_near_plane.clear();
  draw.distance.clear();
  draw.cover.reset(view);
  const vec4 near_plane = view.block.frustum_planes[4];
  uint32_t row = 0;
  draw.drawn.each([&](const Grain& grain, const GrainPrevious& previous, const GrainOrientation&,
                      const GrainSpin&, const GrainLook&) {
    const vec3 center = origin + previous.position + (grain.position - previous.position) * alpha;
    if (sphereInView(view, center, grain.radius)) {
      draw.cover.add(center, grain.radius);
      // A little early: a grain may be tested in vain, but none may be missed.
      if (glm::dot(vec3(near_plane), center) + near_plane.w < 1.001f * grain.radius) {
        draw.at_near_plane.push_back(row);
      } else {
        draw.in_view.push_back(row);
        draw.distance.push_back(std::sqrt(glm::dot(center, center)));
      }
    }
    ++row;
  });
  sortByDistance(draw);
  draw.ordered.insert(draw.ordered.end(), draw.at_near_plane.begin(), draw.at_near_plane.end());
  draw.near_count = static_cast<uint32_t>(draw.at_near_plane.size());
  draw.visible_count = static_cast<uint32_t>(draw.ordered.size());
  draw.cover.spans(draw.covered_spans);
}

// Spheres around the grains at the frame's time; tells whether their shadows are those of the last frame.
void addCasters(DrawState& draw, const dvec3& origin, const dvec3& camera, float alpha, ShadowCasters& casters) {
  const size_t others = casters.spheres.size();
  bool moving = false;
  const size_t group = draw.count <= kLoneCasters ? 1 : kCasterGroup;
  draw.drawn.spans([&](std::span<const Entity>, std::span<const Grain> grain,
                       std::span<const GrainPrevious> previous, auto, auto, auto) {
    for (size_t begin = 0; begin < grain.size(); begin += group) {
      const size_t end = std::min(grain.size(), begin + group);
      vec3 low(3e38f), high(-3e38f);
      for (size_t k = begin; k < end; ++k) {
        const vec3 p = previous[k].position + (grain[k].position - previous[k].position) * alpha;
        moving |= previous[k].position != grain[k].position;
        low = glm::min(low, p - grain[k].radius);
        high = glm::max(high, p + grain[k].radius);
      }
      const vec3 half = 0.5f * (high - low);
      const float radius = group == 1 ? half.x : glm::length(half);
      casters.spheres.push_back({origin + dvec3(0.5f * (low + high)), radius});
    }
  });
  const Cast cast{draw.uploaded, draw.count, origin, camera, moving ? alpha : 1};
  if (cast != draw.cast) ++draw.cast_version;
  draw.cast = cast;
  casters.drawings.push_back({"grains.shadow", draw.cast_version, casters.spheres.size() - others});
}

void upload(GrainsState& state) {
  World& world = state.world;
  DrawState& draw = state.draw;
  const FrameInput& input = world.singleton<const FrameInput>();
  const View& view = world.singleton<const View>();
  const dvec3 origin = fieldOrigin(world);

  uploadRecords(draw);
  rules::GrainFrame frame{};
  frame.origin = vec4(vec3(origin - view.position), 0);
  frame.previous_origin = vec4(vec3(origin - view.previous_position), 0);
  frame.alpha = input.alpha;
  frame.previous_alpha = input.alpha - input.motion_scale;
  frame.tick_s = static_cast<float>(world.singleton<const Tick>().dt_s);
  frame.count = draw.count;
  gatherVisible(draw, view, vec3(frame.origin), input.alpha);
  draw.frame_stream.beginFrame();
  draw.frame = draw.frame_stream.write(frame);
  if (draw.visible_count > 0) {
    draw.visible = draw.frame_stream.write(std::span<const uint32_t>(draw.ordered));
    draw.spans = draw.frame_stream.write(std::span<const uint32_t>(draw.covered_spans));
  }
  if (world.singleton<const Sun>().present)
    addCasters(draw, origin, view.position, input.alpha, world.singleton<ShadowCasters>());
}

}  // namespace

SystemDesc uploadSystem(const SharedState& state) {
  return {.name = "grains.upload",
          .phase = Phase::Prepare,
          .needs = [state] { return !state->draw.drawn.empty(); },
          .run = [state](World&) { upload(*state); }};
}

}  // namespace scree::grains
