// Ranges of a component's fields, for the fault() that a component may have.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

namespace scree {

// A field's value and the range that it must lie in, both ends included; NaN lies in none.
struct FieldRange {
  std::string_view field;
  double value;
  double low, high;
};

// The first that is out of its range, with its value and what is allowed; empty: none.
std::string firstFault(std::initializer_list<FieldRange> ranges);

}  // namespace scree
