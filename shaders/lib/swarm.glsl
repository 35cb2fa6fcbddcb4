// The grains of a swarm, as programs read them. Define SWARM_ROUTES to write representations.
#include "shared/swarm.h"
#include "shared/view.h"

layout(std140, binding = kPassBinding) uniform SwarmUniforms { SwarmBlock swarm; };
layout(std430, binding = kSwarmRecordsBinding) readonly buffer Records { SwarmRecord records[]; };
#ifdef SWARM_ROUTES
layout(std430, binding = kSwarmRepresentationsBinding) buffer Representations { uint representations[]; };
#else
layout(std430, binding = kSwarmRepresentationsBinding) readonly buffer Representations { uint representations[]; };
#endif
#ifdef SWARM_LISTED
layout(std430, binding = kSwarmListBinding) readonly buffer List { uint list[]; };
#endif

// Relative space, m.
vec3 centerOf(SwarmRecord grain) { return swarm.origin.xyz + vec3(grain.x, grain.y, grain.z); }
float radiusOf(SwarmRecord grain) { return radiusOf(grain.size, swarm.origin.w); }
uint idOf(uint grain) { return swarm.first_id + (swarm.same_id == 0u ? grain : 0u); }
