// The inspector's text, from reflection and reports.
#include "modules/overlay/inspector.h"

#include <algorithm>
#include <cstring>

#include "engine/ecs/schedule.h"
#include "engine/ecs/world.h"
#include "engine/frame/frame.h"
#include "modules/overlay/text_layout.h"
#include "modules/scene/scene.h"

namespace scree {
namespace {

constexpr vec4 kPanelColor{0.85f, 0.95f, 0.85f, 1};
constexpr float kPanelBacking = 0.85f;

template <class T>
T read(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <class T>
void formatTuple(fmt::memory_buffer& out, const std::byte* from, int count) {
  for (int i = 0; i < count; ++i)
    fmt::format_to(std::back_inserter(out), "{}{:.5g}", i == 0 ? "(" : ", ",
                   read<T>(from + static_cast<size_t>(i) * sizeof(T)));
  out.push_back(')');
}

void formatValue(fmt::memory_buffer& out, FieldType type, const std::byte* from) {
  auto end = std::back_inserter(out);
  switch (type) {
    case FieldType::Bool:
      fmt::format_to(end, "{}", read<uint8_t>(from) != 0);
      return;
    case FieldType::Int32:
      fmt::format_to(end, "{}", read<int32_t>(from));
      return;
    case FieldType::Enum:
    case FieldType::Uint32:
      fmt::format_to(end, "{}", read<uint32_t>(from));
      return;
    case FieldType::Int64:
      fmt::format_to(end, "{}", read<int64_t>(from));
      return;
    case FieldType::Uint64:
      fmt::format_to(end, "{}", read<uint64_t>(from));
      return;
    case FieldType::Float:
      fmt::format_to(end, "{:.5g}", read<float>(from));
      return;
    case FieldType::Double:
      fmt::format_to(end, "{:.8g}", read<double>(from));
      return;
    case FieldType::Vec2:
      formatTuple<float>(out, from, 2);
      return;
    case FieldType::Vec3:
      formatTuple<float>(out, from, 3);
      return;
    case FieldType::Vec4:
    case FieldType::Quat:
      formatTuple<float>(out, from, 4);
      return;
    case FieldType::DVec3:
      formatTuple<double>(out, from, 3);
      return;
    case FieldType::Entity: {
      const auto entity = read<Entity>(from);
      if (entity == Entity::kNone)
        fmt::format_to(end, "none");
      else
        fmt::format_to(end, "#{}.{}", entity.index, entity.generation);
      return;
    }
    case FieldType::Text:
      return;  // formatField
  }
}

void describeEntity(PanelText& panel, const World& world, Entity entity) {
  const Name* name = world.peek<Name>(entity);
  const size_t length = name ? strnlen(name->text, sizeof name->text) : 0;
  panel.line("#{}.{} {}", entity.index, entity.generation,
             std::string_view(name ? name->text : "", length));
  fmt::memory_buffer value;
  for (ComponentId id : world.componentIds(entity)) {
    const ComponentInfo& info = componentInfo(id);
    if (info.id == componentId<Name>()) continue;
    if (info.fields.empty()) panel.line("  {}", info.name);
    for (const FieldInfo& field : info.fields) {
      if (panel.full()) return;
      value.clear();
      formatField(value, field, world.peek(entity, id));
      panel.line("  {}.{} {}", info.name, field.name, std::string_view(value.data(), value.size()));
    }
  }
}

}  // namespace

void PanelText::begin(ivec2 letters) {
  letters_ = letters;
  rows_ = 0;
  text_.clear();
}

void PanelText::endLine() {
  if (rows_++ > 0) text_.push_back('\n');
  // Anything but printable ASCII would break the columns.
  const size_t shown = std::min(line_.size(), static_cast<size_t>(std::max(letters_.x, 0)));
  for (size_t i = 0; i < shown; ++i)
    text_.push_back(line_[i] >= 32 && line_[i] < 127 ? line_[i] : '?');
}

void formatField(fmt::memory_buffer& out, const FieldInfo& field, const void* component) {
  const auto* from = static_cast<const std::byte*>(component) + field.offset;
  if (field.type == FieldType::Text) {
    const auto* text = reinterpret_cast<const char*>(from);
    fmt::format_to(std::back_inserter(out), "'{}'",
                   std::string_view(text, strnlen(text, field.count)));
  } else {
    for (uint32_t i = 0; i < field.count; ++i) {
      if (i > 0) out.push_back(' ');
      formatValue(out, field.type, from + i * fieldTypeSize(field.type));
    }
  }
  if (!field.unit.empty()) fmt::format_to(std::back_inserter(out), " {}", field.unit);
}

void describeEntities(PanelText& panel, const World& world, const Inspector& inspector) {
  size_t tables = 0;
  for (const auto& table : world.tables()) tables += table->empty() ? 0 : 1;
  panel.line("{} entities in {} tables", world.entityCount(), tables);
  fmt::memory_buffer names;
  for (const auto& table : world.tables()) {
    if (table->empty() || panel.full()) continue;
    names.clear();
    for (ComponentId id : table->componentIds())
      fmt::format_to(std::back_inserter(names), " {}", componentInfo(id).name);
    panel.line("{:>8}{}", table->size(), std::string_view(names.data(), names.size()));
  }
  if (world.alive(inspector.selected)) {
    panel.line("selected:");
    describeEntity(panel, world, inspector.selected);
  }
  size_t skipped = 0;
  for (const auto& table : world.tables()) {
    const size_t begin = std::min(table->size(), inspector.first_entity - skipped);
    skipped += begin;
    for (Entity entity : table->entities().subspan(begin)) {
      if (panel.full()) return;
      describeEntity(panel, world, entity);
    }
  }
}

void describePasses(PanelText& panel, const Frame& frame, const Schedule& schedule, bool times) {
  panel.line("{:<24}{:>8}{:>8}", "pass", times ? "gpu ms" : "", times ? "cpu ms" : "");
  for (const PassReport& pass : frame.report()) {
    if (!pass.on)
      panel.line("{:<24} off: {}", pass.name, pass.why);
    else if (!times)
      panel.line("{:<24} on", pass.name);
    else if (pass.gpu_ms < 0)
      panel.line("{:<24}{:>8}{:>8.2f}", pass.name, "-", pass.cpu_ms);
    else
      panel.line("{:<24}{:>8.2f}{:>8.2f}", pass.name, pass.gpu_ms, pass.cpu_ms);
  }
  panel.line("");
  panel.line("{:<32}{:>8}", "system", times ? "cpu ms" : "");
  for (const SystemReport& system : schedule.report()) {
    if (!system.on)
      panel.line("{:<32}     off", system.name);
    else if (!times)
      panel.line("{:<32}      on", system.name);
    else
      panel.line("{:<32}{:>8.2f}", system.name, system.cpu_ms);
  }
}

void InspectorText::draw(ImDrawList& list, const World& world, const Inspector& inspector,
                         const Frame& frame, const Schedule& schedule, ivec2 size) {
  const int scale = overlayFactor(size.y);
  const ivec2 letters = panelLetters(size, scale);
  entities_.begin(letters);
  describeEntities(entities_, world, inspector);
  passes_.begin(letters);
  describePasses(passes_, frame, schedule, inspector.times);
  const PanelText* panels[] = {&entities_, &passes_};
  for (int i = 0; i < 2; ++i)
    drawBox(list, panelBox(size, scale, i), panels[i]->text(), kPanelColor, kPanelBacking);
}

}  // namespace scree
