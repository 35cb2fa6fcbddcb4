// Drops a block of grains on a plane and waits until it lies, with no GL context.
#include <cmath>
#include <cstdio>

#include "engine/app/app.h"
#include "modules/deferred/deferred.h"
#include "modules/grains/grains.h"
#include "modules/scene/scene.h"

int main() {
  scree::App app(scree::AppOptions{});
  scree::addScene(app);
  scree::addDeferred(app);
  scree::addGrains(app);
  scree::World& world = app.world();
  scree::GrainBlock block;
  block.count = {6, 6, 6};
  block.radius = 0.05f;
  scree::Transform above;
  above.position = {0, 0.6, 0};
  world.spawn(scree::Transform{}, scree::PlaneCollider{});
  world.spawn(above, block);
  for (int tick = 0; tick < 180; ++tick) app.tick();

  int count = 0;
  float lowest = 1e9f, highest = -1e9f;
  world.query<const scree::Grain>().each([&](const scree::Grain& grain) {
    ++count;
    lowest = std::fmin(lowest, grain.position.y - grain.radius);
    highest = std::fmax(highest, grain.position.y);
  });
  const double ground = -scree::grainField(world).origin.y;
  std::printf("%d grains between %g and %g m, state %016llx\n", count, lowest - ground,
              highest - ground, static_cast<unsigned long long>(world.stateHash()));
  const bool lies = count == 216 && lowest - ground > -0.01 && highest - ground < 0.9;
  return lies ? 0 : 1;
}
