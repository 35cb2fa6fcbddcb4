// Function loading and the context's fixed conventions.
#include "engine/gpu/load.h"

#include <fmt/format.h>

#include "engine/gpu/bound.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/state.h"

namespace scree::gpu {
namespace {

Limits& mutableLimits() {
  static Limits instance;
  return instance;
}

int integer(GLenum name) {
  GLint value = 0;
  glGetIntegerv(name, &value);
  return value;
}

size_t bytes(GLenum name) {
  GLint64 value = 0;
  glGetInteger64v(name, &value);
  return value > 0 ? static_cast<size_t>(value) : 0;
}

bool hasExtension(std::string_view wanted) {
  for (GLint i = 0; i < integer(GL_NUM_EXTENSIONS); ++i)
    if (reinterpret_cast<const char*>(glGetStringi(GL_EXTENSIONS, static_cast<GLuint>(i))) == wanted)
      return true;
  return false;
}

}  // namespace

const Limits& limits() {
  return mutableLimits();
}

Status loadFunctions(void (*(*get)(const char*))()) {
  const int version = gladLoadGL(get);
  if (version == 0) return Error{"OpenGL: no functions found; is a context current?"};
  const int major = GLAD_VERSION_MAJOR(version), minor = GLAD_VERSION_MINOR(version);
  if (major * 10 + minor < 45) {
    const auto* renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
    return Error{fmt::format("OpenGL {}.{} on {}: 4.5 core or better is needed", major, minor,
                             renderer ? renderer : "an unnamed renderer")};
  }

  Limits& l = mutableLimits();
  l.renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  l.software = false;
  for (const char* name : {"llvmpipe", "softpipe", "SWR", "SwiftShader"})
    l.software |= l.renderer.find(name) != std::string::npos;
  l.anisotropy = hasExtension("GL_EXT_texture_filter_anisotropic");
  l.texture_size = integer(GL_MAX_TEXTURE_SIZE);
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, l.viewport_size);
  l.array_layers = integer(GL_MAX_ARRAY_TEXTURE_LAYERS);
  l.texture_units = integer(GL_MAX_COMBINED_TEXTURE_IMAGE_UNITS);
  l.color_attachments = integer(GL_MAX_COLOR_ATTACHMENTS);
  l.storage_block_bytes = bytes(GL_MAX_SHADER_STORAGE_BLOCK_SIZE);
  l.uniform_block_bytes = bytes(GL_MAX_UNIFORM_BLOCK_SIZE);
  l.storage_alignment = bytes(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT);
  l.uniform_alignment = bytes(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT);
  for (GLuint axis = 0; axis < 3; ++axis)
    glGetIntegeri_v(GL_MAX_COMPUTE_WORK_GROUP_COUNT, axis, &l.work_groups[axis]);
  l.work_group_invocations = integer(GL_MAX_COMPUTE_WORK_GROUP_INVOCATIONS);

  forgetDefaultTextures();
  forgetEmptyVertexArray();
  forgetWindowSource();
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glClearDepth(0.0);
  glEnable(GL_TEXTURE_CUBE_MAP_SEAMLESS);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  forgetState();
  if (integer(GL_CONTEXT_FLAGS) & GL_CONTEXT_FLAG_DEBUG_BIT) enableDebugOutput();
  return Done{};
}

}  // namespace scree::gpu
