// Moves a hundred thousand entities with an outside program's own component types.
#include <cstdio>

#include "engine/ecs/schedule.h"
#include "engine/ecs/world.h"

struct Place {
  float x = 0, y = 0;
};
SCREE_COMPONENT(Place, (x, "m"), (y, "m"));

struct Pace {
  float x = 1, y = 0.5f;
};
SCREE_COMPONENT(Pace, (x, "m/s"), (y, "m/s"));

int main() {
  constexpr size_t kCount = 100000;
  constexpr int kTicks = 60;
  scree::World world;
  scree::Schedule schedule;
  schedule.add({.name = "outside.move",
                .phase = scree::Phase::Simulate,
                .reads = scree::reads<Pace>(),
                .writes = scree::writes<Place>(),
                .exclusive = false,
                .run = [](scree::World& w) {
                  w.query<Place, const Pace>().each([](Place& place, const Pace& pace) {
                    place.x += pace.x;
                    place.y += pace.y;
                  });
                }});
  const scree::Entity first = world.spawn(Place{}, Pace{2, 3});
  world.spawnMany<Place, Pace>(kCount - 1);
  for (int tick = 0; tick < kTicks; ++tick) schedule.run(scree::Phase::Simulate, world);
  const Place* place = world.peek<Place>(first);
  const bool right = place && place->x == 2 * kTicks && place->y == 3 * kTicks &&
                     world.query<const Place>().count() == kCount;
  std::printf("%zu entities, the first at (%g, %g), state %016llx\n", world.entityCount(), place->x,
              place->y, static_cast<unsigned long long>(world.stateHash()));
  return right ? 0 : 1;
}
