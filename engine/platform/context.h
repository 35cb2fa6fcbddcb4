// An OpenGL 4.5 core context: a window (GLFW), off screen (EGL surfaceless), or in memory (OSMesa).
//
// Everything is rendered into framebuffer objects. Only a window has a default framebuffer worth
// writing to: presents() says so. An object must be used, and destroyed, on the thread that made
// it.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "engine/core/math.h"
#include "engine/core/result.h"

namespace scree {

struct RawInput;

enum class ContextKind {
  Auto,    // the first that works of Window, Egl, OsMesa
  Window,  // GLFW; needs a display
  Egl,     // no display; a GPU where there is one, else software
  OsMesa,  // no display, no driver: Mesa's software renderer in this process
};

// "auto", "window", "egl" or "osmesa".
std::string_view contextKindName(ContextKind kind);
// The inverse; the error names the text and what is allowed.
Result<ContextKind> parseContextKind(std::string_view text);

struct ContextDesc {
  ContextKind kind = ContextKind::Auto;
  ivec2 size{1280, 720};  // pixels, 1 to kMaxContextSize each
  std::string title = "Scree";
  bool debug = false;  // a debug context, where the maker knows one
  bool vsync = true;   // of a window
};
inline constexpr int kMaxContextSize = 16384;

// The same type as glad's GLADloadfunc.
using GlFunction = void (*)();
using GlLoader = GlFunction (*)(const char* name);

class Context {
 public:
  virtual ~Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  virtual ContextKind kind() const = 0;  // never Auto
  // Finds GL functions of this context's driver; each kind has its own.
  virtual GlLoader getProcAddress() const = 0;
  virtual void makeCurrent() = 0;

  // True if swap() shows the default framebuffer to somebody: a window.
  virtual bool presents() const { return false; }
  virtual void swap() {}
  // A window's current size, which the user may change, at least 1x1; otherwise the size asked for.
  virtual ivec2 framebufferSize() const = 0;
  // True while a window is minimised, so that nobody sees a frame.
  virtual bool minimised() const { return false; }
  virtual bool shouldClose() const { return false; }
  virtual void setTitle(const std::string&) {}
  virtual void setVsync(bool) {}
  virtual void resize(ivec2 size) = 0;
  // Hides the cursor and reports its motion without bounds (mouse look).
  virtual void captureCursor(bool) {}
  // Appends what happened at keyboard, mouse and gamepads since the last call; never clears.
  virtual void poll(RawInput&) {}

  // "EGL: llvmpipe (LLVM 15.0.6, 256 bits), 4.5 (Core Profile) Mesa 22.3.6", one line.
  const std::string& description() const { return description_; }

 protected:
  Context() = default;
  std::string description_;
};

// Makes a context and makes it current. The error is one line that says why there is none. Auto
// writes one log line with the reasons when it falls back.
Result<std::unique_ptr<Context>> makeContext(const ContextDesc& desc);

}  // namespace scree
