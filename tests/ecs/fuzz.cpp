// A million random operations agree with a naive model. The stress tier runs millions.
#include "tests/ecs/model_steps.h"

namespace scree {
namespace {

TEST(Fuzz, AgreesWithTheNaiveModel) {
  for (uint64_t seed : {1, 2, 3, 4}) {
    printf("seed %llu\n", static_cast<unsigned long long>(seed));
    SCOPED_TRACE("seed " + std::to_string(seed));
    Fuzzer(seed).run(250000);
  }
}

}  // namespace
}  // namespace scree
