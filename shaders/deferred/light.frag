// Radiance of what the G-buffer holds: sun, sky and its own light.
// Defines: SUN (there is one), SHADOWS (and a shadow map).
#define GBUFFER_READ
#include "lib/gbuffer.glsl"
#include "lib/shadow.glsl"
#include "shared/brdf.h"
#include "shared/lighting.h"

layout(binding = kLobeTableUnit) uniform sampler2D lobe_table;

in vec3 ray;
layout(location = 0) out vec4 radiance;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  Surface s = readGbuffer(pixel);
  vec3 v = -normalize(ray);
  vec3 n = s.normal_ws;
  float n_v = clamp(dot(n, v), 1e-4, 1.0);
  float roughness = max(s.roughness, kMinRoughness);

  vec4 t = textureLod(lobe_table, lobeTableUv(n_v, roughness), 0.0);
  LobeTerms lobe = LobeTerms(t.x, t.y, t.z, t.w);
  Reflectance r = reflectance(s.albedo, s.metallic, lobe.a, lobe.b);
  vec3 sum = s.emissive + reflectSky(lighting.sky, r, lobe, n, v, n_v, roughness);
#ifdef SUN
  vec3 beam = reflectBeam(r, n, v, lighting.to_sun.xyz, n_v, alphaFromRoughness(roughness)) *
              lighting.sun_irradiance.rgb;
#ifdef SHADOWS
  vec3 position = ray * distanceFromDepth(view.near_m, gbufferDepth(pixel));
  beam *= sunVisibility(position, n);
#endif
  sum += beam;
#endif
  radiance = vec4(min(sum, vec3(kMaxRadiance)), 1.0);
}
