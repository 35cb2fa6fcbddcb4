// grains.emit: grains stream from emitters, each where nothing is.
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/app/app.h"
#include "engine/core/random.h"
#include "modules/grains/region.h"

namespace scree::grains {
namespace {

// Points of the mouth that a grain tries before it is held back.
constexpr uint64_t kTries = 8;
// Draws of a point in a disc or a ball before its centre does: once in 5e10, or 1e5, grains.
constexpr uint64_t kDraws = 16;
// Random streams of a grain, beside those of its tries.
constexpr uint64_t kOfGrain = 1000, kOfVelocity = 1001;

// Uniform in the unit disc or ball, without a function that differs between machines.
template <int dimensions>
vec3 inUnitBall(uint64_t seed, uint64_t grain, uint64_t stream) {
  for (uint64_t k = 0; k < kDraws; ++k) {
    vec3 at(0);
    for (int axis = 0; axis < dimensions; ++axis)
      at[axis] = 2 * randomUnit(seed, grain, stream, 3 * k + static_cast<uint64_t>(axis)) - 1;
    if (glm::dot(at, at) <= 1) return at;
  }
  return vec3(0);
}

// An emitter in the tick.
struct Mouth {
  const GrainEmitter& emitter;
  vec3 centre;
  mat3 world_from_local;
  vec3 scale;
  vec3 velocity;  // world axes
  vec3 gravity;

  GrainSpec grain(uint64_t number) const {
    const GrainEmitter& e = emitter;
    const auto draw = [&](uint64_t which) { return randomUnit(e.seed, number, kOfGrain, which); };
    const auto spread = [&](uint64_t which) { return 2 * draw(which) - 1; };
    GrainSpec spec;
    spec.grain.radius = e.radius * (1 + e.radius_jitter * spread(0));
    spec.orientation.rotation =
        glm::normalize(quat(draw(1) + 0.01f, spread(2), spread(3), spread(4)));
    spec.velocity.linear = velocity + e.spread * inUnitBall<3>(e.seed, number, kOfVelocity);
    spec.material = materialOf(e);
    spec.look = {e.color * (1 + e.color_jitter * spread(5)), e.roughness};
    return spec;
  }
  // Where the grain is when it left a point of the mouth `ago` seconds ago.
  vec3 place(uint64_t number, uint64_t attempt, vec3 from_velocity, float ago) const {
    const vec3 at = inUnitBall<2>(emitter.seed, number, attempt);
    const vec3 local = emitter.mouth * vec3(at.x, 0, at.y) * scale;
    return centre + world_from_local * local + ago * from_velocity + 0.5f * ago * ago * gravity;
  }
  // Half the extent of the cube in which all its places of a tick lie.
  float reach(float dt) const {
    const float way = glm::length(velocity) + emitter.spread + 0.5f * dt * glm::length(gravity);
    return 1.001f * (emitter.mouth * std::max(std::abs(scale.x), std::abs(scale.z)) + way * dt);
  }
};

class Emission {
 public:
  Emission(GrainsState& state, float dt) : state_(state), dt_(dt) {}

  void emit(Entity entity) {
    const Transform* transform = state_.world.peek<Transform>(entity);
    GrainEmitter emitter = *state_.world.peek<GrainEmitter>(entity);
    if (!emitter.on) return;
    std::string wrong = fault(emitter);
    const ClumpShape* shape = state_.world.peek<ClumpShape>(entity);
    if (wrong.empty() && shape != nullptr)
      wrong = faultOfClumps(*shape, emitter.radius * (1 - emitter.radius_jitter),
                            emitter.radius * (1 + emitter.radius_jitter));
    if (wrong.empty()) wrong = faultOf(*transform, fieldOrigin(state_.world), vec3(emitter.mouth));
    if (!wrong.empty()) {
      refuse(state_.refused_emitters, state_.world, "grains.emit", "GrainEmitter", entity, wrong);
      return;
    }
    const double total = emitter.due + static_cast<double>(emitter.rate) * static_cast<double>(dt_);
    auto count = static_cast<uint64_t>(total);
    if (emitter.most > 0) {
      if (emitter.emitted >= emitter.most) return;
      count = std::min(count, emitter.most - emitter.emitted);
    }
    emitter.due = std::min(total - static_cast<double>(count), 1.0);
    form_ = count > 0 && shape != nullptr ? state_.forms.of(*shape) : ClumpForm{.count = 1, .bound = 1};
    if (count > 0) stream(emitter, *transform, count, total);
    if (emitter.most > 0 && emitter.emitted >= emitter.most) emitter.due = 0;
    *state_.world.find<GrainEmitter>(entity) = emitter;
  }
  void finish() {
    spawnGrains(state_.world, state_.emitted);
    closeRefusals(state_.refused_emitters);
  }

 private:
  void stream(GrainEmitter& emitter, const Transform& transform, uint64_t count, double total) {
    GrainField& field = placeField(transform);
    const Mouth mouth{emitter,
                      vec3(transform.position - field.origin),
                      glm::mat3_cast(glm::normalize(transform.rotation)),
                      transform.scale,
                      glm::mat3_cast(glm::normalize(transform.rotation)) * emitter.velocity,
                      field.gravity};
    meet(mouth, field.origin);
    size_t room = kMaxGrains - std::min<size_t>(
        kMaxGrains, state_.grains.count() + state_.emitted.size());
    state_.emitted_clumps.clear();
    state_.clump_scale.clear();
    for (uint64_t k = 1; k <= count; ++k) {
      const uint64_t number = emitter.emitted + emitter.held_back;
      const auto ago = static_cast<float>((total - static_cast<double>(k)) / static_cast<double>(emitter.rate));
      GrainSpec spec = mouth.grain(number);
      if (room < form_.count || !findPlace(mouth, number, std::clamp(ago, 0.0f, dt_), spec)) {
        ++emitter.held_back;
        continue;
      }
      state_.crowd.add(spec.grain.position, form_.bound * spec.grain.radius);
      take(spec);
      ++emitter.emitted;
      room -= form_.count;
    }
    spawnClumpsOf(state_.world, form_, state_.clump_scale, state_.emitted_clumps);
  }

  // A clump is placed as the sphere around it.
  void take(const GrainSpec& spec) {
    if (form_.count == 1) {
      state_.emitted.push_back(spec);
      return;
    }
    ClumpSpec clump;
    clump.position = spec.grain.position;
    clump.rotation = spec.orientation.rotation;
    clump.velocity = spec.velocity.linear;
    clump.material = spec.material;
    clump.look = spec.look;
    state_.emitted_clumps.push_back(clump);
    state_.clump_scale.push_back(spec.grain.radius);
  }

  GrainField& placeField(const Transform& transform) {
    GrainField& field = grainField(state_.world);
    if (!field.placed && state_.grains.empty() && state_.emitted.empty()) {
      field.origin = glm::round(transform.position);
      field.placed = true;
    }
    return field;
  }

  // Gathers the grains and colliders that may be in the way.
  void meet(const Mouth& mouth, const dvec3& origin) {
    const float reach = mouth.reach(dt_);
    const float largest = form_.bound * mouth.emitter.radius * (1 + mouth.emitter.radius_jitter);
    const vec3 low = mouth.centre - reach, high = mouth.centre + reach;
    Crowd& crowd = state_.crowd;
    crowd.reset(low, high, largest);
    eachGrainNear(state_, low - largest, high + largest,
                  [&](const SeenGrain& grain) { crowd.add(grain.position, grain.radius); });
    for (const GrainSpec& spec : state_.emitted) crowd.add(spec.grain.position, spec.grain.radius);
    if (!std::exchange(gathered_, true)) gatherColliders(state_, origin, dt_);
    std::vector<PosedCollider>& walls = state_.walls;
    walls.clear();
    for (const Collider& collider : state_.colliders) {
      const Bounds bounds = sweptBounds(collider);
      const vec3 outer_low = low - largest, outer_high = high + largest;
      bool apart = false;
      for (int axis = 0; axis < 3; ++axis)
        apart = apart || !(bounds.min[axis] <= outer_high[axis] && outer_low[axis] <= bounds.max[axis]);
      if (!apart) walls.push_back(poseCollider(collider, 0, 0, 0));
    }
  }

  bool findPlace(const Mouth& mouth, uint64_t number, float ago, GrainSpec& spec) const {
    const float radius = form_.bound * spec.grain.radius;
    for (uint64_t attempt = 0; attempt < kTries; ++attempt) {
      const vec3 at = mouth.place(number, attempt, spec.velocity.linear, ago);
      if (!state_.crowd.free(at, radius)) continue;
      const bool walled = std::any_of(
          state_.walls.begin(), state_.walls.end(), [&](const PosedCollider& wall) {
            return nearestSurface(wall, at).distance < radius;
          });
      if (walled) continue;
      spec.grain.position = at;
      spec.velocity.linear += ago * mouth.gravity;
      return true;
    }
    return false;
  }

  GrainsState& state_;
  float dt_;
  bool gathered_ = false;  // the colliders, for all emitters of the tick
  ClumpForm form_;  // of the emitter at hand; count 1: a sphere
};

void emitAll(GrainsState& state) {
  const auto dt = static_cast<float>(state.world.singleton<const Tick>().dt_s);
  state.emitted.clear();
  state.entities.clear();
  state.emitters.each([&](Entity entity, const Transform&, const GrainEmitter&) {
    state.entities.push_back(entity);
  });
  std::sort(state.entities.begin(), state.entities.end());
  Emission emission(state, dt > 0 ? std::min(dt, kLongestTick) : 0.0f);
  for (const Entity entity : state.entities) emission.emit(entity);
  emission.finish();
}

}  // namespace

SystemDesc emitSystem(const SharedState& state) {
  return {.name = "grains.emit",
          .phase = Phase::Simulate,
          .needs = [state] { return !state->emitters.empty(); },
          .run = [state](World&) { emitAll(*state); }};
}

}  // namespace scree::grains
