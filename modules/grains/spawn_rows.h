// New rows of grains, written grain by grain.
#pragma once

#include "engine/ecs/world.h"
#include "modules/grains/grains.h"

namespace scree::grains {

class NewGrains {
 public:
  explicit NewGrains(const TableRows& rows)
      : grain_(rows.column<Grain>()),
        velocity_(rows.column<GrainVelocity>()),
        spin_(rows.column<GrainSpin>()),
        orientation_(rows.column<GrainOrientation>()),
        previous_(rows.column<GrainPrevious>()),
        material_(rows.column<GrainMaterial>()),
        look_(rows.column<GrainLook>()) {}

  void put(size_t row, const GrainSpec& spec) const {
    grain_[row] = spec.grain;
    velocity_[row] = spec.velocity;
    spin_[row] = spec.spin;
    orientation_[row] = spec.orientation;
    previous_[row].position = spec.grain.position;
    material_[row] = spec.material;
    look_[row] = spec.look;
  }

 private:
  std::span<Grain> grain_;
  std::span<GrainVelocity> velocity_;
  std::span<GrainSpin> spin_;
  std::span<GrainOrientation> orientation_;
  std::span<GrainPrevious> previous_;
  std::span<GrainMaterial> material_;
  std::span<GrainLook> look_;
};

}  // namespace scree::grains
