// What the checks of a glTF document share. Private to assets.
#pragma once

#include <functional>
#include <string>

#include "engine/assets/gltf_document.h"
#include "engine/assets/gltf_fields.h"

namespace scree::gltf {

// Part of the check of one document; the first fault stays in `fault_`.
class CheckBase {
 public:
  CheckBase(const Document& document, const GltfLimits& limits, std::string& fault)
      : json_(document.json), limits_(limits), file_(document.path.string()), fault_(fault) {}

 protected:
  // An array of the document, empty if it is missing.
  const nlohmann::json& section(const char* name) const {
    static const nlohmann::json empty = nlohmann::json::array();
    const auto found = json_.find(name);
    return found == json_.end() ? empty : *found;
  }
  size_t count(const char* name) const { return section(name).size(); }

  // Calls check(fields) for every entry until one is at fault; `kind` names the entries in
  // messages.
  bool each(const nlohmann::json& entries, const char* kind,
            const std::function<bool(Fields&)>& check) {
    for (size_t i = 0; i < entries.size(); ++i) {
      Fields fields(entries[i], file_ + ": " + objectName(kind, i, entries[i]), fault_);
      if (!fields.isObject() || !fields.text("name", Presence::Optional) || !check(fields))
        return false;
    }
    return true;
  }
  bool each(const char* name, const char* kind, const std::function<bool(Fields&)>& check) {
    return each(section(name), kind, check);
  }

  const nlohmann::json& json_;
  const GltfLimits& limits_;
  std::string file_;
  std::string& fault_;
};

// Buffers, buffer views and accessors: after it every range lies inside its buffer.
bool checkStorage(const Document& document, const GltfLimits& limits, std::string& fault);

}  // namespace scree::gltf
