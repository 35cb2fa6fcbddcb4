// The order of modules: what moves colliders comes before the grains, what weighs them after.
#include "game/rules/game.h"

#include "engine/core/file.h"
#include "engine/core/hash.h"
#include "game/rules/rules.h"
#include "modules/deferred/deferred.h"
#include "modules/grains/grains.h"
#include "modules/overlay/overlay.h"
#include "modules/scene/scene.h"

namespace scree::hourglass {

Result<std::unique_ptr<App>> openGame(AppOptions options, const std::filesystem::path& level) {
  options.title = "Hourglass";
  options.level_file = level;
  options.level = level.filename().string();
  // A file that cannot be read has its line when it is loaded.
  if (Result<std::vector<uint8_t>> file = readBytes(level); file.ok())
    options.level_content = hashBytes(file->data(), file->size());
  options.radiance_targets = {std::string(kTruth), std::string(kRadiance)};
  auto app = std::make_unique<App>(std::move(options));
  declareActions(*app);
  addScene(*app);
  if (Status status = addRules(*app, level); !status.ok()) return status.takeError();
  addDeferred(*app);
  addGrains(*app);
  addJudge(*app);
  addOverlay(*app);
  app->addGauge("grains", [q = app->world().query<const Grain>()] {
    return static_cast<double>(q.count());
  });
  return app;
}

}  // namespace scree::hourglass
