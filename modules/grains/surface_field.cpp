// Distance queries of hulls and meshes.
#include "modules/grains/surface_field.h"

#include <fmt/format.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "modules/grains/grid_field.h"
#include "modules/grains/hull.h"
#include "modules/grains/triangle_surface.h"

namespace scree::grains {
namespace {

constexpr float kSameDirection = 0.9998f;  // cosine of one degree
constexpr double kEverywhere = std::numeric_limits<double>::infinity();

// Beyond this no collider reaches; keeps squares finite.
vec3 within(vec3 p) {
  constexpr float kFarthest = 1e12f;
  return glm::clamp(p, vec3(-kFarthest), vec3(kFarthest));
}

class SurfaceField : public DistanceField {
 public:
  enum class Side { Hull, Solid, Sheet };

  SurfaceField(TriangleSurface surface, Side side, float thickness)
      : surface_(std::move(surface)), side_(side), half_(0.5f * thickness) {}

  SurfacePoint nearest(vec3 p) const override {
    p = within(p);
    return pointOf(p, surface_.nearest(p, kEverywhere));
  }

  float distance(vec3 p, float most) const override {
    p = within(p);
    const double asked = std::max(static_cast<double>(most) + half_, 0.0);
    // Inside, all that counts is the true distance.
    const TriangleSurface::Nearest found = surface_.nearest(p, side_ == Side::Sheet ? asked : kEverywhere);
    return found.square < kEverywhere ? pointOf(p, found).distance : most;
  }

  uint32_t touches(vec3 p, float reach, std::span<SurfacePoint> out) const override {
    p = within(p);
    uint32_t n = 0;
    if (side_ != Side::Sheet) {
      // A hull has no second point; from inside, only the nearest way out counts.
      out[n++] = nearest(p);
      if (side_ == Side::Hull || out[0].distance + half_ <= 0) return n;
    }
    TriangleSurface::Nearest found[kMostTouches];
    const uint32_t count = surface_.touches(p, static_cast<double>(reach) + half_, side_ == Side::Solid,
                                            std::span(found, std::min<size_t>(out.size(), kMostTouches)));
    for (uint32_t k = 0; k < count && n < out.size(); ++k) {
      const SurfacePoint touch = pointOf(p, found[k]);
      if (n == 0 || k > 0 || glm::dot(touch.normal, out[0].normal) < kSameDirection) out[n++] = touch;
    }
    return n;
  }
  uint32_t mostTouches() const override { return side_ == Side::Hull ? 1 : kMostTouches; }

  std::array<vec3, 2> bounds() const override { return {surface_.low() - half_, surface_.high() + half_}; }
  std::span<const vec3> corners() const override {
    return side_ != Side::Sheet ? surface_.corners() : std::span<const vec3>();
  }
  size_t memoryBytes() const override { return sizeof *this + surface_.memoryBytes(); }

 private:
  SurfacePoint pointOf(vec3 p, const TriangleSurface::Nearest& near) const {
    const dvec3 d = dvec3(p) - near.point;
    const double length = std::sqrt(near.square);
    const bool behind = glm::dot(d, near.outward) < 0;
    const double sign = behind && side_ != Side::Sheet ? -1 : 1;
    const dvec3 normal = length > 1e-30 ? d * (sign / length) : near.outward;
    const double distance = sign * length - half_;
    const double flat = std::min(static_cast<double>(near.flat), std::abs(sign * length));
    return {vec3(normal), static_cast<float>(distance), static_cast<float>(flat)};
  }

  TriangleSurface surface_;
  Side side_;
  float half_;  // of the thickness, m
};

constexpr const char* kOpen = "it is not closed: some edge has not exactly two triangles, one on each side";

}  // namespace

Result<SharedField> makeHull(std::span<const vec3> points) {
  std::vector<vec3> corners;
  if (std::string fault = convexHull(points, corners); !fault.empty()) return Error{std::move(fault)};
  TriangleSurface surface;
  if (std::string fault = surface.build(corners); !fault.empty()) return Error{std::move(fault)};
  return SharedField(std::make_shared<SurfaceField>(std::move(surface), SurfaceField::Side::Hull, 0.0f));
}

Result<SharedField> makeMesh(std::span<const vec3> corners, bool solid, float thickness) {
  TriangleSurface surface;
  if (std::string fault = surface.build(corners); !fault.empty()) return Error{std::move(fault)};
  if (std::string fault = surface.crowded(); !fault.empty()) return Error{std::move(fault)};
  if (solid && !surface.closed()) return Error{kOpen};
  return SharedField(std::make_shared<SurfaceField>(
      std::move(surface), solid ? SurfaceField::Side::Solid : SurfaceField::Side::Sheet, thickness));
}

Result<SharedField> bakeMesh(std::span<const vec3> corners, int resolution) {
  TriangleSurface surface;
  if (std::string fault = surface.build(corners); !fault.empty()) return Error{std::move(fault)};
  if (std::string fault = surface.crowded(); !fault.empty()) return Error{std::move(fault)};
  if (!surface.closed()) return Error{kOpen};
  const vec3 size = surface.high() - surface.low();
  const float longest = std::max({size.x, size.y, size.z});
  const float cell = longest / static_cast<float>(resolution);
  const vec3 low = surface.low() - 2 * cell, high = surface.high() + 2 * cell;
  const SurfaceField field(std::move(surface), SurfaceField::Side::Solid, 0);
  return GridField::sample([&](vec3 p) { return field.nearest(p).distance; }, low, high, cell,
                           GridField::Calls::Parallel);
}

}  // namespace scree::grains
