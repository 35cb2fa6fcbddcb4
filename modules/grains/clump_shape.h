// What a clump's spheres make up: centre of mass, the share of their volumes that is not counted twice.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "modules/grains/clump.h"

namespace scree::grains {

struct Sphere {
  vec3 centre{0};
  float radius = 0;
};

// Volume of the union / sum of the volumes: by formula for two, else by chords on a lattice of lines.
double unionShare(std::span<const Sphere> spheres);

// Spheres around their centre of mass, and how they fill a solid of density 1.
struct ClumpForm {
  uint32_t count = 0;
  std::array<vec3, kMostMembers> arm{};
  std::array<float, kMostMembers> radius{};
  float density_share = 1;  // member's density / solid's
  float bound = 0;          // radius of the sphere around the centre of mass that holds all
};
ClumpForm formOf(std::span<const Sphere> spheres);
// Of a shape that fault() finds nothing wrong with: itself, or the one that it names.
const ClumpShape& membersOf(const ClumpShape& shape);
// In units of a block's radius; of a shape that fault() finds nothing wrong with.
ClumpForm formOf(const ClumpShape& shape);

// The forms of shapes, each made once: one of three spheres or more takes 0.3 ms.
class ClumpForms {
 public:
  // As formOf(shape); valid until the next call.
  const ClumpForm& of(const ClumpShape& shape);
  uint64_t made() const { return made_; }

 private:
  // A shape that changes all the time must not fill the memory.
  static constexpr size_t kMost = 64;
  struct Made {
    ClumpShape shape;  // as of membersOf()
    ClumpForm form;
  };
  std::vector<Made> form_;
  uint64_t made_ = 0;  // so far
};

}  // namespace scree::grains
