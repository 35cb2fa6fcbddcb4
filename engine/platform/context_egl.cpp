// EGL without a surface: a hardware device where there is one, else Mesa's software renderer.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/platform/context_makers.h"

namespace scree {
namespace {

// eglTerminate ends every context of a display, so the last context of a display calls it.
int& usersOf(EGLDisplay display) {
  static std::map<EGLDisplay, int> users;
  return users[display];
}

bool hasWord(const char* list, std::string_view word) {
  if (!list) return false;
  std::string_view rest(list);
  while (!rest.empty()) {
    const size_t end = std::min(rest.find(' '), rest.size());
    if (rest.substr(0, end) == word) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

template <class Function>
Function load(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

// An initialised display; terminated with its last holder.
class Display {
 public:
  explicit Display(EGLDisplay handle) : handle_(handle) {
    if (handle_ == EGL_NO_DISPLAY) return;
    if (!eglInitialize(handle_, nullptr, nullptr))
      handle_ = EGL_NO_DISPLAY;
    else
      ++usersOf(handle_);
  }
  Display(Display&& other) noexcept : handle_(std::exchange(other.handle_, EGL_NO_DISPLAY)) {}
  Display& operator=(Display&&) = delete;
  ~Display() {
    if (handle_ != EGL_NO_DISPLAY && --usersOf(handle_) == 0) eglTerminate(handle_);
  }
  EGLDisplay handle() const { return handle_; }

 private:
  EGLDisplay handle_;
};

struct Candidate {
  std::string name;
  EGLDisplay display;
};

// Displays in the order in which they are tried: hardware devices, Mesa's surfaceless platform,
// software devices, the default display. LIBGL_ALWAYS_SOFTWARE, Mesa's own switch, leaves out
// the hardware.
std::vector<Candidate> candidates() {
  std::vector<Candidate> found;
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto platform_display = load<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  const char* software = std::getenv("LIBGL_ALWAYS_SOFTWARE");
  const bool allow_hardware = !software || !*software || std::string_view(software) == "0" ||
                              std::string_view(software) == "false";
  std::vector<Candidate> software_devices;
  if (platform_display && hasWord(extensions, "EGL_EXT_platform_device")) {
    const auto query_devices = load<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    const auto query_string = load<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    constexpr EGLint kMaxDevices = 32;  // further ones are not tried
    EGLDeviceEXT devices[kMaxDevices];
    EGLint count = 0;
    if (query_devices && query_string && query_devices(kMaxDevices, devices, &count)) {
      for (EGLint i = 0; i < count; ++i) {
        const bool is_software =
            hasWord(query_string(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software");
        if (!is_software && !allow_hardware) continue;
        Candidate candidate{fmt::format("device {}", i),
                            platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr)};
        (is_software ? software_devices : found).push_back(std::move(candidate));
      }
    }
  }
  if (platform_display && hasWord(extensions, "EGL_MESA_platform_surfaceless"))
    found.push_back({"surfaceless", platform_display(EGL_PLATFORM_SURFACELESS_MESA,
                                                     EGL_DEFAULT_DISPLAY, nullptr)});
  found.insert(found.end(), software_devices.begin(), software_devices.end());
  found.push_back({"default display", eglGetDisplay(EGL_DEFAULT_DISPLAY)});
  return found;
}

class EglContext final : public Context {
 public:
  EglContext(Display display, EGLContext handle, ivec2 size)
      : display_(std::move(display)), handle_(handle), size_(size) {}
  ~EglContext() override {
    eglBindAPI(EGL_OPENGL_API);
    if (eglGetCurrentContext() == handle_)
      eglMakeCurrent(display_.handle(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_.handle(), handle_);
    // Another context of this thread may still be current; it would be released too.
    if (eglGetCurrentContext() == EGL_NO_CONTEXT) eglReleaseThread();
  }

  ContextKind kind() const override { return ContextKind::Egl; }
  GlLoader getProcAddress() const override {
    return [](const char* name) -> GlFunction { return eglGetProcAddress(name); };
  }
  bool bind() {
    // The API is a per-thread setting that another library may have changed.
    eglBindAPI(EGL_OPENGL_API);
    return eglMakeCurrent(display_.handle(), EGL_NO_SURFACE, EGL_NO_SURFACE, handle_);
  }
  void makeCurrent() override { bind(); }
  ivec2 framebufferSize() const override { return size_; }
  void resize(ivec2 size) override { size_ = clampedSize(size); }
  void describe(const std::string& where, const DriverInfo& info) {
    description_ = fmt::format("EGL {}: {}, {}", where, info.renderer, info.version);
  }

 private:
  Display display_;
  EGLContext handle_;
  ivec2 size_;
};

Result<std::unique_ptr<Context>> makeOn(const Candidate& candidate, const ContextDesc& desc) {
  Display display(candidate.display);
  if (display.handle() == EGL_NO_DISPLAY) return Error{"cannot be initialised"};
  const char* extensions = eglQueryString(display.handle(), EGL_EXTENSIONS);
  if (!hasWord(extensions, "EGL_KHR_surfaceless_context"))
    return Error{"has no EGL_KHR_surfaceless_context"};
  if (!hasWord(extensions, "EGL_KHR_create_context")) return Error{"has no EGL_KHR_create_context"};
  if (!eglBindAPI(EGL_OPENGL_API)) return Error{"has no desktop OpenGL"};
  EGLConfig config = EGL_NO_CONFIG_KHR;
  if (!hasWord(extensions, "EGL_KHR_no_config_context")) {
    const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
    EGLint count = 0;
    if (!eglChooseConfig(display.handle(), wanted, &config, 1, &count) || count == 0)
      return Error{"has no configuration for OpenGL"};
  }
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                               4,
                               EGL_CONTEXT_MINOR_VERSION,
                               5,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                               EGL_CONTEXT_FLAGS_KHR,
                               desc.debug ? EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR : 0,
                               EGL_NONE};
  EGLContext handle = eglCreateContext(display.handle(), config, EGL_NO_CONTEXT, attributes);
  if (handle == EGL_NO_CONTEXT)
    return Error{fmt::format("gives no OpenGL 4.5 core (EGL error 0x{:x})", eglGetError())};
  auto context = std::make_unique<EglContext>(std::move(display), handle, desc.size);
  if (!context->bind())
    return Error{fmt::format("cannot make its context current (EGL error 0x{:x})", eglGetError())};
  Result<DriverInfo> info = queryDriver(context->getProcAddress());
  if (!info) return info.takeError();
  context->describe(candidate.name, *info);
  return std::unique_ptr<Context>(std::move(context));
}

}  // namespace

Result<std::unique_ptr<Context>> makeEglContext(const ContextDesc& desc) {
  std::string reasons;
  for (const Candidate& candidate : candidates()) {
    Result<std::unique_ptr<Context>> made = makeOn(candidate, desc);
    if (made) return made;
    reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", candidate.name, made.error());
  }
  return Error{std::move(reasons)};
}

}  // namespace scree
