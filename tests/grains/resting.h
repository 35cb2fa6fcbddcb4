// Grains in plain arrays that fall asleep.
#pragma once

#include "tests/grains/field.h"

namespace scree::grains::test {

struct RestingField : Field {
  std::vector<GrainRest> rest;

  GrainRows rows() {
    rest.resize(grain.size());
    GrainRows all = Field::rows();
    all.rest = rest;
    return all;
  }
  void step(int ticks = 1, RowsAre known = RowsAre::Unknown) {
    for (int k = 0; k < ticks; ++k) {
      const GrainRows all = rows();
      solver.step(std::span(&all, 1), colliders, parameters, known);
    }
  }
  size_t asleep() const {
    size_t n = 0;
    for (const GrainRest& r : rest) n += r.asleep;
    return n;
  }
  void remove(size_t k) {
    const auto at = static_cast<long>(k);
    const auto erase = [&](auto& list) { list.erase(list.begin() + at); };
    erase(entity);
    erase(grain);
    erase(velocity);
    erase(spin);
    erase(orientation);
    erase(previous);
    erase(material);
    erase(rest);
  }
};

}  // namespace scree::grains::test
