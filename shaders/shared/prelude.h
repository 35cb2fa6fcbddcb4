// Lets one file of pure rules and structs compile as C++ and as GLSL.
// In C++ the rules live in namespace scree::rules and use GLM; in GLSL this file is empty.
#ifdef __cplusplus
#pragma once
#include <cmath>
#include <cstdint>

#include "engine/core/math.h"

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/packing.hpp>

namespace scree::rules {
using namespace glm;
using uint = uint32_t;
}  // namespace scree::rules
#define RULES_BEGIN namespace scree::rules {
#define RULES_END }
#define RULE inline
#else
#define RULES_BEGIN
#define RULES_END
#define RULE
#endif
