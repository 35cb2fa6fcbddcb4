// Routing on the GPU against the same rules on the CPU, and what near grains look like.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "engine/gpu/counters.h"
#include "modules/lod/state.h"
#include "tests/lod/swarm_scene.h"

namespace scree::test {
namespace {

class Routing : public GlTest {};

std::vector<uint32_t> listOf(const SwarmPart& part, uint32_t representation) {
  rules::SwarmCommands commands{};
  gpu::readBuffer(*part.commands, &commands, sizeof(commands));
  return gpu::readBuffer<uint32_t>(*part.list, commands.count[representation], 4 * size_t{commands.begin[representation]});
}

// Routes by the rules that the GPU shares, in the CPU's arithmetic; `doubtful` where rounding may decide.
struct Expected {
  std::vector<uint32_t> route;
  std::vector<bool> doubtful;
};
Expected expectedRoutes(SwarmScene& scene, std::span<const rules::SwarmRecord> records, const rules::SwarmBlock& block) {
  const rules::ViewBlock& view = scene.world.singleton<const View>().block;
  Expected expected{std::vector<uint32_t>(records.size()), std::vector<bool>(records.size())};
  std::vector<uint32_t> nearest(rules::candidateBegin(scene.size, rules::kCandidateLevels));
  std::vector<uint32_t> cell(records.size()), key(records.size());
  for (size_t k = 0; k < records.size(); ++k) {
    const rules::SwarmRecord& record = records[k];
    const vec3 center = vec3(block.origin) + vec3(record.x, record.y, record.z);
    const float radius = rules::radiusOf(record.size, block.origin.w), distance = glm::length(center);
    bool outside = false;
    for (const vec4& plane : view.frustum_planes) {
      const float depth = glm::dot(vec3(plane), center) + plane.w;
      outside = outside || depth < -radius;
      if (std::abs(depth + radius) < 1e-5f * distance) expected.doubtful[k] = true;
    }
    const float size = rules::sizePx(radius, distance, view.pixels_at_1m);
    const float own = rules::ownShare(record.look, record.size);
    for (const float t : {block.point_px * (1 - rules::kPointSpread * own), block.impostor_px, block.impostor_from_px, block.small_px, block.mesh_px.y, block.mesh_px.z, block.mesh_px.w})
      if (std::abs(size - t) < 1e-5f * size) expected.doubtful[k] = true;
    expected.route[k] = outside ? rules::kNotDrawn : rules::representationOf(size, own, rules::kNotDrawn, block);
    if (expected.route[k] <= rules::kPoint) continue;
    cell[k] = rules::candidateCell(rules::pixelOf(view, center), size, block.candidate_cell, scene.size);
    key[k] = rules::candidateKey(distance);
    nearest[cell[k]] = std::max(nearest[cell[k]], key[k]);
  }
  for (size_t k = 0; k < records.size(); ++k) {
    if (expected.route[k] <= rules::kPoint) continue;
    const vec3 center = vec3(block.origin) + vec3(records[k].x, records[k].y, records[k].z);
    const vec2 pixel = rules::pixelOf(view, center);
    const float size = rules::sizePx(rules::radiusOf(records[k].size, block.origin.w), glm::length(center), view.pixels_at_1m);
    for (const vec2 d : {vec2(1e-3f, 0), vec2(-1e-3f, 0), vec2(0, 1e-3f), vec2(0, -1e-3f)})
      for (const float s : {0.99999f, 1.00001f})
        if (rules::candidateCell(pixel + d, size * s, block.candidate_cell, scene.size) != cell[k]) expected.doubtful[k] = true;
    if (nearest[cell[k]] - key[k] <= 4 && nearest[cell[k]] != key[k]) expected.doubtful[k] = true;
    if (nearest[cell[k]] == key[k]) expected.route[k] += rules::kFirst;
  }
  return expected;
}

// From the eye to the middle of each run's box, m.
std::vector<float> runDistances(const std::vector<rules::SwarmRecord>& records, const vec3& origin) {
  std::vector<float> distances;
  for (size_t first = 0; first < records.size(); first += rules::kRunGrains) {
    vec3 low(1e9f), high(-1e9f);
    for (size_t k = first; k < std::min(first + rules::kRunGrains, records.size()); ++k) {
      const vec3 p(records[k].x, records[k].y, records[k].z);
      low = glm::min(low, p), high = glm::max(high, p);
    }
    distances.push_back(glm::length(origin + 0.5f * (low + high)));
  }
  return distances;
}

void expectRoutes(SwarmScene& scene, uint32_t swarm, const char* what) {
  scene.render();
  const SwarmPart& part = scene.drawn().part(0);
  const auto& records = scene.world.singleton<const SwarmStore>().swarm(swarm).chunks[0];
  const lod::Part& drawn = static_cast<const lod::Part&>(part);
  const rules::SwarmBlock block = *static_cast<const rules::SwarmBlock*>(drawn.early.data);
  const Expected expected = expectedRoutes(scene, records, block);
  const std::vector<uint32_t> words = gpu::readBuffer<uint32_t>(drawn.routes->representations, (records.size() + 7) / 8);
  size_t wrong = 0, doubtful = 0, of[rules::kRepresentations] = {};
  std::vector<uint32_t> lists[rules::kRepresentations];
  for (uint32_t k = 0; k < records.size(); ++k) {
    const uint32_t route = words[k / 8] >> 4 * (k % 8) & 15;
    ASSERT_LT(route, rules::kRepresentations);
    ++of[route];
    lists[route].push_back(k);
    doubtful += expected.doubtful[k];
    // Behind the depth pyramid: tests/occlusion and the pictures below say whether rightly so.
    const bool hidden = route == rules::kHidden && expected.route[k] > rules::kPoint && expected.route[k] < rules::kFirst;
    wrong += route != expected.route[k] && !hidden && !expected.doubtful[k];
  }
  std::printf("%s:", what);
  for (const size_t n : of) std::printf(" %zu", n);
  std::printf("; %zu doubtful\n", doubtful);
  EXPECT_EQ(wrong, 0u) << what;
  // Passes that draw what no grain can be here are left out.
  for (uint32_t r = rules::kPoint; r < rules::kRepresentations; ++r)
    if (of[r] > 0 && r != rules::kHidden) {
      EXPECT_TRUE(scene.drawn().mayBe(r & (rules::kFirst - 1))) << what << ", representation " << r;
    }
  EXPECT_LE(doubtful, 20 + records.size() / 100) << what;
  // The lists are those of the routes: the nearest run first, a run in the order of its rows.
  const std::vector<float> distances = runDistances(records, vec3(block.origin));
  for (uint32_t r = rules::kSmallImpostor; r < rules::kRepresentations; ++r) {
    if (r == rules::kHidden) continue;  // in no list
    std::vector<uint32_t> list = listOf(part, r);
    float farthest = 0;
    size_t out_of_order = 0;
    for (size_t k = 1; k < list.size(); ++k) {
      const uint32_t run = list[k] / rules::kRunGrains, before = list[k - 1] / rules::kRunGrains;
      farthest = std::max(farthest, distances[before]);
      // Distances are rounded to steps of this size.
      out_of_order += run == before ? list[k - 1] >= list[k] : distances[run] < farthest - 1.001f * drawn.chunk->run_size;
    }
    EXPECT_EQ(out_of_order, 0u) << what << ", representation " << r;
    std::ranges::sort(list);
    EXPECT_EQ(list, lists[r]) << what << ", representation " << r;
  }
}

TEST_F(Routing, IsTheCpusAndListsAreInOrder) {
  for (const size_t count : {size_t{1}, size_t{63}, size_t{64}, size_t{65}, size_t{4096}, size_t{4097}, size_t{100003}}) {
    SwarmScene scene;
    GrainShape shape = scene.ballShape();
    shape.impostor = {{2, 0.05f, 0.1f}, {40, 0.01f, 0.1f}};
    scene.look({0, 0, 3}, {0, 0, 0});
    const std::vector<SwarmGrain> grains = cloud(count, 2, 0.001f, 0.3f);
    scene.show(scene.world.singleton<SwarmStore>().addShape(shape), grains);
    expectRoutes(scene, 0, std::to_string(count).c_str());
  }
}

// Runs that lie in one place each: many are points as a whole, or outside, beside those that are looked at.
TEST_F(Routing, OfCompactRunsToo) {
  for (const size_t count : {size_t{64}, size_t{65}, size_t{100003}})
    for (const double away : {2.0, 40.0, 120.0}) {
      SwarmScene scene;
      GrainShape shape = scene.ballShape();
      shape.impostor = {{0.1f, 0.1f, 1}, {40, 0.4f, 1}};
      scene.look({0, 0, away}, {0.7 * away, 0, 0});
      std::vector<SwarmGrain> grains = cloud(count, 2, 0.02f, 0.3f);
      for (size_t k = 0; k < grains.size(); ++k) {
        const size_t run = k / rules::kRunGrains;
        const auto unit = [&](uint32_t at) { return randomUnit(3, run, 0, at); };
        grains[k].position = 0.05f * grains[k].position + (vec3(unit(0), unit(1), unit(2)) * 2.0f - 1.0f) * vec3(60, 20, 20);
      }
      scene.show(scene.world.singleton<SwarmStore>().addShape(shape), grains);
      expectRoutes(scene, 0, (std::to_string(count) + " from " + std::to_string(away)).c_str());
    }
}

// By the sizes that its grains can have at most and at least, whatever they were drawn as.
TEST_F(Routing, PassesRunForSizesThatGrainsHave) {
  SwarmScene scene;
  GrainShape shape = scene.ballShape();
  shape.impostor = {{40, 0.01f, 0.1f}};
  scene.show(scene.world.singleton<SwarmStore>().addShape(shape), cloud(1000, 0.01f, 0.02f, 0.02f));  // eight a word
  scene.look({0, 0, 100}, {0, 0, 0});
  scene.render();
  const float pixels_at_1m = scene.world.singleton<const View>().block.pixels_at_1m;
  const LodThresholds t = thresholdsOf(shape, {}, pixels_at_1m);
  ASSERT_LT(t.point_px, t.small_px);
  ASSERT_LT(t.small_px, t.impostor_px);
  std::map<std::string_view, uint64_t> ran;
  const auto possibleAt = [&](double px) {
    scene.look({0, 0, 0.02 * static_cast<double>(pixels_at_1m) / px}, {0, 0, 0});
    scene.render();
    const lod::Part& part = static_cast<const lod::Part&>(scene.drawn().part(0));
    for (const uint32_t eight : gpu::readBuffer<uint32_t>(part.routes->representations, 1000 / 8))
      for (uint32_t shift = 0; shift < 32; shift += 4)
        if (const uint32_t route = eight >> shift & 15; route != rules::kHidden) {
          EXPECT_TRUE(scene.drawn().mayBe(route & (rules::kFirst - 1))) << px << " px, representation " << route;
        }
    std::string possible;
    for (uint32_t r = rules::kPoint; r <= rules::kMesh; ++r) possible += scene.drawn().mayBe(r) ? "psim"[r - rules::kPoint] : '-';
    // Passes that ran.
    for (const auto& [pass, letter] : {std::pair{"lod.list_late", 'L'}, {"lod.meshes", 'M'}})
      if (scene.app.frame().runCount(pass) > std::exchange(ran[pass], scene.app.frame().runCount(pass))) possible += letter;
    return possible;
  };
  EXPECT_EQ(possibleAt(0.5 * static_cast<double>(t.point_px)), "p---");
  EXPECT_EQ(possibleAt(static_cast<double>(t.point_px)), "ps--L");
  EXPECT_EQ(possibleAt(1.3 * static_cast<double>(t.point_px)), "-s--L");
  EXPECT_EQ(possibleAt(static_cast<double>(t.small_px)), "-si-L");
  EXPECT_EQ(possibleAt(1.5 * static_cast<double>(t.small_px)), "--i-L");
  EXPECT_EQ(possibleAt(static_cast<double>(t.impostor_px)), "--imLM");
  EXPECT_EQ(possibleAt(1.3 * static_cast<double>(t.impostor_px)), "---mLM");
  EXPECT_EQ(possibleAt(0.5 * static_cast<double>(t.point_px)), "p---");
  EXPECT_EQ(possibleAt(1.3 * static_cast<double>(t.impostor_px)), "---mLM");
  // A frozen picture keeps what it was made of.
  scene.world.singleton<LodSettings>().view = SwarmView::Frozen;
  scene.look({0, 0, 1e4}, {0, 0, 0});
  scene.render();
  EXPECT_TRUE(scene.drawn().mayBe(rules::kMesh));
  EXPECT_FALSE(scene.drawn().mayBe(rules::kPoint));
}

// Lists that had grains in the last frame are empty in one that has none of them.
TEST_F(Routing, ListsEmptyAgain) {
  SwarmScene scene;
  GrainShape shape = scene.ballShape();
  shape.impostor = {{0.1f, 0.1f, 1}, {40, 0.4f, 1}};
  scene.show(scene.world.singleton<SwarmStore>().addShape(shape), cloud(3000, 2, 0.02f, 0.3f));
  const auto listed = [&] {
    size_t all = 0;
    for (uint32_t r = rules::kSmallImpostor; r < rules::kRepresentations; ++r)
      if (scene.drawn().mayBe(r & (rules::kFirst - 1))) all += listOf(scene.drawn().part(0), r).size();
    return all;
  };
  for (int round = 0; round < 3; ++round) {
    scene.look({0, 0, 5}, {0, 0, 0});
    scene.render();
    EXPECT_GT(listed(), 1000u) << round;
    scene.look({0, 0, 5000}, {0, 0, 0});  // all are points
    scene.render();
    EXPECT_EQ(listed(), 0u) << round;
    scene.look({0, 0, 5}, {0, 0, 10});  // behind the eye
    scene.render();
    EXPECT_EQ(listed(), 0u) << round;
  }
}

TEST_F(Routing, WhatWasSeenIsDrawnFirst) {
  SwarmScene scene;
  scene.look({0, 0, 3}, {0, 0, 0});
  scene.show(scene.addShape(), cloud(2000, 1, 0.02f, 0.1f));
  scene.render();
  const std::vector<uint32_t> visible = gpu::readUints(scene.app.frame().texture(kSwarmVisible), 1);
  scene.render();
  const lod::Part& part = static_cast<const lod::Part&>(scene.drawn().part(0));
  const std::vector<uint32_t> words = gpu::readBuffer<uint32_t>(part.routes->representations, 2000 / 8);
  size_t shown = 0;
  for (const uint32_t number : visible) {
    if (number == 0) continue;
    ++shown;
    EXPECT_GE(words[(number - 1) / 8] >> 4 * ((number - 1) % 8) & 15, rules::kFirst) << "grain " << number - 1;
  }
  EXPECT_GT(shown, 1000u);
}

TEST_F(Routing, EmptySwarmsAndNoSwarms) {
  SwarmScene scene;
  scene.render();
  EXPECT_EQ(scene.app.frame().runCount("lod.classify"), 0u);
  const gpu::Counters before = gpu::counters();
  scene.render();
  const gpu::Counters spent = gpu::counters() - before;
  EXPECT_EQ(spent.dispatches, 0u);
  EXPECT_EQ(spent.buffers, 0u);
  EXPECT_EQ(spent.programs, 0u);
  scene.show(scene.addShape(), {});
  scene.render();
  EXPECT_EQ(scene.app.frame().runCount("lod.classify"), 0u);
}

TEST_F(Routing, GoneSwarmsAreNotDrawn) {
  SwarmScene scene;
  scene.look({0, 0, 3}, {0, 0, 0});
  const Entity entity = scene.show(scene.addShape(), cloud(100, 1, 0.1f, 0.2f));
  scene.render();
  EXPECT_EQ(scene.app.frame().runCount("lod.meshes"), 1u);
  scene.world.destroy(entity);
  scene.render();
  EXPECT_EQ(scene.app.frame().runCount("lod.meshes"), 1u);
  EXPECT_EQ(scene.drawn().size(), 0u);
}

TEST_F(Routing, MeshesAreWhereTheGrainsAre) {
  SwarmScene scene;
  scene.look({0, 0, 4}, {0, 0, 0});
  const std::vector<SwarmGrain> grains = cloud(200, 1, 0.05f, 0.15f);
  const Entity entity = scene.show(scene.addShape(), grains, dvec3(1e6, 0, 0));
  scene.look(dvec3(1e6, 0, 4), dvec3(1e6, 0, 0));
  scene.render();
  // Every pixel against the spheres: outlines of the mesh lie within them.
  const std::vector<uint32_t> id = gpu::readUints(scene.app.frame().texture(kGbufferId), 1);
  const double tan_y = std::tan(0.5 * static_cast<double>(scene.world.peek<Camera>(scene.camera)->fov_y_rad));
  size_t covered = 0, wrong = 0;
  for (int y = 0; y < scene.size.y; ++y)
    for (int x = 0; x < scene.size.x; ++x) {
      const dvec3 ray = glm::normalize(dvec3((2 * (x + 0.5) / scene.size.x - 1) * tan_y * scene.size.x / scene.size.y,
                                             (2 * (y + 0.5) / scene.size.y - 1) * tan_y, -1));
      double most = -1e9;  // how deep the ray goes into a grain, m
      for (const SwarmGrain& grain : grains) {
        const dvec3 to = dvec3(grain.position) - dvec3(0, 0, 4);
        const double along = glm::dot(to, ray);
        most = std::max(most, static_cast<double>(grain.radius) - glm::length(to - along * ray));
      }
      const bool drawn = id[static_cast<size_t>(y) * static_cast<size_t>(scene.size.x) + static_cast<size_t>(x)] == entity.index + 1;
      covered += drawn;
      const double pixel = 8 * tan_y / scene.size.y;
      const bool off = drawn ? most < -0.1 * pixel : most > 1.5 * pixel;
      wrong += off;

    }
  EXPECT_GT(covered, 1000u);
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace scree::test
