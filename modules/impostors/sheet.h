// A contact sheet of an atlas: all views, lit, in one picture.
#pragma once

#include <filesystem>

#include "engine/assets/image_pixels.h"
#include "modules/impostors/atlas.h"

namespace scree {

// Views in rows from the top left, in the order of their layers, at most 4,096 pixels a side: at
// the mip level that fits.
images::Image contactSheet(const ImpostorAtlas& atlas);
Status writeContactSheet(const std::filesystem::path& path, const ImpostorAtlas& atlas);

}  // namespace scree
