// Making, finding and destroying singletons.
#include "engine/ecs/singletons.h"

#include <algorithm>
#include <cstring>
#include <new>
#include <string>

#include "engine/core/log.h"

namespace scree {
namespace {

// A value of a component type: trivially copyable and destructible.
class DescribedSingleton final : public SingletonHolder {
 public:
  explicit DescribedSingleton(const ComponentInfo& info)
      : alignment_(info.alignment),
        value_(::operator new (std::max(info.size, 1u), std::align_val_t{alignment_})) {
    if (info.size) std::memcpy(value_, info.default_value, info.size);
  }
  ~DescribedSingleton() override { ::operator delete (value_, std::align_val_t{alignment_}); }
  void* value() override { return value_; }

 private:
  size_t alignment_;
  void* value_;
};

struct PlainTypes {
  std::mutex mutex;
  std::vector<std::string> names;
};
PlainTypes& plainTypes() {
  static auto* types = new PlainTypes;
  return *types;
}

}  // namespace

uint32_t detail::registerSingletonType(std::string_view signature) {
  // "... [with T = Name; ...]" or "... [T = Name]"
  std::string_view name = signature;
  if (const size_t begin = name.find("T = "); begin != name.npos) name.remove_prefix(begin + 4);
  name = name.substr(0, name.find_first_of(";]"));
  PlainTypes& types = plainTypes();
  const std::lock_guard lock(types.mutex);
  if (types.names.size() == kMaxPlainSingletonTypes)
    fail(fmt::format("singleton {}: more than {} types", name, kMaxPlainSingletonTypes));
  types.names.emplace_back(name);
  return kMaxComponentTypes + static_cast<uint32_t>(types.names.size()) - 1;
}

std::string_view accessName(AccessId id) {
  if (id < kFirstSingletonAccess) return componentInfo(id).name;
  const uint32_t type = id - kFirstSingletonAccess;
  if (type < kMaxComponentTypes) return componentInfo(type).name;
  PlainTypes& types = plainTypes();
  const std::lock_guard lock(types.mutex);
  return types.names[type - kMaxComponentTypes];
}

Singletons::~Singletons() {
  while (!entries_.empty()) {
    values_[entries_.back().type] = nullptr;
    entries_.pop_back();
  }
}

void* Singletons::get(uint32_t type, MakeSingleton make, bool writes) {
  if (writes)
    checkWrite(kFirstSingletonAccess + type);
  else
    checkRead(kFirstSingletonAccess + type);
  if (void* value = find(type)) return value;
  std::unique_ptr<SingletonHolder> holder;
  if (type < kMaxComponentTypes)
    holder = std::make_unique<DescribedSingleton>(componentInfo(type));
  else if (make)
    holder = make();
  else
    fail(fmt::format("singleton {} has no default constructor: set it before it is asked for",
                     accessName(kFirstSingletonAccess + type)));
  const std::lock_guard lock(mutex_);
  if (void* value = find(type)) return value;
  values_[type].store(holder->value(), std::memory_order_release);
  entries_.push_back({type, std::move(holder)});
  return entries_.back().holder->value();
}

void* Singletons::set(uint32_t type, std::unique_ptr<SingletonHolder> holder) {
  checkWrite(kFirstSingletonAccess + type);
  const std::lock_guard lock(mutex_);
  values_[type].store(holder->value(), std::memory_order_release);
  std::erase_if(entries_, [&](const Entry& entry) { return entry.type == type; });
  entries_.push_back({type, std::move(holder)});
  return entries_.back().holder->value();
}

}  // namespace scree
