// Six million random operations, by six seeds, agree with a naive model.
#include "tests/ecs/model_steps.h"

namespace scree {
namespace {

TEST(StressFuzz, AgreesWithTheNaiveModel) {
  for (uint64_t seed : {11, 22, 33, 44, 55, 66}) {
    printf("seed %llu\n", static_cast<unsigned long long>(seed));
    SCOPED_TRACE("seed " + std::to_string(seed));
    Fuzzer(seed).run(1000000);
  }
}

}  // namespace
}  // namespace scree
