// The guard band: around the picture, vertices that are not clipped.
layout(location = 0) uniform float guard;  // of clip space, the picture's share; 1: there is no band

vec4 guarded(vec4 clip) { return vec4(clip.xy * guard, clip.zw); }
// Shows nothing. Not clipped either, if there is a band: one clipped vertex costs all that are drawn with it.
vec4 nowhere() { return guard < 1.0 ? vec4(-1.0, -1.0, 0.5, 1.0) : vec4(0.0, 0.0, 2.0, 1.0); }
