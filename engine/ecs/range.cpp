// The line about a field that is out of its range.
#include "engine/ecs/range.h"

#include <fmt/format.h>

namespace scree {

std::string firstFault(std::initializer_list<FieldRange> ranges) {
  for (const FieldRange& range : ranges)
    if (!(range.value >= range.low && range.value <= range.high))
      return fmt::format("{} = {:g}; allowed is {:g} to {:g}", range.field, range.value, range.low,
                         range.high);
  return {};
}

}  // namespace scree
