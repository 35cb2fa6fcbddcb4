// What the solver knows of each grain, one cache line each, and of the grains' order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/math.h"
#include "engine/core/parallel.h"
#include "engine/ecs/entity.h"
#include "modules/grains/grains.h"
#include "modules/grains/materials.h"
#include "modules/grains/room.h"

namespace scree::grains {

struct alignas(64) Body {
  vec3 position{0};  // m, relative to the field's origin
  float radius = 0;
  vec3 velocity{0};
  float inverse_mass = 1;  // 1/kg, as the solver uses it: see GrainSolver::shareHeavyLoads
  vec3 spin{0};
  float friction_root = 0;  // of two grains: the product is their geometric mean
  vec3 velocity_before{0};  // at the substep's begin
  float gravity_scale = 1;  // true mass / mass that the solver uses
};
static_assert(sizeof(Body) == 64);

// Radius / moment of inertia of a solid sphere: 2.5 / (mass radius).
inline float spinFactor(const Body& body) { return 2.5f * body.inverse_mass / body.radius; }

// Position at the last neighbour search, and how far the grain may stray from it (plus the drift).
struct Reference {
  vec3 position{0};
  float margin = 0;
};

inline constexpr uint32_t kNoSlot = 0xffffffffu;
// Of a body: awake; or gone since the last search, at which it leaves the bodies.
inline constexpr uint32_t kAwake = 0xffffffffu, kGone = 0xfffffffeu;

// The grains that the solver visits: those awake, and the sleepers near them.
struct Bodies {
  std::vector<Body> body;  // grains by slot, then idle bodies that fill up batches
  std::vector<Entity> entity;
  std::vector<uint32_t> material;  // among `materials`
  std::vector<float> margin;       // of its Reference, whose position the grid has
  std::vector<uint32_t> berth;  // of a sleeper, among Sleepers; kAwake; kGone
  std::vector<uint32_t> clump;  // of a member awake, among Clumps; kNoSlot; empty: no clump is awake
  uint32_t count = 0;  // grains
  Materials materials;

  const GrainMaterial& materialOf(uint32_t slot) const { return materials[material[slot]]; }
  // Of what is known of a grain; of clumps it is found out anew.
  template <class Visit>
  void eachColumn(const Visit& visit) {
    visit(body);
    visit(entity);
    visit(material);
    visit(margin);
    visit(berth);
  }
  void move(uint32_t from, uint32_t to) {
    eachColumn([&](auto& column) { column[to] = column[from]; });
  }
  // Keeps the first n.
  void cut(uint32_t n) {
    const size_t smaller = need_.shrinks(count, entity.capacity());
    count = n;
    eachColumn([&](auto& column) {
      column.resize(n);
      if (smaller > 0) shrinkTo(column, smaller);
    });
    if (materials.stale(n))
      materials.renew([&](const auto& visit) { for (uint32_t& number : material) visit(number); });
  }
  // From now on k is what order[k] was; in place, along the order's cycles. Uses the order up.
  void permute(std::span<uint32_t> order);

 private:
  Need need_;
};

inline void Bodies::permute(std::span<uint32_t> order) {
  for (uint32_t first = 0; first < order.size(); ++first) {
    if (order[first] == first) continue;
    const Body first_body = body[first];
    const Entity first_entity = entity[first];
    const uint32_t first_material = material[first];
    const float first_margin = margin[first];
    const uint32_t first_berth = berth[first];
    uint32_t to = first;
    for (uint32_t from = order[to]; from != first; from = order[to]) {
      move(from, to);
      order[to] = to;
      to = from;
    }
    order[to] = to;
    body[to] = first_body;
    entity[to] = first_entity;
    material[to] = first_material;
    margin[to] = first_margin;
    berth[to] = first_berth;
  }
}

// Empty, for bodies that never sleep, counts as awake.
inline bool isAwake(const Bodies& bodies, uint32_t slot) {
  return slot >= bodies.berth.size() || bodies.berth[slot] == kAwake;
}
inline bool isAsleep(const Bodies& bodies, uint32_t slot) {
  return !isAwake(bodies, slot) && bodies.berth[slot] != kGone;
}

// Loops over fewer than these are over before a second thread has woken: pairs and collider contacts
// of a pass, grains of a search. No result depends on them.
inline constexpr size_t kFewPairs = 2048, kFewGrains = 512;
inline Worth worthOf(size_t n, size_t few) { return n < few ? Worth::OneThread : Worth::Threads; }

// Impulses on a grain in a substep.
struct Load {
  vec3 impulse{0};    // left over: of all contacts and gravity, N s
  vec3 moment{0};     // left over, angular impulse / radius, N s
  float carried = 0;  // sum of the contacts' sizes, N s
};

// Makes `values` hold n copies of `value`. Grows with room to spare, so that lists whose length
// wavers a little do not allocate again and again.
template <class T>
void refill(std::vector<T>& values, size_t n, T value) {
  if (values.capacity() < n) {
    values.clear();
    values.reserve(roomFor(n));
  }
  values.assign(n, value);
}
// The same, contents undefined.
template <class T>
void remake(std::vector<T>& values, size_t n) {
  if (values.capacity() < n) {
    values.clear();
    values.reserve(roomFor(n));
  }
  values.resize(n);
}

}  // namespace scree::grains
