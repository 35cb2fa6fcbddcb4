// The registry of component types.
#include "engine/ecs/component.h"

#include <algorithm>
#include <array>
#include <memory>

#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/ecs/world.h"

namespace scree {
namespace {

struct FieldTypeRow {
  std::string_view name;
  size_t size;
};
constexpr std::array<FieldTypeRow, 15> kFieldTypes{{{"bool", 1},
                                                    {"int32", 4},
                                                    {"uint32", 4},
                                                    {"int64", 8},
                                                    {"uint64", 8},
                                                    {"float", 4},
                                                    {"double", 8},
                                                    {"vec2", 8},
                                                    {"vec3", 12},
                                                    {"vec4", 16},
                                                    {"dvec3", 24},
                                                    {"quat", 16},
                                                    {"Entity", 8},
                                                    {"enum", 4},
                                                    {"text", 1}}};
static_assert(sizeof(vec3) == 12 && sizeof(dvec3) == 24 && sizeof(quat) == 16);
static_assert(static_cast<size_t>(FieldType::Text) + 1 == kFieldTypes.size());

// Never destroyed, since components are registered before main and looked up until the end.
std::vector<std::unique_ptr<ComponentInfo>>& registry() {
  static auto* infos = new std::vector<std::unique_ptr<ComponentInfo>>;
  return *infos;
}

std::vector<ByteRun> valueRuns(std::vector<FieldInfo> fields) {
  std::erase_if(fields, [](const FieldInfo& field) { return field.type == FieldType::Text; });
  std::sort(fields.begin(), fields.end(),
            [](const FieldInfo& a, const FieldInfo& b) { return a.offset < b.offset; });
  std::vector<ByteRun> runs;
  for (const FieldInfo& field : fields) {
    const auto size = static_cast<uint32_t>(field.size());
    if (!runs.empty() && runs.back().offset + runs.back().size == field.offset)
      runs.back().size += size;
    else
      runs.push_back({field.offset, size});
  }
  return runs;
}

}  // namespace

std::string_view fieldTypeName(FieldType type) {
  return kFieldTypes[static_cast<size_t>(type)].name;
}

size_t fieldTypeSize(FieldType type) {
  return kFieldTypes[static_cast<size_t>(type)].size;
}

const FieldInfo* ComponentInfo::findField(std::string_view field) const {
  for (const FieldInfo& info : fields)
    if (info.name == field) return &info;
  return nullptr;
}

void* ComponentInfo::addDefault(World& world, Entity entity) const {
  if (world.has(entity, id)) return world.find(entity, id);
  return world.add(entity, ComponentValue{id, nullptr});
}

const ComponentInfo* findComponent(std::string_view name) {
  for (const auto& info : registry())
    if (info->name == name) return info.get();
  return nullptr;
}

const ComponentInfo& componentInfo(ComponentId id) {
  if (id >= registry().size()) fail(fmt::format("component id {} is not registered", id));
  return *registry()[id];
}

std::vector<const ComponentInfo*> components() {
  std::vector<const ComponentInfo*> infos;
  for (const auto& info : registry()) infos.push_back(info.get());
  std::sort(infos.begin(), infos.end(), [](auto* a, auto* b) { return a->name < b->name; });
  return infos;
}

const ComponentInfo& detail::registerComponent(ComponentInfo info) {
  if (findComponent(info.name))
    fail(fmt::format("SCREE_COMPONENT({}): another type has this name", info.name));
  if (registry().size() == kMaxComponentTypes)
    fail(fmt::format("SCREE_COMPONENT({}): more than {} component types", info.name,
                     kMaxComponentTypes));
  for (size_t i = 0; i < info.fields.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      if (info.fields[i].offset == info.fields[j].offset)
        fail(fmt::format("SCREE_COMPONENT({}): field '{}' is listed twice", info.name,
                         info.fields[i].name));
  info.id = static_cast<ComponentId>(registry().size());
  info.hash = hashName(info.name);
  info.runs = valueRuns(info.fields);
  info.has_entities = std::any_of(info.fields.begin(), info.fields.end(),
                                  [](const FieldInfo& f) { return f.type == FieldType::Entity; });
  registry().push_back(std::make_unique<ComponentInfo>(std::move(info)));
  return *registry().back();
}

}  // namespace scree
