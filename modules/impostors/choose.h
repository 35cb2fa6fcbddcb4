// How many views of how many texels a grain needs.
#pragma once

#include <functional>
#include <span>

#include "modules/impostors/bake.h"

namespace scree {

// What is asked of an impostor.
struct ImpostorWish {
  float diameter_px = 32;  // the largest at which it is drawn
  float max_flip = 0.02f;  // mean FLIP there
  uint64_t max_bytes = uint64_t{32} << 20;  // impostorBytes()
  ImpostorScheme scheme = ImpostorScheme::Proxy;
  int supersample = 4;  // with which it will be baked
};
struct ImpostorChoice {
  int edge = 0, texels = 0;
  uint64_t bytes = 0;  // impostorBytes()
  float flip = 1;     // measured
  bool good = false;  // flip <= max_flip; if not, it is the best that fits max_bytes
};

// Of the sizes offered (n and p) the one of fewest bytes that is good; `flipOf` measures one, and
// is asked in order of bytes until one is good, never for one that does not fit. Refuses a wish of
// numbers that are not finite, and one that nothing fits.
Result<ImpostorChoice> chooseImpostor(
    const ImpostorWish& wish, std::span<const std::pair<int, int>> sizes,
    const std::function<Result<float>(int edge, int texels)>& flipOf);

// Bakes and measures the grain at the usual sizes: n = 3 to 12, p = 16 to 128 (at most the power of
// two above twice the diameter, which nothing can show).
Result<ImpostorChoice> chooseImpostor(const GrainMesh& grain, const ImpostorWish& wish,
                                      int directions = 24, const BakeProgress& progress = {});

}  // namespace scree
