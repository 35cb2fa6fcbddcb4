// scree_bench NAME [--quick] [--json FILE] [--plot DIR]
#include "tests/bench/bench.h"

int main(int argc, char** argv) {
  return scree::bench::runBenches(argc, argv);
}
