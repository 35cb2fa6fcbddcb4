// An impostor's atlas, as programs read it; layout and meaning: modules/impostors/atlas.h.
#include "shared/bindings.h"
#include "shared/impostor.h"
#include "shared/rotation.h"

layout(std140, binding = kDrawBinding) uniform AtlasUniforms { ImpostorBlock atlas; };
layout(binding = kImpostorShapeUnit) uniform sampler2DArray atlas_shape;

// A vector of the world in the grain's axes.
vec3 toGrain(vec4 rotation, vec3 v) { return rotateBy(vec4(-rotation.xyz, rotation.w), v); }
