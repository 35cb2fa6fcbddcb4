// Whether the sun's shadow map is to be drawn in a frame: what it shows, and what it is to show.
#pragma once

#include <vector>

#include "modules/deferred/deferred.h"
#include "modules/deferred/shadow_fit.h"

namespace scree {

struct ShadowContent {
  uint64_t view_version = 0;  // ShadowView's; 0: what nobody can tell from something else
  std::vector<ShadowCasters::Drawing> drawings;
  bool operator==(const ShadowContent&) const = default;
};

// World singleton. The map's texture lives as long as the frame: in frames without a sun, or in which
// nobody reads it, it stays as it was.
struct ShadowMap {
  bool decided = false, wanted = false;  // in this frame
  ShadowFit fit;                         // of the last frame with a sun and a caster
  uint64_t reloads = 0;                  // of programs, likewise
  ShadowContent due;                     // in this frame
  ShadowContent shown;                   // set by deferred.shadow, after which all others draw
};

// At the start of Phase::Prepare.
void beginShadows(World& world);

}  // namespace scree
