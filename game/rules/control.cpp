// Actions and the level's life: declare the controls, load, pause, restart, quit.
#include <vector>

#include "engine/core/log.h"
#include "game/rules/creature.h"
#include "game/rules/rules.h"
#include "modules/overlay/overlay.h"
#include "modules/scene/scene.h"

namespace scree::hourglass {
namespace {

// World singleton: what a restart loads again.
struct Level {
  std::filesystem::path path;
};

// Spawns the level's entities and what the rules add to them.
Status loadLevel(World& world, const std::filesystem::path& path) {
  world.singleton<ActiveCamera>().entity = Entity::kNone;
  if (Status status = loadScene(world, path); !status.ok()) return status;
  world.singleton<Match>() = {};
  std::vector<Entity> scales;
  world.query<With<Scale>>().each([&](Entity entity) { scales.push_back(entity); });
  for (const Entity scale : scales) world.add(scale, ScaleReading{});
  std::vector<Entity> needles;
  world.query<With<Needle>>().each([&](Entity entity) { needles.push_back(entity); });
  for (const Entity needle : needles)
    world.add(needle, NeedleZero{world.peek<Transform>(needle)->rotation});
  equipCreatures(world);
  equipCamera(world);
  return Done{};
}

void control(App& app) {
  World& world = app.world();
  const ActionState& actions = world.singleton<const ActionState>();
  const Controls& controls = world.singleton<const Controls>();
  if (actions.pressed(controls.quit)) world.singleton<QuitRequest>().requested = true;
  if (actions.pressed(controls.inspect)) {
    Inspector& inspector = world.singleton<Inspector>();
    inspector.open = !inspector.open;
  }
  Simulation& simulation = world.singleton<Simulation>();
  if (actions.pressed(controls.pause)) simulation.paused = !simulation.paused;
  if (actions.pressed(controls.restart)) {
    simulation.paused = false;
    app.waitForPasses();
    world.clear();
    // The file was good when the run began; if it no longer is, the run ends rather than going on
    // in an empty world.
    if (Status status = loadLevel(world, world.singleton<Level>().path); !status.ok())
      world.singleton<QuitRequest>() = {true, status.error()};
  }
}

}  // namespace

void declareActions(App& app) {
  using S = Source;
  const auto axis = [&](const char* name, std::vector<Binding> bindings) {
    return app.actions().add({name, ActionKind::Axis, std::move(bindings)});
  };
  const auto button = [&](const char* name, std::vector<Binding> bindings) {
    return app.actions().add({name, ActionKind::Button, std::move(bindings)});
  };
  Controls& controls = app.world().singleton<Controls>();
  controls.move_x = axis("move_x", {{S::KeyD}, {S::KeyA, -1}, {S::KeyRight}, {S::KeyLeft, -1},
                                    {S::PadLeftX}});
  controls.move_y = axis("move_y", {{S::KeyW}, {S::KeyS, -1}, {S::KeyUp}, {S::KeyDown, -1},
                                    {S::PadLeftY, -1}});
  controls.look_x = axis("look_x", {{S::KeyE}, {S::KeyQ, -1}, {S::PadRightX}});
  controls.pause = button("pause", {{S::KeyP}, {S::KeySpace}, {S::PadStart}});
  controls.restart = button("restart", {{S::KeyR}, {S::PadBack}});
  controls.quit = button("quit", {{S::KeyEscape}});
  controls.inspect = button("inspect", {{S::KeyF1}});
}

Status addRules(App& app, const std::filesystem::path& level) {
  World& world = app.world();
  world.singleton<Level>().path = level;
  if (Status status = loadLevel(world, level); !status.ok()) return status;
  app.addSystem({.name = "hourglass.control", .phase = Phase::Input, .run = [&app](World&) { control(app); }});
  addCreature(app);
  return Done{};
}

}  // namespace scree::hourglass
