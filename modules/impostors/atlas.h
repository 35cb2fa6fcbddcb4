// An impostor's atlas: what a grain looks like from the views of shared/impostor.h, as plain bytes.
//
//   texture  format  holds
//   shape    RG8     coverage | height over the centre along the view's axis, as a code
//   color    RGBA8   square root of the linear base colour (shared/gbuffer.h) | metallic
//   normal   RGBA8   mean of the unit normals in the grain's axes, as a code | perceptual roughness
//
// The codes are those of impostorHeightFromCode and impostorNormalFromCode.
//
// 10 bytes a texel: 13.3 a texel of the finest level, in memory and in the cache's file. What programs read
// is packed (shared/coverage.h), and takes 24: impostorBytes().
//
// Each is an array texture of one layer a view and all mip levels down to 1 x 1, stored level after level, in
// a level layer after layer, in a layer row after row from the bottom: a level is one glTextureSubImage3D.
// Views never share a texel in any level.
//
// Only coverage is 0 where nothing was seen. The other values are means over what was seen (not
// multiplied by coverage: filter them as they are, weight the views with coverage), continued
// outwards, so that no filter reads an undefined texel. The spread of the normals under a texel
// (shared/spread.h) is in the length of their mean, 1 - kMostSpread at least.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/core/math.h"
#include "shaders/shared/ellipsoid.h"
#include "shaders/shared/impostor.h"

namespace scree {

// p, a power of two. n, up to which all views fit the layers that every GL has: for ImpostorStore::bindTextures().
inline constexpr int kImpostorMinTexels = 16;
inline constexpr int kImpostorMaxTexels = 256;
inline constexpr int kImpostorMaxBakedEdge = 23;
// Largest outer radius, and distance of the centre from the mesh's origin along each axis, in the mesh's unit.
inline constexpr float kImpostorMostUnits = 1e9f;
// Largest atlas, impostorBytes().
inline constexpr uint64_t kImpostorMaxBytes = uint64_t{3} << 28;

// ---- Measured error -------------------------------------------------------------------------

// How a point of the ray is found (shared/impostor.h); Parallax is Proxy and one impostorStep.
// Nearest: as small grains are drawn, by the nearest view alone; Proxy's points, but for the outline, which is that of the
// view's plane.
// Mesh: the mesh itself, one sample a pixel, for comparison.
enum class ImpostorScheme : uint32_t { Planar, Spherical, Mixed, Proxy, Parallax, Nearest, Mesh };
inline constexpr size_t kImpostorSchemes = 7;
inline constexpr const char* kImpostorSchemeNames[kImpostorSchemes] = {
    "planar", "spherical", "mixed", "proxy", "parallax", "nearest", "mesh"};
// Diameters of the outer sphere at which errors are measured, pixels.
inline constexpr size_t kImpostorSizes = 11;
inline constexpr float kImpostorSizesPx[kImpostorSizes] = {4,  6,  8,  12,  16, 24,
                                                           32, 48, 64, 100, 160};

// Of one scheme at one size, over random directions, lit by one lamp, against the mesh with 64
// samples a pixel on even grey (measure.h).
struct ImpostorError {
  float ssim = 1;                 // mean; 1 = equal
  float flip = 0;                 // mean; 0 = equal
  float silhouette_px = 0;        // area between the silhouettes over the true one's length, mean
  float worst_silhouette_px = 0;  // the same, of the worst of these directions: other ones may be worse
};

// Bounds of how far outlines of Proxy are off, shares of the outer radius: as much as was found by searching for
// the worst view, and a margin (outline.h). Of three views, and of the nearest alone, which small grains show.
inline constexpr size_t kImpostorMostLevels = 9;
inline constexpr float kImpostorOutlineUnknown = 10;
struct ImpostorOutlines {
  // By the mip level of coverage, for an eye at infinity.
  std::array<float, kImpostorMostLevels> full, small;
  // More for a nearer one: of outer radius / distance, up to rules::kImpostorMostNear.
  float full_near = 0, small_near = 0;
  // Of a disc with the mean shadow in the mesh's place, wherever the eye is.
  float point = kImpostorOutlineUnknown;

  ImpostorOutlines() { full.fill(kImpostorOutlineUnknown), small.fill(kImpostorOutlineUnknown); }
};
struct ImpostorErrors {
  uint32_t directions = 0;  // 0: not measured
  std::array<std::array<ImpostorError, kImpostorSizes>, kImpostorSchemes> of{};
  ImpostorOutlines outlines;

  // At a diameter of so many pixels: between the sizes measured by the logarithm, beyond them that
  // of the nearest.
  ImpostorError at(ImpostorScheme scheme, float diameter_px) const;
};

// ---- The atlas ------------------------------------------------------------------------------

struct ImpostorAtlas {
  int edge = 0;      // n
  int texels = 0;    // p
  uint64_t key = 0;  // of the mesh's content and the parameters
  vec3 center{0};    // of the spheres, in the mesh's axes and unit
  float outer = 0;   // R: radius of the smallest sphere around the mesh, in the mesh's unit
  float inner = 0;   // r / R: the largest sphere around the same centre inside the mesh; 0: none
  rules::ImpostorProxy proxy{};
  rules::Ellipsoid bound = rules::unitBall();  // holds the mesh; what an impostor shows outside of it is cut off
  ImpostorErrors errors;
  std::vector<uint8_t> shape, color, normal;

  int views() const { return rules::impostorViewCount(edge); }
  int levels() const;
  int side(int level) const { return texels >> level; }
  // Texels before a level, and before a layer in it; times the texture's channels: bytes.
  uint64_t levelOffset(int level) const;
  uint64_t offset(int level, int layer) const;
  uint64_t texelCount() const { return levelOffset(levels()); }
  uint64_t bytes() const { return shape.size() + color.size() + normal.size(); }
};

// Largest diameter in pixels at which a mip level of coverage is read.
float impostorLevelMostPx(int texels, int level);
// What drawing an atlas with n and p takes on the GPU.
uint64_t impostorBytes(int edge, int texels);

// ---- Reading an atlas on the CPU ------------------------------------------------------------

// What a texture unit returns: bilinear with clamped edges in one level. Stored codes in [0, 1].
vec2 sampleShape(const ImpostorAtlas& atlas, int level, int layer, vec2 uv);
vec4 sampleColor(const ImpostorAtlas& atlas, int level, int layer, vec2 uv);
vec4 sampleNormal(const ImpostorAtlas& atlas, int level, int layer, vec2 uv);

}  // namespace scree
