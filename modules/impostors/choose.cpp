// A search by growing memory.
#include "modules/impostors/choose.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "modules/impostors/measure.h"

namespace scree {

Result<ImpostorChoice> chooseImpostor(const ImpostorWish& wish,
                                      std::span<const std::pair<int, int>> sizes,
                                      const std::function<Result<float>(int, int)>& flipOf) {
  if (!std::isfinite(wish.diameter_px) || !(wish.diameter_px > 0))
    return Error{fmt::format("impostor: a diameter of {} px; allowed is a positive number",
                             wish.diameter_px)};
  if (!std::isfinite(wish.max_flip))
    return Error{fmt::format("impostor: an error of {}; allowed is a number", wish.max_flip)};
  std::vector<ImpostorChoice> candidates;
  for (const auto& [edge, texels] : sizes) {
    const uint64_t bytes = impostorBytes(edge, texels);
    if (bytes <= wish.max_bytes) candidates.push_back({edge, texels, bytes});
  }
  if (candidates.empty())
    return Error{fmt::format("impostor: no size offered fits {} bytes", wish.max_bytes)};
  std::ranges::sort(candidates, [](const ImpostorChoice& a, const ImpostorChoice& b) {
    return a.bytes != b.bytes ? a.bytes < b.bytes : a.edge < b.edge;
  });
  const ImpostorChoice* best = nullptr;
  for (ImpostorChoice& candidate : candidates) {
    Result<float> flip = flipOf(candidate.edge, candidate.texels);
    if (!flip.ok()) return Error{flip.error(), flip.errorKind()};
    candidate.flip = *flip;
    candidate.good = candidate.flip <= wish.max_flip;
    if (candidate.good) return candidate;
    if (best == nullptr || candidate.flip < best->flip) best = &candidate;
  }
  return *best;
}

Result<ImpostorChoice> chooseImpostor(const GrainMesh& grain, const ImpostorWish& wish,
                                      int directions, const BakeProgress& progress) {
  if (directions < 1 || directions > 1024)
    return Error{fmt::format("impostor: {} directions, allowed are 1 to 1024", directions)};
  std::vector<std::pair<int, int>> sizes;
  for (int texels : {16, 32, 64, 128}) {
    if (texels > kImpostorMinTexels && static_cast<float>(texels) >= 4 * wish.diameter_px) break;
    for (int edge : {3, 4, 5, 6, 7, 8, 10, 12}) sizes.emplace_back(edge, texels);
  }
  if (Status fine = checkGrain(grain); !fine.ok()) return fine.takeError();
  Result<impostors::UnitGrain> unit = impostors::unitGrain(grain);
  if (!unit.ok()) return Error{unit.error()};
  return chooseImpostor(wish, sizes, [&](int edge, int texels) -> Result<float> {
    Result<ImpostorAtlas> atlas =
        bake(grain, {.edge = edge, .texels = texels, .supersample = wish.supersample, .directions = 0}, progress);
    if (!atlas.ok()) return atlas.takeError();
    return impostors::flipAt(*unit, *atlas, wish.scheme, wish.diameter_px, directions);
  });
}

}  // namespace scree
