// Whole-file reading and writing.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "engine/core/file.h"

namespace scree {
namespace {

namespace fs = std::filesystem;

class File : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  size_t filesInFolder() const {
    return static_cast<size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
  }
  fs::path folder = fs::path(SCREE_BINARY_DIR) / "test_core_file";
  fs::path path = folder / "file.txt";
};

TEST_F(File, RoundTripKeepsEveryByte) {
  std::string content;
  for (int i = 0; i < 1000; ++i) content += static_cast<char>(i);
  ASSERT_TRUE(writeFile(path, content).ok());
  EXPECT_EQ(readText(path).value(), content);
  const std::vector<uint8_t> bytes = readBytes(path).value();
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), content);
  ASSERT_TRUE(writeFile(path, "").ok());
  EXPECT_EQ(readText(path).value(), "");
  EXPECT_EQ(filesInFolder(), 1u) << "no temporary file is left";
}

TEST_F(File, ErrorsNameTheFileAndTheReason) {
  EXPECT_EQ(readText(path).error(), path.string() + ": no such file");
  EXPECT_EQ(readText(folder).error(), folder.string() + ": not a regular file");
  ASSERT_TRUE(writeFile(path, "12345").ok());
  EXPECT_EQ(readText(path, 4).error(), path.string() + ": 5 bytes; at most 4 are read");
  EXPECT_TRUE(readText(path, 5).ok());
  const Status status = writeFile(folder / "missing" / "file.txt", "x");
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().find("file.txt"), std::string::npos) << status.error();
}

TEST_F(File, AFailedWriteKeepsTheOldFile) {
  ASSERT_TRUE(writeFile(path, "old").ok());
  fs::path used;
  const Status status = writeThenRename(path, [&](const fs::path& temporary) -> Status {
    used = temporary;
    std::ofstream(temporary) << "half";
    return Error{"disk full"};
  });
  EXPECT_EQ(status.error(), "disk full");
  EXPECT_EQ(used.extension(), path.extension()) << "libraries choose formats by it";
  EXPECT_NE(used, path);
  EXPECT_EQ(readText(path).value(), "old");
  EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(File, AFailedWriteLeavesNoTemporaryFile) {
  ASSERT_TRUE(writeFile(path, "old").ok());
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{1 << 16, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const Status status = writeFile(path, std::string(1 << 20, 'x'));
  const Status fits = writeFile(folder / "small.txt", "x");
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error(), path.string() + ": cannot write: File too large");
  EXPECT_TRUE(fits.ok());
  EXPECT_EQ(readText(path).value(), "old");
  EXPECT_EQ(filesInFolder(), 2u);

  EXPECT_THROW((void)writeThenRename(path,
                                     [](const fs::path& to) -> Status {
                                       std::ofstream(to) << "half";
                                       throw std::runtime_error("out of memory");
                                     }),
               std::runtime_error);
  EXPECT_EQ(filesInFolder(), 2u);
}

TEST_F(File, LinksStayLinksAndPipesStayPipes) {
  const fs::path real = folder / "real.txt", link = folder / "link.txt", pipe = folder / "pipe";
  fs::create_symlink(real, link);
  ASSERT_TRUE(writeFile(link, "through").ok());
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(readText(real).value(), "through");

  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_TRUE(writeFile(pipe, "flow").ok());
  char text[5] = {};
  EXPECT_EQ(read(reader, text, 4), 4);
  EXPECT_STREQ(text, "flow");
  close(reader);
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_FALSE(writeThenRename(pipe, [](const fs::path& to) { return writeFile(to, "x"); }).ok());
  EXPECT_TRUE(fs::is_fifo(pipe));
}

TEST_F(File, OutputPathsAreCheckedBeforehand) {
  EXPECT_TRUE(checkOutputPath(folder / "new.txt", "--out").ok());
  EXPECT_FALSE(checkOutputPath("", "--out").ok());
  EXPECT_FALSE(checkOutputPath(folder, "--out").ok());
  EXPECT_FALSE(checkOutputPath(folder / "no" / "such.txt", "--out").ok());
  EXPECT_TRUE(writeFile(folder / std::string(255, 'n'), "longest name").ok());
}

TEST_F(File, RootsFollowTheEnvironment) {
  setenv("SCREE_SHADERS", "/somewhere/shaders", 1);
  setenv("SCREE_CONTENT", "/somewhere/content", 1);
  EXPECT_EQ(shaderRoot(), "/somewhere/shaders");
  EXPECT_EQ(contentRoot(), "/somewhere/content");
  unsetenv("SCREE_SHADERS");
  unsetenv("SCREE_CONTENT");
  EXPECT_EQ(shaderRoot(), fs::path(SCREE_SOURCE_DIR) / "shaders");
  EXPECT_EQ(contentRoot(), fs::path(SCREE_SOURCE_DIR) / "content");
}

TEST_F(File, RootsFollowTheDataFolderOfTheProgram) {
  setDataRoot("/opt/game");
  EXPECT_EQ(shaderRoot(), "/opt/game/shaders");
  EXPECT_EQ(contentRoot(), "/opt/game/content");
  setenv("SCREE_SHADERS", "/somewhere/shaders", 1);
  EXPECT_EQ(shaderRoot(), "/somewhere/shaders") << "the environment comes first";
  unsetenv("SCREE_SHADERS");
  setDataRoot({});
  EXPECT_EQ(shaderRoot(), fs::path(SCREE_SOURCE_DIR) / "shaders");
}

}  // namespace
}  // namespace scree
