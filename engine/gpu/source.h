// Puts GLSL sources together: #include, defines, #line, and the way back from a compiler's log to
// file names. No GL.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"

namespace scree::gpu {

enum class ShaderStage : unsigned char { Vertex, Fragment, Compute };

// Mesa names source-string 0 in every error but those of syntax (its parser drops the number), so
// #line carries the number of the file in the line number, too: number * kLinesPerFile + line.
// Files of more lines are refused.
inline constexpr int kLinesPerFile = 65536;

struct ShaderSource {
  std::string text;
  // Index = GLSL source-string number. Number 0 is the prologue; 1 is the shader's own file.
  // Paths are relative to the root, as written after #include without a leading "shaders/".
  std::vector<std::string> files;
};

// Includes may nest this deep.
inline constexpr int kMaxIncludeDepth = 32;

// Reads `path` below `root` and everything it includes. Sections in #ifdef __cplusplus are dropped.
// Refused, with file and line: a missing file, a path that leaves the root, a cycle (the chain is
// named), an #include inside another #if (files are included once, so it could vanish), #version.
// On an error, `read` still gets the files that were read or missing, so that they can be watched.
Result<ShaderSource> assembleShader(const std::filesystem::path& root, std::string_view path,
                                    ShaderStage stage, std::span<const std::string> defines,
                                    std::vector<std::string>* read = nullptr);

// Replaces source-string numbers in a compiler's log by file names: "file:line: rest" for the
// formats of Mesa "1:65548(5): ", NVIDIA "1(65548) : " and the older "ERROR: 1:65548: ".
std::string nameFilesInLog(std::string_view log, std::span<const std::string> files);

}  // namespace scree::gpu
