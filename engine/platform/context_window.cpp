// A GLFW window: context, keyboard, mouse and gamepads.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/platform/context_makers.h"
#include "engine/platform/gamepads.h"
#include "engine/platform/input.h"

namespace scree {
namespace {

struct CodedSource {
  Source source;
  SourceGroup group;
  int code;
};
constexpr CodedSource kCoded[] = {
#define SCREE_SOURCE(identifier, name, group, code) {Source::identifier, SourceGroup::group, code},
#include "engine/platform/input_sources.h"
};

Source sourceOf(SourceGroup group, int code) {
  for (const CodedSource& coded : kCoded)
    if (coded.group == group && coded.code == code) return coded.source;
  return Source::Count;
}

// What GLFW reported last; it reports nothing on the terminal by itself.
std::string& lastGlfwError() {
  static std::string text;
  return text;
}

void noteError(int, const char* description) {
  lastGlfwError() = description;
  std::replace(lastGlfwError().begin(), lastGlfwError().end(), '\n', ' ');
}

std::string glfwReason(const char* fallback) {
  return lastGlfwError().empty() ? fallback : lastGlfwError();
}

// GLFW is one library for the process: begun with the first window, ended with the last.
class Library {
 public:
  Library() {
    lastGlfwError().clear();
    glfwSetErrorCallback(noteError);
    ready_ = users() > 0 || glfwInit() == GLFW_TRUE;
    if (ready_) ++users();
  }
  Library(Library&& other) noexcept : ready_(std::exchange(other.ready_, false)) {}
  Library& operator=(Library&&) = delete;
  ~Library() {
    if (ready_ && --users() == 0) glfwTerminate();
  }
  bool ready() const { return ready_; }

 private:
  static int& users() {
    static int count = 0;
    return count;
  }
  bool ready_;
};

class WindowContext final : public Context {
 public:
  WindowContext(Library library, GLFWwindow* window)
      : library_(std::move(library)), window_(window) {
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int) {
      if (action != GLFW_REPEAT)
        self(w).note(sourceOf(SourceGroup::Key, key), action == GLFW_PRESS);
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int) {
      self(w).note(sourceOf(SourceGroup::MouseButton, button), action == GLFW_PRESS);
    });
    glfwSetScrollCallback(window_, [](GLFWwindow* w, double, double y) {
      self(w).note(Source::MouseWheel, static_cast<float>(y));
    });
    glfwSetCursorPosCallback(window_,
                             [](GLFWwindow* w, double x, double y) { self(w).moved(x, y); });
    glfwSetCursorEnterCallback(window_, [](GLFWwindow* w, int) { self(w).cursor_known_ = false; });
  }
  ~WindowContext() override {
    if (glfwGetCurrentContext() == window_) glfwMakeContextCurrent(nullptr);
    glfwDestroyWindow(window_);
  }

  ContextKind kind() const override { return ContextKind::Window; }
  GlLoader getProcAddress() const override {
    return [](const char* name) -> GlFunction { return glfwGetProcAddress(name); };
  }
  void makeCurrent() override { glfwMakeContextCurrent(window_); }
  bool presents() const override { return true; }
  void swap() override { glfwSwapBuffers(window_); }
  ivec2 framebufferSize() const override {
    ivec2 size;
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return clampedSize(size);
  }
  bool minimised() const override {
    return glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE;
  }
  bool shouldClose() const override { return glfwWindowShouldClose(window_) == GLFW_TRUE; }
  void setTitle(const std::string& title) override { glfwSetWindowTitle(window_, title.c_str()); }
  void setVsync(bool on) override { glfwSwapInterval(on ? 1 : 0); }
  void resize(ivec2 size) override {
    size = clampedSize(size);
    glfwSetWindowSize(window_, size.x, size.y);
  }
  void captureCursor(bool on) override {
    glfwSetInputMode(window_, GLFW_CURSOR, on ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
    if (glfwRawMouseMotionSupported()) glfwSetInputMode(window_, GLFW_RAW_MOUSE_MOTION, on);
    cursor_known_ = false;
  }
  void poll(RawInput& input) override {
    glfwPollEvents();
    input.events.insert(input.events.end(), pending_.begin(), pending_.end());
    pending_.clear();
    gamepads_.poll(glfwGetGamepadState, input.events);
  }
  void describe(const DriverInfo& info) {
    description_ = fmt::format("window: {}, {}", info.renderer, info.version);
  }

 private:
  static WindowContext& self(GLFWwindow* window) {
    return *static_cast<WindowContext*>(glfwGetWindowUserPointer(window));
  }

  void note(Source source, float value) {
    if (source != Source::Count) pending_.push_back({source, value});
  }

  void moved(double x, double y) {
    if (cursor_known_) {
      if (x != cursor_x_) note(Source::MouseX, static_cast<float>(x - cursor_x_));
      if (y != cursor_y_) note(Source::MouseY, static_cast<float>(y - cursor_y_));
    }
    cursor_known_ = true;
    cursor_x_ = x;
    cursor_y_ = y;
  }

  Library library_;
  GLFWwindow* window_;
  std::vector<RawEvent> pending_;
  Gamepads gamepads_;
  bool cursor_known_ = false;
  double cursor_x_ = 0, cursor_y_ = 0;
};

}  // namespace

Result<std::unique_ptr<Context>> makeWindowContext(const ContextDesc& desc) {
  Library library;
  if (!library.ready()) return Error{glfwReason("GLFW cannot be initialised")};
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, desc.debug ? GLFW_TRUE : GLFW_FALSE);
  // The frame is drawn into targets of its own; the window only receives the result.
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  GLFWwindow* window =
      glfwCreateWindow(desc.size.x, desc.size.y, desc.title.c_str(), nullptr, nullptr);
  if (!window) return Error{glfwReason("GLFW cannot create the window")};
  auto context = std::make_unique<WindowContext>(std::move(library), window);
  context->makeCurrent();
  Result<DriverInfo> info = queryDriver(context->getProcAddress());
  if (!info) return info.takeError();
  context->describe(*info);
  context->setVsync(desc.vsync);
  return std::unique_ptr<Context>(std::move(context));
}

}  // namespace scree
