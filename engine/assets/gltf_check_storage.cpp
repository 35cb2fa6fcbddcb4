// The check of what holds the numbers: buffers, buffer views, accessors.
#include <fmt/format.h>

#include "engine/assets/gltf_check.h"

namespace scree::gltf {
using nlohmann::json;
namespace {

using enum Presence;
constexpr uint64_t kAnyWhole = uint64_t{1} << 53;
// An accessor without a buffer view is zeros: a claim of any size in a few bytes.
constexpr uint64_t kMaxElementsOfZeros = uint64_t{1} << 20;

class StorageCheck : CheckBase {
 public:
  using CheckBase::CheckBase;
  bool run() { return buffers() && bufferViews() && accessors(); }

 private:
  bool buffers() {
    uint64_t total = 0;
    return each("buffers", "buffer", [&](Fields& buffer) {
      uint64_t length = 0;
      if (!buffer.whole("byteLength", 1, limits_.max_file_bytes, Required, &length)) return false;
      total += length;
      if (total > limits_.max_total_bytes)
        return buffer.refuse("byteLength", fmt::format("all buffers together may have {} bytes",
                                                       limits_.max_total_bytes));
      return buffer.text("uri", Optional);
    });
  }

  bool bufferViews() {
    return each("bufferViews", "bufferView", [&](Fields& view) {
      uint64_t buffer = 0, offset = 0, length = 0;
      if (!view.index("buffer", "buffers", count("buffers"), Required, &buffer) ||
          !view.whole("byteOffset", 0, kAnyWhole, Optional, &offset) ||
          !view.whole("byteLength", 1, kAnyWhole, Required, &length))
        return false;
      const auto available = section("buffers")[buffer].at("byteLength").get<uint64_t>();
      if (offset > available || length > available - offset)
        return view.refuse("byteLength",
                           fmt::format("with byteOffset {} it passes the {} bytes of buffer {}",
                                       offset, available, buffer));
      if (view.find("byteStride") == nullptr) return true;
      uint64_t stride = 0;
      if (!view.whole("byteStride", 4, 252, Required, &stride)) return false;
      return stride % 4 == 0 || view.refuse("byteStride", "must be a multiple of 4");
    });
  }

  // Elements of `bytes` each, `stride` apart, inside a buffer view?
  bool fits(Fields& fields, std::string_view counted, uint64_t view, uint64_t offset,
            uint64_t elements, uint64_t bytes, uint64_t stride) {
    const auto available = section("bufferViews")[view].at("byteLength").get<uint64_t>();
    const uint64_t needed = (elements - 1) * stride + bytes;  // < 2^36, by the limits of all three
    if (offset <= available && needed <= available - offset) return true;
    return fields.refuse(counted, fmt::format("{} bytes at byteOffset {} pass the {} bytes of "
                                              "bufferView {}",
                                              needed, offset, available, view));
  }

  bool accessors() {
    return each("accessors", "accessor", [&](Fields& accessor) {
      uint64_t view = 0, offset = 0, elements = 0, component = 0;
      std::string type;
      if (!accessor.index("bufferView", "bufferViews", count("bufferViews"), Optional, &view) ||
          !accessor.whole("byteOffset", 0, kAnyWhole, Optional, &offset) ||
          !accessor.whole("count", 1, limits_.max_indices, Required, &elements) ||
          !accessor.oneOf("componentType", {5120, 5121, 5122, 5123, 5125, 5126}, Required) ||
          !accessor.oneOf("type", {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"},
                          Required) ||
          !accessor.boolean("normalized") ||
          !accessor.whole("componentType", 0, kAnyWhole, Required, &component) ||
          !accessor.text("type", Required, &type))
        return false;
      // Columns of matrices begin at multiples of 4 bytes; no matrix is read, so its padding is
      // left out of the bound.
      const auto bytes = static_cast<uint64_t>(componentBytes(static_cast<int64_t>(component)) *
                                               typeComponents(type));
      if (accessor.find("bufferView") != nullptr) {
        uint64_t stride = bytes;
        if (const auto& v = section("bufferViews")[view]; v.contains("byteStride"))
          stride = v.at("byteStride").get<uint64_t>();
        if (stride < bytes)
          return accessor.refuse("bufferView",
                                 fmt::format("its byteStride {} is below the {} bytes "
                                             "of an element",
                                             stride, bytes));
        if (!fits(accessor, "count", view, offset, elements, bytes, stride)) return false;
      } else if (elements > kMaxElementsOfZeros) {
        return accessor.refuse(
            "count", fmt::format("without a bufferView at most {} are read", kMaxElementsOfZeros));
      }
      return sparse(accessor, elements, bytes);
    });
  }

  bool sparse(Fields& accessor, uint64_t elements, uint64_t bytes) {
    const json* sparse = accessor.object("sparse", Optional);
    if (sparse == nullptr) return accessor.sound();
    Fields fields(*sparse, accessor.where() + ": sparse", fault_);
    uint64_t replaced = 0;
    if (!fields.whole("count", 1, elements, Required, &replaced)) return false;
    const json* indices = fields.object("indices", Required);
    const json* values = fields.object("values", Required);
    if (indices == nullptr || values == nullptr) return false;
    Fields index(*indices, fields.where() + ".indices", fault_);
    Fields value(*values, fields.where() + ".values", fault_);
    uint64_t view = 0, offset = 0, component = 0;
    if (!index.index("bufferView", "bufferViews", count("bufferViews"), Required, &view) ||
        !index.whole("byteOffset", 0, kAnyWhole, Optional, &offset) ||
        !index.oneOf("componentType", {5121, 5123, 5125}, Required) ||
        !index.whole("componentType", 0, kAnyWhole, Required, &component))
      return false;
    const auto size = static_cast<uint64_t>(componentBytes(static_cast<int64_t>(component)));
    if (!fits(fields, "count", view, offset, replaced, size, size)) return false;
    offset = 0;
    return value.index("bufferView", "bufferViews", count("bufferViews"), Required, &view) &&
           value.whole("byteOffset", 0, kAnyWhole, Optional, &offset) &&
           fits(fields, "count", view, offset, replaced, bytes, bytes);
  }
};

}  // namespace

bool checkStorage(const Document& document, const GltfLimits& limits, std::string& fault) {
  return StorageCheck(document, limits, fault).run();
}

}  // namespace scree::gltf
