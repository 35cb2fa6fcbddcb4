// Placing text: whole factors, whole pixels.
#include "modules/overlay/text_layout.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>

namespace scree {
namespace {

// At scale 1, pixels.
constexpr int kMargin = 4;
constexpr ivec2 kPadding{3, 1};

// Rows of an output at which the factor is 1.
constexpr int kRowsOfFactor = 360;

// Letters that a tab takes in Dear ImGui's fonts.
constexpr int kTabLetters = 4;

bool isContinuation(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

// 0 to 1; NaN is 0.
float unit(float value) {
  return value > 0 ? std::min(value, 1.0f) : 0.0f;
}

ImU32 packed(vec4 color) {
  return ImGui::ColorConvertFloat4ToU32(
      ImVec4(unit(color.x), unit(color.y), unit(color.z), unit(color.w)));
}

ImVec2 corner(ivec2 at) {
  return ImVec2(static_cast<float>(at.x), static_cast<float>(at.y));
}

int column(Anchor anchor) {
  return static_cast<int>(anchor) % 3;
}
int row(Anchor anchor) {
  return static_cast<int>(anchor) / 3;
}

}  // namespace

int overlayFactor(int output_height) {
  return std::max(1, (2 * output_height + kRowsOfFactor) / (2 * kRowsOfFactor));
}

std::string_view shownText(std::string_view text) {
  if (text.size() <= kMaxTextBytes) return text;
  size_t end = kMaxTextBytes;
  while (end > 0 && isContinuation(text[end])) --end;
  return text.substr(0, end);
}

ivec2 textExtent(std::string_view text) {
  ivec2 extent{0, 1};
  int letters = 0;
  const char* const end = text.data() + text.size();
  for (const char* at = text.data(); at < end;) {
    auto c = static_cast<unsigned>(static_cast<unsigned char>(*at));
    at += c < 0x80 ? 1 : ImTextCharFromUtf8(&c, at, end);  // as ImFont::RenderText does
    if (c == '\n') {
      ++extent.y;
      letters = 0;
    } else if (c != '\r') {
      letters += c == '\t' ? kTabLetters : 1;
      extent.x = std::max(extent.x, letters);
    }
  }
  return extent;
}

int textScale(const TextLine& line, ivec2 extent, ivec2 size) {
  const float factor = std::isfinite(line.size) ? std::clamp(line.size, 0.0f, kMaxTextSize) : 1.0f;
  const auto wanted =
      static_cast<int>(std::lround(factor * static_cast<float>(overlayFactor(size.y))));
  const int margin = 2 * kMargin * overlayFactor(size.y);
  const int fitting = (size.x - margin) / (extent.x * kLetterWidth + 2 * kPadding.x);
  return std::max(1, std::min(wanted, fitting));
}

void placeLines(std::span<const TextLine> lines, ivec2 size, std::vector<TextBox>& boxes) {
  boxes.clear();
  std::array<int, kAnchorCount> stack{};  // heights
  for (const TextLine& line : lines) {
    const ivec2 extent = textExtent(shownText(line.text));
    TextBox box;
    box.scale = textScale(line, extent, size);
    box.size = (extent * ivec2(kLetterWidth, kLineHeight) + 2 * kPadding) * box.scale;
    stack[static_cast<size_t>(line.anchor) % kAnchorCount] += box.size.y;
    boxes.push_back(box);
  }
  const int margin = kMargin * overlayFactor(size.y);
  std::array<int, kAnchorCount> next{};  // top of each stack's next box
  for (size_t i = 0; i < kAnchorCount; ++i) {
    const int room = size.y - stack[i];
    const int tops[] = {margin, room / 2, room - margin};
    next[i] = tops[row(static_cast<Anchor>(i))];
  }
  for (size_t i = 0; i < lines.size(); ++i) {
    TextBox& box = boxes[i];
    const size_t anchor = static_cast<size_t>(lines[i].anchor) % kAnchorCount;
    const int room = size.x - box.size.x;
    const int lefts[] = {margin, room / 2, room - margin};
    box.origin = {lefts[column(static_cast<Anchor>(anchor))], next[anchor]};
    next[anchor] += box.size.y;
  }
}

TextBox panelBox(ivec2 size, int scale, int panel) {
  const int margin = kMargin * scale;
  const ivec2 box = glm::max(ivec2((size.x - 3 * margin) / 2, size.y - 2 * margin), ivec2(0));
  return {{margin + panel * (box.x + margin), margin}, box, scale};
}

ivec2 panelLetters(ivec2 size, int scale) {
  const ivec2 room = panelBox(size, scale, 0).size - 2 * kPadding * scale;
  return glm::max(room / (ivec2(kLetterWidth, kLineHeight) * scale), ivec2(0));
}

void drawBox(ImDrawList& list, const TextBox& box, std::string_view text, vec4 color,
             float backing) {
  const ivec2 end = box.origin + box.size;
  if (backing > 0)
    list.AddRectFilled(corner(box.origin), corner(end), packed(vec4(0, 0, 0, backing)));
  list.AddText(ImGui::GetFont(), static_cast<float>(kLineHeight * box.scale),
               corner(box.origin + kPadding * box.scale), packed(color), text.data(),
               text.data() + text.size());
}

void TextLayout::draw(ImDrawList& list, std::span<const TextLine> lines, ivec2 size) {
  placeLines(lines, size, boxes_);
  for (size_t i = 0; i < lines.size(); ++i)
    drawBox(list, boxes_[i], shownText(lines[i].text), lines[i].color, lines[i].backing);
}

}  // namespace scree
