// Radiance of what the G-buffer holds: sun, sky and its own light.
// Defines: SUN (there is one), SHADOWS (and a shadow map), DISPLAY (see lib/shaded.glsl), GBUFFER_READ_SPREAD
// (normals may be spread).
#define GBUFFER_READ
#include "lib/gbuffer.glsl"
#include "lib/shaded.glsl"
#include "lib/shadow.glsl"
#include "shared/brdf.h"
#include "shared/lighting.h"

#ifdef GBUFFER_READ_SPREAD
layout(binding = kLobeTableUnit) uniform sampler2DArray lobe_table;  // a layer a step of spread
#else
layout(binding = kLobeTableUnit) uniform sampler2D lobe_table;
#endif

in vec3 ray;
flat in LightingBlock lit;
flat in float near_m;
#ifdef SHADOWS
flat in vec4 shadow_rows[3];
flat in vec4 shadow_axes[3];
flat in vec3 shadow_size;

// What sunVisibility needs of it.
ShadowViewBlock shadowView() {
  ShadowViewBlock shadow;
  shadow.shadow_from_relative =
      transpose(mat4(shadow_rows[0], shadow_rows[1], shadow_rows[2], vec4(0.0, 0.0, 0.0, 1.0)));
  shadow.axis_x = shadow_axes[0];
  shadow.axis_y = shadow_axes[1];
  shadow.to_sun = shadow_axes[2];
  shadow.size_px = shadow_size.xy;
  shadow.texel_m = shadow_size.z;
  return shadow;
}
#endif

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  Surface s = readGbuffer(pixel);
  vec3 v = -normalize(ray);
  vec3 n = s.normal_ws;
  float n_v = clamp(dot(n, v), 1e-4, 1.0);
  float roughness = max(s.roughness, kMinRoughness);

  vec3 to_sun = lit.to_sun.xyz;
#ifdef GBUFFER_READ_SPREAD
  SpreadLook look = spreadLook(n, to_sun, roughness, s.spread);
  vec4 t = textureLod(lobe_table, vec3(lobeTableUv(n_v, roughness), float(spreadCode(s.spread))), 0.0);
  roughness = look.roughness;
  vec2 height = look.height;
#else
  vec4 t = textureLod(lobe_table, lobeTableUv(n_v, roughness), 0.0);
  vec2 height = vec2(n.y, n.y * n.y);
#endif
  LobeTerms lobe = LobeTerms(t.x, t.y, t.z, t.w);
  Reflectance r = reflectance(s.albedo, s.metallic, lobe.a, lobe.b);
  vec3 sum = s.emissive + reflectSky(lit.sky, r, lobe, n, v, n_v, roughness, height);
#ifdef SUN
#ifdef GBUFFER_READ_SPREAD
  vec3 beam = reflectSpreadBeam(r, n, v, to_sun, n_v, look);
#else
  vec3 beam = reflectBeam(r, n, v, to_sun, dot(n, to_sun), n_v, alphaFromRoughness(roughness));
#endif
  beam *= lit.sun_irradiance.rgb;
#ifdef SHADOWS
  vec3 position = ray * distanceFromDepth(near_m, gbufferDepth(pixel));
#ifdef GBUFFER_READ_SPREAD
  position -= n * (shadowNormalOffset(n, shadowView()) * spreadUnmoved(s.spread));
#endif
  beam *= sunVisibility(shadowView(), position, n);
#endif
  sum += beam;
#endif
  writeShaded(sum);
}
