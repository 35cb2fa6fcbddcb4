// An atlas in a file: a checked header, then the three textures.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/core/result.h"
#include "modules/impostors/atlas.h"

namespace scree {

// The file appears whole or not at all.
Status writeAtlas(const std::filesystem::path& path, const ImpostorAtlas& atlas);
// Refuses, in one line, what is not a whole and sound file of this version.
Result<ImpostorAtlas> readAtlas(const std::filesystem::path& path);

// Whether a file may be replaced by an atlas: it is empty, or begins as one. What else is there belongs to somebody.
bool mayReplace(const std::filesystem::path& path);

// The same to and from memory; `where` begins every error.
std::string encodeAtlas(const ImpostorAtlas& atlas);
Result<ImpostorAtlas> decodeAtlas(std::string_view bytes, std::string_view where);

}  // namespace scree
