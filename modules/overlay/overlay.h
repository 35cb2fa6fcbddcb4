// Text and a debug inspector on top of the finished image.
//
// Fill the OverlayText singleton in Phase::Animate (or earlier); it is shown until it is changed.
// Letters are the 13 px bitmap font of Dear ImGui, scaled by whole factors, on a dark box, so that
// they are crisp and readable from 640x360 to 4K: factor 1 up to 539 lines, 2 from 540, 3 from 900,
// 6 at 2160. Same text and size, same pixels. The inspector lists entities with their components,
// passes and systems; its times differ from run to run.
// Inputs: OverlayText, Inspector. Output: Frame::kOutput, drawn over (pass overlay.draw, Present).
// Cost: one draw and 20 bytes a corner of a letter; nothing at all, no font, no program, no buffer,
// while there is no text and the inspector is closed.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/math.h"
#include "engine/ecs/entity.h"

namespace scree {

class App;

// Where a line of text stands. Lines of one anchor are stacked from top to bottom in their order.
enum class Anchor : uint32_t {
  TopLeft,
  TopCenter,
  TopRight,
  CenterLeft,
  Center,
  CenterRight,
  BottomLeft,
  BottomCenter,
  BottomRight,
};
inline constexpr size_t kAnchorCount = 9;

// The rest of a longer text is cut, bytes.
inline constexpr size_t kMaxTextBytes = 4096;
// Larger sizes are clamped, and sizes that are not numbers are 1.
inline constexpr float kMaxTextSize = 64;

struct TextLine {
  std::string text;  // UTF-8; '\n' breaks lines; letters beyond Latin-1 are shown as '?'
  Anchor anchor = Anchor::TopLeft;
  float size = 1;        // times the screen's factor, rounded to a whole factor; less if too wide
  vec4 color{1};         // sRGB-encoded, straight alpha, 0 to 1
  float backing = 0.6f;  // opacity of the dark box behind, 0 to 1
};

// World singleton: the text on the screen. Keeps its memory when cleared.
class OverlayText {
 public:
  void clear() { count_ = 0; }
  // The returned line is valid until the next add().
  TextLine& add(std::string_view text, Anchor anchor = Anchor::TopLeft, float size = 1,
                vec4 color = vec4(1));
  std::span<const TextLine> lines() const { return {lines_.data(), count_}; }
  bool empty() const { return count_ == 0; }

 private:
  std::vector<TextLine> lines_;
  size_t count_ = 0;
};

// World singleton: the debug inspector.
struct Inspector {
  bool open = false;
  Entity selected = Entity::kNone;  // shown first, with all its fields
  uint32_t first_entity = 0;        // in the order of tables and rows: where the list begins
  bool times = true;                // show times; off, the same world gives the same pixels
};

// The whole factor by which the font is scaled on an output of this height, pixels.
int overlayFactor(int output_height);

// Registers overlay.layout (Prepare) and overlay.draw (Present). Call it after the modules whose
// image it is drawn over.
void addOverlay(App& app);

}  // namespace scree
