// Pictures on a disk that is full: an error, and no half of a file.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <vector>

#include "engine/assets/image.h"

namespace scree {
namespace {

namespace fs = std::filesystem;

// Files end at `bytes` while it lives, as on a full disk.
class Full {
 public:
  explicit Full(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~Full() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, SIG_DFL);
  }

 private:
  rlimit before_{};
};

TEST(FullDisk, PicturesAreRefusedAndLeaveNothing) {
  const fs::path folder = fs::temp_directory_path() / ("scree_full_" + std::to_string(getpid()));
  fs::create_directory(folder);
  // Noise, which no compression makes small.
  std::vector<uint8_t> pixels(64 * 64 * 3);
  uint32_t state = 1;
  for (uint8_t& p : pixels) p = static_cast<uint8_t>((state = state * 1664525u + 1013904223u) >> 24);
  const std::vector<float> radiance(pixels.begin(), pixels.end());
  const std::vector<std::string> channels{"R", "G", "B"};
  const auto png = [&] { return writePng(folder / "a.png", 64, 64, 3, pixels); };
  const auto exr = [&] { return writeExr(folder / "a.exr", 64, 64, channels, radiance); };
  {
    const Full disk(1000);
    EXPECT_FALSE(png().ok());
    EXPECT_FALSE(exr().ok());
    EXPECT_TRUE(fs::is_empty(folder));
  }
  EXPECT_TRUE(png().ok());
  EXPECT_TRUE(exr().ok());
  EXPECT_GT(fs::file_size(folder / "a.png"), 1000u);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace scree
