// Registration of the scene's systems.
#include "modules/scene/scene.h"

#include <algorithm>
#include <cstring>

#include "engine/app/app.h"
#include "modules/scene/view.h"

namespace scree {
namespace {

static_assert(sizeof(Transform) == sizeof(PreviousTransform) &&
              offsetof(Transform, scale) == offsetof(PreviousTransform, scale));

// Tables in which nothing moved are left untouched, so that nobody uploads or hashes them again.
void keepPrevious(const Query<const Transform, PreviousTransform>& placed) {
  for (Table* table : placed.tables()) {
    const std::span<const Transform> current = table->read<Transform>();
    if (current.empty() || std::memcmp(current.data(), table->read<PreviousTransform>().data(),
                                       current.size_bytes()) == 0)
      continue;
    std::memcpy(static_cast<void*>(table->write<PreviousTransform>().data()), current.data(),
                current.size_bytes());
  }
}

}  // namespace

Name makeName(std::string_view text) {
  Name name;
  std::memcpy(name.text, text.data(), std::min(text.size(), sizeof(name.text) - 1));
  return name;
}

void addScene(App& app) {
  const auto placed = app.world().query<const Transform, PreviousTransform>();
  app.addSystem({.name = "scene.keep_previous",
                 .phase = Phase::Simulate,
                 .reads = reads<Transform>(),
                 .writes = writes<PreviousTransform>(),
                 .exclusive = false,
                 .needs = [placed] { return !placed.empty(); },
                 .run = [placed](World&) { keepPrevious(placed); }});
  app.addSystem({.name = "scene.view", .phase = Phase::Prepare, .run = prepareView});
}

Status loadScene(App& app, const std::filesystem::path& path, std::vector<Entity>* spawned) {
  return loadScene(app.world(), path, spawned);
}

}  // namespace scree
