// The line about a field that is out of its range.
#include "engine/ecs/range.h"

#include <fmt/format.h>

#include <algorithm>

namespace scree {

std::string firstFault(std::initializer_list<FieldRange> ranges) {
  // Most fields are floats: a limit is allowed as the float nearest to it, too.
  const auto nearest = [](double limit) { return static_cast<double>(static_cast<float>(limit)); };
  for (const FieldRange& range : ranges)
    if (!(range.value >= std::min(range.low, nearest(range.low)) && range.value <= std::max(range.high, nearest(range.high))))
      return fmt::format("{} = {:g}; allowed is {:g} to {:g}", range.field, range.value, range.low,
                         range.high);
  return {};
}

}  // namespace scree
