// The whole game as an App: modules, rules and overlay in the one order that they need.
#pragma once

#include <filesystem>
#include <memory>

#include "engine/app/app.h"
#include "engine/core/result.h"

namespace scree::hourglass {

// An App with the level loaded, ready to run() or to tick(); no context is made. Errors are the
// level's.
Result<std::unique_ptr<App>> openGame(AppOptions options, const std::filesystem::path& level);

}  // namespace scree::hourglass
