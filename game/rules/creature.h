// The creature: walks where the player points, pushes with its plough, never leaves its ground.
#pragma once

#include "engine/app/app.h"

namespace scree::hourglass {

// Gives every Creature without one its motion, and the capsules of its plough and body. Called when
// a level was loaded.
void equipCreatures(World& world);

// Points the active camera at the first creature, if there is one.
void equipCamera(World& world);

// Registers creature.walk and creature.look (Simulate).
void addCreature(App& app);

}  // namespace scree::hourglass
