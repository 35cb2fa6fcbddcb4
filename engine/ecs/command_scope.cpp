// The thread's current scope, and the checks of what a system declared.
#include "engine/ecs/command_scope.h"

#include "engine/core/log.h"
#include "engine/ecs/world_state.h"

namespace scree {
namespace {

constinit thread_local CommandScope* t_scope = nullptr;

template <size_t n>
bool contains(const std::array<uint64_t, n>& set, AccessId id) {
  return set[id / 64] >> id % 64 & 1;
}

[[noreturn]] void failAccess(const SystemAccess& access, AccessId id, std::string_view verb) {
  fail(fmt::format("system '{}' {} {}, which it does not declare", access.name, verb,
                   accessName(id)));
}

}  // namespace

CommandScope::CommandScope(const CommandScope& parent, uint32_t sequence, uint32_t index,
                           const SystemAccess* access)
    : world_(parent.world_),
      access_(access),
      outer_(t_scope),
      on_stack_(true),
      prefix_(parent.prefix_),
      depth_(parent.depth_ + 1) {
  prefix_[parent.depth_] = uint64_t{sequence} << 32 | index;
  t_scope = this;
  world_.stack_scopes.fetch_add(1, std::memory_order_relaxed);
}

CommandScope::~CommandScope() {
  if (!on_stack_) return;
  world_.stack_scopes.fetch_sub(1, std::memory_order_relaxed);
  t_scope = outer_;
}

Commands& CommandScope::commands() {
  if (!open_) {
    if (depth_ >= kMaxCommandDepth)
      fail(fmt::format("commands in parallel iterations nested more than {} deep",
                       kMaxCommandDepth - 1));
    CommandKey key = prefix_;
    key[depth_] = uint64_t{++sequence_} << 32;
    open_ = &world_.openCommands(key);
  }
  return *open_;
}

CommandScope* CommandScope::current(const WorldState& world) {
  for (CommandScope* scope = t_scope; scope; scope = scope->outer_)
    if (&scope->world_ == &world) return scope;
  return nullptr;
}

const CommandScope* CommandScope::current() {
  return t_scope;
}

void checkRead(AccessId id) {
  const SystemAccess* access = t_scope ? t_scope->access() : nullptr;
  if (access && !contains(access->reads, id) && !contains(access->writes, id))
    failAccess(*access, id, "reads");
}

void checkWrite(AccessId id) {
  const SystemAccess* access = t_scope ? t_scope->access() : nullptr;
  if (access && !contains(access->writes, id)) failAccess(*access, id, "writes");
}

}  // namespace scree
