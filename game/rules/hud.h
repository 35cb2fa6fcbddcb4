// The player's text: mass, time, state, and what the keys do.
#pragma once

#include "engine/app/app.h"

namespace scree::hourglass {

// Registers hourglass.hud (Animate).
void addHud(App& app);

}  // namespace scree::hourglass
