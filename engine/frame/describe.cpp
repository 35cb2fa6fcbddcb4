// The text of --print-frame.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "engine/frame/frame_state.h"
#include "engine/gpu/format.h"

namespace scree {

std::string_view accessName(Access access) {
  switch (access) {
    case Access::Clear:
      return "clear";
    case Access::Color:
      return "color";
    case Access::Depth:
      return "depth";
    case Access::DepthTest:
      return "depth test";
    case Access::Sampled:
      return "sampled";
    case Access::StorageRead:
      return "storage";
    case Access::StorageWrite:
      return "storage";
    case Access::Indirect:
      return "indirect";
    case Access::Vertex:
      return "vertex";
    case Access::Uniform:
      return "uniform";
  }
  return "";
}

namespace {

std::string listUses(const FramePass& pass, const std::vector<FrameResource>& resources,
                     bool written) {
  std::string list;
  for (const FrameUse& use : pass.uses)
    if (isWrite(use.access) == written)
      list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", resources[use.resource].name,
                          accessName(use.access));
  return list;
}

}  // namespace

std::string Frame::describe() const {
  const State& s = *state_;
  size_t width = 0, why_width = 0;
  for (const PassReport& report : s.reports) {
    width = std::max(width, report.name.size());
    if (!report.on) why_width = std::max(why_width, report.why.size());
  }
  std::string text;
  auto out = std::back_inserter(text);
  const auto on =
      std::count_if(s.reports.begin(), s.reports.end(), [](const auto& r) { return r.on; });
  fmt::format_to(out, "frame {}x{}: {} of {} passes on\n", s.size.x, s.size.y, on,
                 s.reports.size());
  for (size_t i = 0; i < s.passes.size(); ++i) {
    const PassReport& report = s.reports[i];
    if (i == 0 || report.stage != s.reports[i - 1].stage)
      fmt::format_to(out, "{}\n", stageName(report.stage));
    const std::string reads = listUses(*s.passes[i], s.resources, false);
    fmt::format_to(out, "  {:<3}  {:<{}}  {:<{}}  ", report.on ? "on" : "off", report.name, width,
                   report.on ? "" : report.why, why_width);
    if (!reads.empty()) fmt::format_to(out, "{} ", reads);
    fmt::format_to(out, "-> {}\n", listUses(*s.passes[i], s.resources, true));
  }
  size_t name_width = 0;
  for (const FrameResource& r : s.resources)
    if (r.texture) name_width = std::max(name_width, r.name.size());
  if (name_width > 0) fmt::format_to(out, "targets\n");
  for (const FrameResource& r : s.resources) {
    if (!r.texture) continue;
    const ivec2 size = r.texture.size();
    fmt::format_to(out, "  {:<{}}  {} {}x{}", r.name, name_width,
                   gpu::formatInfo(r.desc.format).name, size.x, size.y);
    if (r.desc.layers > 1) fmt::format_to(out, "x{}", r.desc.layers);
    fmt::format_to(
        out, ", {} KiB{}\n", (r.texture.bytes() + 1023) / 1024,
        s.activity.hasContent(static_cast<size_t>(&r - s.resources.data())) ? "" : ", empty");
  }
  return text;
}

}  // namespace scree
