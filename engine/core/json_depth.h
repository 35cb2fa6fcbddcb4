// How deeply a JSON text nests: parsers and printers that recurse end with the stack.
#pragma once

#include <cstddef>
#include <string_view>

namespace scree {

// Offset of the bracket that opens the first level below `max_depth`; npos: there is none. The text
// need not be valid JSON.
size_t findTooDeep(std::string_view json, int max_depth);

}  // namespace scree
