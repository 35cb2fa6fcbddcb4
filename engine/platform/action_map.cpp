// The names of input sources, and actions with their bindings.
#include <algorithm>
#include <cmath>

#include "engine/core/log.h"
#include "engine/platform/input.h"

namespace scree {
namespace {

struct SourceInfo {
  std::string_view name;
  SourceGroup group;
};
constexpr SourceInfo kSources[] = {
#define SCREE_SOURCE(identifier, name, group, code) {name, SourceGroup::group},
#include "engine/platform/input_sources.h"
};
static_assert(std::size(kSources) == static_cast<size_t>(Source::Count));

bool isBinding(const Binding& binding) {
  return binding.source < Source::Count && std::isfinite(binding.scale) && binding.scale != 0 &&
         std::abs(binding.scale) <= kMaxBindingScale && binding.dead_zone >= 0 &&
         binding.dead_zone <= kMaxDeadZone;
}

}  // namespace

std::string_view sourceName(Source source) {
  return source < Source::Count ? kSources[static_cast<size_t>(source)].name : "none";
}

Source findSource(std::string_view name) {
  for (size_t i = 0; i < std::size(kSources); ++i)
    if (kSources[i].name == name) return static_cast<Source>(i);
  return Source::Count;
}

SourceGroup sourceGroup(Source source) {
  return kSources[static_cast<size_t>(source)].group;
}

int16_t quantise(float value) {
  if (!(value == value)) return 0;
  const double clamped = std::clamp(static_cast<double>(value), -1.0, 1.0);
  return static_cast<int16_t>(std::lround(clamped * kFullValue));
}

bool isActionName(std::string_view name) {
  if (name.empty() || name.size() > kMaxActionName) return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

ActionId ActionMap::add(ActionDesc action) {
  if (!isActionName(action.name))
    fail(fmt::format("action '{}': a name has 1 to {} lower-case letters, digits and '_'",
                     action.name, kMaxActionName));
  if (has(action.name)) fail(fmt::format("action '{}' is declared twice", action.name));
  if (actions_.size() == kMaxActions)
    fail(fmt::format("action '{}': at most {} actions", action.name, kMaxActions));
  if (action.bindings.size() > kMaxBindings ||
      !std::all_of(action.bindings.begin(), action.bindings.end(), isBinding))
    fail(fmt::format("action '{}': a default binding is out of range", action.name));
  actions_.push_back(std::move(action));
  return static_cast<ActionId>(actions_.size() - 1);
}

ActionId ActionMap::id(std::string_view name) const {
  for (size_t i = 0; i < actions_.size(); ++i)
    if (actions_[i].name == name) return static_cast<ActionId>(i);
  fail(fmt::format("action '{}' was not declared", name));
}

bool ActionMap::has(std::string_view name) const {
  return std::any_of(actions_.begin(), actions_.end(),
                     [&](const ActionDesc& action) { return action.name == name; });
}

}  // namespace scree
