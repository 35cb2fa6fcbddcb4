// Type and range checks of single JSON fields.
#include "engine/assets/gltf_fields.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "engine/assets/gltf_document.h"

namespace scree::gltf {
using nlohmann::json;

bool Fields::refuse(std::string_view name, std::string_view allowed) {
  if (!sound()) return false;
  if (const json* value = find(name))
    fault_ = fmt::format("{}: {} = {}: {}", where_, name, valueText(*value), allowed);
  else
    fault_ = fmt::format("{}: {}: missing; {}", where_, name, allowed);
  return false;
}

const json* Fields::find(std::string_view name) const {
  if (!object_.is_object()) return nullptr;
  const auto found = object_.find(name);
  return found == object_.end() ? nullptr : &*found;
}

bool Fields::isObject() {
  if (object_.is_object()) return sound();
  if (sound()) fault_ = fmt::format("{}: {}: must be an object", where_, valueText(object_));
  return false;
}

bool Fields::present(std::string_view name, Presence presence, const json*& value) {
  value = sound() ? find(name) : nullptr;
  if (value == nullptr && sound() && presence == Presence::Required) refuse(name, "required");
  return value != nullptr;
}

bool Fields::whole(std::string_view name, uint64_t least, uint64_t most, Presence presence,
                   uint64_t* out) {
  const json* value = nullptr;
  if (!present(name, presence, value)) return sound();
  if (!value->is_number_unsigned() || value->get<uint64_t>() < least ||
      value->get<uint64_t>() > most)
    return refuse(name, fmt::format("must be a whole number from {} to {}", least, most));
  if (out != nullptr) *out = value->get<uint64_t>();
  return true;
}

bool Fields::index(std::string_view name, std::string_view target, size_t count, Presence presence,
                   uint64_t* out) {
  const json* value = nullptr;
  if (!present(name, presence, value)) return sound();
  if (!value->is_number_unsigned() || value->get<uint64_t>() >= count)
    return refuse(name, fmt::format("must be an index into {}, which has {}", target, count));
  if (out != nullptr) *out = value->get<uint64_t>();
  return true;
}

bool Fields::number(std::string_view name, double least, double most, Presence presence,
                    double* out) {
  const json* value = nullptr;
  if (!present(name, presence, value)) return sound();
  if (!value->is_number() || !(value->get<double>() >= least && value->get<double>() <= most))
    return refuse(name, fmt::format("must be a number from {} to {}", least, most));
  if (out != nullptr) *out = value->get<double>();
  return true;
}

bool Fields::numbers(std::string_view name, size_t count, double least, double most, double* out) {
  const json* value = nullptr;
  if (!present(name, Presence::Optional, value)) return sound();
  const auto good = [&](const json& entry) {
    return entry.is_number() && entry.get<double>() >= least && entry.get<double>() <= most;
  };
  if (!value->is_array() || value->size() != count ||
      !std::all_of(value->begin(), value->end(), good))
    return refuse(name, fmt::format("must be {} numbers from {} to {}", count, least, most));
  if (out != nullptr)
    for (size_t i = 0; i < count; ++i) out[i] = (*value)[i].get<double>();
  return true;
}

bool Fields::indices(std::string_view name, std::string_view target, size_t count) {
  const json* value = nullptr;
  if (!present(name, Presence::Optional, value)) return sound();
  const std::string allowed = fmt::format("must be indices into {}, which has {}", target, count);
  if (!value->is_array()) return refuse(name, allowed);
  for (size_t i = 0; i < value->size(); ++i) {
    const json& entry = (*value)[i];
    if (entry.is_number_unsigned() && entry.get<uint64_t>() < count) continue;
    fault_ = fmt::format("{}: {}[{}] = {}: {}", where_, name, i, valueText(entry), allowed);
    return false;
  }
  return true;
}

bool Fields::text(std::string_view name, Presence presence, std::string* out) {
  const json* value = nullptr;
  if (!present(name, presence, value)) return sound();
  if (!value->is_string()) return refuse(name, "must be a text");
  if (out != nullptr) *out = value->get<std::string>();
  return true;
}

bool Fields::boolean(std::string_view name) {
  const json* value = nullptr;
  if (!present(name, Presence::Optional, value)) return sound();
  return value->is_boolean() || refuse(name, "must be true or false");
}

bool Fields::oneOf(std::string_view name, std::initializer_list<uint64_t> allowed,
                   Presence presence) {
  const json* value = nullptr;
  if (!present(name, presence, value)) return sound();
  if (value->is_number_unsigned() &&
      std::find(allowed.begin(), allowed.end(), value->get<uint64_t>()) != allowed.end())
    return true;
  return refuse(name, fmt::format("must be one of {}", fmt::join(allowed, ", ")));
}

bool Fields::oneOf(std::string_view name, std::initializer_list<std::string_view> allowed,
                   Presence presence) {
  const json* value = nullptr;
  if (!present(name, presence, value)) return sound();
  if (value->is_string() && std::find(allowed.begin(), allowed.end(),
                                      value->get_ref<const std::string&>()) != allowed.end())
    return true;
  return refuse(name, fmt::format("must be one of {}", fmt::join(allowed, ", ")));
}

const json* Fields::object(std::string_view name, Presence presence) {
  const json* value = nullptr;
  if (!present(name, presence, value)) return nullptr;
  if (!value->is_object()) refuse(name, "must be an object");
  return sound() ? value : nullptr;
}

}  // namespace scree::gltf
