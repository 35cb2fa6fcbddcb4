// Registration: the systems and passes of the module, in the order of the tick and the frame.
#include "modules/grains/grains.h"

#include "engine/app/app.h"
#include "engine/gpu/gl.h"
#include "modules/grains/state.h"

namespace scree {
namespace grains {

GrainsState::GrainsState(World& world_in)
    : world(world_in),
      blocks(world_in.query<const GrainBlock>()),
      grains(world_in.query<Grain, GrainVelocity, GrainSpin, GrainOrientation, GrainPrevious,
                            GrainRest, const GrainMaterial>()),
      members(world_in.query<const GrainClump>()),
      planes(world_in.query<const Transform, const PlaneCollider>()),
      boxes(world_in.query<const Transform, const BoxCollider>()),
      capsules(world_in.query<const Transform, const CapsuleCollider>()),
      spheres(world_in.query<const Transform, const SphereCollider>()),
      hulls(world_in.query<const Transform, const HullCollider>()),
      meshes(world_in.query<const Transform, const MeshCollider>()),
      fields(world_in.query<const Transform, const SdfCollider>()),
      regions(world_in.query<const Transform, RegionSensor>()),
      loads(world_in.query<LoadSensor>()),
      seen(world_in.query<const Grain, const GrainVelocity, const GrainMaterial>()),
      emitters(world_in.query<const Transform, const GrainEmitter>()),
      sinks(world_in.query<const Transform, const GrainSink>()),
      force_query(world_in.query<const Transform, const GrainForce>()),
      blow_query(world_in.query<const Transform, const GrainBlow>()),
      grids(world_in.query<const Transform, const GrainGrid>()),
      bodies(world_in.query<const Transform, const RigidBody>()) {
  draw.drawn = world_in.query<const Grain, const GrainPrevious, const GrainOrientation,
                              const GrainSpin, const GrainLook>();
}

}  // namespace grains

void addGrains(App& app) {
  const auto state = std::make_shared<grains::GrainsState>(app.world());
  app.world().singleton<GrainStats>();
  grains::addToSaves(state);
  app.world().singleton<GrainStrikes>();
  app.world().singleton<GrainGrids>();
  app.addTarget(grains::kVisibleTarget, {.format = GL_R32UI});

  app.addSystem(grains::spawnSystem(state));
  app.addSystem(grains::emitSystem(state));
  app.addSystem(grains::pushSystem(state));
  app.addSystem(grains::stepSystem(state));
  app.addSystem(grains::sinkSystem(state));
  app.addSystem(grains::splatSystem(state));
  app.addSystem(grains::uploadSystem(state));

  app.addPass(grains::visiblePass(state));
  app.addPass(grains::drawPass(state));
  app.addPass(grains::shadowPass(state));
}

}  // namespace scree
