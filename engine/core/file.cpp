// File reading and writing over the standard streams.
#include "engine/core/file.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include "engine/core/hash.h"

namespace scree {
namespace fs = std::filesystem;
namespace {

template <class Buffer>
Result<Buffer> readWhole(const fs::path& path, uint64_t max_bytes) {
  std::error_code code;
  const auto status = fs::status(path, code);
  if (code || !fs::exists(status)) return Error{fmt::format("{}: no such file", path.string())};
  if (!fs::is_regular_file(status)) return Error{fmt::format("{}: not a regular file", path.string())};
  const uint64_t size = fs::file_size(path, code);
  if (code) return Error{fmt::format("{}: {}", path.string(), code.message())};
  if (size > max_bytes)
    return Error{fmt::format("{}: {} bytes; at most {} are read", path.string(), size, max_bytes)};
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return Error{fmt::format("{}: {}", path.string(), std::strerror(errno))};
  Buffer content(size, {});
  stream.read(reinterpret_cast<char*>(content.data()), static_cast<std::streamsize>(size));
  if (static_cast<uint64_t>(stream.gcount()) != size)
    return Error{fmt::format("{}: read {} of {} bytes", path.string(), stream.gcount(), size)};
  return content;
}

fs::path& dataRoot() {
  static fs::path folder;
  return folder;
}

fs::path rootFrom(const char* variable, const char* folder, const char* source,
                  const char* installed) {
  if (const char* set = std::getenv(variable); set && *set) return set;
  if (!dataRoot().empty()) return dataRoot() / folder;
  std::error_code ignored;
  if (fs::is_directory(source, ignored)) return source;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path beside = program.parent_path().parent_path() / "share/scree" / folder;
  if (fs::is_directory(beside, ignored)) return beside;
  return installed;
}

}  // namespace

Result<std::string> readText(const fs::path& path, uint64_t max_bytes) {
  return readWhole<std::string>(path, max_bytes);
}

Result<std::vector<uint8_t>> readBytes(const fs::path& path, uint64_t max_bytes) {
  return readWhole<std::vector<uint8_t>>(path, max_bytes);
}

fs::path temporaryPath(const fs::path& path) {
  // Short, since a name that is as long as may be leaves no room for more.
  const uint64_t name = hashBytes(path.c_str(), path.native().size());
  fs::path temporary = path;
  temporary.replace_filename(
      fmt::format(".{:08x}.{}{}", name >> 32, getpid(), path.extension().string()));
  return temporary;
}

fs::path behindLink(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as the kernel follows
  fs::path target = path;
  std::error_code ignored, code;
  for (int i = 0; i < kMostLinks && fs::is_symlink(target, ignored); ++i) {
    const fs::path next = fs::read_symlink(target, code);
    if (code) return path;
    target = target.parent_path() / next;
  }
  return target;
}

bool areSameFile(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored) ||
         fs::weakly_canonical(fs::absolute(a, ignored), ignored) ==
             fs::weakly_canonical(fs::absolute(b, ignored), ignored);
}

Status checkOutputPath(const fs::path& path, std::string_view what) {
  const auto refuse = [&](std::string_view why) {
    return Error{fmt::format("{}: '{}': {}", what, path.string(), why)};
  };
  if (path.empty()) return refuse("allowed is the path of a file");
  std::error_code ignored;
  const fs::path target = behindLink(path);
  if (fs::is_directory(target, ignored) || !target.has_filename()) return refuse("is a folder");
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored)) return refuse("there is no such folder");
  if (access(folder.c_str(), W_OK) != 0) return refuse("the folder cannot be written to");
  return Done{};
}

namespace {

sigset_t fileLimitSignal() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGXFSZ);
  return set;
}

}  // namespace

TemporaryFile::TemporaryFile(fs::path path) : path_(std::move(path)) {
  const sigset_t limit = fileLimitSignal();
  sigset_t before;
  unblocks_ = pthread_sigmask(SIG_BLOCK, &limit, &before) == 0 && sigismember(&before, SIGXFSZ) == 0;
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  fs::remove(path_, ignored);
  if (!unblocks_) return;
  // The kernel sends it to the thread that wrote: taken here, it does not come later.
  const sigset_t limit = fileLimitSignal();
  const timespec at_once{};
  sigtimedwait(&limit, nullptr, &at_once);
  pthread_sigmask(SIG_UNBLOCK, &limit, nullptr);
}

Status renameInto(const fs::path& temporary, const fs::path& path) {
  std::error_code code, ignored;
  const fs::file_status old = fs::status(path, ignored);
  if (fs::exists(old) && !fs::is_regular_file(old))
    code = std::make_error_code(std::errc::not_supported);
  else
    fs::rename(temporary, path, code);
  if (!code) return Done{};
  return Error{fmt::format("{}: cannot write: {}", path.string(), code.message()),
               ErrorKind::Failure};
}

Status writeFile(const fs::path& path, std::string_view content) {
  const auto write = [&](const fs::path& to) -> Status {
    std::ofstream stream(to, std::ios::binary);
    stream.write(content.data(), static_cast<std::streamsize>(content.size()));
    stream.close();
    if (!stream)
      return Error{fmt::format("{}: cannot write: {}", path.string(), std::strerror(errno)),
                   ErrorKind::Failure};
    return Done{};
  };
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  return fs::is_character_file(status) || fs::is_fifo(status) ? write(path)
                                                              : writeThenRename(path, write);
}

fs::path shaderRoot() {
  return rootFrom("SCREE_SHADERS", "shaders", SCREE_SOURCE_SHADERS, SCREE_INSTALLED_SHADERS);
}

fs::path contentRoot() {
  return rootFrom("SCREE_CONTENT", "content", SCREE_SOURCE_CONTENT, SCREE_INSTALLED_CONTENT);
}

void setDataRoot(fs::path folder) { dataRoot() = std::move(folder); }

}  // namespace scree
