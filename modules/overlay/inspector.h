// The inspector's two panels: entities with their components, and passes with systems. Private to
// modules/overlay.
#pragma once

#include <fmt/format.h>

#include <string_view>

#include "engine/core/math.h"
#include "engine/ecs/component.h"
#include "modules/overlay/overlay.h"

struct ImDrawList;

namespace scree {

class Frame;
class Schedule;
class World;

// A panel's text, cut to whole lines and columns.
class PanelText {
 public:
  void begin(ivec2 letters);  // columns, rows
  // One line; nothing once the panel is full.
  template <class... T>
  void line(fmt::format_string<T...> format, T&&... args) {
    if (full()) return;
    line_.clear();
    fmt::format_to(std::back_inserter(line_), format, std::forward<T>(args)...);
    endLine();
  }
  bool full() const { return rows_ >= letters_.y; }
  std::string_view text() const { return {text_.data(), text_.size()}; }

 private:
  void endLine();
  ivec2 letters_{0};
  int rows_ = 0;
  fmt::memory_buffer line_, text_;
};

// One field's value with its unit: "(1, 2.5, 0) m", "true", "'Creature'".
void formatField(fmt::memory_buffer& out, const FieldInfo& field, const void* component);

// Tables with their sizes, then entities: the selected one, then from `first_entity` on.
void describeEntities(PanelText& panel, const World& world, const Inspector& inspector);
void describePasses(PanelText& panel, const Frame& frame, const Schedule& schedule, bool times);

class InspectorText {
 public:
  void draw(ImDrawList& list, const World& world, const Inspector& inspector, const Frame& frame,
            const Schedule& schedule, ivec2 size);

 private:
  PanelText entities_, passes_;
};

}  // namespace scree
