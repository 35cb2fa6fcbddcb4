// What overlay registers: one system that lays out and uploads, one pass that draws.
#include "modules/overlay/overlay.h"

#include "engine/app/app.h"
#include "modules/overlay/painter.h"

namespace scree {
namespace {

bool isShown(World& world) {
  // In truth mode the image is complete with the last sample.
  const FrameInput& input = world.singleton<const FrameInput>();
  if (input.sample + 1 < input.sample_count) return false;
  return !world.singleton<const OverlayText>().empty() || world.singleton<const Inspector>().open;
}

}  // namespace

TextLine& OverlayText::add(std::string_view text, Anchor anchor, float size, vec4 color) {
  if (count_ == lines_.size()) lines_.emplace_back();
  TextLine& line = lines_[count_++];
  line.text = text;
  line.anchor = anchor;
  line.size = size;
  line.color = color;
  line.backing = TextLine().backing;
  return line;
}

void addOverlay(App& app) {
  World& world = app.world();
  world.singleton<OverlayText>();
  world.singleton<Inspector>();
  const auto painter = std::make_shared<OverlayPainter>();
  const auto shown = [&world] { return isShown(world); };
  app.addSystem({.name = "overlay.layout",
                 .phase = Phase::Prepare,
                 .needs = shown,
                 .run = [&app, painter](World& w) {
                   painter->prepare(w, app.frame(), app.schedule(),
                                    w.singleton<const FrameInput>().size);
                 }});
  app.addPass({.name = "overlay.draw",
               .stage = Stage::Present,
               .needs_text = "text, or the inspector",
               .needs = shown,
               .uses = {{std::string(Frame::kOutput), Access::Color}},
               .run = [painter](PassContext& context) { painter->draw(context.input.size); }});
}

}  // namespace scree
