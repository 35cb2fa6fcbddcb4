// Bullet as the baseline of the grains bench: the same spheres in the same box.
#pragma once

#include <memory>
#include <vector>

#include "tests/bench/drop.h"

namespace scree::bench {

struct BulletSettings {
  int substeps = 1;     // a tick
  int iterations = 10;  // Bullet's own default
  // False: Bullet's margins, which are meant for bodies of a metre. True: in proportion to the
  // grains; far fewer pairs are then kept that do not touch.
  bool small_margins = false;
};

class BulletDrop {
 public:
  BulletDrop(const Drop& drop, const BulletSettings& settings);
  ~BulletDrop();
  void step();
  std::vector<vec3> positions() const;
  std::vector<vec3> velocities() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace scree::bench
