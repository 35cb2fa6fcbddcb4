// Which of a set of files changed on disk since the last look: for hot reload.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace scree {

class FileWatch {
 public:
  // Begins to watch a file, as it is now; it need not exist yet. A second call does nothing.
  void add(const std::filesystem::path& path);
  // The files that appeared, vanished or changed in time of modification, size or identity since
  // the last call. One stat() a file; no allocation when nothing changed. Valid until the next
  // call.
  std::span<const std::filesystem::path> poll();
  size_t size() const { return files_.size(); }
  void clear();

 private:
  struct Stamp {
    int64_t modified_ns = 0;
    int64_t size = -1;  // -1: the file does not exist
    uint64_t inode = 0;
    bool operator==(const Stamp&) const = default;
  };
  struct File {
    std::filesystem::path path;
    Stamp stamp;
  };
  static Stamp stampOf(const std::filesystem::path& path);

  std::vector<File> files_;
  std::vector<std::filesystem::path> changed_;
};

}  // namespace scree
