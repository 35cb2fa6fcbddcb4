// OSMesa: Mesa's software renderer in this process, without display, driver or EGL.
#include "engine/platform/context_makers.h"

#if SCREE_HAS_OSMESA
#include <GL/osmesa.h>
#include <fmt/format.h>

#include <vector>
#endif

namespace scree {

#if SCREE_HAS_OSMESA
namespace {

// The buffer behind the default framebuffer, which nobody reads: everything is drawn into
// framebuffer objects.
constexpr int kBackingSize = 16;

class OsMesaContext final : public Context {
 public:
  OsMesaContext(OSMesaContext handle, ivec2 size)
      : handle_(handle), size_(size), backing_(kBackingSize * kBackingSize * 4) {}
  ~OsMesaContext() override {
    if (OSMesaGetCurrentContext() == handle_) OSMesaMakeCurrent(nullptr, nullptr, 0, 0, 0);
    OSMesaDestroyContext(handle_);
  }

  ContextKind kind() const override { return ContextKind::OsMesa; }
  GlLoader getProcAddress() const override {
    return [](const char* name) -> GlFunction { return OSMesaGetProcAddress(name); };
  }
  bool bind() {
    return OSMesaMakeCurrent(handle_, backing_.data(), kUnsignedByte, kBackingSize, kBackingSize);
  }
  void makeCurrent() override { bind(); }
  ivec2 framebufferSize() const override { return size_; }
  void resize(ivec2 size) override { size_ = clampedSize(size); }
  void describe(const DriverInfo& info) {
    description_ = fmt::format("OSMesa: {}, {}", info.renderer, info.version);
  }

 private:
  static constexpr unsigned kUnsignedByte = 0x1401;
  OSMesaContext handle_;
  ivec2 size_;
  std::vector<unsigned char> backing_;
};

}  // namespace

Result<std::unique_ptr<Context>> makeOsMesaContext(const ContextDesc& desc) {
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            4,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            5,
                            0};
  OSMesaContext handle = OSMesaCreateContextAttribs(attributes, nullptr);
  if (!handle) return Error{"OSMesa gives no OpenGL 4.5 core"};
  auto context = std::make_unique<OsMesaContext>(handle, desc.size);
  if (!context->bind()) return Error{"OSMesaMakeCurrent failed"};
  Result<DriverInfo> info = queryDriver(context->getProcAddress());
  if (!info) return info.takeError();
  context->describe(*info);
  return std::unique_ptr<Context>(std::move(context));
}

#else

Result<std::unique_ptr<Context>> makeOsMesaContext(const ContextDesc&) {
  return Error{"this build has no OSMesa (CMake option SCREE_OSMESA)"};
}

#endif

}  // namespace scree
