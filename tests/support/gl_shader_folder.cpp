// Temporary shader folders.
#include "tests/support/gl_shader_folder.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <string>

namespace scree::test {
namespace fs = std::filesystem;

ShaderFolder::ShaderFolder() {
  static std::atomic<int> count{0};
  path_ = fs::temp_directory_path() /
          ("scree_shaders_" + std::to_string(getpid()) + "_" + std::to_string(count++));
  fs::remove_all(path_);
  fs::create_directories(path_);
}

ShaderFolder::~ShaderFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

void ShaderFolder::write(std::string_view name, std::string_view text) {
  const fs::path file = path_ / name;
  fs::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
  fs::last_write_time(file, fs::file_time_type::clock::now() + std::chrono::seconds(++writes_));
}

}  // namespace scree::test
