// The union of a few spheres, and the shapes that have names.
#include "modules/grains/clump_shape.h"

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "modules/grains/ranges.h"
#include "modules/grains/solver.h"

namespace scree {
namespace grains {
namespace {

double cube(double x) { return x * x * x; }

// What two spheres share, divided by pi: two caps.
double lens(double a, double b, double d) {
  if (d >= a + b) return 0;
  if (d <= std::abs(a - b)) return 4.0 / 3 * cube(std::min(a, b));
  const double depth = a + b - d;
  return depth * depth * (d * d + 2 * d * (a + b) - 3 * (a - b) * (a - b)) / (12 * d);
}

double shareOfTwo(const Sphere& a, const Sphere& b) {
  const double ra = a.radius, rb = b.radius, sum = 4.0 / 3 * (cube(ra) + cube(rb));
  return (sum - lens(ra, rb, glm::length(dvec3(a.centre) - dvec3(b.centre)))) / sum;
}

// Both volumes come from the same chords, whose errors then mostly cancel.
double shareByChords(std::span<const Sphere> spheres) {
  constexpr int kLines = 160;  // along y and z
  double low[3], high[3];
  for (int axis = 1; axis < 3; ++axis) {
    low[axis] = 1e300;
    high[axis] = -1e300;
    for (const Sphere& s : spheres) {
      low[axis] = std::min(low[axis], static_cast<double>(s.centre[axis]) - static_cast<double>(s.radius));
      high[axis] = std::max(high[axis], static_cast<double>(s.centre[axis]) + static_cast<double>(s.radius));
    }
  }
  double together = 0, sum = 0;
  std::array<std::pair<double, double>, kMostMembers> chord;
  for (int j = 0; j < kLines; ++j)
    for (int k = 0; k < kLines; ++k) {
      const double y = low[1] + (high[1] - low[1]) * (j + 0.5) / kLines;
      const double z = low[2] + (high[2] - low[2]) * (k + 0.5) / kLines;
      size_t n = 0;  // chords, by their begin
      for (const Sphere& s : spheres) {
        const double dy = y - static_cast<double>(s.centre.y), dz = z - static_cast<double>(s.centre.z);
        const double square = static_cast<double>(s.radius) * static_cast<double>(s.radius) - dy * dy - dz * dz;
        if (!(square > 0)) continue;
        const double half = std::sqrt(square), x = s.centre.x;
        size_t at = n++;
        for (; at > 0 && chord[at - 1].first > x - half; --at) chord[at] = chord[at - 1];
        chord[at] = {x - half, x + half};
        sum += 2 * half;
      }
      double end = -1e300;
      for (size_t c = 0; c < n; ++c) {
        together += std::max(0.0, chord[c].second - std::max(chord[c].first, end));
        end = std::max(end, chord[c].second);
      }
    }
  return sum > 0 ? together / sum : 1.0;
}

struct NamedShape {
  std::string_view name;
  ClumpShape shape;
};
const std::array<NamedShape, 5>& namedShapes() {
  static const std::array<NamedShape, 5> all{{
      {"bean", {}},
      {"bolt", {"", 4, {vec3(0), vec3(0.95f, 0, 0), vec3(1.6f, 0, 0), vec3(2.25f, 0, 0)}, {1, 0.5f, 0.5f, 0.5f}}},
      {"rod", {"", 4, {vec3(-1.5f, 0, 0), vec3(-0.5f, 0, 0), vec3(0.5f, 0, 0), vec3(1.5f, 0, 0)}, {1, 1, 1, 1}}},
      {"triangle", {"", 3, {vec3(1, 0, 0), vec3(-0.5f, 0, 0.8660254f), vec3(-0.5f, 0, -0.8660254f), vec3(0)},
                    {1, 1, 1, 1}}},
      {"tetrapod", {"", 4, {vec3(0.6f, 0.6f, 0.6f), vec3(0.6f, -0.6f, -0.6f), vec3(-0.6f, 0.6f, -0.6f),
                            vec3(-0.6f, -0.6f, 0.6f)}, {0.7f, 0.7f, 0.7f, 0.7f}}},
  }};
  return all;
}

std::string_view nameIn(const ClumpShape& shape) {
  return {shape.name, strnlen(shape.name, sizeof shape.name)};
}

// Null: no shape has that name.
const ClumpShape* found(const ClumpShape& shape) {
  if (nameIn(shape).empty()) return &shape;
  for (const NamedShape& named : namedShapes())
    if (named.name == nameIn(shape)) return &named.shape;
  return nullptr;
}

}  // namespace

double unionShare(std::span<const Sphere> spheres) {
  return spheres.size() == 2 ? shareOfTwo(spheres[0], spheres[1]) : shareByChords(spheres);
}

ClumpForm formOf(std::span<const Sphere> spheres) {
  ClumpForm form;
  form.count = static_cast<uint32_t>(spheres.size());
  double sum = 0;
  dvec3 centre(0);
  for (const Sphere& s : spheres) {
    sum += cube(s.radius);
    centre += cube(s.radius) * dvec3(s.centre);
  }
  centre /= sum;
  for (size_t k = 0; k < spheres.size(); ++k) {
    form.arm[k] = vec3(dvec3(spheres[k].centre) - centre);
    form.radius[k] = spheres[k].radius;
    form.bound = std::max(form.bound, glm::length(form.arm[k]) + form.radius[k]);
  }
  form.density_share = static_cast<float>(unionShare(spheres));
  return form;
}

const ClumpShape& membersOf(const ClumpShape& shape) { return *found(shape); }

ClumpForm formOf(const ClumpShape& shape) {
  const ClumpShape& own = membersOf(shape);
  std::array<Sphere, kMostMembers> spheres;
  const auto n = static_cast<size_t>(own.count);
  for (size_t k = 0; k < n; ++k) spheres[k] = {own.offset[k], own.radius[k]};
  return formOf(std::span<const Sphere>(spheres).first(n));
}

const ClumpForm& ClumpForms::of(const ClumpShape& shape) {
  const ClumpShape& own = membersOf(shape);
  const auto n = static_cast<size_t>(own.count);
  for (const Made& made : form_) {
    // To the bit, so that a form does not depend on who asked before.
    if (made.shape.count == own.count &&
        std::memcmp(made.shape.offset.data(), own.offset.data(), n * sizeof(vec3)) == 0 &&
        std::memcmp(made.shape.radius.data(), own.radius.data(), n * sizeof(float)) == 0)
      return made.form;
  }
  if (form_.size() < kMost) form_.emplace_back();
  Made& made = form_[made_++ % kMost];  // the oldest, if there are as many
  made = {own, formOf(own)};
  return made.form;
}

}  // namespace grains

std::string fault(const GrainClump&) { return "is made by the simulation itself; use a ClumpShape"; }

std::string fault(const ClumpShape& shape) {
  using namespace grains;
  if (found(shape) == nullptr) {
    std::string names;
    for (const NamedShape& named : namedShapes()) names += fmt::format("\"{}\", ", named.name);
    return fmt::format("name = \"{}\"; allowed is {}or none", nameIn(shape), names);
  }
  std::string wrong = firstFault({{"count", static_cast<double>(shape.count), 2, kMostMembers}});
  for (size_t k = 0; k < kMostMembers && wrong.empty(); ++k) {
    if (static_cast<int32_t>(k) >= shape.count) break;
    const std::string offset = fmt::format("offset[{}]", k), radius = fmt::format("radius[{}]", k);
    wrong = firstFault({{offset + ".x", shape.offset[k].x, -10, 10},
                        {offset + ".y", shape.offset[k].y, -10, 10},
                        {offset + ".z", shape.offset[k].z, -10, 10},
                        {radius, shape.radius[k], 0.01, 10}});
  }
  return wrong;
}

}  // namespace scree
