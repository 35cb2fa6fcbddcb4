// Guards: no centre goes through a surface, however thin, bent or fast it is.
//
// In the collider's own space a grain goes from where it was to where it is; if the straight way comes
// nearer to the surface than a quarter of its radius, it ends there. Ways that never meet the surface
// leave a grain on its side, whatever happens to it on the way.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "modules/grains/solver.h"

namespace scree::grains {
namespace {

constexpr float kCore = 0.25f;  // radii
constexpr float kDeep = 0.5f;   // radii from a plane to the centre

// Takes a grain that was `distance` away at `local` back if its way leads through the surface: it
// goes on along the surface from there.
bool keep(const PosedCollider& end, vec3 local, float distance, Body& grain) {
  if (!(distance > 0)) return false;  // inside already: the contact pushes it out
  vec3 from = end.position + end.world_from_local * local, to = grain.position;
  const float core = std::min(kCore * grain.radius, 0.5f * distance);
  constexpr int kTurns = 3;
  for (int turn = 0; turn < kTurns; ++turn) {
    const float free = freeWay(end, from, to, distance, core);
    if (!(free < 1)) {
      grain.position = to;
      return turn > 0;
    }
    from += (to - from) * free;
    const SurfacePoint near = nearestSurface(end, from);
    const vec3 rest = to - from;
    to -= near.normal * glm::dot(rest, near.normal);
    // Along the surface it stays where it is, but for rounding and for what the surface does.
    distance = std::max(near.distance, core);
    from += near.normal * (0.01f * core);
    to += near.normal * (0.01f * core);
  }
  grain.position = from;
  return true;
}

}  // namespace

void keepGuards(ColliderSlab& slab, Body* body, std::span<const PosedCollider> begin,
                std::span<const PosedCollider> end) {
  // A grain that a blade takes along may come to a wall, and one that slides along a wall to a blade.
  // What stands has the last word: a grain pressed between the two slips through the blade.
  constexpr int kRounds = 4;
  bool met = true;
  for (int round = 0; round < kRounds && met; ++round) {
    met = false;
    for (const bool moving : {true, false}) {
      for (const Guard& guard : slab.guards) {
        const ColliderContact& contact = slab.contact[guard.contact];
        if (begin[contact.collider].moves() != moving) continue;
        met |= keep(end[contact.collider], guard.local, guard.distance, body[contact.grain]);
      }
    }
  }
}

bool stopAt(const PosedCollider& begin, const PosedCollider& end, vec3 from, Body& grain) {
  const vec3 local = (from - begin.position) * begin.world_from_local;
  const vec3 way = grain.position - (end.position + end.world_from_local * local);
  const float distance = distanceTo(begin, from, glm::length(way) + grain.radius);
  return keep(end, local, distance, grain);
}

// Grains that a substep took beyond where they are listed with colliders: a blow drove them away.
void GrainSolver::stopDriven(std::span<const Collider> colliders, float t1) {
  bool any = false;
  for (const std::vector<Driven>& driven : driven_) any = any || !driven.empty();
  if (!any) return;
  // A bounce displaces a grain so that the move takes it to the right place.
  std::vector<std::pair<uint32_t, vec3>>& shifts = shifts_;
  shifts.clear();
  eachBounce([&](uint32_t slot, vec3 shift) { shifts.emplace_back(slot, shift); });
  std::stable_sort(shifts.begin(), shifts.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  parallelChunks(driven_.size(), 1, [&](size_t chunk, size_t, size_t) {
    for (const Driven& driven : driven_[chunk]) {
      Body& grain = bodies_.body[driven.slot];
      vec3 from = driven.from;
      auto at = std::lower_bound(shifts.begin(), shifts.end(), driven.slot,
                                 [](const auto& a, uint32_t slot) { return a.first < slot; });
      for (; at != shifts.end() && at->first == driven.slot; ++at) from -= at->second;
      const vec3 low = glm::min(from, grain.position) - grain.radius,
                 high = glm::max(from, grain.position) + grain.radius;
      for (const bool moving : {true, false})
        for (size_t k = 0; k < colliders.size(); ++k) {
          const Bounds& bounds = walls_.swept()[k].bounds;
          const bool gives = rigids_.awake(colliders[k]);
          if ((colliders[k].moves() || gives) != moving || high.x < bounds.min.x || bounds.max.x < low.x ||
              high.y < bounds.min.y || bounds.max.y < low.y || high.z < bounds.min.z ||
              bounds.max.z < low.z)
            continue;
          const PosedCollider end = gives ? rigids_.posed(colliders[k], posed_[k])
                                    : moving ? poseCollider(colliders[k], t1, t1, 0) : posed_[k];
          if (colliders[k].shape == Shape::Plane) {  // no other side: only not deep in it
            const SurfacePoint near = nearestSurface(end, grain.position);
            if (near.distance < kDeep * grain.radius)
              grain.position += near.normal * (grain.radius - near.distance);
          } else {
            stopAt(posed_[k], end, from, grain);
          }
        }
    }
    driven_[chunk].clear();
  });
}

// At the substep's end, a share t1 of the tick.
void GrainSolver::guard(std::span<const Collider> colliders, float t1) {
  bool any = false;
  for (uint32_t s = 0; s < walls_.slab_count && !any; ++s) any = !walls_.slab[s].guards.empty();
  if (any) {
    posed_end_.resize(colliders.size());
    for (size_t k = 0; k < colliders.size(); ++k)
      posed_end_[k] = colliders[k].moves() ? poseCollider(colliders[k], t1, t1, 0) : posed_[k];
    if (rigids_.anyAwake()) rigids_.pose(posed_end_, colliders);
    parallelChunks(walls_.slab_count, 4, [&](size_t, size_t begin, size_t end) {
      for (size_t s = begin; s < end; ++s)
        keepGuards(walls_.slab[s], bodies_.body.data(), posed_, posed_end_);
    }, worthOf(walls_.contact_count, kFewPairs));
  }
  stopDriven(colliders, t1);
}

}  // namespace scree::grains
