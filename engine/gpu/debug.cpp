// GL debug output to log lines and a count.
#include "engine/gpu/debug.h"

#include <algorithm>
#include <unordered_map>

#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/gpu/gl.h"

namespace scree::gpu {
namespace {

struct Messages {
  uint64_t count = 0;
  std::string last;
  std::unordered_map<uint64_t, int> logged;  // by kind of message
};

Messages& messages() {
  static Messages instance;
  return instance;
}

void note(uint64_t kind, LogLevel level, std::string line) {
  Messages& all = messages();
  ++all.count;
  all.last = std::move(line);
  const int times = ++all.logged[kind];
  if (times <= kMaxLogsPerId) logLine(level, all.last);
  if (times == kMaxLogsPerId) logLine(level, "further messages of this kind are only counted");
}

const char* typeName(GLenum type) {
  switch (type) {
    case GL_DEBUG_TYPE_ERROR:
      return "error";
    case GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR:
      return "deprecated behaviour";
    case GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR:
      return "undefined behaviour";
    case GL_DEBUG_TYPE_PORTABILITY:
      return "portability";
    default:
      return "message";
  }
}

void GLAD_API_PTR onMessage(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                            const GLchar* text, const void*) {
  if (severity == GL_DEBUG_SEVERITY_NOTIFICATION || type == GL_DEBUG_TYPE_PERFORMANCE) return;
  // A failed compilation is an ordinary outcome with an error of its own (see program.cpp).
  if (source == GL_DEBUG_SOURCE_SHADER_COMPILER) return;
  std::string_view line =
      length < 0 ? std::string_view(text) : std::string_view(text, static_cast<size_t>(length));
  while (!line.empty() && (line.back() == '\n' || line.back() == '\0')) line.remove_suffix(1);
  const uint64_t kind = hashCombine(hashCombine(source, type), id);
  note(kind, severity == GL_DEBUG_SEVERITY_LOW ? LogLevel::Warning : LogLevel::Error,
       fmt::format("GL {} {}: {}", typeName(type), id, line));
}

}  // namespace

void enableDebugOutput() {
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(&onMessage, nullptr);
  glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_TRUE);
  glDebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DEBUG_SEVERITY_NOTIFICATION, 0, nullptr,
                        GL_FALSE);
}

uint64_t debugMessageCount() {
  return messages().count;
}
const std::string& lastDebugMessage() {
  return messages().last;
}

void reportFault(std::string_view line) {
  note(hashName(line), LogLevel::Error, std::string(line));
}

int drainErrors() {
  int count = 0;
  // A lost context returns errors for ever.
  while (count < 100) {
    const GLenum code = glGetError();
    if (code == GL_NO_ERROR) break;
    ++count;
    logError("GL error 0x{:04x}", code);
  }
  return count;
}

void labelObject(unsigned kind, unsigned id, std::string_view label) {
  if (label.empty()) return;
  constexpr size_t kMaxLabel = 255;  // GL_MAX_LABEL_LENGTH is at least 256 with the terminator
  glObjectLabel(kind, id, static_cast<GLsizei>(std::min(label.size(), kMaxLabel)), label.data());
}

DebugGroup::DebugGroup(std::string_view name) {
  glPushDebugGroup(GL_DEBUG_SOURCE_APPLICATION, 0, static_cast<GLsizei>(name.size()), name.data());
}
DebugGroup::~DebugGroup() {
  glPopDebugGroup();
}

}  // namespace scree::gpu
