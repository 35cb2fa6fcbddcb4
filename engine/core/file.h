// Whole-file reading with a size limit, and writing that never leaves half a file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/result.h"

namespace scree {

// The largest file that is read into memory, bytes; a larger one is refused.
inline constexpr uint64_t kMaxFileBytes = 1ull << 30;

Result<std::string> readText(const std::filesystem::path& path, uint64_t max_bytes = kMaxFileBytes);
Result<std::vector<uint8_t>> readBytes(const std::filesystem::path& path,
                                       uint64_t max_bytes = kMaxFileBytes);

// Writes beside the target, then renames; on an error the old file stays as it was. A link stays a
// link; into a device or a pipe it writes without renaming.
Status writeFile(const std::filesystem::path& path, std::string_view content);
// Calls write(temporary path), then renames to `path`; for libraries that write files themselves.
// The temporary path keeps the extension of `path`. Refuses to replace what is no regular file.
template <class Write>
Status writeThenRename(const std::filesystem::path& path, Write&& write);

// Where shader sources are, the first of: $SCREE_SHADERS; shaders/ in the folder that setDataRoot
// was given; the source tree; ../share/scree/shaders beside the program; the installed share folder.
std::filesystem::path shaderRoot();
// Where levels, models and textures are: $SCREE_CONTENT, else content/ in the same places.
std::filesystem::path contentRoot();
// For a program that keeps shaders/ and content/ in a folder of its own, or was built against an
// installed package (its CMake variable scree_DATA_DIR). Empty: back to the default.
void setDataRoot(std::filesystem::path folder);

// An error if a file cannot be written at `path` later: an empty name, a folder, no folder to be in.
// `what` begins the line: "--stats".
Status checkOutputPath(const std::filesystem::path& path, std::string_view what);

// The file behind a link, which need not exist; any other path as it is.
std::filesystem::path behindLink(const std::filesystem::path& path);

// Whether two paths name one file, be there such a file yet or not.
bool areSameFile(const std::filesystem::path& a, const std::filesystem::path& b);
// The temporary path that writeThenRename writes to.
std::filesystem::path temporaryPath(const std::filesystem::path& path);
Status renameInto(const std::filesystem::path& temporary, const std::filesystem::path& path);

// While it lives, a file that grows beyond the process's limit is an error of the write in this thread, not the
// program's end; and on its end the file is removed, unless it was renamed.
class TemporaryFile {
 public:
  explicit TemporaryFile(std::filesystem::path path);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool unblocks_ = false;
};

template <class Write>
Status writeThenRename(const std::filesystem::path& link, Write&& write) {
  const std::filesystem::path path = behindLink(link);
  const TemporaryFile temporary(temporaryPath(path));
  if (Status written = write(temporary.path()); !written.ok()) return written;
  return renameInto(temporary.path(), path);
}

}  // namespace scree
