// scree_bake with flags that make no sense: one clear line, exit status 2, and no file is touched.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "engine/core/file.h"

namespace scree::test {
namespace {

namespace fs = std::filesystem;

struct Baked {
  int status = -1;
  std::string said;
};
Baked bakeWith(const fs::path& mesh, const std::string& flags) {
  const std::string command =
      fmt::format("{}/bin/scree_bake impostor '{}' --directions 0 {} 2>&1", SCREE_BINARY_DIR, mesh.string(), flags);
  Baked run;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 512> part{};
  while (const size_t n = std::fread(part.data(), 1, part.size(), pipe)) run.said.append(part.data(), n);
  const int status = pclose(pipe);
  run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return run;
}

TEST(BakeRefusals, FlagsThatMakeNoSense) {
  const fs::path folder = fs::path(::testing::TempDir()) / "scree_bake_refusals";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const fs::path mesh = folder / "pebble.glb", link = folder / "link.glb";
  fs::copy_file(fs::path(SCREE_SOURCE_DIR) / "content/models/pebble.glb", mesh);
  fs::create_symlink("pebble.glb", link);
  const auto size = fs::file_size(mesh);
  const std::string out = "--out " + (folder / "o.png").string();
  for (const auto& [flags, said] : std::initializer_list<std::pair<std::string, std::string>>{
           {"--out " + mesh.string(), "the mesh and --out name the same file"},
           {"--out " + link.string(), "the mesh and --out name the same file"},
           {out + " --picture " + (folder / "o.png").string(), "--out and --picture name the same file"},
           {out + " --picture " + mesh.string(), "the mesh and --picture name the same file"},
           {out + " --error 0.1 --size 4000", "--size 4000: allowed is 1 to 1024"},
           {out + " --error 0.1 --size nan", "--size nan"},
           {out + " --error -1", "--error -1: allowed is 0 to 1"},
           {out + " --error 0.1 --memory nan", "--memory nan: allowed is 0 to 768"},
           {out + " --error 0.1 --views 5", "either it or these"},
           {out + " --error 0.1 --texels 32", "either it or these"},
           {out + " --error 0.1", "--error beside --directions 0"},
           {out + " --size 20", "--size requires --error"},
           {out + " --views 1", "1"},
           {out + " --texels 17", "17"},
           {"--out /nonexistent/o", "there is no such folder"}}) {
    const Baked run = bakeWith(mesh, flags);
    EXPECT_EQ(run.status, 2) << flags << "\n" << run.said;
    EXPECT_EQ(std::ranges::count(run.said, '\n'), 1) << flags << "\n" << run.said;
    EXPECT_NE(run.said.find(said), std::string::npos) << flags << "\n" << run.said;
  }
  EXPECT_EQ(fs::file_size(mesh), size);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 2);
  EXPECT_EQ(bakeWith(mesh, "--views 2 --texels 16").status, 0);  // the same with sense
  EXPECT_TRUE(fs::exists(folder / "pebble.impostor"));
}

}  // namespace
}  // namespace scree::test
