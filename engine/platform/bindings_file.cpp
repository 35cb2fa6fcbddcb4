// The JSON file of action bindings.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "engine/core/file.h"
#include "engine/core/json_depth.h"
#include "engine/platform/input.h"

namespace scree {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBindingsVersion = 1;
constexpr uint64_t kMaxBindingsBytes = 1 << 20;
constexpr int kMaxBindingsDepth = 16;  // 4 are used

// A value as the file has it, short enough for one line.
std::string shown(const Json& value) {
  constexpr size_t kShown = 60;
  std::string text = value.dump();
  if (text.size() > kShown) text = text.substr(0, kShown) + "...";
  return text;
}

// `text` as JSON with every key once an object, or the reason with its line.
Result<Json> parseJson(std::string_view text, std::string_view file) {
  if (const size_t at = findTooDeep(text, kMaxBindingsDepth); at != std::string_view::npos)
    return Error{fmt::format("{}: nested deeper than {} at byte {}", file, kMaxBindingsDepth, at)};
  std::vector<std::set<std::string>> keys;
  std::string twice;
  const auto see = [&](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second &&
        twice.empty())
      twice = shown(value);
    return true;
  };
  try {
    Json parsed = Json::parse(text, see);
    if (!twice.empty()) return Error{fmt::format("{}: the key {} is given twice", file, twice)};
    return parsed;
  } catch (const Json::exception& error) {
    std::string where(file);
    if (const auto* at = dynamic_cast<const Json::parse_error*>(&error)) {
      const std::string_view before = text.substr(0, std::min(at->byte, text.size()));
      where += fmt::format(":{}", std::count(before.begin(), before.end(), '\n') + 1);
    }
    std::string why = error.what();
    if (const size_t colon = why.find("] "); colon != std::string::npos)
      why = why.substr(colon + 2);
    std::replace_if(
        why.begin(), why.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
    return Error{fmt::format("{}: not JSON: {}", where, why.substr(0, 200))};
  }
}

Result<float> numberField(const Json& object, const char* field, float fallback, float low,
                          float high, const std::string& where) {
  if (!object.contains(field)) return fallback;
  const Json& value = object[field];
  const double number = value.is_number() ? value.get<double>() : NAN;
  if (!(number >= low && number <= high))
    return Error{fmt::format("{}: {} is {}; allowed is a number from {} to {}", where, field,
                             shown(value), low, high)};
  return static_cast<float>(number);
}

Result<Binding> parseBinding(const Json& value, const std::string& where) {
  if (value.is_string()) return parseBinding(Json{{"source", value}}, where);
  if (!value.is_object())
    return Error{
        fmt::format("{}: {}; allowed is the name of a source, or an object with source, "
                    "scale, dead_zone",
                    where, shown(value))};
  for (const auto& [key, unused] : value.items())
    if (key != "source" && key != "scale" && key != "dead_zone")
      return Error{fmt::format("{}: unknown field {}; allowed are source, scale, dead_zone", where,
                               shown(Json(key)))};
  if (!value.contains("source")) return Error{fmt::format("{}: source is missing", where)};
  Binding binding;
  if (value["source"].is_string()) binding.source = findSource(value["source"].get<std::string>());
  if (binding.source == Source::Count)
    return Error{
        fmt::format("{}: source is {}; allowed are names such as \"key.a\", "
                    "\"mouse.left\", \"mouse.x\", \"pad.a\", \"pad.left_x\"",
                    where, shown(value["source"]))};
  Result<float> scale =
      numberField(value, "scale", binding.scale, -kMaxBindingScale, kMaxBindingScale, where);
  if (!scale) return scale.takeError();
  if (*scale == 0) return Error{fmt::format("{}: scale is 0; allowed is anything but 0", where)};
  binding.scale = *scale;
  Result<float> dead_zone =
      numberField(value, "dead_zone", binding.dead_zone, 0, kMaxDeadZone, where);
  if (!dead_zone) return dead_zone.takeError();
  if (value.contains("dead_zone") && sourceGroup(binding.source) != SourceGroup::PadAxis)
    return Error{fmt::format("{}: dead_zone is given for {}; only gamepad axes have one", where,
                             shown(value["source"]))};
  binding.dead_zone = *dead_zone;
  return binding;
}

std::string actionNames(std::span<const ActionDesc> actions) {
  std::string names;
  for (const ActionDesc& action : actions) names += (names.empty() ? "" : ", ") + action.name;
  return names;
}

}  // namespace

Status ActionMap::loadBindings(const std::filesystem::path& path) {
  Result<std::string> text = readText(path, kMaxBindingsBytes);
  if (!text) return text.takeError();
  return parseBindings(*text, path.string());
}

Status ActionMap::parseBindings(std::string_view json, std::string_view file) {
  Result<Json> parsed = parseJson(json, file);
  if (!parsed) return parsed.takeError();
  const Json& root = *parsed;
  if (!root.is_object())
    return Error{
        fmt::format("{}: {}; allowed is an object with version and actions", file, shown(root))};
  for (const auto& [key, unused] : root.items())
    if (key != "version" && key != "actions")
      return Error{fmt::format("{}: unknown field {}; allowed are version, actions", file,
                               shown(Json(key)))};
  if (!root.contains("version")) return Error{fmt::format("{}: version is missing", file)};
  if (!root["version"].is_number_integer() || root["version"] != kBindingsVersion)
    return Error{fmt::format("{}: version is {}; allowed is {}", file, shown(root["version"]),
                             kBindingsVersion)};
  if (!root.contains("actions")) return Error{fmt::format("{}: actions is missing", file)};
  if (!root["actions"].is_object())
    return Error{fmt::format("{}: actions is {}; allowed is an object of lists", file,
                             shown(root["actions"]))};

  std::vector<ActionDesc> changed = actions_;
  for (const auto& [name, list] : root["actions"].items()) {
    const auto found = std::find_if(changed.begin(), changed.end(),
                                    [&](const ActionDesc& action) { return action.name == name; });
    if (found == changed.end())
      return Error{fmt::format("{}: unknown action {}; allowed are {}", file, shown(Json(name)),
                               actionNames(actions_))};
    if (!list.is_array())
      return Error{fmt::format("{}: action '{}': {}; allowed is a list of bindings", file, name,
                               shown(list))};
    if (list.size() > kMaxBindings)
      return Error{fmt::format("{}: action '{}': {} bindings; at most {}", file, name, list.size(),
                               kMaxBindings)};
    found->bindings.clear();
    for (size_t i = 0; i < list.size(); ++i) {
      Result<Binding> binding =
          parseBinding(list[i], fmt::format("{}: action '{}': binding {}", file, name, i + 1));
      if (!binding) return binding.takeError();
      found->bindings.push_back(*binding);
    }
  }
  actions_ = std::move(changed);
  return Done{};
}

std::string ActionMap::formatBindings() const {
  Json actions = Json::object();
  for (const ActionDesc& action : actions_) {
    Json list = Json::array();
    for (const Binding& binding : action.bindings) {
      // Through text, so that 0.15f is written as 0.15.
      const auto number = [](float value) { return Json::parse(fmt::format("{}", value)); };
      Json entry{{"source", sourceName(binding.source)}, {"scale", number(binding.scale)}};
      if (sourceGroup(binding.source) == SourceGroup::PadAxis)
        entry["dead_zone"] = number(binding.dead_zone);
      list.push_back(std::move(entry));
    }
    actions[action.name] = std::move(list);
  }
  return Json{{"version", kBindingsVersion}, {"actions", std::move(actions)}}.dump(2) + "\n";
}

}  // namespace scree
