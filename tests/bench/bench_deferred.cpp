// Deferred shading: frame time against error over the shadow map's resolution and filter, and over
// truth mode's samples.
#include <algorithm>
#include <cmath>
#include <memory>

#include "engine/app/app.h"
#include "engine/core/hash.h"
#include "engine/core/log.h"
#include "engine/gpu/gl.h"
#include "engine/gpu/load.h"
#include "engine/gpu/readback.h"
#include "modules/deferred/deferred.h"
#include "modules/scene/scene.h"
#include "tests/bench/bench.h"
#include "tests/bench/gl_context.h"

namespace scree::bench {
namespace {

constexpr ivec2 kSize{640, 360};

MeshData box() {
  MeshData m;
  m.name = "box";
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      vec3 n(0), u(0), v(0);
      n[axis] = side;
      u[(axis + 1) % 3] = 1;
      v[(axis + 2) % 3] = side;
      const auto first = static_cast<uint32_t>(m.vertices.size());
      for (const vec2 c : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)})
        m.vertices.push_back({n + c.x * u + c.y * v, n, vec4(u, 1), c * 0.5f + 0.5f});
      m.indices.insert(m.indices.end(), {first, first + 1, first + 2, first, first + 2, first + 3});
    }
  computeBounds(m);
  return m;
}

// Turned boxes on a floor under a slanting sun: many shadow edges.
struct Yard {
  App app{AppOptions{}};

  Yard() {
    addScene(app);
    addDeferred(app);
    app.frame().keep(kRadiance, true);
    World& world = app.world();
    const uint32_t mesh = world.singleton<MeshStore>().add(box());
    const auto put = [&](dvec3 p, vec3 scale, float turn) {
      const Transform t{p, glm::angleAxis(turn, vec3(0, 1, 0)), scale};
      world.spawn(t, previousOf(t), MeshInstance{mesh, 0}, CastsShadow{});
    };
    put({0, -0.1, 0}, vec3(8, 0.1f, 8), 0);
    for (int i = 0; i < 64; ++i)
      put({i % 8 * 1.7 - 6, 0.3, i / 8 * 1.7 - 6}, vec3(0.2f, 0.3f + 0.05f * static_cast<float>(i % 5), 0.2f), 0.37f * static_cast<float>(i));
    const Transform sun{dvec3(0), glm::quatLookAt(glm::normalize(vec3(-1, -1.2f, -0.6f)), vec3(0, 1, 0)), vec3(1)};
    Light light;
    light.intensity = 3;
    world.spawn(sun, previousOf(sun), light);
    const Transform eye{{0, 6, 10}, glm::angleAxis(-0.6f, vec3(1, 0, 0)), vec3(1)};
    world.singleton<ActiveCamera>().entity = world.spawn(eye, previousOf(eye), Camera{});
  }
  void render(int samples = 1) {
    app.render(kSize, 1, 1, samples);
    glFinish();
  }
  std::vector<float> radiance(int samples) {
    render(samples);
    return gpu::readFloats(app.frame().texture(samples > 1 ? kTruth : kRadiance), 4);
  }
};

double rmse(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += (static_cast<double>(a[i]) - b[i]) * (static_cast<double>(a[i]) - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

uint64_t hashOf(const std::vector<float>& values) { return hashBytes(values.data(), values.size() * sizeof(float)); }

SCREE_BENCH(deferred, "shading: shadow map and truth samples against error") {
  openContext();
  bench.fact("gl_renderer", gpu::limits().renderer);
  Yard yard;
  ShadowSettings& shadows = yard.app.world().singleton<ShadowSettings>();

  // Reference: the largest map; error of one frame without anti-aliasing on either side.
  shadows = {.side_texels = rules::kShadowMapSize};
  const auto finest = yard.radiance(1);
  struct Setting {
    int side;
    bool single_fetch;
  };
  std::vector<Setting> settings;
  for (const int side : {256, 512, 1024, 2048})
    for (const bool single : {true, false}) settings.push_back({side, single});
  std::vector<Variant> variants;
  for (const Setting& s : settings)
    variants.push_back({fmt::format("{} {}", s.side, s.single_fetch ? "2x2" : "3x3"),
                        [&yard] { yard.render(); },
                        [&shadows, s] { shadows = {.side_texels = s.side, .single_fetch = s.single_fetch}; }});
  const Paired timed = bench.paired(variants);
  for (size_t i = 0; i < settings.size(); ++i) {
    shadows = {.side_texels = settings[i].side, .single_fetch = settings[i].single_fetch};
    const auto picture = yard.radiance(1);
    bench.row({.scenario = "shadow map", .label = variants[i].name,
               .knobs = {{"side_texels", settings[i].side}, {"taps", settings[i].single_fetch ? 1 : 9}},
               .time_ms = timed.variants[i].median_ms, .error = rmse(picture, finest),
               .error_kind = "rmse of radiance against 2048 texels, 3x3", .hash = hashOf(picture),
               .baseline = settings[i].single_fetch});
  }
  bench.claimAtMost("time of 1024 / 2048 texels, 3x3", timed.ratio(5, 7).median, 1.02);

  shadows = {};
  const auto truth = yard.radiance(bench.quick() ? 512 : 4096);
  std::vector<int> samples = {1, 4, 16, 64};
  std::vector<Variant> runs;
  for (const int n : samples) runs.push_back({fmt::format("{}", n), [&yard, n] { yard.render(n); }});
  const Paired truth_timed = bench.paired(runs);
  std::vector<double> errors;
  for (size_t i = 0; i < samples.size(); ++i) {
    const auto picture = yard.radiance(samples[i]);
    errors.push_back(rmse(picture, truth));
    bench.row({.scenario = "truth", .label = runs[i].name, .knobs = {{"samples", samples[i]}},
               .time_ms = truth_timed.variants[i].median_ms, .error = errors.back(),
               .error_kind = "rmse of radiance against many samples", .hash = hashOf(picture),
               .baseline = samples[i] == 1});
  }
  bench.claimAtMost("error of 64 samples / 1 sample", errors[3] / errors[0], 0.15);
}

}  // namespace
}  // namespace scree::bench
