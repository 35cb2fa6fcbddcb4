// Encoding of atlases, and the checks of what is read.
#include "modules/impostors/cache.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "engine/core/bytes.h"
#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "modules/lod/lod.h"

namespace scree {
namespace {

constexpr uint64_t kMagic = 0x504d494545524353ull;  // "SCREEIMP"
constexpr uint32_t kVersion = 5;
// Numbers this far from what a grain can have are damage.

bool within(float x, float low, float high) {
  return x >= low && x <= high;
}

struct Fields {
  uint32_t edge, texels;
  uint64_t key;
  vec3 center;
  float outer, inner;
  rules::ImpostorProxy proxy;
};

// Everything after the magic number and the hash.
std::string body(const ImpostorAtlas& a) {
  ByteWriter out;
  out.content.reserve(a.bytes() + (1 << 12));
  out.number(kVersion);
  out.number(static_cast<uint32_t>(a.edge));
  out.number(static_cast<uint32_t>(a.texels));
  out.number(a.key);
  for (float x : {a.center.x, a.center.y, a.center.z, a.outer, a.inner}) out.number(x);
  for (const vec4& v : {a.proxy.center, a.proxy.diagonal, a.proxy.upper})
    for (int c = 0; c < 3; ++c) out.number(v[c]);
  for (const vec4& v : {a.bound.center, a.bound.axis_a, a.bound.axis_b, a.bound.axis_c})
    for (int c = 0; c < 4; ++c) out.number(v[c]);
  out.number(a.errors.directions);
  for (const auto& scheme : a.errors.of)
    for (const ImpostorError& e : scheme)
      for (float x : {e.ssim, e.flip, e.silhouette_px, e.worst_silhouette_px}) out.number(x);
  for (const auto* levels : {&a.errors.outlines.full, &a.errors.outlines.small})
    for (float x : *levels) out.number(x);
  for (float x : {a.errors.outlines.full_near, a.errors.outlines.small_near, a.errors.outlines.point}) out.number(x);
  for (const std::vector<uint8_t>* texture : {&a.shape, &a.color, &a.normal})
    out.content.append(reinterpret_cast<const char*>(texture->data()), texture->size());
  return std::move(out.content);
}

// What is wrong with the numbers; nullptr: nothing.
const char* fault(const ImpostorAtlas& a) {
  for (int c = 0; c < 3; ++c) {
    if (!within(a.center[c], -kImpostorMostUnits, kImpostorMostUnits)) return "its centre is no place";
    if (!within(a.proxy.center[c], -2, 2)) return "its ellipsoid's centre lies outside";
    if (!within(a.proxy.diagonal[c], 0.1f, 1e3f)) return "its ellipsoid has no extent";
    if (!within(a.proxy.upper[c], -1e6f, 1e6f)) return "its ellipsoid is no ellipsoid";
  }
  if (!soundEllipsoid(a.bound)) return "its bounding ellipsoid is no ellipsoid";
  if (!within(a.outer, 1e-30f, kImpostorMostUnits)) return "its outer radius is no length";
  if (!within(a.inner, 0, 1)) return "its inner radius is not between 0 and the outer one";
  if (a.errors.directions > 1024) return "its errors were measured from too many directions";
  for (const auto& scheme : a.errors.of)
    for (const ImpostorError& e : scheme)
      if (!within(e.ssim, -1, 1) || !within(e.flip, 0, 1) || !within(e.silhouette_px, 0, 1e4f) ||
          !within(e.worst_silhouette_px, 0, 1e4f))
        return "an error in its table is out of range";
  for (const auto* levels : {&a.errors.outlines.full, &a.errors.outlines.small})
    for (const float x : *levels)
      if (!within(x, 0, kImpostorOutlineUnknown)) return "a bound of its outlines is out of range";
  if (!within(a.errors.outlines.point, 0, kImpostorOutlineUnknown)) return "a bound of its outlines is out of range";
  for (const float x : {a.errors.outlines.full_near, a.errors.outlines.small_near})
    if (!within(x, 0, kImpostorOutlineUnknown / rules::kImpostorMostNear)) return "a bound of its outlines is out of range";
  return nullptr;
}

}  // namespace

std::string encodeAtlas(const ImpostorAtlas& atlas) {
  ByteWriter out;
  const std::string content = body(atlas);
  out.content.reserve(content.size() + 16);
  out.number(kMagic);
  out.number(hashBytes(content.data(), content.size(), kMagic));
  out.content.append(content);
  return std::move(out.content);
}

Result<ImpostorAtlas> decodeAtlas(std::string_view bytes, std::string_view where) {
  const auto refuse = [&](std::string_view what) {
    return Error{fmt::format("{}: {}", where, what)};
  };
  ByteReader in(bytes);
  if (in.number<uint64_t>() != kMagic) return refuse("is no impostor atlas");
  const auto hash = in.number<uint64_t>();
  const std::string_view content = bytes.substr(in.offset());
  if (const auto version = in.number<uint32_t>(); version != kVersion)
    return refuse(fmt::format("is of version {}, this program reads {}", version, kVersion));
  ImpostorAtlas a;
  const auto edge = in.number<uint32_t>(), texels = in.number<uint32_t>();
  if (edge < static_cast<uint32_t>(rules::kImpostorMinEdge) ||
      edge > static_cast<uint32_t>(kImpostorMaxBakedEdge))
    return refuse(fmt::format("has {} views an edge, allowed are {} to {}", edge,
                              rules::kImpostorMinEdge, kImpostorMaxBakedEdge));
  if (texels < static_cast<uint32_t>(kImpostorMinTexels) ||
      texels > static_cast<uint32_t>(kImpostorMaxTexels) || (texels & (texels - 1)) != 0)
    return refuse(fmt::format("has {} texels a side, allowed are 16, 32, 64, 128, 256", texels));
  if (impostorBytes(static_cast<int>(edge), static_cast<int>(texels)) > kImpostorMaxBytes)
    return refuse(fmt::format("has {} views an edge of {} texels a side, more than {} MiB", edge, texels, kImpostorMaxBytes >> 20));
  a.edge = static_cast<int>(edge);
  a.texels = static_cast<int>(texels);
  a.key = in.number<uint64_t>();
  for (float* x : {&a.center.x, &a.center.y, &a.center.z, &a.outer, &a.inner})
    *x = in.number<float>();
  for (vec4* v : {&a.proxy.center, &a.proxy.diagonal, &a.proxy.upper}) {
    *v = vec4(0);
    for (int c = 0; c < 3; ++c) (*v)[c] = in.number<float>();
  }
  for (vec4* v : {&a.bound.center, &a.bound.axis_a, &a.bound.axis_b, &a.bound.axis_c})
    for (int c = 0; c < 4; ++c) (*v)[c] = in.number<float>();
  a.errors.directions = in.number<uint32_t>();
  for (auto& scheme : a.errors.of)
    for (ImpostorError& e : scheme)
      for (float* x : {&e.ssim, &e.flip, &e.silhouette_px, &e.worst_silhouette_px})
        *x = in.number<float>();
  for (auto* levels : {&a.errors.outlines.full, &a.errors.outlines.small})
    for (float& x : *levels) x = in.number<float>();
  for (float* x : {&a.errors.outlines.full_near, &a.errors.outlines.small_near, &a.errors.outlines.point}) *x = in.number<float>();
  if (in.failed()) return refuse(fmt::format("ends after {} bytes", bytes.size()));
  if (const char* wrong = fault(a)) return refuse(wrong);
  const uint64_t count = a.texelCount();
  const uint64_t rest = bytes.size() - in.offset();
  if (rest != count * 10)
    return refuse(fmt::format("{} bytes of texels, {} views of {} x {} have {}", rest, a.views(),
                              texels, texels, count * 10));
  if (hashBytes(content.data(), content.size(), kMagic) != hash)
    return refuse("is damaged: its hash differs");
  for (const auto& [texture, channels] :
       {std::pair{&a.shape, 2}, std::pair{&a.color, 4}, std::pair{&a.normal, 4}}) {
    const uint64_t size = count * static_cast<uint64_t>(channels);
    const char* from = in.take(size);
    texture->assign(from, from + size);
  }
  return a;
}

Status writeAtlas(const std::filesystem::path& path, const ImpostorAtlas& atlas) {
  return writeFile(path, encodeAtlas(atlas));
}

bool mayReplace(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  uint64_t magic = 0;
  file.read(reinterpret_cast<char*>(&magic), sizeof magic);
  return file.is_open() && (file.gcount() == 0 || (file.gcount() == sizeof magic && magic == kMagic));
}

Result<ImpostorAtlas> readAtlas(const std::filesystem::path& path) {
  Result<std::string> bytes = readText(path);
  if (!bytes.ok()) return Error{bytes.error(), bytes.errorKind()};
  return decodeAtlas(*bytes, path.string());
}

}  // namespace scree
