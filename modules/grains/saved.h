// What a saved solver is made of: everything that later ticks depend on and that the rows do not say.
//
//   uint32 version; scalars of the solver
//   sleepers, their contacts with each other and with colliders     sleepers_save.cpp
//   bodies, and what woken grains brought along since the search    solver_save.cpp
//   slabs; contacts of pairs and with colliders, by slab            lists_save.cpp
//   rigid bodies and their contacts                                 rigid_save.cpp
//
// Little-endian, counts before lists. Positions, velocities and the like are in the rows of the
// world, and are read from there in the first tick, which looks at all rows; a row that does not fit
// is then taken as one that somebody wrote to. Cells, colours and sums are made anew. All numbers are
// checked, so that no bytes make the solver read beyond its arrays.
#pragma once

#include <cstdint>

#include "engine/core/bytes.h"
#include "engine/core/math.h"

namespace scree::grains {

inline constexpr uint32_t kSavedVersion = 4;

}  // namespace scree::grains
