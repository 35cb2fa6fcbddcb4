// Noting contacts that are struck, substep by substep.
#include "modules/grains/strikes.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/core/parallel.h"

namespace scree::grains {
namespace {

auto key(const Strike& s) { return std::tuple(s.a.index, s.b.index, s.collider); }
bool before(const Strike& a, const Strike& b) { return key(a) < key(b); }

}  // namespace

void Strikes::begin(const StrikeLimits& limits, int substeps) {
  found_.clear();
  limits_ = limits;
  share_ = limits.impulse / static_cast<float>(std::clamp(substeps, 1, 64));
}

// Takes what passes a limit, and what goes on of contacts that have.
void Strikes::add(std::vector<Strike>& out, const Strike& strike) const {
  if (!(strike.impulse > 0)) return;
  const bool passes = (limits_.speed > 0 && strike.speed > limits_.speed) ||
                      (limits_.impulse > 0 && strike.impulse > share_);
  if (passes || (!found_.empty() &&
                 std::binary_search(found_.begin(), found_.end(), strike, before)))
    out.push_back(strike);
}

void Strikes::note(const PairLists& pairs, const ColliderLists& walls, const Bodies& bodies) {
  if (!limits_.asked()) return;
  if (noted_.size() < pairs.slab_count) noted_.resize(pairs.slab_count);
  const uint32_t listed = pairs.bodyCount();
  const auto notePairs = [&](const PairSlab& slab, std::vector<Strike>& out) {
    for (uint32_t c = 0; c < slab.count; ++c) {
      if (slab.i[c] >= listed || !slab.carriesImpulse(c)) continue;
      uint32_t i = slab.i[c], j = slab.j[c];
      vec3 impulse = slab.impulseAt(c);
      if (bodies.entity[j].index < bodies.entity[i].index) {
        std::swap(i, j);
        impulse = -impulse;
      }
      const Body &a = bodies.body[i], &b = bodies.body[j];
      const vec3 d = a.position - b.position;
      const float distance = std::sqrt(glm::dot(d, d));
      if (!(distance > 1e-6f * (a.radius + b.radius))) continue;  // coincident: without direction
      const vec3 normal = d / distance;
      Strike strike;
      strike.a = bodies.entity[i];
      strike.b = bodies.entity[j];
      strike.position = a.position - d * (a.radius / (a.radius + b.radius));
      strike.normal = normal;
      strike.impulse = glm::dot(impulse, normal);
      strike.speed = -glm::dot(a.velocity_before - b.velocity_before, normal);
      add(out, strike);
    }
  };
  const auto noteWalls = [&](const ColliderSlab& slab, std::vector<Strike>& out) {
    for (const ColliderContact& contact : slab.contact) {
      const Body& grain = bodies.body[contact.grain];
      Strike strike;
      strike.a = bodies.entity[contact.grain];
      strike.collider = colliderKey(contact.key);
      strike.position = grain.position - grain.radius * contact.normal;
      strike.normal = contact.normal;
      strike.impulse = glm::dot(contact.impulse, contact.normal);
      strike.speed = -glm::dot(grain.velocity_before - contact.surface_velocity, contact.normal);
      add(out, strike);
    }
  };
  parallelChunks(pairs.slab_count, 4, [&](size_t, size_t begin, size_t end) {
    for (size_t s = begin; s < end; ++s) {
      noted_[s].clear();
      notePairs(pairs.slab[s], noted_[s]);
      noteWalls(walls.slab[s], noted_[s]);
    }
  });

  // Of each contact one, with the sum of its impulses, and where it was struck fastest.
  merged_.assign(found_.begin(), found_.end());
  for (uint32_t s = 0; s < pairs.slab_count; ++s)
    merged_.insert(merged_.end(), noted_[s].begin(), noted_[s].end());
  if (merged_.size() == found_.size()) return;
  std::sort(merged_.begin() + static_cast<std::ptrdiff_t>(found_.size()), merged_.end(), before);
  std::inplace_merge(merged_.begin(), merged_.begin() + static_cast<std::ptrdiff_t>(found_.size()),
                     merged_.end(), before);
  found_.clear();
  for (const Strike& strike : merged_) {
    if (found_.empty() || before(found_.back(), strike)) {
      found_.push_back(strike);
      continue;
    }
    Strike& so_far = found_.back();
    const float impulse = so_far.impulse + strike.impulse;
    if (strike.speed > so_far.speed) so_far = strike;
    so_far.impulse = impulse;
  }
}

void Strikes::close() {
  if (!limits_.asked()) return;
  std::erase_if(found_, [&](const Strike& s) {
    return !(limits_.speed > 0 && s.speed > limits_.speed) &&
           !(limits_.impulse > 0 && s.impulse > limits_.impulse);
  });
}

size_t Strikes::memoryBytes() const {
  size_t bytes = (found_.capacity() + merged_.capacity()) * sizeof(Strike) +
                 noted_.capacity() * sizeof(noted_[0]);
  for (const std::vector<Strike>& noted : noted_) bytes += noted.capacity() * sizeof(Strike);
  return bytes;
}

}  // namespace scree::grains
