// Sorts mesh instances into batches that one draw call can draw, and culls them against the view.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/frame/frame.h"
#include "modules/deferred/deferred.h"
#include "modules/deferred/shadow_fit.h"
#include "shaders/shared/mesh_instance.h"

namespace scree {

// Instances of one mesh with one material override and one handedness, side by side in the records.
struct MeshBatch {
  uint32_t mesh = 0;
  uint32_t material = 0;  // MeshInstance::kOwnMaterials: each part's own
  bool mirrored = false;
  uint32_t first = 0;
  uint32_t count = 0;
  float far_side_m = 0;  // from the camera to the far side of the bounding sphere that ends nearest
  uint32_t slot = 0;    // internal: 2 * group + mirrored
};

inline uint32_t materialOf(const MeshBatch& batch, const MeshPart& part) {
  return batch.material == MeshInstance::kOwnMaterials ? part.material : batch.material;
}

// Bounding sphere of a placed mesh.
struct PlacedSphere {
  dvec3 center{0};  // world, m
  float radius = 0;
};
PlacedSphere boundingSphere(const Transform& placed, const LocalBounds& bounds);
// True if the transform turns the mesh inside out.
bool mirrors(const Transform& placed);

class MeshBatches {
 public:
  explicit MeshBatches(World& world);

  // True if the world has a mesh instance.
  bool any() const { return !query_.empty(); }
  // Without mesh instances there is no update: what is kept would be of an earlier scene.
  void forget() { opaque_count_ = still_count_ = moving_count_ = 0; }
  // Culls and counts; appends the casters' spheres to `casters` if there is a sun. Rows are grouped
  // anew only when MeshInstance values or the set of rows changed.
  void update(World& world, const FrameInput& input, const View& view, bool sun,
              ShadowCasters& casters);

  // Batches with something in view, by far_side_m, and how many records they take.
  std::span<const MeshBatch> opaque() const { return opaque_; }
  size_t opaqueCount() const { return opaque_count_; }
  void writeOpaque(std::span<rules::MeshInstanceRecord> records) const;
  // Batches that cast shadows, in view or not: of what stands still, or of what moves this frame.
  std::span<const MeshBatch> casting(bool still) const { return still ? casting_still_ : casting_moving_; }
  size_t castingCount(bool still) const { return still ? still_count_ : moving_count_; }
  void writeCasting(bool still, const ShadowFit& fit, std::span<rules::MeshCasterRecord> records) const;
  // Moves on when the casters that stand still, or where they stand, are others than before.
  uint64_t stillVersion() const { return noted_still_.version; }
  // The same of all casters.
  uint64_t castingVersion() const { return noted_still_.version + noted_moving_.version; }

 private:
  struct Key {
    uint32_t mesh, material;
    auto operator<=>(const Key&) const = default;
  };
  // What is drawn or casts this frame, in the order of rows.
  struct Placed {
    Transform now;
    Transform before;  // one frame ago
    uint32_t id;
    uint32_t slot;  // 2 * group + mirrored
    bool visible, casts, still;
  };
  // A caster where it is in a frame.
  struct Caster {
    uint32_t slot;
    Transform placed;
    bool operator==(const Caster& other) const;
  };
  struct Noted {
    std::vector<Caster> now, before;
    uint64_t groupings = 0;  // slots mean other meshes after a new grouping
    uint64_t version = 1;
  };
  enum class Part { Opaque, CastingStill, CastingMoving };
  static bool belongs(const Placed& p, Part part);
  void group(World& world);
  void place(World& world, const FrameInput& input, const View& view, bool sun,
             ShadowCasters& casters);
  void layOut(std::vector<MeshBatch>& batches, size_t& total, Part part);
  void note(Noted& noted, Part part) const;
  void setCursors(std::span<const MeshBatch> batches) const;

  Query<const Transform, const MeshInstance> query_;
  Version grouped_ = 0;
  uint64_t groupings_ = 0;
  size_t known_meshes_ = 0, known_materials_ = 0;
  std::vector<Key> groups_;
  std::vector<uint32_t> group_of_row_;  // all tables one after the other; kNoGroup: not drawable
  std::vector<Placed> placed_;
  std::vector<MeshBatch> slots_;  // two a group; far_side_m is of the frame, the rest scratch
  std::vector<MeshBatch> opaque_, casting_still_, casting_moving_;
  size_t opaque_count_ = 0, still_count_ = 0, moving_count_ = 0;
  Noted noted_still_, noted_moving_;
  dvec3 camera_{0}, previous_camera_{0};
  mutable std::vector<uint32_t> cursor_;  // scratch of the writers
};

}  // namespace scree
