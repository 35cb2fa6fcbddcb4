// Shader programs: errors that name the included file and line, compilation on first use, reload.
#include <string>
#include <vector>

#include "engine/gpu/counters.h"
#include "engine/gpu/draw.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/program.h"
#include "engine/gpu/readback.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/gl_shader_folder.h"

namespace scree::gpu {
namespace {

class ProgramTest : public test::GlTest {
 protected:
  Program compute(std::vector<std::string> defines = {}) {
    return Program({.name = "test.value",
                    .compute = "value.comp",
                    .defines = std::move(defines),
                    .root = folder_.path()});
  }
  // Runs a program that stores one number to b[0]; ~0u if it stored nothing.
  uint32_t valueOf(Program& program) {
    Buffer buffer("b", 16);
    buffer.fill(~0u);
    buffer.bindStorage(0);
    program.use();
    dispatch(1);
    return readBuffer<uint32_t>(buffer, 1)[0];
  }
  void writeValue(std::string_view expression) {
    folder_.write(
        "value.comp",
        "#include \"lib/out.glsl\"\nlayout(local_size_x = 1) in;\nvoid main() {\n  store(" +
            std::string(expression) + ");\n}\n");
    folder_.write(
        "lib/out.glsl",
        "layout(std430, binding = 0) buffer B { uint b[]; };\nvoid store(uint v) { b[0] = v; }\n");
  }
  test::ShaderFolder folder_;
};

TEST_F(ProgramTest, NothingIsReadOrCompiledBeforeFirstUse) {
  const Counters before = counters();
  Program program = compute();  // the file does not even exist
  EXPECT_FALSE(program.compiled());
  EXPECT_EQ((counters() - before).programs, 0u);
  writeValue("7u");
  EXPECT_EQ(valueOf(program), 7u);
  EXPECT_EQ((counters() - before).programs, 1u);
  EXPECT_EQ(valueOf(program), 7u);
  EXPECT_EQ((counters() - before).programs, 1u);
}

TEST_F(ProgramTest, ErrorsNameTheIncludedFileAndLine) {
  folder_.write("value.comp",
                "#include \"lib/a.glsl\"\nlayout(local_size_x = 1) in;\nvoid main() { f(); }\n");
  folder_.write("lib/a.glsl", "\n#include \"lib/b.glsl\"\nvoid f() {\n  g(undeclared_here);\n}\n");
  folder_.write("lib/b.glsl", "void g(float x) {}\n");
  Program in_include = compute();
  Status status = in_include.compile();
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().rfind("program 'test.value': lib/a.glsl:4: ", 0), 0u) << status.error();
  EXPECT_NE(status.error().find("undeclared_here"), std::string::npos);

  folder_.write("lib/a.glsl", "\n#include \"lib/b.glsl\"\nvoid f() { g(1.0); }\n");
  folder_.write("lib/b.glsl", "\n\n\nvoid g(float x) { wrong_in_b; }\n");
  Program deeper = compute();
  status = deeper.compile();
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().rfind("program 'test.value': lib/b.glsl:4: ", 0), 0u) << status.error();

  folder_.write("lib/b.glsl", "void g(float x) {}\n");
  folder_.write(
      "value.comp",
      "#include \"lib/a.glsl\"\nlayout(local_size_x = 1) in;\nvoid main() { f(); oops; }\n");
  Program outer = compute();
  status = outer.compile();
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().rfind("program 'test.value': value.comp:3: ", 0), 0u) << status.error();
}

TEST_F(ProgramTest, BadIncludesAndLinksAreErrors) {
  folder_.write("value.comp", "\n#include \"absent.glsl\"\nvoid main() {}\n");
  EXPECT_NE(compute().compile().error().find("value.comp:2: #include \"absent.glsl\""),
            std::string::npos);
  folder_.write("value.comp", "#include \"lib/x.glsl\"\nvoid main() {}\n");
  folder_.write("lib/x.glsl", "#include \"value.comp\"\n");
  EXPECT_NE(compute().compile().error().find("a cycle: value.comp -> lib/x.glsl -> value.comp"),
            std::string::npos);

  folder_.write("a.vert",
                "out vec3 color; void main() { color = vec3(1); gl_Position = vec4(0); }");
  folder_.write("a.frag",
                "in vec4 color; layout(location=0) out vec4 o; void main() { o = color; }");
  Program mismatch({.name = "m", .vertex = "a.vert", .fragment = "a.frag", .root = folder_.path()});
  EXPECT_NE(mismatch.compile().error().find("linking"), std::string::npos);

  Program both({.name = "m", .vertex = "a.vert", .compute = "value.comp", .root = folder_.path()});
  EXPECT_FALSE(both.compile().ok());
  EXPECT_FALSE(Program().compile().ok());
  EXPECT_FALSE(Program().use());
}

TEST_F(ProgramTest, SamplersOfTwoTypesOnOneUnitAreRefused) {
  folder_.write("value.comp",
                "layout(local_size_x = 1) in; layout(std430, binding = 0) buffer B { uint b[]; };\n"
                "uniform sampler2D first; uniform usampler2D second;\n"
                "void main() { b[0] = texelFetch(second, ivec2(0), 0).x + uint(texelFetch(first, "
                "ivec2(0), 0).x); }");
  const Status status = compute().compile();
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().find("share unit 0"), std::string::npos) << status.error();
}

TEST_F(ProgramTest, DefinesReachEveryStage) {
  writeValue("VALUE + uint(COMPUTE_STAGE)");
  Program a = compute({"VALUE 41u"}), b = compute({"VALUE 99u"});
  EXPECT_EQ(valueOf(a), 42u);
  EXPECT_EQ(valueOf(b), 100u);
}

TEST_F(ProgramTest, BrokenProgramDrawsNothing) {
  writeValue("not_declared");
  Program broken = compute();
  EXPECT_FALSE(broken.use());
  const Counters before = counters();
  EXPECT_EQ(valueOf(broken), ~0u);
  broken.set(0, 1.0f);
  EXPECT_EQ(broken.uniform("x"), -1);
  EXPECT_EQ((counters() - before).dispatches, 0u);
  EXPECT_EQ((counters() - before).programs, 0u);
}

TEST_F(ProgramTest, ReloadKeepsTheLastGoodProgramAndRecovers) {
  writeValue("1u");
  Program program = compute();
  EXPECT_FALSE(program.reload());  // not compiled yet: nothing to reload
  EXPECT_EQ(valueOf(program), 1u);
  EXPECT_EQ(reloadPrograms(), 0);
  const unsigned first = program.id();

  folder_.write("lib/out.glsl",
                "layout(std430, binding = 0) buffer B { uint b[]; };\nvoid store(uint v) { b[0] = "
                "v + 10u; }\n");
  EXPECT_EQ(reloadPrograms(), 1);
  EXPECT_EQ(valueOf(program), 11u);

  folder_.write("lib/out.glsl", "broken\n");
  const Counters before = counters();
  EXPECT_EQ(reloadPrograms(), 0);
  EXPECT_EQ(valueOf(program), 11u);
  EXPECT_TRUE(program.compiled());
  EXPECT_FALSE(program.compile().ok());
  // Not tried again, nor reported again, until a file changes.
  EXPECT_EQ(reloadPrograms(), 0);
  EXPECT_EQ((counters() - before).programs, 0u);

  // An include that does not exist yet is watched, too.
  folder_.write("lib/out.glsl", "#include \"lib/new.glsl\"\n");
  EXPECT_FALSE(program.reload());
  EXPECT_EQ(valueOf(program), 11u);
  folder_.write("lib/new.glsl",
                "layout(std430, binding = 0) buffer B { uint b[]; };\nvoid store(uint v) { b[0] = "
                "v + 20u; }\n");
  EXPECT_TRUE(program.reload());
  EXPECT_EQ(valueOf(program), 21u);
  EXPECT_NE(first, 0u);
}

TEST_F(ProgramTest, AProgramThatNeverCompiledRecovers) {
  writeValue("nonsense");
  Program program = compute();
  EXPECT_FALSE(program.use());
  EXPECT_FALSE(program.use());
  writeValue("5u");
  EXPECT_FALSE(program.use());
  EXPECT_EQ(reloadPrograms(), 1);
  EXPECT_EQ(valueOf(program), 5u);
}

TEST_F(ProgramTest, UniformLocationsSurviveReload) {
  folder_.write("value.comp",
                "layout(local_size_x = 1) in; layout(std430, binding = 0) buffer B { uint b[]; };\n"
                "uniform uint a; uniform vec4 c[2];\nvoid main() { b[0] = a + uint(c[1].y); }\n");
  Program program = compute();
  program.set("a", 4u);
  const std::vector<vec4> values = {vec4(0), vec4(0, 3, 0, 0)};
  program.set("c[0]", std::span<const vec4>(values));
  program.set("no_such_uniform", 1.0f);
  EXPECT_EQ(valueOf(program), 7u);
  folder_.write("value.comp",
                "layout(local_size_x = 1) in; layout(std430, binding = 0) buffer B { uint b[]; };\n"
                "uniform float z; uniform uint a;\nvoid main() { b[0] = a * 2u + uint(z); }\n");
  EXPECT_TRUE(program.reload());
  program.set("a", 4u);
  program.set("z", 0.0f);
  EXPECT_EQ(valueOf(program), 8u);
}

TEST_F(ProgramTest, EverySetterSetsItsType) {
  folder_.write(
      "value.comp",
      "layout(local_size_x = 1) in; layout(std430, binding = 0) buffer B { uint b[]; };\n"
      "layout(location=0) uniform float f; layout(location=1) uniform int i;\n"
      "layout(location=2) uniform uint u; layout(location=3) uniform vec2 v2;\n"
      "layout(location=4) uniform vec3 v3; layout(location=5) uniform vec4 v4;\n"
      "layout(location=6) uniform ivec2 i2; layout(location=7) uniform uvec2 u2;\n"
      "layout(location=8) uniform uvec4 u4; layout(location=9) uniform mat3 m3;\n"
      "layout(location=10) uniform mat4 m4;\n"
      "void main() {\n"
      "  bool good = f == 1.5 && i == -2 && u == 3u && v2 == vec2(4, 5) && v3 == vec3(6, 7, 8) &&\n"
      "    v4 == vec4(9, 10, 11, 12) && i2 == ivec2(-1, 2) && u2 == uvec2(1, 2) &&\n"
      "    u4 == uvec4(1, 2, 3, 4) && m3[2] == vec3(1, 2, 3) && m4[3] == vec4(4, 3, 2, 1);\n"
      "  b[0] = good ? 1u : 0u;\n}\n");
  Program program = compute();
  program.set(0, 1.5f);
  program.set(1, -2);
  program.set(2, 3u);
  program.set(3, vec2(4, 5));
  program.set(4, vec3(6, 7, 8));
  program.set(5, vec4(9, 10, 11, 12));
  program.set(6, ivec2(-1, 2));
  program.set(7, uvec2(1, 2));
  program.set(8, uvec4(1, 2, 3, 4));
  mat3 m3(0.0f);
  m3[2] = vec3(1, 2, 3);
  mat4 m4(0.0f);
  m4[3] = vec4(4, 3, 2, 1);
  program.set(9, m3);
  program.set(10, m4);
  EXPECT_EQ(valueOf(program), 1u);
}

TEST_F(ProgramTest, ProgramsMove) {
  writeValue("3u");
  Program a = compute();
  EXPECT_EQ(valueOf(a), 3u);
  Program b = std::move(a);
  EXPECT_EQ(valueOf(b), 3u);
  a = compute();
  writeValue("4u");
  EXPECT_EQ(reloadPrograms(), 1);  // b only: a was never used
  EXPECT_EQ(valueOf(b), 4u);
  { Program gone = std::move(b); }
  writeValue("5u");
  EXPECT_EQ(reloadPrograms(), 0);
}

// The rules shared with C++ compile in every stage of this driver.
TEST_F(ProgramTest, SharedRulesCompile) {
  folder_.write("value.comp", "void main() {}");
  for (const char* name : {"octahedral", "jitter"}) {
    const std::string path = std::string("shared/") + name + ".h";
    test::ShaderFolder root;
    std::filesystem::copy(std::string(SCREE_SOURCE_DIR) + "/shaders", root.path(),
                          std::filesystem::copy_options::recursive |
                              std::filesystem::copy_options::overwrite_existing);
    root.write("probe.comp",
               "#include \"" + path + "\"\nlayout(local_size_x = 1) in;\nvoid main() {}\n");
    Program program({.name = path, .compute = "probe.comp", .root = root.path()});
    const Status status = program.compile();
    EXPECT_TRUE(status.ok()) << status.error();
  }
}

}  // namespace
}  // namespace scree::gpu
