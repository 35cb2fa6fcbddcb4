// The overlay's font, its layout through Dear ImGui, and the GPU objects that draw the result.
// Private to modules/overlay.
#pragma once

#include <vector>

#include "engine/core/math.h"
#include "engine/gpu/objects.h"
#include "engine/gpu/program.h"
#include "engine/gpu/state.h"
#include "engine/gpu/stream.h"
#include "modules/overlay/inspector.h"
#include "modules/overlay/text_layout.h"

struct ImGuiContext;
struct ImDrawData;

namespace scree {

class Frame;
class Schedule;
class World;

// Makes nothing before its first prepare().
class OverlayPainter {
 public:
  OverlayPainter();
  ~OverlayPainter();
  OverlayPainter(const OverlayPainter&) = delete;
  OverlayPainter& operator=(const OverlayPainter&) = delete;

  // Lays out the text and the inspector for an output of `size` pixels, and uploads the corners.
  void prepare(World& world, const Frame& frame, const Schedule& schedule, ivec2 size);
  // Draws what was prepared last into the bound framebuffer.
  void draw(ivec2 size);

 private:
  // Triangles within a rectangle.
  struct Command {
    gpu::Rect scissor;
    int index_count = 0;
    size_t first_index = 0;
    int base_vertex = 0;
  };
  void create();
  void upload(const ImDrawData& data, ivec2 size);

  ImGuiContext* ui_ = nullptr;
  TextLayout layout_;
  InspectorText inspector_;
  gpu::Texture font_;
  gpu::Program program_;
  gpu::StreamBuffer stream_;
  gpu::VertexArray vertex_array_;
  gpu::StreamSlice vertices_, indices_;
  std::vector<Command> commands_;
};

}  // namespace scree
