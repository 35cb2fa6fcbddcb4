// JSON to components through their reflection.
#include "engine/assets/extras.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <set>

#include "engine/assets/gltf_document.h"
#include "engine/core/log.h"

namespace scree {
using nlohmann::json;
namespace {

template <class T>
bool store(std::byte* out, T value) {
  std::memcpy(out, &value, sizeof(T));
  return true;
}

// The functions below return false if `value` is not what the field takes.
template <class T>
bool whole(const json& value, std::byte* out) {
  if (value.is_number_unsigned()) {
    const auto number = value.get<uint64_t>();
    return number <= static_cast<uint64_t>(std::numeric_limits<T>::max()) &&
           store(out, static_cast<T>(number));
  }
  if (!value.is_number_integer()) return false;
  const auto number = value.get<int64_t>();
  return number >= static_cast<int64_t>(std::numeric_limits<T>::min()) &&
         (number < 0 ? std::is_signed_v<T> : true) && store(out, static_cast<T>(number));
}

template <class T>
bool real(const json& value, std::byte* out) {
  if (!value.is_number()) return false;
  const double number = value.get<double>();
  return std::isfinite(number) && std::abs(number) <= std::numeric_limits<T>::max() &&
         store(out, static_cast<T>(number));
}

template <class T>
bool reals(const json& value, size_t count, std::byte* out) {
  if (!value.is_array() || value.size() != count) return false;
  for (size_t i = 0; i < count; ++i)
    if (!real<T>(value[i], out + i * sizeof(T))) return false;
  return true;
}

bool rotation(const json& value, std::byte* out) {
  double xyzw[4];
  if (!reals<double>(value, 4, reinterpret_cast<std::byte*>(xyzw))) return false;
  const double length = std::hypot(std::hypot(xyzw[0], xyzw[1]), std::hypot(xyzw[2], xyzw[3]));
  if (!(length > 1e-6) || !std::isfinite(length)) return false;
  for (size_t i = 0; i < 4; ++i) store(out + i * 4, static_cast<float>(xyzw[i] / length));
  return true;
}

bool element(FieldType type, const json& value, std::byte* out) {
  switch (type) {
    case FieldType::Bool:
      return value.is_boolean() && store(out, value.get<bool>());
    case FieldType::Int32:
      return whole<int32_t>(value, out);
    case FieldType::Enum:
      return whole<int32_t>(value, out) || whole<uint32_t>(value, out);
    case FieldType::Uint32:
      return whole<uint32_t>(value, out);
    case FieldType::Int64:
      return whole<int64_t>(value, out);
    case FieldType::Uint64:
      return whole<uint64_t>(value, out);
    case FieldType::Float:
      return real<float>(value, out);
    case FieldType::Double:
      return real<double>(value, out);
    case FieldType::Vec2:
      return reals<float>(value, 2, out);
    case FieldType::Vec3:
      return reals<float>(value, 3, out);
    case FieldType::Vec4:
      return reals<float>(value, 4, out);
    case FieldType::DVec3:
      return reals<double>(value, 3, out);
    case FieldType::Quat:
      return rotation(value, out);
    case FieldType::Entity:
    case FieldType::Text:
      return false;  // handled as whole fields
  }
  return false;
}

std::string allowedText(const FieldInfo& field) {
  std::string one;
  switch (field.type) {
    case FieldType::Bool:
      one = "true or false";
      break;
    case FieldType::Int32:
    case FieldType::Enum:
      one = "a whole number of 32 bits";
      break;
    case FieldType::Uint32:
      one = "a whole number from 0 to 4294967295";
      break;
    case FieldType::Int64:
      one = "a whole number of 64 bits";
      break;
    case FieldType::Uint64:
      one = "a whole number of 64 bits, not negative";
      break;
    case FieldType::Float:
    case FieldType::Double:
      one = "a finite number";
      break;
    case FieldType::Vec2:
      one = "2 finite numbers";
      break;
    case FieldType::Vec3:
    case FieldType::DVec3:
      one = "3 finite numbers";
      break;
    case FieldType::Vec4:
      one = "4 finite numbers";
      break;
    case FieldType::Quat:
      one = "4 numbers x, y, z, w, not all 0";
      break;
    case FieldType::Entity:
      one = "the name of one node, or null";
      break;
    case FieldType::Text:
      return fmt::format("must be a text of at most {} bytes", field.count - 1);
  }
  if (field.count > 1) return fmt::format("must be an array of {}, each {}", field.count, one);
  return "must be " + one + (field.unit.empty() ? "" : fmt::format(" ({})", field.unit));
}

// One field of one component into `out`; an error names what is allowed.
Status readField(const FieldInfo& field, const json& value, const CountNodes& count_nodes,
                 ParsedExtras::Value& out) {
  const auto refuse = [&] { return Error{allowedText(field)}; };
  ParsedExtras::Patch patch{field.offset, std::vector<std::byte>(field.size())};
  if (field.type == FieldType::Text) {
    if (!value.is_string() || value.get_ref<const std::string&>().size() >= field.count)
      return refuse();
    const auto& text = value.get_ref<const std::string&>();
    std::memcpy(patch.bytes.data(), text.data(), text.size());
    out.patches.push_back(std::move(patch));
    return Done{};
  }
  const size_t size = fieldTypeSize(field.type);
  if (field.count > 1 && (!value.is_array() || value.size() != field.count)) return refuse();
  for (size_t i = 0; i < field.count; ++i) {
    const json& entry = field.count > 1 ? value[i] : value;
    if (field.type != FieldType::Entity) {
      if (!element(field.type, entry, patch.bytes.data() + i * size)) return refuse();
      continue;
    }
    store(patch.bytes.data() + i * size, Entity::kNone);
    if (entry.is_null()) continue;
    if (!entry.is_string()) return refuse();
    const auto& name = entry.get_ref<const std::string&>();
    const size_t named = count_nodes ? count_nodes(name) : 0;
    if (named != 1) return Error{fmt::format("{} nodes have that name; exactly one must", named)};
    out.links.push_back({field.offset + i * size, name});
  }
  out.patches.push_back(std::move(patch));
  return Done{};
}

std::string fieldNames(const ComponentInfo& component) {
  std::string names;
  for (const FieldInfo& field : component.fields)
    names += (names.empty() ? "" : ", ") + std::string(field.name);
  return names.empty() ? "it has none" : "its fields are " + names;
}

void warnUnknown(const std::string& name, std::string_view where) {
  static std::mutex mutex;
  static std::set<std::string> known;
  const std::lock_guard lock(mutex);
  // A hostile file may hold any number of names.
  constexpr size_t kMostWarnings = 8;
  if (known.size() == kMostWarnings || !known.insert(name).second) return;
  logWarning("{}: extras: {}: no component has this name; ignored{}", where, gltf::printable(name),
             known.size() == kMostWarnings ? ", as are further ones" : "");
}

// What the component says of the value that the file gives it.
std::string faultOf(const ParsedExtras::Value& value) {
  const ComponentInfo& info = *value.component;
  if (info.fault == nullptr) return {};
  std::vector<std::byte> bytes(info.size);
  std::memcpy(bytes.data(), info.default_value, info.size);
  for (const ParsedExtras::Patch& patch : value.patches)
    std::memcpy(bytes.data() + patch.offset, patch.bytes.data(), patch.bytes.size());
  return info.fault(bytes.data());
}

}  // namespace

Result<ParsedExtras> parseExtras(const json& extras, std::string_view where,
                                 const CountNodes& count_nodes) {
  ParsedExtras parsed;
  if (!extras.is_object()) return parsed;
  for (const auto& [name, content] : extras.items()) {
    const ComponentInfo* component = findComponent(name);
    if (component == nullptr) {
      warnUnknown(name, where);
      continue;
    }
    ParsedExtras::Value value;
    value.component = component;
    if (content.is_boolean()) {
      value.present = content.get<bool>();
      parsed.values.push_back(std::move(value));
      continue;
    }
    if (!content.is_object())
      return Error{fmt::format("{}: extras: {} = {}: must be an object of fields, true or false",
                               where, name, gltf::valueText(content))};
    for (const auto& [field_name, field_value] : content.items()) {
      const FieldInfo* field = component->findField(field_name);
      if (field == nullptr)
        return Error{fmt::format("{}: extras: {}: {} = {}: no such field; {}", where, name,
                                 gltf::printable(field_name), gltf::valueText(field_value),
                                 fieldNames(*component))};
      if (Status read = readField(*field, field_value, count_nodes, value); !read.ok())
        return Error{fmt::format("{}: extras: {}: {} = {}: {}", where, name, field_name,
                                 gltf::valueText(field_value), read.error())};
    }
    if (const std::string wrong = faultOf(value); !wrong.empty())
      return Error{fmt::format("{}: extras: {}: {}", where, name, wrong)};
    parsed.values.push_back(std::move(value));
  }
  return parsed;
}

void attach(World& world, Entity entity, const ParsedExtras& parsed, const FindNode& find_node) {
  for (const ParsedExtras::Value& value : parsed.values) {
    if (!value.present) {
      world.remove(entity, value.component->id);
      continue;
    }
    auto* storage = static_cast<std::byte*>(value.component->addDefault(world, entity));
    if (storage == nullptr) fail("attach: the entity is dead");
    for (const ParsedExtras::Patch& patch : value.patches)
      std::memcpy(storage + patch.offset, patch.bytes.data(), patch.bytes.size());
    for (const ParsedExtras::Link& link : value.links)
      store(storage + link.offset, find_node ? find_node(link.name) : Entity::kNone);
  }
}

Status attachExtras(World& world, Entity entity, const json& extras, std::string_view where,
                    const FindNode& find_node) {
  const auto count = [&](std::string_view name) {
    return find_node && find_node(name) != Entity::kNone ? size_t{1} : size_t{0};
  };
  Result<ParsedExtras> parsed = parseExtras(extras, where, count);
  if (!parsed.ok()) return parsed.takeError();
  attach(world, entity, *parsed, find_node);
  return Done{};
}

}  // namespace scree
