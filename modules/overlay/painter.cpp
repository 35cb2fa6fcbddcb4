// Dear ImGui's draw lists, drawn through engine/gpu: its own GL backend brings a function loader
// that does not know OSMesa.
#include "modules/overlay/painter.h"

#include <imgui.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "engine/ecs/world.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "modules/overlay/overlay.h"
#include "shaders/shared/bindings.h"

namespace scree {
namespace {

static_assert(sizeof(ImDrawIdx) == 2, "indices are drawn as GL_UNSIGNED_SHORT");

// Dear ImGui has one current context a process; what was current is put back.
class CurrentUi {
 public:
  explicit CurrentUi(ImGuiContext* ui) : before_(ImGui::GetCurrentContext()) {
    ImGui::SetCurrentContext(ui);
  }
  ~CurrentUi() { ImGui::SetCurrentContext(before_); }
  CurrentUi(const CurrentUi&) = delete;
  CurrentUi& operator=(const CurrentUi&) = delete;

 private:
  ImGuiContext* before_;
};

}  // namespace

OverlayPainter::OverlayPainter()
    : program_({.name = "overlay.draw",
                .vertex = "overlay/overlay.vert",
                .fragment = "overlay/overlay.frag"}),
      stream_("overlay.stream") {}

OverlayPainter::~OverlayPainter() {
  if (ui_) ImGui::DestroyContext(ui_);
}

void OverlayPainter::create() {
  ImGuiContext* before = ImGui::GetCurrentContext();
  ui_ = ImGui::CreateContext();
  ImGui::SetCurrentContext(before);
  const CurrentUi current(ui_);
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
  // Edges on pixel boundaries, so that nothing is blurred.
  ImGuiStyle& style = ImGui::GetStyle();
  style.AntiAliasedLines = style.AntiAliasedLinesUseTex = style.AntiAliasedFill = false;
  io.Fonts->Flags |= ImFontAtlasFlags_NoBakedLines | ImFontAtlasFlags_NoMouseCursors;
  io.Fonts->AddFontDefault();
  unsigned char* pixels = nullptr;
  ivec2 size;
  io.Fonts->GetTexDataAsAlpha8(&pixels, &size.x, &size.y);
  font_ = gpu::Texture("overlay.font", {.format = GL_R8, .size = size});
  font_.upload(std::span<const uint8_t>(pixels, static_cast<size_t>(size.x * size.y)), 1);
  io.Fonts->ClearTexData();

  vertex_array_ = gpu::VertexArray("overlay.vertices");
  vertex_array_.attribute(0, 2, GL_FLOAT, offsetof(ImDrawVert, pos));
  vertex_array_.attribute(1, 2, GL_FLOAT, offsetof(ImDrawVert, uv));
  vertex_array_.attribute(2, 4, GL_UNSIGNED_BYTE, offsetof(ImDrawVert, col), 0, true);
}

void OverlayPainter::prepare(World& world, const Frame& frame, const Schedule& schedule,
                             ivec2 size) {
  commands_.clear();
  if (size.x <= 0 || size.y <= 0) return;
  if (!ui_) create();
  const CurrentUi current(ui_);
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = ImVec2(static_cast<float>(size.x), static_cast<float>(size.y));
  io.DeltaTime = 1.0f / 60.0f;  // nothing here moves with time
  ImGui::NewFrame();
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  layout_.draw(list, world.singleton<const OverlayText>().lines(), size);
  if (const Inspector& inspector = world.singleton<const Inspector>(); inspector.open)
    inspector_.draw(list, world, inspector, frame, schedule, size);
  ImGui::Render();
  upload(*ImGui::GetDrawData(), size);
}

void OverlayPainter::upload(const ImDrawData& data, ivec2 size) {
  stream_.beginFrame();
  vertices_ = stream_.allocate(static_cast<size_t>(data.TotalVtxCount) * sizeof(ImDrawVert));
  indices_ = stream_.allocate(static_cast<size_t>(data.TotalIdxCount) * sizeof(ImDrawIdx));
  size_t vertex = 0, index = 0;
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    std::memcpy(static_cast<ImDrawVert*>(vertices_.data) + vertex, list.VtxBuffer.Data,
                static_cast<size_t>(list.VtxBuffer.size_in_bytes()));
    std::memcpy(static_cast<ImDrawIdx*>(indices_.data) + index, list.IdxBuffer.Data,
                static_cast<size_t>(list.IdxBuffer.size_in_bytes()));
    for (const ImDrawCmd& command : list.CmdBuffer) {
      const ivec2 low = glm::max(
          ivec2(static_cast<int>(command.ClipRect.x), static_cast<int>(command.ClipRect.y)),
          ivec2(0));
      const ivec2 high = glm::min(
          ivec2(static_cast<int>(command.ClipRect.z), static_cast<int>(command.ClipRect.w)), size);
      if (high.x <= low.x || high.y <= low.y || command.ElemCount == 0) continue;
      // From y down to y up.
      commands_.push_back({.scissor = {{low.x, size.y - high.y}, high - low},
                           .index_count = static_cast<int>(command.ElemCount),
                           .first_index = index + command.IdxOffset,
                           .base_vertex = static_cast<int>(vertex + command.VtxOffset)});
    }
    vertex += static_cast<size_t>(list.VtxBuffer.Size);
    index += static_cast<size_t>(list.IdxBuffer.Size);
  }
}

void OverlayPainter::draw(ivec2 size) {
  if (commands_.empty() || !program_.use()) return;
  program_.set("size_px", vec2(size));
  gpu::apply({.depth_test = false,
              .depth_write = false,
              .cull = gpu::Cull::None,
              .blend = gpu::Blend::Alpha});
  font_.bind(rules::kPassTextureUnit);
  vertex_array_.vertexBuffer(0, vertices_.buffer, sizeof(ImDrawVert), vertices_.offset);
  vertex_array_.indexBuffer(indices_.buffer);
  vertex_array_.bind();
  for (const Command& command : commands_) {
    gpu::setScissor(command.scissor);
    gpu::drawElements(GL_TRIANGLES, command.index_count, GL_UNSIGNED_SHORT,
                      indices_.offset + command.first_index * sizeof(ImDrawIdx),
                      command.base_vertex);
  }
  gpu::setScissor(std::nullopt);
}

}  // namespace scree
