// Reading of JSON fields with their type and range checked; the first fault is kept as one line.
// Private to assets.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "engine/core/result.h"

namespace scree::gltf {

enum class Presence { Optional, Required };

// Fields of one object. Every function returns false once a fault was found, so that calls chain
// with &&; a missing optional field is fine and leaves `out` as it is.
class Fields {
 public:
  // `where`: "level.gltf: accessor 3 \"positions\"".
  Fields(const nlohmann::json& object, std::string where, std::string& fault)
      : object_(object), where_(std::move(where)), fault_(fault) {}

  bool isObject();
  bool whole(std::string_view name, uint64_t least, uint64_t most, Presence presence,
             uint64_t* out = nullptr);
  // An index into an array of `count` entries called `target`.
  bool index(std::string_view name, std::string_view target, size_t count, Presence presence,
             uint64_t* out = nullptr);
  bool number(std::string_view name, double least, double most, Presence presence,
              double* out = nullptr);
  // Exactly `count` numbers.
  bool numbers(std::string_view name, size_t count, double least, double most,
               double* out = nullptr);
  // An array of indices, at least `least` of them.
  bool indices(std::string_view name, std::string_view target, size_t count);
  bool text(std::string_view name, Presence presence, std::string* out = nullptr);
  bool boolean(std::string_view name);
  // One of these numbers, or texts.
  bool oneOf(std::string_view name, std::initializer_list<uint64_t> allowed, Presence presence);
  bool oneOf(std::string_view name, std::initializer_list<std::string_view> allowed,
             Presence presence);

  const nlohmann::json* find(std::string_view name) const;
  // The nested object's fields, or fault; null if it is missing and may be.
  const nlohmann::json* object(std::string_view name, Presence presence);

  // Notes the fault "where: field = value: allowed" and returns false.
  bool refuse(std::string_view name, std::string_view allowed);
  const std::string& where() const { return where_; }
  bool sound() const { return fault_.empty(); }
  std::string& fault() { return fault_; }

 private:
  // True if the field is there; otherwise faults if it is required.
  bool present(std::string_view name, Presence presence, const nlohmann::json*& value);

  const nlohmann::json& object_;
  std::string where_;
  std::string& fault_;
};

}  // namespace scree::gltf
