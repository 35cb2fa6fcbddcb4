// Kinds of contexts, and the choice among them.
#include "engine/platform/context.h"

#include <algorithm>

#include "engine/core/log.h"
#include "engine/platform/context_makers.h"

namespace scree {
namespace {

constexpr ContextKind kMakers[] = {ContextKind::Window, ContextKind::Egl, ContextKind::OsMesa};

Result<std::unique_ptr<Context>> makeKind(ContextKind kind, const ContextDesc& desc) {
  switch (kind) {
    case ContextKind::Window:
      return makeWindowContext(desc);
    case ContextKind::Egl:
      return makeEglContext(desc);
    case ContextKind::OsMesa:
      return makeOsMesaContext(desc);
    case ContextKind::Auto:
      break;
  }
  fail("makeKind: a context cannot be of kind auto");
}

}  // namespace

std::string_view contextKindName(ContextKind kind) {
  switch (kind) {
    case ContextKind::Auto:
      return "auto";
    case ContextKind::Window:
      return "window";
    case ContextKind::Egl:
      return "egl";
    case ContextKind::OsMesa:
      return "osmesa";
  }
  return "unknown";
}

Result<ContextKind> parseContextKind(std::string_view text) {
  for (ContextKind kind :
       {ContextKind::Auto, ContextKind::Window, ContextKind::Egl, ContextKind::OsMesa})
    if (text == contextKindName(kind)) return kind;
  return Error{
      fmt::format("context is '{}'; allowed are auto, window, egl, osmesa", text.substr(0, 40))};
}

ivec2 clampedSize(ivec2 size) {
  return {std::clamp(size.x, 1, kMaxContextSize), std::clamp(size.y, 1, kMaxContextSize)};
}

Result<DriverInfo> queryDriver(GlLoader load) {
  constexpr unsigned kRenderer = 0x1F01, kVersion = 0x1F02, kMajor = 0x821B, kMinor = 0x821C;
  const auto get_string = reinterpret_cast<const unsigned char* (*)(unsigned)>(load("glGetString"));
  const auto get_integer = reinterpret_cast<void (*)(unsigned, int*)>(load("glGetIntegerv"));
  if (!get_string || !get_integer) return Error{"the driver has no glGetString"};
  const auto text = [&](unsigned name) {
    const auto* value = reinterpret_cast<const char*>(get_string(name));
    return std::string(value ? value : "unknown");
  };
  DriverInfo info{text(kRenderer), text(kVersion)};
  int major = 0, minor = 0;
  get_integer(kMajor, &major);
  get_integer(kMinor, &minor);
  if (major < 4 || (major == 4 && minor < 5))
    return Error{fmt::format("{} gives OpenGL {}.{} ({}); needed is 4.5 core", info.renderer, major,
                             minor, info.version)};
  return info;
}

Result<std::unique_ptr<Context>> makeContext(const ContextDesc& desc) {
  if (desc.size != clampedSize(desc.size))
    return Error{fmt::format("context size is {}x{}; allowed is 1 to {} each", desc.size.x,
                             desc.size.y, kMaxContextSize)};
  if (desc.kind != ContextKind::Auto) {
    Result<std::unique_ptr<Context>> made = makeKind(desc.kind, desc);
    if (made) return made;
    return Error{fmt::format("no {} context: {}", contextKindName(desc.kind), made.error())};
  }
  std::string reasons;
  for (ContextKind kind : kMakers) {
    Result<std::unique_ptr<Context>> made = makeKind(kind, desc);
    if (made) {
      if (!reasons.empty())
        logInfo("{}; using {}", reasons, contextKindName(kind));
      return made;
    }
    reasons += fmt::format("{}no {} context: {}", reasons.empty() ? "" : "; ",
                           contextKindName(kind), made.error());
  }
  return Error{std::move(reasons)};
}

}  // namespace scree
