// Grains by formula, of any ratio of inner to outer radius, for stacks of them.
#pragma once

#include "modules/impostors/grain_mesh.h"

namespace scree::bench {

// All with the outer radius 1.
GrainMesh needle(float inner);  // ellipsoid, two axes shorter
GrainMesh disc(float inner);    // ellipsoid, one axis shorter
GrainMesh cube();
GrainMesh star(float inner);    // a ball with blunt spikes, over a third of its directions

// The volume that a closed mesh encloses.
double volumeOf(const GrainMesh& grain);

}  // namespace scree::bench
