// Grouping, culling and record writing of mesh instances.
#include "modules/deferred/mesh_batches.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "engine/core/log.h"

namespace scree {
namespace {

constexpr uint32_t kNoGroup = 0xffffffffu;

bool same(const PreviousTransform& a, const Transform& b) {
  return a.position == b.position && a.rotation == b.rotation && a.scale == b.scale;
}

// Rows of relative_from_local.
void writeRows(vec4* rows, const Transform& placed, const dvec3& camera) {
  const mat4 m = relativeFromLocal(placed, camera);
  for (int r = 0; r < 3; ++r) rows[r] = vec4(m[0][r], m[1][r], m[2][r], m[3][r]);
}

}  // namespace

PlacedSphere boundingSphere(const Transform& placed, const LocalBounds& bounds) {
  const vec3 s = glm::abs(placed.scale);
  return {placed.position + dvec3(placed.rotation * (placed.scale * bounds.center)),
          bounds.radius * std::max({s.x, s.y, s.z})};
}

bool mirrors(const Transform& placed) {
  const bool xy = (placed.scale.x < 0) != (placed.scale.y < 0);
  return xy != (placed.scale.z < 0);
}

MeshBatches::MeshBatches(World& world) : query_(world.query<const Transform, const MeshInstance>()) {}

void MeshBatches::group(World& world) {
  const MeshStore& meshes = world.singleton<const MeshStore>();
  const MaterialStore& materials = world.singleton<const MaterialStore>();
  const Version version = query_.version<MeshInstance>();
  if (version == grouped_ && known_meshes_ == meshes.size() && known_materials_ == materials.size()) return;
  grouped_ = version;
  ++groupings_;
  known_meshes_ = meshes.size();
  known_materials_ = materials.size();

  groups_.clear();
  group_of_row_.clear();
  const auto drawable = [&](const MeshInstance& m) {
    if (m.mesh >= known_meshes_) return false;
    if (m.material != MeshInstance::kOwnMaterials) return m.material < known_materials_;
    const std::vector<MeshPart>& parts = meshes.mesh(m.mesh).parts;
    return std::all_of(parts.begin(), parts.end(),
                       [&](const MeshPart& part) { return part.material < known_materials_; });
  };
  size_t refused = 0;
  MeshInstance example;
  query_.each([&](const Transform&, const MeshInstance& m) {
    if (drawable(m)) {
      groups_.push_back({m.mesh, m.material});
    } else if (refused++ == 0) {
      example = m;
    }
  });
  if (refused > 0)
    logWarning("deferred: {} mesh instances are not drawn; the first has mesh {} of {}, material {} of {}",
               refused, example.mesh, known_meshes_, example.material, known_materials_);
  std::sort(groups_.begin(), groups_.end());
  groups_.erase(std::unique(groups_.begin(), groups_.end()), groups_.end());
  query_.each([&](const Transform&, const MeshInstance& m) {
    const auto found = std::lower_bound(groups_.begin(), groups_.end(), Key{m.mesh, m.material});
    group_of_row_.push_back(drawable(m) ? static_cast<uint32_t>(found - groups_.begin()) : kNoGroup);
  });
  slots_.assign(2 * groups_.size(), MeshBatch());
  for (size_t i = 0; i < slots_.size(); ++i) {
    slots_[i].mesh = groups_[i / 2].mesh;
    slots_[i].material = groups_[i / 2].material;
    slots_[i].mirrored = i % 2 != 0;
    slots_[i].slot = static_cast<uint32_t>(i);
  }
}

void MeshBatches::place(World& world, const FrameInput& input, const View& view, bool sun,
                        ShadowCasters& casters) {
  const MeshStore& meshes = world.singleton<const MeshStore>();
  const double then = double{input.alpha} - input.motion_scale;
  placed_.clear();
  size_t row = 0;
  for (const Table* table : query_.tables()) {
    if (table->empty()) continue;
    const auto entities = table->entities();
    const auto transforms = table->read<Transform>();
    const bool casting_table = sun && table->has(componentId<CastsShadow>());
    std::span<const PreviousTransform> previous;
    if (table->has(componentId<PreviousTransform>())) previous = table->read<PreviousTransform>();
    for (size_t i = 0; i < entities.size(); ++i, ++row) {
      const uint32_t group = group_of_row_[row];
      if (group == kNoGroup) continue;
      const bool still = previous.empty() || same(previous[i], transforms[i]);
      const Transform now = still ? transforms[i] : interpolate(previous[i], transforms[i], input.alpha);
      const PlacedSphere sphere = boundingSphere(now, meshes.mesh(groups_[group].mesh).bounds);
      const bool sound = std::isfinite(glm::dot(sphere.center, sphere.center) + sphere.radius);
      const vec3 relative(sphere.center - view.position);
      const bool visible = sound && sphereInView(view, relative, sphere.radius);
      const bool casts = sound && casting_table && sphere.radius > 0;
      if (casts) casters.spheres.push_back({sphere.center, sphere.radius});
      if (!visible && !casts) continue;
      placed_.push_back({now, still ? now : interpolate(previous[i], transforms[i], then),
                         entities[i].index + 1, 2 * group + (mirrors(now) ? 1u : 0u), visible, casts, still});
      if (visible) {
        MeshBatch& slot = slots_[placed_.back().slot];
        slot.far_side_m = std::min(slot.far_side_m, glm::length(relative) + sphere.radius);
      }
    }
  }
}

bool MeshBatches::Caster::operator==(const Caster& other) const {
  return slot == other.slot && placed.position == other.placed.position &&
         placed.rotation == other.placed.rotation && placed.scale == other.placed.scale;
}

void MeshBatches::note(Noted& noted, Part part) const {
  noted.now.swap(noted.before);
  noted.now.clear();
  for (const Placed& p : placed_)
    if (belongs(p, part)) noted.now.push_back({p.slot, p.now});
  if (noted.now != noted.before || noted.groupings != groupings_) ++noted.version;
  noted.groupings = groupings_;
}

bool MeshBatches::belongs(const Placed& p, Part part) {
  return part == Part::Opaque ? p.visible : p.casts && p.still == (part == Part::CastingStill);
}

void MeshBatches::layOut(std::vector<MeshBatch>& batches, size_t& total, Part part) {
  for (MeshBatch& slot : slots_) slot.count = 0;
  for (const Placed& p : placed_)
    if (belongs(p, part)) ++slots_[p.slot].count;
  uint32_t first = 0;
  batches.clear();
  for (MeshBatch& slot : slots_) {
    slot.first = first;
    first += slot.count;
    if (slot.count > 0) batches.push_back(slot);
  }
  total = first;
}

void MeshBatches::update(World& world, const FrameInput& input, const View& view, bool sun,
                         ShadowCasters& casters) {
  group(world);
  for (MeshBatch& slot : slots_) slot.far_side_m = std::numeric_limits<float>::infinity();
  camera_ = view.position;
  previous_camera_ = view.previous_position;
  place(world, input, view, sun, casters);
  layOut(opaque_, opaque_count_, Part::Opaque);
  layOut(casting_still_, still_count_, Part::CastingStill);
  layOut(casting_moving_, moving_count_, Part::CastingMoving);
  note(noted_still_, Part::CastingStill);
  note(noted_moving_, Part::CastingMoving);
  // Near surfaces first, so that the depth test saves shading what they hide. By the spheres' far
  // sides: what ends nearer hides what goes on behind it, and a ground around the camera comes last.
  std::sort(opaque_.begin(), opaque_.end(), [](const MeshBatch& a, const MeshBatch& b) {
    return a.far_side_m != b.far_side_m ? a.far_side_m < b.far_side_m : a.first < b.first;
  });
}

void MeshBatches::setCursors(std::span<const MeshBatch> batches) const {
  cursor_.resize(slots_.size());
  for (const MeshBatch& batch : batches) cursor_[batch.slot] = batch.first;
}

void MeshBatches::writeOpaque(std::span<rules::MeshInstanceRecord> records) const {
  setCursors(opaque_);
  for (const Placed& p : placed_) {
    if (!p.visible) continue;
    rules::MeshInstanceRecord record{};
    writeRows(record.relative_from_local, p.now, camera_);
    writeRows(record.previous_relative_from_local, p.before, previous_camera_);
    record.id = p.id;
    record.mirrored = p.slot % 2;
    records[cursor_[p.slot]++] = record;
  }
}

void MeshBatches::writeCasting(bool still, const ShadowFit& fit,
                               std::span<rules::MeshCasterRecord> records) const {
  setCursors(casting(still));
  for (const Placed& p : placed_) {
    if (!belongs(p, still ? Part::CastingStill : Part::CastingMoving)) continue;
    rules::MeshCasterRecord record{};
    writeCasterRows(record.clip_from_local, fit, p.now);
    records[cursor_[p.slot]++] = record;
  }
}

}  // namespace scree
