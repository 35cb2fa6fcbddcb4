// World's public functions: checks, then WorldState.
#include "engine/ecs/world.h"

#include "engine/core/log.h"
#include "engine/ecs/world_state.h"

namespace scree {

World::World() : state_(std::make_unique<WorldState>()) {}
World::~World() = default;

bool World::alive(Entity entity) const {
  return state_->slots.find(entity) != nullptr;
}
size_t World::entityCount() const {
  return state_->slots.aliveCount();
}
Singletons& World::singletons() const {
  return state_->singletons;
}
std::span<const std::unique_ptr<Table>> World::tables() const {
  return state_->tables;
}

Entity World::spawn(std::span<const ComponentValue> values) {
  state_->requireAlone("spawn");
  return state_->spawn(values);
}

TableRows World::spawnMany(size_t count, std::span<const ComponentValue> values) {
  state_->requireAlone("spawnMany");
  return state_->spawnMany(count, values);
}

TableRows World::spawnRaw(size_t count, std::span<const ComponentId> ids) {
  state_->requireAlone("spawnMany");
  return state_->spawnRaw(count, ids);
}

bool World::destroy(Entity entity) {
  state_->requireAlone("destroy");
  return state_->destroy(entity);
}

size_t World::destroyMany(std::span<const Entity> entities) {
  state_->requireAlone("destroyMany");
  return state_->destroyMany(entities);
}

void World::clear() {
  state_->requireAlone("clear");
  state_->clear();
}

void* World::find(Entity entity, ComponentId id) {
  checkWrite(id);
  return state_->find(entity, id, true);
}

const void* World::peek(Entity entity, ComponentId id) const {
  checkRead(id);
  return state_->find(entity, id, false);
}

bool World::has(Entity entity, ComponentId id) const {
  const EntitySlots::Slot* slot = state_->slots.find(entity);
  return slot && state_->tables[slot->table]->has(id);
}

void* World::add(Entity entity, ComponentValue value) {
  state_->requireAlone("add");
  return state_->add(entity, value);
}

bool World::remove(Entity entity, ComponentId id) {
  state_->requireAlone("remove");
  return state_->remove(entity, id);
}

std::span<const ComponentId> World::componentIds(Entity entity) const {
  const EntitySlots::Slot* slot = state_->slots.find(entity);
  return slot ? state_->tables[slot->table]->componentIds() : std::span<const ComponentId>{};
}

void World::permute(Table& table, std::span<const uint32_t> order) {
  state_->requireAlone("permute");
  state_->permute(table, order);
}

Commands& World::commands() {
  if (CommandScope* scope = CommandScope::current(*state_)) return scope->commands();
  if (state_->stack_scopes.load(std::memory_order_relaxed) > 0)
    fail("World::commands() on a thread of its own inside a system: use Query::eachParallel");
  return state_->root_scope.commands();
}

FlushResult World::flush() {
  state_->requireAlone("flush");
  return state_->flush();
}

uint64_t World::stateHash() {
  state_->requireAlone("stateHash");
  return state_->hash(true);
}

uint64_t World::stateHashFromScratch() const {
  state_->requireAlone("stateHashFromScratch");
  return state_->hash(false);
}

QueryCache* World::queryCache(const QuerySignature& signature) {
  return state_->queryCache(signature);
}

}  // namespace scree
