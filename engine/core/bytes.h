// Numbers, texts and plain structs to and from bytes, in the order of memory: little-endian.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace scree {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

class ByteWriter {
 public:
  // A number, or a struct of numbers without padding.
  template <class T>
  void number(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    content.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  // Length as uint32, then the characters.
  void text(std::string_view value) {
    number(static_cast<uint32_t>(value.size()));
    content.append(value);
  }
  std::string content;
};

// Takes numbers off the front. After the first one that is missing, all are zero and failed().
class ByteReader {
 public:
  explicit ByteReader(std::string_view content) : rest_(content), total_(content.size()) {}

  template <class T>
  T number() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value{};
    if (const char* from = take(sizeof value)) std::memcpy(&value, from, sizeof value);
    return value;
  }
  std::string_view text() {
    const auto length = number<uint32_t>();
    const char* from = take(length);
    return from ? std::string_view(from, length) : std::string_view{};
  }
  // `count` items of `size` bytes; nullptr if there are fewer.
  const char* take(uint64_t count, uint64_t size = 1) {
    if (failed_ || !has(count, size)) {
      failed_ = true;
      return nullptr;
    }
    const char* from = rest_.data();
    rest_.remove_prefix(count * size);
    return from;
  }
  // Whether there are that many: ask before making room for them.
  bool has(uint64_t count, uint64_t size) const { return size == 0 || count <= rest_.size() / size; }
  bool failed() const { return failed_; }
  bool atEnd() const { return rest_.empty(); }
  size_t offset() const { return total_ - rest_.size(); }

 private:
  std::string_view rest_;
  size_t total_;
  bool failed_ = false;
};

}  // namespace scree
