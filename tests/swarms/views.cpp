// Debug views of swarms: their colours against the router's rules on the CPU, counts against masks, frozen lists, and
// that what is off costs nothing.
#include <algorithm>
#include <cmath>
#include <set>

#include "engine/gpu/counters.h"
#include "modules/impostors/impostors.h"
#include "modules/lod/state.h"
#include "modules/points/points.h"
#include "shaders/shared/swarm_view.h"
#include "tests/impostors/shapes.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

class SwarmViews : public GlTest {};

// Sizes, in pixels, from which on a ball is drawn as the next of them.
constexpr float kImpostorTo = 24, kLevels[] = {100, 60, 40};

struct ViewScene : SwarmScene {
  explicit ViewScene(ivec2 output) : SwarmScene(output) {
    addImpostors(app);
    addPoints(app);
    uniformSky(vec3(0.5f));
  }
  // With four levels, an impostor, and thresholds that are set, not measured.
  uint32_t addBall() {
    const GrainMesh grain = grainOf(globe(24));
    Result<ImpostorAtlas> atlas = bake(grain, {.edge = 4, .texels = 32, .supersample = 2, .directions = 0});
    GrainShape shape;
    shape.name = "ball";
    shape.center = atlas->center;
    shape.outer_radius = atlas->outer;
    shape.inner_radius = atlas->inner * atlas->outer;
    const int bands[] = {24, 16, 12, 8};
    for (size_t k = 0; k < rules::kMeshLevels; ++k) {
      const MeshData level = globe(bands[k]);
      const float error = k == 0 ? 0 : LodSettings{}.tolerance_px / kLevels[k - 1];
      shape.levels.push_back({world.singleton<MeshStore>().add("ball", std::span(&level, 1)), error});
    }
    shape.impostor = {{.size_px = rules::kSmallPx, .outline = 0.01f, .small_outline = 0.1f},
                      {.size_px = kImpostorTo, .outline = 0.02f, .small_outline = 1}};
    const uint32_t handle = world.singleton<SwarmStore>().addShape(std::move(shape));
    world.singleton<ImpostorStore>().set(handle, std::move(atlas).value());
    return handle;
  }
  LodSettings& settings() { return world.singleton<LodSettings>(); }
  std::vector<uint8_t> output() { return gpu::readBytes(app.frame().texture(Frame::kOutput), 4); }
  // Which grain each pixel shows, + 1.
  std::vector<uint32_t> shown() { return gpu::readUints(app.frame().texture(kSwarmVisible), 1); }
  size_t covered() {
    const std::vector<uint32_t> numbers = shown();
    return numbers.size() - static_cast<size_t>(std::count(numbers.begin(), numbers.end(), 0u));
  }
};

// Whether a pixel is a shade of the color.
bool isShadeOf(const uint8_t* pixel, vec3 color) {
  const float most = std::max({color.x, color.y, color.z}), lit = std::max({pixel[0], pixel[1], pixel[2]});
  if (lit < 0.3f * 255 * most) return false;
  for (int c = 0; c < 3; ++c)
    if (std::abs(static_cast<float>(pixel[c]) / lit - color[c] / most) > 0.03f) return false;
  return true;
}

TEST_F(SwarmViews, NoColorIsAShadeOfAnother) {
  std::vector<vec3> colors;
  for (uint32_t r = rules::kPoint; r < rules::kFirst; ++r) colors.push_back(rules::representationColor(r));
  for (size_t a = 0; a < colors.size(); ++a)
    for (size_t b = 0; b < a; ++b) {
      const vec3 x = colors[a] / std::max({colors[a].x, colors[a].y, colors[a].z}),
                 y = colors[b] / std::max({colors[b].x, colors[b].y, colors[b].z});
      EXPECT_GT(glm::length(x - y), 0.25f) << a << ", " << b;
    }
}

TEST_F(SwarmViews, EachRepresentationHasItsColor) {
  ViewScene scene({760, 300});
  constexpr float kAway = 500, kFov = 0.3f;
  scene.look({0, 0, kAway}, {0, 0, 0}, kFov);
  const float pixel = 2 * kAway * std::tan(0.5f * kFov) / 300;  // m
  std::vector<SwarmGrain> grains;
  const auto add = [&](float x_px, float y_px, float radius_px) {
    SwarmGrain grain;
    grain.position = vec3(x_px, y_px, 0) * pixel;
    grain.radius = radius_px * pixel;
    grains.push_back(grain);
  };
  // Points cover a pixel together.
  for (int k = 0; k < 64; ++k) add(-370.0f + 0.45f * static_cast<float>(k % 8), 0.45f * static_cast<float>(k / 8), 0.3f);
  float x = -355;
  for (const float radius_px : {2.5f, 12.0f, 30.0f, 50.0f, 80.0f, 130.0f}) {
    add(x + radius_px, 0, radius_px);
    x += 2 * radius_px + 8;
  }
  scene.show(scene.addBall(), grains);
  scene.render();
  const std::vector<uint8_t> plain = scene.output();
  scene.settings().view = SwarmView::Representation;
  scene.render();
  const std::vector<uint8_t> seen = scene.output();
  const auto& part = static_cast<const lod::Part&>(scene.drawn().part(0));
  const rules::SwarmBlock block = *static_cast<const rules::SwarmBlock*>(part.early.data);
  const rules::ViewBlock& view = scene.world.singleton<const View>().block;
  std::set<uint32_t> representations;
  std::vector<int> wrong(grains.size()), right(grains.size());
  size_t beside = 0;
  for (int py = 0; py < 300; ++py)
    for (int px = 0; px < 760; ++px) {
      const uint8_t* at = &seen[4 * scene.at(px, py)];
      bool near = false;
      for (size_t k = 0; k < grains.size(); ++k) {
        const vec3 center = grains[k].position - vec3(0, 0, kAway);
        const float radius_px = grains[k].radius / pixel;
        const float off = glm::length(vec2(px + 0.5f, py + 0.5f) - rules::pixelOf(view, center));
        near = near || off < 1.15f * radius_px + 2;  // spheres beside the middle look longer
        // Points: inside of their block.
        const bool is_point = radius_px < 1;
        if (is_point ? off > 0.4f || k % 8 < 2 || k % 8 > 5 || k < 16 || k >= 48 : off > 0.85f * radius_px) continue;
        const rules::SwarmRecord record = packed(grains[k], block.origin.w);
        const uint32_t expected =
            rules::representationOf(rules::sizePx(grains[k].radius, glm::length(center), view.pixels_at_1m),
                                    rules::ownShare(record.look, record.size), 0, block);
        representations.insert(expected);
        ++(isShadeOf(at, rules::representationColor(expected)) ? right : wrong)[k];
      }
      if (!near) beside += !std::equal(at, at + 4, &plain[4 * scene.at(px, py)]);
    }
  EXPECT_EQ(representations.size(), 7u);
  EXPECT_EQ(beside, 0u);
  for (size_t k = 0; k < grains.size(); ++k) {
    EXPECT_EQ(wrong[k], 0) << "grain " << k;
    if (k < 64) continue;
    EXPECT_GT(right[k], 3) << "grain " << k;
  }
  EXPECT_GT(*std::max_element(right.begin(), right.begin() + 64), 0);
}

TEST_F(SwarmViews, OverdrawCountsWhatIsWritten) {
  for (const uint32_t only : {rules::kMesh, rules::kImpostor}) {
    ViewScene scene({160, 120});
    scene.look({0, 0, 10}, {0, 0, 0});
    const uint32_t ball = scene.addBall();
    SwarmGrain far, near;
    near.position = vec3(0.8f, 0, 2.5f);
    const std::vector<SwarmGrain> first{far};
    scene.show(ball, first);
    scene.settings().only = only;
    scene.settings().view = SwarmView::Overdraw;
    // The first in the list is drawn first; both are the nearest in their cells.
    const auto counts = [&](const std::vector<SwarmGrain>& grains) {
      scene.world.singleton<SwarmStore>().replace(0, grains);
      scene.render();
      return scene.floats(kSwarmOverdraw, 1);
    };
    const std::vector<float> far_alone = counts({far}), near_alone = counts({near});
    const std::vector<float> far_first = counts({far, near}), near_first = counts({near, far});
    // Nothing but the counts is blended.
    const std::vector<float> albedo = scene.floats(kGbufferAlbedo, 4), normal = scene.floats(kGbufferNormal, 4);
    const std::vector<uint8_t> picture = scene.output();
    size_t both = 0, wrong = 0, off_color = 0;
    for (size_t p = 0; p < far_alone.size(); ++p) {
      EXPECT_LE(far_alone[p], 1);
      both += far_first[p] == 2;
      wrong += far_first[p] != far_alone[p] + near_alone[p];
      wrong += near_first[p] != std::max(far_alone[p], near_alone[p]);
      const vec3 color = rules::overdrawColor(near_first[p]) * 255.0f;
      for (int c = 0; c < 3; ++c)
        off_color += std::abs(static_cast<float>(picture[4 * p + static_cast<size_t>(c)]) - color[c]) > 1;
    }
    scene.settings().view = SwarmView::Off;
    scene.render();
    EXPECT_EQ(scene.floats(kGbufferAlbedo, 4), albedo);
    EXPECT_EQ(scene.floats(kGbufferNormal, 4), normal);
    EXPECT_GT(both, 100u) << only;
    EXPECT_EQ(wrong, 0u) << only;
    EXPECT_EQ(off_color, 0u) << only;
  }
}

TEST_F(SwarmViews, OverdrawCountsPoints) {
  ViewScene scene({40, 30});
  scene.look({0, 0, 10}, {0, 0, 0});
  SwarmGrain grain;
  grain.radius = 0.1f;  // so that all are drawn
  grain.position = vec3(0.03f, 0.02f, 0);      // not on the corner of four pixels
  const std::vector<SwarmGrain> grains(9, grain);
  scene.show(scene.addBall(), grains);
  scene.settings().view = SwarmView::Overdraw;
  for (int frame = 0; frame < 2; ++frame) {
    scene.render();
    std::vector<uint32_t> counts = gpu::readUints(scene.app.frame().texture(kPointOverdraw), 1);
    EXPECT_EQ(std::count(counts.begin(), counts.end(), 9u), 4);
    EXPECT_EQ(std::count(counts.begin(), counts.end(), 0u), 40 * 30 - 4);
  }
}

TEST_F(SwarmViews, FrozenKeepsWhatTheCameraLeftOut) {
  ViewScene scene({240, 160});
  const uint32_t ball = scene.addBall();
  scene.show(ball, cloud(4000, 1, 0.05f, 0.12f));
  scene.settings().only = rules::kImpostor;
  scene.look({0, 0, 5}, {0, 0, 0});
  for (int frame = 0; frame < 2; ++frame) scene.render();
  const std::vector<uint32_t> left_out = scene.routes(), from_front = scene.shown();
  EXPECT_GT(std::count(left_out.begin(), left_out.end(), rules::kNotDrawn), 1000);

  scene.settings().view = SwarmView::Frozen;
  scene.render();
  EXPECT_EQ(scene.shown(), from_front) << "what is culled hides nothing from the camera that culled it";
  scene.look({5, 1, 0}, {0, 0, 0});
  for (int frame = 0; frame < 2; ++frame) scene.render();
  EXPECT_EQ(scene.routes(), left_out);
  const std::vector<uint32_t> from_side = scene.shown(), ids = scene.ids();
  const std::vector<uint8_t> picture = scene.output();
  size_t wrong = 0, of_turn[2] = {};
  for (size_t p = 0; p < ids.size(); ++p) {
    if (ids[p] == 0) continue;
    wrong += ids[p] != (rules::kGrainIdBit | from_side[p]);
    const uint32_t route = left_out[from_side[p] - 1];
    wrong += route == rules::kNotDrawn || !isShadeOf(&picture[4 * p], rules::turnColor(route));
    ++of_turn[route >= rules::kFirst];
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(of_turn[0], 100u);
  EXPECT_GT(of_turn[1], 100u);

  scene.settings().view = SwarmView::Off;
  scene.render();
  size_t missing = 0;
  const std::vector<uint32_t> complete = scene.shown();
  for (size_t p = 0; p < complete.size(); ++p) missing += complete[p] != 0 && left_out[complete[p] - 1] == rules::kNotDrawn;
  EXPECT_GT(missing, 1000u) << "from the side nothing was missing: the test shows nothing";
  EXPECT_NE(scene.routes(), left_out);
}

TEST_F(SwarmViews, SwarmsThatComeWhileFrozenDoNoHarm) {
  ViewScene scene({60, 40});
  const uint32_t ball = scene.addBall();
  scene.settings().view = SwarmView::Frozen;
  scene.look({0, 0, 5}, {0, 0, 0});
  scene.render();
  const Entity first = scene.show(ball, cloud(100, 1, 0.1f, 0.2f));
  scene.render();
  EXPECT_GT(scene.covered(), 100u);
  scene.show(ball, cloud(1000, 1, 0.1f, 0.2f));
  scene.world.singleton<SwarmStore>().replace(0, cloud(500, 1, 0.1f, 0.2f));
  scene.render();
  for (const uint32_t number : scene.shown()) ASSERT_EQ(number, 0u);
  scene.world.destroy(first);
  scene.settings().view = SwarmView::Off;
  scene.render();
  EXPECT_GT(scene.covered(), 100u);
}

TEST_F(SwarmViews, CostNothingWhenOff) {
  ViewScene scene({120, 80});
  scene.look({0, 0, 5}, {0, 0, 0});
  // Meshes, impostors and points.
  scene.show(scene.addBall(), cloud(2000, 2, 0.001f, 0.6f));
  const auto cost = [&] {
    for (int frame = 0; frame < 3; ++frame) scene.render();
    const gpu::Counters before = gpu::counters();
    scene.render();
    return gpu::counters() - before;
  };
  const gpu::Counters off = cost();
  const char* const kPasses[] = {"lod.view_routes", "lod.view_turns", "lod.view_overdraw", "points.count"};
  for (const char* pass : kPasses) EXPECT_EQ(scene.app.frame().runCount(pass), 0u) << pass;
  EXPECT_EQ(scene.app.frame().runCount("points.sum"), 4u);
  for (const std::string_view target : {kSwarmOverdraw, kPointOverdraw}) EXPECT_FALSE(scene.app.frame().hasTexture(target));
  const uint64_t programs = gpu::counters().programs;
  for (const SwarmView view : {SwarmView::Representation, SwarmView::Overdraw, SwarmView::Frozen}) {
    scene.settings().view = view;
    scene.render();
  }
  EXPECT_GT(gpu::counters().programs, programs + 4);
  for (const char* pass : kPasses) EXPECT_EQ(scene.app.frame().runCount(pass), 1u) << pass;
  scene.settings().view = SwarmView::Off;
  const gpu::Counters again = cost();
  EXPECT_EQ(again.draws, off.draws);
  EXPECT_EQ(again.dispatches, off.dispatches);
  EXPECT_EQ(again.barriers, off.barriers);
  EXPECT_EQ(again.binds, off.binds);
  EXPECT_EQ(again.bytes_uploaded, off.bytes_uploaded);
  EXPECT_EQ(again.programs + again.buffers + again.textures + again.framebuffers, 0u);
}

}  // namespace
}  // namespace scree::test
