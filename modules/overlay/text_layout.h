// Lines of text at anchors, as quads of a draw list. Private to modules/overlay.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "engine/core/math.h"
#include "modules/overlay/overlay.h"

struct ImDrawList;

namespace scree {

// Height of a line of text at scale 1, pixels.
inline constexpr int kLineHeight = 13;
// Width of every letter at scale 1, pixels.
inline constexpr int kLetterWidth = 7;

// What is drawn of a text: at most kMaxTextBytes, cut between letters.
std::string_view shownText(std::string_view text);
// Letters of the longest line, and lines; of UTF-8.
ivec2 textExtent(std::string_view text);
// The whole factor at which a line is drawn on an output of `size` pixels.
int textScale(const TextLine& line, ivec2 extent, ivec2 size);

// Where a line's box is, pixels from the upper left corner.
struct TextBox {
  ivec2 origin{0};
  ivec2 size{0};
  int scale = 1;
};

// Boxes of all lines: those of one anchor stacked without overlap.
void placeLines(std::span<const TextLine> lines, ivec2 size, std::vector<TextBox>& boxes);

// The inspector's panels: left (0) and right (1) half of the output, and how many letters and lines
// fit into each.
TextBox panelBox(ivec2 size, int scale, int panel);
ivec2 panelLetters(ivec2 size, int scale);

// A dark box, and text within its padding.
void drawBox(ImDrawList& list, const TextBox& box, std::string_view text, vec4 color,
             float backing);

class TextLayout {
 public:
  void draw(ImDrawList& list, std::span<const TextLine> lines, ivec2 size);

 private:
  std::vector<TextBox> boxes_;
};

}  // namespace scree
