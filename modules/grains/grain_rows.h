// The columns of grains that the solver reads and writes.
#pragma once

#include <span>

#include "engine/ecs/entity.h"
#include "modules/grains/grains.h"

namespace scree::grains {

// Rows of one table; all spans have the same length.
struct GrainRows {
  std::span<const Entity> entity;
  std::span<Grain> grain;
  std::span<GrainVelocity> velocity;
  std::span<GrainSpin> spin;
  std::span<GrainOrientation> orientation;
  std::span<GrainPrevious> previous;
  std::span<const GrainMaterial> material;
  std::span<GrainRest> rest;  // empty: these grains never sleep
  std::span<const GrainClump> clump;  // empty: of these grains none is in a clump
};

}  // namespace scree::grains
