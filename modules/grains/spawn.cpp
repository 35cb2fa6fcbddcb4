// grains.spawn: blocks of grains become grains; and the functions that spawn grains.
#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "engine/core/log.h"
#include "engine/core/random.h"
#include "engine/ecs/range.h"
#include "modules/grains/spawn_rows.h"
#include "modules/grains/state.h"

namespace scree {
namespace grains {

// The first field by entity index; Entity::kNone if there is none.
static Entity firstField(World& world) {
  Entity first = Entity::kNone;
  world.query<const GrainField>().each([&](Entity entity, const GrainField&) {
    if (first == Entity::kNone || entity < first) first = entity;
  });
  return first;
}

namespace {

struct FoundBlock {
  Entity entity;
  GrainBlock block;
  Transform transform;
  std::optional<ClumpShape> shape;
};

// What is wrong with a block in the world as it is; empty: nothing.
std::string faultIn(GrainsState& state, const GrainBlock& block, const ClumpShape* shape) {
  const size_t grains_so_far = state.grains.count();
  if (std::string wrong = fault(block); !wrong.empty()) return wrong;
  double total = 1.0 * block.count[0] * block.count[1] * block.count[2];
  if (shape != nullptr) {
    if (std::string wrong = faultOfClumps(block, *shape, state.forms); !wrong.empty()) return wrong;
    total *= state.forms.of(*shape).count;
  }
  if (total + static_cast<double>(grains_so_far) > kMaxGrains)
    return fmt::format("{} grains beside {}; a world holds {}", total, grains_so_far, kMaxGrains);
  return {};
}

// Of a block's lattice point: the same for spheres and for clumps.
struct Point {
  float scale;  // radius
  vec3 position;
  quat rotation;
  GrainLook look;
};
Point pointOf(const FoundBlock& found, size_t k, vec3 base, float spacing, float bound) {
  const GrainBlock& block = found.block;
  const auto draw = [&](uint64_t which) { return randomUnit(block.seed, k, 0, which); };
  const auto spread = [&](uint64_t which) { return 2 * draw(which) - 1; };
  const auto nx = static_cast<size_t>(block.count[0]), ny = static_cast<size_t>(block.count[1]),
             nz = static_cast<size_t>(block.count[2]);
  Point point;
  point.scale = block.radius * (1 + block.radius_jitter * spread(0));
  // Shaken within the cell, so that grains do not stand on one another like coins.
  const float slack = 0.5f * spacing - bound * point.scale;
  const vec3 cell(static_cast<float>(k % nx), static_cast<float>(k / nx % ny),
                  static_cast<float>(k / nx / ny));
  const vec3 middle = 0.5f * vec3(static_cast<float>(nx - 1), static_cast<float>(ny - 1),
                                  static_cast<float>(nz - 1));
  const vec3 shaken = slack * vec3(spread(1), spread(2), spread(3));
  const vec3 local = (cell - middle) * spacing + shaken;
  point.position = base + found.transform.rotation * local;
  const quat turned(draw(4) + 0.01f, spread(5), spread(6), spread(7));
  point.rotation = glm::normalize(turned);
  point.look = {block.color * (1 + block.color_jitter * spread(8)), block.roughness};
  return point;
}

void spawnBlockOfClumps(World& world, const FoundBlock& found, const ClumpForm& form, const dvec3& origin) {
  const GrainBlock& block = found.block;
  const float spacing = spacingOf(block, form.bound);
  const vec3 base = vec3(found.transform.position - origin);
  const size_t total = static_cast<size_t>(block.count[0]) * static_cast<size_t>(block.count[1]) *
                       static_cast<size_t>(block.count[2]);
  std::vector<ClumpSpec> specs(total);
  std::vector<float> scale(total);
  for (size_t k = 0; k < total; ++k) {
    const Point point = pointOf(found, k, base, spacing, form.bound);
    scale[k] = point.scale;
    specs[k].position = point.position;
    specs[k].rotation = point.rotation;
    specs[k].material = materialOf(block);
    specs[k].look = point.look;
  }
  spawnClumpsOf(world, form, scale, specs);
}

void spawnBlock(World& world, const FoundBlock& found, const dvec3& origin) {
  const GrainBlock& block = found.block;
  const float spacing = spacingOf(block, 1);
  const vec3 base = vec3(found.transform.position - origin);
  const size_t total = static_cast<size_t>(block.count[0]) * static_cast<size_t>(block.count[1]) *
                       static_cast<size_t>(block.count[2]);
  if (total == 0) return;
  const TableRows rows =
      world.spawnMany(total, Grain{}, GrainVelocity{}, GrainSpin{}, GrainOrientation{},
                      GrainPrevious{}, GrainRest{}, materialOf(block),
                      GrainLook{block.color, block.roughness});
  const std::span<Grain> grain = rows.column<Grain>();
  const std::span<GrainPrevious> previous = rows.column<GrainPrevious>();
  const std::span<GrainOrientation> orientation = rows.column<GrainOrientation>();
  const std::span<GrainLook> look = rows.column<GrainLook>();
  for (size_t k = 0; k < total; ++k) {
    const Point point = pointOf(found, k, base, spacing, 1);
    grain[k] = {point.position, point.scale};
    previous[k].position = point.position;
    orientation[k].rotation = point.rotation;
    look[k] = point.look;
  }
}

void spawnBlocks(GrainsState& state) {
  World& world = state.world;
  std::vector<FoundBlock> found;
  state.blocks.each([&](Entity entity, const GrainBlock& block) {
    const Transform* transform = world.peek<Transform>(entity);
    const ClumpShape* shape = world.peek<ClumpShape>(entity);
    found.push_back({entity, block, transform != nullptr ? *transform : Transform{},
                     shape != nullptr ? std::optional(*shape) : std::nullopt});
  });
  std::sort(found.begin(), found.end(),
            [](const FoundBlock& a, const FoundBlock& b) { return a.entity < b.entity; });
  GrainField& field = grainField(world);
  uint64_t refused = 0;
  if (!field.placed) {
    field.origin = glm::round(found.front().transform.position);
    field.placed = true;
  }
  const dvec3 origin = field.origin;
  for (const FoundBlock& block : found) {
    const ClumpShape* shape = block.shape ? &*block.shape : nullptr;
    if (const std::string wrong = faultIn(state, block.block, shape); !wrong.empty()) {
      if (refused++ == 0)
        logWarning("grains.spawn: GrainBlock of {} refused: {}", nameOf(world, block.entity), wrong);
    } else if (shape != nullptr) {
      spawnBlockOfClumps(world, block, state.forms.of(*shape), origin);
    } else {
      spawnBlock(world, block, origin);
    }
    world.remove<GrainBlock>(block.entity);
  }
  if (refused > 1) logWarning("grains.spawn: {} blocks refused, the first is named above", refused);
  grainField(world).refused += refused;
}

}  // namespace

const GrainField* peekField(World& world) { return world.peek<GrainField>(firstField(world)); }

dvec3 fieldOrigin(World& world) {
  const GrainField* field = peekField(world);
  return field != nullptr ? field->origin : GrainField().origin;
}

std::string faultOfClumps(const GrainBlock& block, const ClumpShape& shape, ClumpForms& forms) {
  const float largest = block.radius * (1 + block.radius_jitter);
  std::string wrong = faultOfClumps(shape, block.radius * (1 - block.radius_jitter), largest);
  if (wrong.empty() && block.spacing != 0)
    wrong = firstFault({{"spacing", block.spacing, 2.0 * largest * forms.of(shape).bound, 1e6}});
  return wrong;
}

std::string nameOf(const World& world, Entity entity) {
  const Name* name = world.peek<Name>(entity);
  return name != nullptr && name->text[0] != 0
             ? fmt::format("\"{}\"", std::string_view(name->text, strnlen(name->text, sizeof name->text)))
             : fmt::format("entity {}", entity.index);
}

SystemDesc spawnSystem(const SharedState& state) {
  return {.name = "grains.spawn",
          .phase = Phase::Simulate,
          .needs = [state] { return !state->blocks.empty(); },
          .run = [state](World&) { spawnBlocks(*state); }};
}

}  // namespace grains

void spawnGrains(World& world, std::span<const GrainSpec> specs) {
  if (specs.empty()) return;
  const grains::NewGrains rows(
      world.spawnMany<Grain, GrainVelocity, GrainSpin, GrainOrientation, GrainPrevious, GrainRest,
                      GrainMaterial, GrainLook>(specs.size()));
  for (size_t k = 0; k < specs.size(); ++k) rows.put(k, specs[k]);
}

GrainField& grainField(World& world) {
  Entity first = grains::firstField(world);
  if (first == Entity::kNone) first = world.spawn(GrainField{});
  return *world.find<GrainField>(first);
}

}  // namespace scree
