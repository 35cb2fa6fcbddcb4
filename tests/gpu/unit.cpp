// engine/gpu without a context: shader sources and compiler logs.
#include <gtest/gtest.h>

#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "engine/gpu/counters.h"
#include "engine/gpu/format.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/source.h"
#include "tests/support/gl_shader_folder.h"

namespace scree::gpu {
namespace {

using test::ShaderFolder;

Result<ShaderSource> assemble(const ShaderFolder& folder, std::string_view path,
                              std::vector<std::string> defines = {},
                              std::vector<std::string>* read = nullptr) {
  return assembleShader(folder.path(), path, ShaderStage::Fragment, defines, read);
}

std::string errorOf(const ShaderFolder& folder, std::string_view path) {
  const Result<ShaderSource> source = assemble(folder, path);
  return source.ok() ? "(no error)" : source.error();
}

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

// Walks the assembled text as a GLSL compiler does: file:line of every line by the #line rule.
std::map<std::string, std::string> placesOfLines(const ShaderSource& source) {
  std::map<std::string, std::string> places;
  std::istringstream stream(source.text);
  std::string line;
  size_t number = 1, file = 0;
  while (std::getline(stream, line)) {
    if (line.starts_with("#line ")) {
      std::istringstream(line.substr(6)) >> number >> file;
      EXPECT_EQ(number / kLinesPerFile, file);
      number %= kLinesPerFile;
      continue;
    }
    if (!line.empty()) places[line] = source.files.at(file) + ":" + std::to_string(number);
    ++number;
  }
  return places;
}

TEST(ShaderSources, EveryLineKeepsItsFileAndNumber) {
  ShaderFolder folder;
  folder.write("main.frag",
               "int a;\n#include \"lib/one.glsl\"\nint b;\n\n#include \"lib/two.glsl\"\nint c;\n");
  folder.write("lib/one.glsl", "\n\nint one;\n#include \"lib/deep.glsl\"\nint one_end;");
  folder.write("lib/two.glsl", "int two;\r\n#include \"lib/deep.glsl\"\r\nint two_end;\r\n");
  folder.write("lib/deep.glsl", "// nothing\n/* more\nlines */ int deep;\n");
  auto source = assemble(folder, "main.frag", {"SIZE 4", "FLAG"});
  ASSERT_TRUE(source.ok()) << source.error();
  EXPECT_TRUE(
      source->text.starts_with("#version 450 core\n#define FRAGMENT_STAGE 1\n#define SIZE 4\n"
                               "#define FLAG\n"));
  auto places = placesOfLines(*source);
  EXPECT_EQ(places["int a;"], "main.frag:1");
  EXPECT_EQ(places["int b;"], "main.frag:3");
  EXPECT_EQ(places["int c;"], "main.frag:6");
  EXPECT_EQ(places["int one;"], "lib/one.glsl:3");
  EXPECT_EQ(places["int one_end;"], "lib/one.glsl:5");
  EXPECT_EQ(places["int two;"], "lib/two.glsl:1");
  EXPECT_EQ(places["int two_end;"], "lib/two.glsl:3");
  EXPECT_EQ(places[" int deep;"], "lib/deep.glsl:3");
  // Once, though two files include it.
  EXPECT_EQ(source->text.find("int deep;"), source->text.rfind("int deep;"));
}

TEST(ShaderSources, DropsSectionsForCpp) {
  ShaderFolder folder;
  folder.write(
      "main.frag",
      "#ifdef __cplusplus\n#pragma once\n#include <cmath>\n#include \"engine/core/math.h\"\n"
      "#if 1\nint cpp;\n#else\nint cpp_too;\n#endif\n#else\nint glsl;\n#endif\n"
      "#ifndef __cplusplus\n#include \"shaders/lib/a.glsl\"\n#else\n#include <vector>\n#endif\n"
      "#if defined( __cplusplus )\nint cpp;\n#endif\n#if !defined(__cplusplus)\nint "
      "last;\n#endif\n");
  folder.write("lib/a.glsl", "#pragma once\nint included;\n");
  auto source = assemble(folder, "main.frag");
  ASSERT_TRUE(source.ok()) << source.error();
  EXPECT_FALSE(contains(source->text, "cpp")) << source->text;
  EXPECT_FALSE(contains(source->text, "pragma"));
  auto places = placesOfLines(*source);
  EXPECT_EQ(places["int glsl;"], "main.frag:11");
  EXPECT_EQ(places["int included;"], "lib/a.glsl:2");
  EXPECT_EQ(places["int last;"], "main.frag:22");
}

TEST(ShaderSources, KeepsConditionalsOfGlsl) {
  ShaderFolder folder;
  folder.write("main.frag",
               "#if SIZE > 2\nint big;\n#elif SIZE == 1\nint one;\n#else\nint small;\n#endif\n");
  auto source = assemble(folder, "main.frag");
  ASSERT_TRUE(source.ok()) << source.error();
  EXPECT_TRUE(
      contains(source->text,
               "#if SIZE > 2\nint big;\n#elif SIZE == 1\nint one;\n#else\nint small;\n#endif\n"));
}

TEST(ShaderSources, IgnoresIncludesInComments) {
  ShaderFolder folder;
  folder.write("main.frag",
               "// #include \"no.glsl\"\n/*\n#include \"no.glsl\"\n*/ int a; // b\nint c;/*d*/\n");
  auto source = assemble(folder, "main.frag");
  ASSERT_TRUE(source.ok()) << source.error();
  EXPECT_EQ(placesOfLines(*source)[" int a; "], "main.frag:4");
}

TEST(ShaderSources, RefusesWithFileAndLine) {
  ShaderFolder folder;
  folder.write("missing.frag", "\n\n#include \"lib/deeper.glsl\"\n");
  folder.write("lib/deeper.glsl", "int a;\n#include \"lib/absent.glsl\"\n");
  std::string error = errorOf(folder, "missing.frag");
  EXPECT_TRUE(error.starts_with("lib/deeper.glsl:2: #include \"lib/absent.glsl\": ")) << error;
  EXPECT_TRUE(contains(error, "no such file")) << error;

  folder.write("a.glsl", "\n#include \"b.glsl\"\n");
  folder.write("b.glsl", "#include \"c.glsl\"\n");
  folder.write("c.glsl", "\n\n\n#include \"shaders/a.glsl\"\n");
  EXPECT_EQ(errorOf(folder, "a.glsl"),
            "c.glsl:4: #include \"a.glsl\": a cycle: a.glsl -> b.glsl -> c.glsl -> a.glsl");
  folder.write("self.glsl", "#include \"self.glsl\"\n");
  EXPECT_EQ(errorOf(folder, "self.glsl"),
            "self.glsl:1: #include \"self.glsl\": a cycle: self.glsl -> self.glsl");

  folder.write("out.frag", "#include \"../secret.glsl\"\n");
  EXPECT_TRUE(contains(errorOf(folder, "out.frag"), "out.frag:1: #include \"../secret.glsl\""));
  folder.write("angle.frag", "int a;\n#include <cmath>\n");
  EXPECT_TRUE(errorOf(folder, "angle.frag").starts_with("angle.frag:2: "))
      << errorOf(folder, "angle.frag");
  folder.write("version.frag", "#version 330\n");
  EXPECT_TRUE(errorOf(folder, "version.frag").starts_with("version.frag:1: #version"));
  folder.write("inside.frag", "#ifdef A\n#include \"a.glsl\"\n#endif\n");
  EXPECT_TRUE(errorOf(folder, "inside.frag").starts_with("inside.frag:2: #include inside #if"));
  folder.write("open.frag", "int a;\n#if 1\nint b;\n");
  EXPECT_EQ(errorOf(folder, "open.frag"), "open.frag:2: #if without #endif");
  folder.write("shut.frag", "int a;\n#endif\n");
  EXPECT_EQ(errorOf(folder, "shut.frag"), "shut.frag:2: #endif without #if");
  folder.write("comment.frag", "int a;\n/* b\n");
  EXPECT_EQ(errorOf(folder, "comment.frag"), "comment.frag:2: comment without end");
  EXPECT_TRUE(contains(errorOf(folder, "none.frag"), "none.frag: "));
  EXPECT_TRUE(contains(errorOf(folder, "/etc/hostname"), "below the shader root"));
  const std::vector<std::string> bad_define = {"A\n#include \"b\""};
  EXPECT_FALSE(assembleShader(folder.path(), "a.glsl", ShaderStage::Vertex, bad_define).ok());
}

TEST(ShaderSources, RefusesFilesOfTooManyLines) {
  ShaderFolder folder;
  folder.write("long.glsl", std::string(kLinesPerFile - 1, '\n'));
  EXPECT_TRUE(assemble(folder, "long.glsl").ok());
  folder.write("long.glsl", std::string(kLinesPerFile, '\n'));
  EXPECT_EQ(errorOf(folder, "long.glsl"), "long.glsl: more than 65535 lines");
}

TEST(ShaderSources, RefusesEndlessNesting) {
  ShaderFolder folder;
  for (int i = 0; i < kMaxIncludeDepth + 2; ++i)
    folder.write(std::to_string(i) + ".glsl", "#include \"" + std::to_string(i + 1) + ".glsl\"\n");
  EXPECT_TRUE(contains(errorOf(folder, "0.glsl"), "nest deeper than 32"));
}

TEST(ShaderSources, NamesEveryFileThatItReadOrMissed) {
  ShaderFolder folder;
  folder.write("main.frag", "#include \"a.glsl\"\n#include \"absent.glsl\"\n");
  folder.write("a.glsl", "\n");
  std::vector<std::string> read;
  EXPECT_FALSE(assemble(folder, "main.frag", {}, &read).ok());
  EXPECT_EQ(read, (std::vector<std::string>{"main.frag", "a.glsl", "absent.glsl"}));
}

TEST(CompilerLogs, NameFilesOfThreeDrivers) {
  const std::vector<std::string> files = {"prologue", "main.frag", "lib/a.glsl"};
  EXPECT_EQ(nameFilesInLog("2:12(5): error: `x' undeclared\n", files),
            "lib/a.glsl:12: error: `x' undeclared");
  EXPECT_EQ(nameFilesInLog("2(12) : error C1008: undefined variable \"x\"\n", files),
            "lib/a.glsl:12: error C1008: undefined variable \"x\"");
  EXPECT_EQ(nameFilesInLog("ERROR: 1:7: 'x' : undeclared identifier\nWARNING: 2:1: odd\n", files),
            "main.frag:7: 'x' : undeclared identifier\nlib/a.glsl:1: odd");
  EXPECT_EQ(nameFilesInLog("error: out of memory\n\n9:1(1): x", files),
            "error: out of memory\n9:1(1): x");
  // Mesa's semantic errors: source-string 0, but the line knows the file.
  EXPECT_EQ(nameFilesInLog("0:131084(5): error: x\n2:131085(1): y", files),
            "lib/a.glsl:12: error: x\nlib/a.glsl:13: y");
  EXPECT_EQ(nameFilesInLog("0:3(5): error: x", files), "prologue:3: error: x");
  EXPECT_EQ(nameFilesInLog("7:1(5): x", files), "7:1(5): x");
  EXPECT_EQ(nameFilesInLog("", files), "");
}

TEST(Formats, BytesAndComponents) {
  EXPECT_EQ(formatInfo(GL_SRGB8_ALPHA8).bytes, 4);
  EXPECT_TRUE(formatInfo(GL_SRGB8_ALPHA8).srgb);
  EXPECT_EQ(formatInfo(GL_R11F_G11F_B10F).bytes, 4);
  EXPECT_EQ(formatInfo(GL_RG16F).bytes, 4);
  EXPECT_EQ(formatInfo(GL_RGBA32F).bytes, 16);
  EXPECT_EQ(formatInfo(GL_R32UI).component, Component::Uint);
  EXPECT_TRUE(isDepth(GL_DEPTH_COMPONENT32F));
  EXPECT_DEATH(formatInfo(0x1234), "0x1234");
}

TEST(CountersTest, DifferenceIsFieldByField) {
  Counters a, b;
  a.draws = 3;
  b.draws = 10;
  b.live_texture_bytes = 7;
  a.live_texture_bytes = 5;
  b.binds = 2;
  const Counters d = b - a;
  EXPECT_EQ(d.draws, 7u);
  EXPECT_EQ(d.binds, 2u);
  EXPECT_EQ(d.live_texture_bytes, 7u);
}

}  // namespace
}  // namespace scree::gpu
