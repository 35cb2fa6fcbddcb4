// Deferred shading: the G-buffer that every representation writes, opaque meshes, one sun with a
// shadow map, the sky and its light, tone mapping; and truth mode, the average of many samples a pixel.
//
// Equations: GGX with multiple scattering and glTF's mix of metal and dielectric (shared/brdf.h), sky
// as a quadratic in the direction's height (shared/sky.h), normal-offset shadows with 3x3 filtering
// (shared/shadow.h), PBR Neutral tone curve (shared/tonemap.h). In: modules/scene's MeshInstance,
// Light, Sky, View; ShadowCasters. Out: the targets below and Frame::kOutput.
// Cost: see README.md. An empty scene runs deferred.clear, deferred.sky and deferred.present only.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/core/math.h"
#include "engine/frame/frame.h"
#include "modules/scene/scene.h"
#include "shaders/shared/lighting.h"
#include "shaders/shared/shadow.h"

namespace scree {

class App;
namespace gpu {
struct DrawState;
}

// ---- Targets (formats and meaning: shaders/shared/gbuffer.h) -----------------------------------

inline constexpr std::string_view kGbufferAlbedo = "gbuffer.albedo";
inline constexpr std::string_view kGbufferNormal = "gbuffer.normal";
// Zero but where what emits is drawn, in Stage::Emission, after everything that does not.
inline constexpr std::string_view kGbufferEmissive = "gbuffer.emissive";
// Motion and id are drawn only in frames in which a pass that is on reads them, or Frame::keep() asks
// for them.
inline constexpr std::string_view kGbufferMotion = "gbuffer.motion";
inline constexpr std::string_view kGbufferId = "gbuffer.id";
inline constexpr std::string_view kGbufferDepth = "gbuffer.depth";
// No target: written, as Access::StorageWrite, by passes whose surfaces may have spread normals; what shades then
// reckons with them.
inline constexpr std::string_view kGbufferSpread = "gbuffer.spread";
// Depth of what the sun sees first; see shaders/shared/shadow.h.
inline constexpr std::string_view kShadowMap = "deferred.shadow_map";
// RGBA16F, linear radiance of this sample; alpha 1. Made and written only if a pass that is on reads it
// beside deferred.present, or Frame::keep() asks for it: whoever only draws into it keeps it.
inline constexpr std::string_view kRadiance = "deferred.radiance";
// RGBA32F, mean linear radiance of samples 0 to FrameInput::sample; truth mode only.
inline constexpr std::string_view kTruth = "deferred.truth";

// The uses of a pass that draws surfaces into the G-buffer with lib/gbuffer.glsl, in the order of
// the fragment shader's outputs. `extra` is appended: first kGbufferEmissive, if the pass writes it.
std::vector<Use> gbufferUses(std::vector<Use> extra = {});

// ---- Shadows: how a representation casts them --------------------------------------------------
//
// 1. In Phase::Prepare, a system registered after addDeferred appends spheres that contain what it
//    will draw to ShadowCasters. Large groups may share a sphere: only the union's extent matters.
//    It says by a Drawing whether that has changed: as long as nothing has, the map is kept.
// 2. A pass of Stage::Geometry, registered after addDeferred, with needs = shadowsWanted and uses =
//    shadowUses(), draws depth with shadow_view.clip_from_relative (#include "shared/shadow.h"; the
//    block is bound). Its DrawState: shadowDrawState(). The map is cleared already: it draws all.

// World singleton. Emptied at the start of every Phase::Prepare.
struct ShadowCasters {
  struct Sphere {
    dvec3 center{0};  // world, m
    float radius = 0; // m
  };
  std::vector<Sphere> spheres;
  // What a pass draws in this frame: spheres that no drawing counts are of something that may change
  // in each, and the map is drawn anew.
  struct Drawing {
    std::string_view pass;
    uint64_t version = 0;  // another one than ever before when other depths are drawn
    size_t spheres = 0;    // how many of them are of it
    bool operator==(const Drawing&) const = default;
  };
  std::vector<Drawing> drawings;
};

// True if the scene has a sun and some caster in reach, and the map does not show them yet as they are
// in this frame. For PassDesc::needs.
bool shadowsWanted(World& world);
std::vector<Use> shadowUses(std::vector<Use> extra = {});
gpu::DrawState shadowDrawState();

// World singleton; of the current frame as soon as it is decided which passes are on.
struct ShadowView {
  rules::ShadowViewBlock block{};  // enabled = 0 without a sun too
  // Goes up when the map's place in the world or its resolution changes, or a program was reloaded.
  uint64_t version = 0;
};

// World singleton.
struct ShadowSettings {
  // The map covers no more than this far from the camera, across the light; what lies outside casts
  // no shadow. Smaller is sharper, where the casters reach that far.
  float max_distance_m = 150;
  // Side of the used part of the map, 64 to rules::kShadowMapSize. 0: by the output's height, with
  // about as many texels as the picture's finest use of them (shadowMapSide).
  int side_texels = 0;
  // One bilinear comparison in place of 3x3: harder, more jagged edges for less time.
  bool single_fetch = false;
};

// Texels along a side of the map for an output of this height: 360 -> 1024, 720 and more -> 2048.
int shadowMapSide(const ShadowSettings& settings, int output_height);

// ---- Light -------------------------------------------------------------------------------------

// World singleton; written in Phase::Prepare from the first directional Light (lowest entity index)
// with a positive intensity. Other lights do not shine yet.
struct Sun {
  bool present = false;
  vec3 to_sun{0, 1, 0};     // unit
  vec3 irradiance{0};       // across the beam; colour * lux
};

// World singleton: radiance is multiplied by this before the tone curve.
struct Exposure {
  float scale = 1;
};

// Registers the systems and passes. Needs addScene before.
void addDeferred(App& app);

}  // namespace scree
