// A temporary folder of shader sources, removed at the end.
#pragma once

#include <filesystem>
#include <string_view>

namespace scree::test {

class ShaderFolder {
 public:
  ShaderFolder();
  ~ShaderFolder();
  ShaderFolder(const ShaderFolder&) = delete;
  ShaderFolder& operator=(const ShaderFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  // Writes a file, with a time of modification later than that of every file written before:
  // the clock of a file system may be too coarse to tell two writes apart.
  void write(std::string_view name, std::string_view text);

 private:
  std::filesystem::path path_;
  int writes_ = 0;
};

}  // namespace scree::test
