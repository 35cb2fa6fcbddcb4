// Hashing and packing of components by their descriptions.
#include "engine/ecs/value_codec.h"

namespace scree {
namespace {

uint64_t loadWord(const std::byte* bytes, size_t size) {
  uint64_t word = 0;
  std::memcpy(&word, bytes, size);
  return word;
}

inline uint64_t hashRun(const std::byte* bytes, size_t size, uint64_t hash) {
  for (; size >= 8; bytes += 8, size -= 8) hash = mix64(hash ^ loadWord(bytes, 8));
  return size ? mix64(hash ^ loadWord(bytes, size)) : hash;
}

uint64_t rowSeed(const ComponentInfo& info, Entity entity) {
  return mix64(entity.bits() + info.hash);
}

uint64_t hashFields(const ComponentInfo& info, const std::byte* value, uint64_t hash) {
  for (const ByteRun& run : info.runs) hash = hashRun(value + run.offset, run.size, hash);
  for (const FieldInfo& field : info.fields) {
    if (field.type != FieldType::Text) continue;
    const size_t length =
        textLength(reinterpret_cast<const char*>(value + field.offset), field.count);
    hash = hashRun(value + field.offset, length, mix64(hash ^ length));
  }
  return hash;
}

bool isOneRun(const ComponentInfo& info) {
  return info.runs.size() == 1 && info.runs[0].size == info.size;
}

// A compile-time size lets the compiler unroll the words of a value.
template <size_t kSize>
uint64_t hashFixed(const ComponentInfo& info, const std::byte* values, const Entity* entities,
                   size_t count) {
  uint64_t sum = 0;
  for (size_t i = 0; i < count; ++i)
    sum += hashRun(values + i * kSize, kSize, rowSeed(info, entities[i]));
  return sum;
}

}  // namespace

uint64_t hashValue(const ComponentInfo& info, const std::byte* value, uint64_t seed) {
  return hashFields(info, value, mix64(seed + info.hash));
}

uint64_t hashValues(const ComponentInfo& info, const std::byte* values, const Entity* entities,
                    size_t count) {
  if (isOneRun(info)) {
    switch (info.size) {
      case 4:
        return hashFixed<4>(info, values, entities, count);
      case 8:
        return hashFixed<8>(info, values, entities, count);
      case 12:
        return hashFixed<12>(info, values, entities, count);
      case 16:
        return hashFixed<16>(info, values, entities, count);
      case 24:
        return hashFixed<24>(info, values, entities, count);
      case 32:
        return hashFixed<32>(info, values, entities, count);
      default:
        break;
    }
  }
  uint64_t sum = 0;
  for (size_t i = 0; i < count; ++i)
    sum += hashFields(info, values + i * info.size, rowSeed(info, entities[i]));
  return sum;
}

size_t packedSize(const ComponentInfo& info) {
  size_t size = 0;
  for (const FieldInfo& field : info.fields) size += field.size();
  return size;
}

void packValue(const ComponentInfo& info, const std::byte* value, std::string& out) {
  for (const ByteRun& run : info.runs)
    out.append(reinterpret_cast<const char*>(value + run.offset), run.size);
  for (const FieldInfo& field : info.fields) {
    if (field.type != FieldType::Text) continue;
    const auto* text = reinterpret_cast<const char*>(value + field.offset);
    const size_t length = textLength(text, field.count);
    out.append(text, length);
    out.append(field.count - length, '\0');
  }
}

std::string_view unpackValue(const ComponentInfo& info, const char* packed, std::byte* value) {
  for (const ByteRun& run : info.runs) {
    std::memcpy(value + run.offset, packed, run.size);
    packed += run.size;
  }
  for (const FieldInfo& field : info.fields) {
    if (field.type == FieldType::Text) {
      std::memcpy(value + field.offset, packed, field.count);
      packed += field.count;
    } else if (field.type == FieldType::Bool) {
      for (uint32_t i = 0; i < field.count; ++i)
        if (std::to_integer<unsigned>(value[field.offset + i]) > 1) return field.name;
    }
  }
  return {};
}

}  // namespace scree
