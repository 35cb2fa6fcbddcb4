// The GL context of benches that draw.
#pragma once

namespace scree::bench {

// Makes it at the first call, current; ends the program if there is none.
void openContext();

}  // namespace scree::bench
