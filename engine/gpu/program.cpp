// Compiling, linking, reflecting and reloading programs.
#include "engine/gpu/program.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/core/file.h"
#include "engine/core/log.h"
#include "engine/gpu/bound.h"
#include "engine/gpu/counters.h"
#include "engine/gpu/debug.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/source.h"
#include "engine/platform/file_watch.h"

namespace scree::gpu {
namespace {

// A linked program and what was found out about it.
struct Linked {
  GLuint id = 0;
  std::vector<SamplerSlot> samplers;

  Linked() = default;
  Linked(Linked&& other) noexcept { *this = std::move(other); }
  Linked& operator=(Linked&& other) noexcept {
    std::swap(id, other.id);
    std::swap(samplers, other.samplers);
    return *this;
  }
  ~Linked() {
    if (id == 0) return;
    if (bound().program == id) useProgram(0, nullptr, nullptr);
    glDeleteProgram(id);
  }
};

std::string shaderLog(GLuint shader) {
  GLint length = 0;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
  glGetShaderInfoLog(shader, length, nullptr, log.data());
  return log;
}

std::string programLog(GLuint program) {
  GLint length = 0;
  glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<size_t>(std::max(length, 1)), '\0');
  glGetProgramInfoLog(program, length, nullptr, log.data());
  while (!log.empty() && (log.back() == '\0' || log.back() == '\n')) log.pop_back();
  return log;
}

// How a sampler type reads its texture; nothing for types that the engine's textures never have.
std::optional<SamplerSlot> describeSampler(GLenum type) {
  auto slot = [](TextureKind kind, Component component) {
    SamplerSlot s;
    s.kind = kind;
    s.component = component;
    return s;
  };
  switch (type) {
    case GL_SAMPLER_2D:
    case GL_SAMPLER_2D_SHADOW:
      return slot(TextureKind::Flat, Component::Float);
    case GL_SAMPLER_2D_ARRAY:
    case GL_SAMPLER_2D_ARRAY_SHADOW:
      return slot(TextureKind::Array, Component::Float);
    case GL_SAMPLER_CUBE:
    case GL_SAMPLER_CUBE_SHADOW:
      return slot(TextureKind::Cube, Component::Float);
    case GL_SAMPLER_3D:
      return slot(TextureKind::Volume, Component::Float);
    case GL_INT_SAMPLER_2D:
      return slot(TextureKind::Flat, Component::Int);
    case GL_INT_SAMPLER_2D_ARRAY:
      return slot(TextureKind::Array, Component::Int);
    case GL_INT_SAMPLER_CUBE:
      return slot(TextureKind::Cube, Component::Int);
    case GL_INT_SAMPLER_3D:
      return slot(TextureKind::Volume, Component::Int);
    case GL_UNSIGNED_INT_SAMPLER_2D:
      return slot(TextureKind::Flat, Component::Uint);
    case GL_UNSIGNED_INT_SAMPLER_2D_ARRAY:
      return slot(TextureKind::Array, Component::Uint);
    case GL_UNSIGNED_INT_SAMPLER_CUBE:
      return slot(TextureKind::Cube, Component::Uint);
    case GL_UNSIGNED_INT_SAMPLER_3D:
      return slot(TextureKind::Volume, Component::Uint);
    default:
      return std::nullopt;
  }
}

// The samplers of a program by unit. Two of different types on one unit are refused: GL allows no
// draw with them.
Status findSamplers(GLuint program, std::vector<SamplerSlot>& samplers) {
  GLint count = 0;
  glGetProgramiv(program, GL_ACTIVE_UNIFORMS, &count);
  for (GLint i = 0; i < count; ++i) {
    char name[256];
    GLsizei length = 0;
    GLint size = 0;
    GLenum type = 0;
    glGetActiveUniform(program, static_cast<GLuint>(i), sizeof name, &length, &size, &type, name);
    std::optional<SamplerSlot> slot = describeSampler(type);
    if (!slot) continue;
    const GLint location = glGetUniformLocation(program, name);
    for (GLint element = 0; location >= 0 && element < size; ++element) {
      GLint unit = 0;
      glGetUniformiv(program, location + element, &unit);
      if (unit < 0 || unit >= static_cast<GLint>(kTextureUnits))
        return Error{
            fmt::format("sampler '{}': unit {}; at most {} are used", name, unit, kTextureUnits)};
      slot->name = name;
      slot->unit = static_cast<unsigned>(unit);
      for (const SamplerSlot& other : samplers)
        if (other.unit == slot->unit &&
            (other.kind != slot->kind || other.component != slot->component))
          return Error{
              fmt::format("samplers '{}' and '{}' of different types share unit {}; give each "
                          "a layout(binding)",
                          other.name, slot->name, unit)};
      samplers.push_back(*slot);
    }
  }
  return Done{};
}

struct Stage {
  const std::string* path;
  ShaderStage stage;
  GLenum type;
};

// `read` gets every file that was read or missed.
Result<Linked> link(const ProgramDesc& desc, std::vector<std::string>& read) {
  const Stage stages[] = {{&desc.vertex, ShaderStage::Vertex, GL_VERTEX_SHADER},
                          {&desc.fragment, ShaderStage::Fragment, GL_FRAGMENT_SHADER},
                          {&desc.compute, ShaderStage::Compute, GL_COMPUTE_SHADER}};
  if (desc.compute.empty() == desc.vertex.empty() ||
      (!desc.compute.empty() && !desc.fragment.empty()))
    return Error{
        "a program has either a compute shader, or a vertex shader and perhaps a fragment shader"};

  const std::filesystem::path root = desc.root.empty() ? shaderRoot() : desc.root;
  Linked linked;
  linked.id = glCreateProgram();
  labelObject(GL_PROGRAM, linked.id, desc.name);
  for (const Stage& stage : stages) {
    if (stage.path->empty()) continue;
    Result<ShaderSource> source =
        assembleShader(root, *stage.path, stage.stage, desc.defines, &read);
    if (!source.ok()) return source.takeError();
    const GLuint shader = glCreateShader(stage.type);
    labelObject(GL_SHADER, shader, *stage.path);
    const char* text = source->text.data();
    const GLint length = static_cast<GLint>(source->text.size());
    glShaderSource(shader, 1, &text, &length);
    glCompileShader(shader);
    GLint good = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    std::string log = good ? std::string() : nameFilesInLog(shaderLog(shader), source->files);
    if (good) glAttachShader(linked.id, shader);
    glDeleteShader(shader);  // lives on while it is attached
    if (!good) return Error{std::move(log)};
  }
  glLinkProgram(linked.id);
  GLint good = 0;
  glGetProgramiv(linked.id, GL_LINK_STATUS, &good);
  if (!good) return Error{fmt::format("linking: {}", programLog(linked.id))};
  if (Status found = findSamplers(linked.id, linked.samplers); !found.ok())
    return found.takeError();
  ++counters().programs;
  return linked;
}

}  // namespace

struct Program::State {
  ProgramDesc desc;
  Linked linked;
  bool attempted = false;
  std::string error;  // of the last attempt; empty if it was good
  FileWatch watch;
  std::vector<std::pair<std::string, int>> uniforms;

  // Compiles; on an error the linked program stays as it was.
  Status attempt() {
    attempted = true;
    std::vector<std::string> read;
    Result<Linked> result = link(desc, read);
    const std::filesystem::path root = desc.root.empty() ? shaderRoot() : desc.root;
    for (const std::string& file : read) watch.add(root / file);
    if (!result.ok()) {
      error = fmt::format("program '{}': {}", desc.name, result.error());
      logError("{}", error);
      return Error{error};
    }
    linked = std::move(*result);
    uniforms.clear();
    error.clear();
    return Done{};
  }
};

// All programs, for reloadPrograms(). Only the GL thread makes and destroys programs.
struct ProgramAccess {
  static std::vector<Program::State*>& live() {
    static auto* instance = new std::vector<Program::State*>;
    return *instance;
  }
  static bool reload(Program::State& state);
};

Program::Program() = default;

Program::Program(ProgramDesc desc) : state_(std::make_unique<State>()) {
  state_->desc = std::move(desc);
  ProgramAccess::live().push_back(state_.get());
}

Program::~Program() {
  if (state_) std::erase(ProgramAccess::live(), state_.get());
}

Program::Program(Program&& other) noexcept = default;

Program& Program::operator=(Program&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

const std::string& Program::name() const {
  static const std::string kNone = "(none)";
  return state_ ? state_->desc.name : kNone;
}

Status Program::compile() {
  if (!state_) return Error{"an empty program cannot be compiled"};
  if (!state_->attempted) return state_->attempt();
  if (!state_->error.empty()) return Error{state_->error};
  return Done{};
}

bool Program::compiled() const {
  return id() != 0;
}
unsigned Program::id() const {
  return state_ ? state_->linked.id : 0;
}

bool Program::use() {
  if (state_ && !state_->attempted) (void)state_->attempt();
  if (id() == 0) {
    useProgram(0, nullptr, nullptr);
    return false;
  }
  useProgram(id(), &state_->desc.name, &state_->linked.samplers);
  return true;
}

int Program::uniform(std::string_view name) {
  if (!state_) return -1;
  if (!state_->attempted) (void)state_->attempt();
  if (id() == 0) return -1;
  for (const auto& [known, location] : state_->uniforms)
    if (known == name) return location;
  std::string key(name);
  const int location = glGetUniformLocation(id(), key.c_str());
  state_->uniforms.emplace_back(std::move(key), location);
  return location;
}

// Locations in range of a program that did not compile are dropped here; GL ignores -1 itself.
#define SCREE_SET(PARAMETER, CALL)                             \
  void Program::set(int location, PARAMETER) {                 \
    if (state_ && !state_->attempted) (void)state_->attempt(); \
    if (id() == 0 || location < 0) return;                     \
    CALL;                                                      \
  }
SCREE_SET(float value, glProgramUniform1f(id(), location, value))
SCREE_SET(int value, glProgramUniform1i(id(), location, value))
SCREE_SET(unsigned value, glProgramUniform1ui(id(), location, value))
SCREE_SET(vec2 value, glProgramUniform2fv(id(), location, 1, &value.x))
SCREE_SET(vec3 value, glProgramUniform3fv(id(), location, 1, &value.x))
SCREE_SET(vec4 value, glProgramUniform4fv(id(), location, 1, &value.x))
SCREE_SET(ivec2 value, glProgramUniform2iv(id(), location, 1, &value.x))
SCREE_SET(uvec2 value, glProgramUniform2uiv(id(), location, 1, &value.x))
SCREE_SET(uvec4 value, glProgramUniform4uiv(id(), location, 1, &value.x))
SCREE_SET(const mat3& value, glProgramUniformMatrix3fv(id(), location, 1, GL_FALSE, &value[0].x))
SCREE_SET(const mat4& value, glProgramUniformMatrix4fv(id(), location, 1, GL_FALSE, &value[0].x))
SCREE_SET(std::span<const vec4> values,
          glProgramUniform4fv(id(), location, static_cast<GLsizei>(values.size()),
                              &values.data()->x))
#undef SCREE_SET

bool ProgramAccess::reload(Program::State& state) {
  if (!state.attempted || state.watch.poll().empty()) return false;
  const bool replaced = state.attempt().ok();
  counters().reloads += replaced;
  return replaced;
}

bool Program::reload() {
  return state_ && ProgramAccess::reload(*state_);
}

int brokenPrograms() {
  const auto& live = ProgramAccess::live();
  return static_cast<int>(std::count_if(live.begin(), live.end(), [](const Program::State* state) {
    return state->attempted && state->linked.id == 0;
  }));
}

int reloadPrograms() {
  int replaced = 0;
  for (Program::State* state : ProgramAccess::live())
    if (ProgramAccess::reload(*state)) {
      ++replaced;
      logInfo("program '{}' reloaded", state->desc.name);
    }
  return replaced;
}

}  // namespace scree::gpu
