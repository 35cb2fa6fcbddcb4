// Change detection by stat().
#include "engine/platform/file_watch.h"

#include <sys/stat.h>

namespace scree {

FileWatch::Stamp FileWatch::stampOf(const std::filesystem::path& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return {};
  return {static_cast<int64_t>(info.st_mtim.tv_sec) * 1'000'000'000 + info.st_mtim.tv_nsec,
          static_cast<int64_t>(info.st_size), static_cast<uint64_t>(info.st_ino)};
}

void FileWatch::add(const std::filesystem::path& path) {
  for (const File& file : files_)
    if (file.path == path) return;
  files_.push_back({path, stampOf(path)});
}

std::span<const std::filesystem::path> FileWatch::poll() {
  changed_.clear();
  for (File& file : files_) {
    const Stamp now = stampOf(file.path);
    if (now == file.stamp) continue;
    file.stamp = now;
    changed_.push_back(file.path);
  }
  return changed_;
}

void FileWatch::clear() {
  files_.clear();
  changed_.clear();
}

}  // namespace scree
