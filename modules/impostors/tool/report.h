// What scree_bake prints: progress on standard error, figures on standard output.
#pragma once

#include "modules/impostors/impostors.h"

namespace scree::tool {

// A bar that is redrawn in place; silent where standard error is no terminal.
class ProgressBar {
 public:
  ProgressBar();
  ~ProgressBar();  // clears the line
  void show(double done);

 private:
  bool terminal_;
  int shown_ = -1;
};

void printAtlas(const ImpostorAtlas& atlas, double seconds);
void printErrors(const ImpostorErrors& errors);

}  // namespace scree::tool
