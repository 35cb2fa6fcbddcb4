// The system that computes the frame's View and gives it to the GPU. Private to the module.
#pragma once

namespace scree {

class World;

void prepareView(World& world);

}  // namespace scree
