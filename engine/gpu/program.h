// Shader programs: compiled on first use, with #include, defines, and reload while running.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/math.h"
#include "engine/core/result.h"

namespace scree::gpu {

struct ProgramDesc {
  std::string name;  // "grains.draw": label, and the name in messages
  // Files, relative to `root`; either vertex (and fragment), or compute. A vertex shader alone
  // draws depth only.
  std::string vertex;
  std::string fragment;
  std::string compute;
  std::vector<std::string> defines;  // "NAME" or "NAME VALUE"
  std::filesystem::path root;        // empty: shaderRoot()
};

// How sources are put together (see source.h): every stage begins with "#version 450 core", the
// defines, and VERTEX_STAGE, FRAGMENT_STAGE or COMPUTE_STAGE; `#include "shared/x.h"` or
// `#include "shaders/shared/x.h"` is resolved from the root, each file once per stage.
class Program {
 public:
  Program();
  explicit Program(ProgramDesc desc);
  ~Program();
  Program(Program&&) noexcept;
  Program& operator=(Program&&) noexcept;

  const std::string& name() const;

  // Makes it current; compiles it first if that has not been done. If it does not compile, the
  // error is logged once, false is returned, and draws and dispatches do nothing until another
  // program is used.
  bool use();
  // Compiles now if that has not been done; the error names file and line.
  Status compile();
  bool compiled() const;
  unsigned id() const;  // 0 if not compiled

  // Location of a uniform of the default block, looked up once a name; -1 if the shader has none
  // (setting -1 does nothing). Programs that are not compiled are compiled first.
  int uniform(std::string_view name);

  // By layout(location = n), or a location from uniform(). Valid whether or not it is current.
  void set(int location, float value);
  void set(int location, int value);
  void set(int location, unsigned value);
  void set(int location, vec2 value);
  void set(int location, vec3 value);
  void set(int location, vec4 value);
  void set(int location, ivec2 value);
  void set(int location, uvec2 value);
  void set(int location, uvec4 value);
  void set(int location, const mat3& value);
  void set(int location, const mat4& value);
  void set(int location, std::span<const vec4> values);
  template <class T>
  void set(std::string_view name, const T& value) {
    set(uniform(name), value);
  }

  // Compiles anew if a source file has changed since the last attempt. If that fails, the last
  // good program stays and the error is logged once. True if a new program is in place.
  bool reload();

 private:
  friend int reloadPrograms();
  friend int brokenPrograms();
  friend struct ProgramAccess;
  struct State;
  std::unique_ptr<State> state_;
};

// Reloads every live, compiled program whose sources changed (by time stamp and size); returns how
// many new programs are in place. Costs one stat a source file: call it about once a second.
int reloadPrograms();

// Live programs that were asked for and have never compiled: what they draw is missing.
int brokenPrograms();

}  // namespace scree::gpu
