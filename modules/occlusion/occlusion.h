// Occlusion culling against what was drawn: a pyramid of the farthest depths, and the test of spheres
// and ellipsoids.
//
// In: gbuffer.depth, as it is after Stage::Geometry. Out: occlusion.pyramid, each texel the farthest
// depth of the pixels that it covers, from 2 x 2 pixels up to the whole picture. What a pass of a later
// stage would draw inside a sphere, or an ellipsoid, is hidden if that is behind that depth wherever it can show:
// lib/occlusion.glsl tests so; the rules and their error bounds are in shared/occlusion.h and shared/ellipsoid.h. Culling
// never changes the picture. Occluders are fused: gaps between grains count as what is seen in them.
// Source: Greene, Kass and Miller 1993, "Hierarchical Z-Buffer Visibility". Cost: README.md; a scene
// in which no pass reads the pyramid pays nothing.
#pragma once

#include <string_view>

namespace scree {

class App;
class World;
namespace gpu {
class Texture;
}
struct PassContext;

// A pass that tests uses this with Access::Sampled, in a stage after Stage::DepthPyramid.
inline constexpr std::string_view kOcclusionPyramid = "occlusion.pyramid";

// Registers the pass occlusion.pyramid. Needs addDeferred before; modules that read the pyramid are
// added after.
void addOcclusion(App& app);

// Binds the pyramid for lib/occlusion.glsl; to be called in each pass that uses it. If nothing was
// drawn before Stage::DepthPyramid of this frame, its depths are those of an empty picture, and hide
// nothing. Returns what it bound.
const gpu::Texture& bindPyramid(World& world, const PassContext& context);

}  // namespace scree
