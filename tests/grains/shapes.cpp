// Sphere, hull, mesh and SDF colliders in a World: from files, refused, shared, moved, far away, asleep on.
#include <gtest/gtest.h>

#include "tests/assets/gltf_builder.h"
#include "tests/grains/app.h"
#include "tests/grains/meshes.h"

namespace scree::grains::test {
namespace {

using scree::test::GltfBuilder;
using scree::test::json;
using scree::test::TemporaryFolder;

void addGrain(World& world, vec3 position, float radius = 0.05f, vec3 velocity = vec3(0)) {
  GrainSpec spec;
  spec.grain = {position, radius};
  spec.velocity.linear = velocity;
  spec.material = {1000, 0.5f, 0.1f, 0};
  spawnGrains(world, {&spec, 1});
}

void run(App& app, int ticks) {
  for (int k = 0; k < ticks; ++k) app.tick();
}

std::vector<vec3> places(World& world) {
  std::vector<vec3> all;
  world.query<const Grain>().each([&](const Grain& g) { all.push_back(g.position); });
  return all;
}

const ColliderShapes& shapesOf(World& world) { return world.singleton<const ColliderShapes>(); }

// A file of nodes 10 m apart along x, each with a mesh (empty: none) and extras.
struct Node {
  const char* name;
  Soup soup;
  json extras;
};
Status loadNodes(World& world, const std::vector<Node>& nodes) {
  TemporaryFolder folder;
  GltfBuilder b;
  json roots = json::array();
  for (size_t k = 0; k < nodes.size(); ++k) {
    json node = {{"name", nodes[k].name}, {"translation", {10.0 * static_cast<double>(k), 0, 0}}, {"extras", nodes[k].extras}};
    if (!nodes[k].soup.empty()) {
      std::vector<float> numbers;
      vec3 low(1e9f), high(-1e9f);
      for (const vec3 p : nodes[k].soup) {
        numbers.insert(numbers.end(), {p.x, p.y, p.z});
        low = glm::min(low, p);
        high = glm::max(high, p);
      }
      const int position = b.addAccessor(numbers, "VEC3", {{"min", {low.x, low.y, low.z}}, {"max", {high.x, high.y, high.z}}});
      node["mesh"] = b.add("meshes", {{"name", nodes[k].name}, {"primitives", {{{"attributes", {{"POSITION", position}}}}}}});
    }
    roots.push_back(b.add("nodes", node));
  }
  b.doc["scenes"] = json::array({{{"nodes", roots}}});
  b.saveGltf(folder / "level.gltf");
  return loadScene(world, folder / "level.gltf");
}

const json kDefault = json::object();

TEST(Shapes, ComeFromTheExtrasOfAFile) {
  auto app = makeApp();
  World& world = app->world();
  const Soup ball = starSoup(4, [](vec3) { return 1.0f; });
  const Status loaded = loadNodes(world, {
      {"sphere", {}, {{"SphereCollider", {{"radius", 1.0}, {"center", {0, 0.25, 0}}}}}},
      {"hull", ball, {{"HullCollider", kDefault}}},
      {"sheet", floorSoup(1, 6, [](float, float) { return 0.5f; }), {{"MeshCollider", {{"thickness", 0.2}}}}},
      {"solid", ball, {{"MeshCollider", {{"solid", true}}}}},
      {"baked", ball, {{"SdfCollider", {{"resolution", 40}}}}}});
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  for (int k = 0; k < 5; ++k) addGrain(world, {10.0f * static_cast<float>(k), 2, 0});
  run(*app, 120);
  const std::vector<vec3> now = places(world);
  const float want[] = {1.3f, 1.05f, 0.65f, 1.05f, 1.05f};
  ASSERT_EQ(now.size(), 5u);
  for (size_t k = 0; k < 5; ++k) EXPECT_NEAR(now[k].y, want[k], k == 4 ? 4e-3 : 1e-3) << k;
  EXPECT_EQ(shapesOf(world).hulls, 1u);
  EXPECT_EQ(shapesOf(world).meshes, 2u);
  EXPECT_EQ(shapesOf(world).fields, 1u);
  EXPECT_EQ(shapesOf(world).kept, 4u);
  EXPECT_EQ(shapesOf(world).refused, 0u);
  EXPECT_GT(shapesOf(world).bytes, 10'000u);
}

TEST(Shapes, WhatWillNotDoIsRefusedWithOneLineEach) {
  auto app = makeApp();
  World& world = app->world();
  Soup open = boxSoup(vec3(-1), vec3(1));
  open.resize(open.size() - 3);
  Soup line;
  for (int k = 0; k < 5; ++k) addTriangle(line, {0, 0, 0}, {1, 1, 1}, {2, 2, 2});
  const Soup flat = floorSoup(1, 3, [](float, float) { return 0.0f; });
  // A file may not have these (grains.standing); a program may.
  world.spawn(Transform{}, makeName("no hull"), HullCollider{});
  world.spawn(Transform{}, makeName("no mesh"), MeshCollider{});
  world.spawn(Transform{}, makeName("no field"), SdfCollider{});
  ASSERT_TRUE(loadNodes(world, {{"flat hull", flat, {{"HullCollider", kDefault}}},
                                {"line", line, {{"MeshCollider", kDefault}}},
                                {"open solid", open, {{"MeshCollider", {{"solid", true}}}}},
                                {"open field", open, {{"SdfCollider", kDefault}}},
                                {"wrong number", flat, {{"SdfCollider", {{"field", 7}}}}},
                                {"good", flat, {{"MeshCollider", kDefault}}}}).ok());
  addGrain(world, {50, 0.5f, 0});
  testing::internal::CaptureStderr();
  run(*app, 60);
  const std::string log = testing::internal::GetCapturedStderr();
  const auto expectOnce = [&](const std::string& text) {
    const size_t first = log.find(text);
    EXPECT_NE(first, std::string::npos) << text << "\n" << log;
    EXPECT_EQ(log.find(text, first + 1), std::string::npos) << text << "\n" << log;
  };
  expectOnce("HullCollider of \"no hull\" refused: its node has no mesh");
  expectOnce("MeshCollider of \"no mesh\" refused: its node has no mesh");
  expectOnce("SdfCollider of \"no field\" refused: its node has no mesh");
  expectOnce("HullCollider of \"flat hull\" refused: mesh \"flat hull\": its 16 points lie in a plane");
  expectOnce("MeshCollider of \"line\" refused: mesh \"line\": none of its 5 triangles has an area");
  expectOnce("MeshCollider of \"open solid\" refused: mesh \"open solid\": it is not closed");
  expectOnce("SdfCollider of \"open field\" refused: mesh \"open field\": it is not closed");
  expectOnce("SdfCollider of \"wrong number\" refused: field = 7; the program has given 0");
  EXPECT_EQ(shapesOf(world).refused, 8u);
  EXPECT_NEAR(places(world)[0].y, 0.05, 1e-3);  // the good one holds
}

TEST(Shapes, AMeshTooThinForABodyStandsStill) {
  auto app = makeApp();
  World& world = app->world();
  ASSERT_TRUE(loadNodes(world, {{"plate", boxSoup({-1, -4e-6f, -1}, {1, 4e-6f, 1}), {{"HullCollider", kDefault}}}}).ok());
  Entity plate = Entity::kNone;
  world.query<const HullCollider>().each([&](Entity entity, const HullCollider&) { plate = entity; });
  world.add(plate, RigidBody{});
  testing::internal::CaptureStderr();
  run(*app, 3);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("RigidBody of \"plate\" refused: its mesh is 8e-06 m thick"), std::string::npos) << log;
  EXPECT_EQ(world.peek<Transform>(plate)->position.y, 0);
}

TEST(Shapes, NumbersOutOfRangeRefuseTheFile) {
  auto app = makeApp();
  const auto refused = [&](const json& extras, const std::string& text) {
    const Status loaded = loadNodes(app->world(), {{"node", boxSoup(vec3(-1), vec3(1)), extras}});
    ASSERT_FALSE(loaded.ok()) << text;
    EXPECT_NE(loaded.error().find(text), std::string::npos) << loaded.error();
    EXPECT_NE(loaded.error().find("\"node\""), std::string::npos) << loaded.error();
  };
  refused({{"SphereCollider", {{"radius", -1}}}}, "radius = -1");
  refused({{"HullCollider", {{"friction", -1}}}}, "friction = -1");
  refused({{"MeshCollider", {{"thickness", -0.5}}}}, "thickness = -0.5");
  refused({{"SdfCollider", {{"resolution", 1000}}}}, "resolution = 1000");
  refused({{"SdfCollider", {{"restitution", 2}}}}, "restitution = 2");
}

TEST(Shapes, AreMadeOnceAndSharedAndLetGo) {
  auto app = makeApp();
  World& world = app->world();
  const uint32_t mesh = addMesh(world, bumpySoup(3, 1));
  const Entity standing = world.spawn(at({0, -1, 0}), MeshInstance{mesh}, MeshCollider{});
  const Entity moving = world.spawn(at({5, 0, 0}), MeshInstance{mesh}, MeshCollider{});
  world.spawn(at({9, 0, 0}), MeshInstance{mesh}, HullCollider{});
  addGrain(world, {0, 1, 0});
  for (int k = 0; k < 100; ++k) {
    world.find<Transform>(moving)->position.x += 0.02;
    world.find<Transform>(moving)->rotation = glm::angleAxis(0.03f * static_cast<float>(k), vec3(0, 1, 0));
    app->tick();
  }
  EXPECT_EQ(shapesOf(world).meshes, 1u);
  EXPECT_EQ(shapesOf(world).hulls, 1u);
  world.find<Transform>(moving)->scale = vec3(2, 1, 1);
  run(*app, 3);
  EXPECT_EQ(shapesOf(world).meshes, 2u);  // another size, another shape
  EXPECT_EQ(shapesOf(world).kept, 3u);
  world.destroy(moving);
  run(*app, 90);
  EXPECT_EQ(shapesOf(world).kept, 2u);
  world.remove<MeshCollider>(standing);
  world.query<const HullCollider>().each([&](Entity e, const HullCollider&) { world.commands().destroy(e); });
  run(*app, 90);
  EXPECT_EQ(shapesOf(world).kept, 0u);
  EXPECT_EQ(shapesOf(world).meshes, 2u);
}

TEST(Shapes, AWorldWithoutThemMakesNone) {
  auto app = makeApp();
  World& world = app->world();
  addMesh(world, bumpySoup(3, 1));
  world.spawn(at({0, 0, 0}), PlaneCollider{});
  world.spawn(at({0, 0, 0}), BoxCollider{});
  world.spawn(at({0, 0, 0}), SphereCollider{});
  world.spawn(at({0, 0, 0}), MeshInstance{0});
  addGrain(world, {0, 3, 0});
  run(*app, 60);
  EXPECT_EQ(shapesOf(world).hulls + shapesOf(world).meshes + shapesOf(world).fields + shapesOf(world).kept, 0u);
  EXPECT_EQ(shapesOf(world).bytes, 0u);
}

// A mesh mirrored by its Transform keeps its outside outside.
TEST(Shapes, ScaleAppliesAndMayMirror) {
  auto app = makeApp();
  World& world = app->world();
  const uint32_t mesh = addMesh(world, starSoup(4, [](vec3) { return 1.0f; }));
  Transform transform = at({0, 0, 0});
  transform.scale = {-1, 0.5f, 1};
  world.spawn(transform, MeshInstance{mesh}, MeshCollider{.solid = true});
  transform.position.x = 10;
  world.spawn(transform, MeshInstance{mesh}, HullCollider{});
  transform.position.x = 20;
  world.spawn(transform, MeshInstance{mesh}, SdfCollider{});
  for (int k = 0; k < 3; ++k) addGrain(world, {10.0f * static_cast<float>(k), 1, 0});
  run(*app, 90);
  for (const vec3 p : places(world)) EXPECT_NEAR(p.y, 0.55, 5e-3) << p.x;
}

// A ring, by its formula.
struct Ring : DistanceField {
  SurfacePoint nearest(vec3 p) const override {
    const float around = std::sqrt(p.x * p.x + p.z * p.z);
    const vec3 centre = around > 0 ? vec3(p.x / around, 0, p.z / around) : vec3(1, 0, 0);
    const vec3 d = p - centre;
    const float length = glm::length(d);
    return {length > 0 ? d / length : vec3(0, 1, 0), length - 0.25f, 0};
  }
  std::array<vec3, 2> bounds() const override { return {vec3(-1.25f, -0.25f, -1.25f), vec3(1.25f, 0.25f, 1.25f)}; }
};

TEST(Shapes, AProgramsOwnField) {
  auto app = makeApp();
  World& world = app->world();
  const uint32_t ring = addDistanceField(world, std::make_shared<Ring>());
  EXPECT_EQ(ring, 1u);
  const Entity body = world.spawn(at({3, 1, 0}), SdfCollider{.field = ring, .friction = 2}, LoadSensor{});
  world.spawn(at({0, 0, 0}), PlaneCollider{});
  addGrain(world, {3, 1.5f, 0});      // through the hole
  addGrain(world, {4.0f, 1.5f, 0});   // onto the top of the ring, and off or not
  addGrain(world, {3, 1.34f, 1.0f});  // just above it
  run(*app, 3);
  EXPECT_NEAR(places(world)[2].y, 1.3, 0.03);
  run(*app, 100);
  EXPECT_NEAR(places(world)[0].y, 0.05, 1e-3);
  for (const vec3 p : places(world)) EXPECT_GT(Ring().nearest(p - vec3(3, 1, 0)).distance, 0.049f);
  // Turned on edge, with the grains inside of it: nothing is where it is.
  world.find<Transform>(body)->rotation = glm::angleAxis(1.5707963f, vec3(1, 0, 0));
  run(*app, 60);
  EXPECT_EQ(places(world).size(), 3u);
}

TEST(Shapes, BitForBitFarFromTheOrigin) {
  std::vector<vec3> want;
  const Soup rock = bumpySoup(2, 6, 0.5f), floor = floorSoup(3, 12, [](float x, float z) { return 0.125f * x * z; });
  for (const dvec3 origin : {dvec3(0, 0, 0), dvec3(1e6, 0, -1e6), dvec3(-3, 1e6, 7), dvec3(1e9, 1e9, 1e9)}) {
    auto app = makeApp();
    World& world = app->world();
    GrainBlock block;
    block.count = {7, 5, 7};
    block.radius_jitter = 0.2f;
    world.spawn(at(origin + dvec3(0, 2, 0)), block);
    world.spawn(at(origin + dvec3(0, -0.25, 0)), MeshInstance{addMesh(world, floor)}, MeshCollider{});
    const uint32_t mesh = addMesh(world, rock);
    world.spawn(at(origin + dvec3(0.5, 0.5, 0)), MeshInstance{mesh}, HullCollider{});
    world.spawn(at(origin + dvec3(-0.5, 0.5, 0.25)), MeshInstance{mesh}, SdfCollider{.resolution = 20});
    world.spawn(at(origin + dvec3(0, 0.5, -1)), SphereCollider{.radius = 0.5f});
    run(*app, 100);
    const std::vector<vec3> now = places(world);
    if (want.empty()) want = now;
    EXPECT_TRUE(now == want) << origin.x;
    EXPECT_EQ(now.size(), 245u);
  }
}

// Sleepers on a mesh: each counts once, though it leans on two sides; the mesh that moves wakes them.
TEST(Shapes, GrainsSleepOnAMeshAndWakeWithIt) {
  auto app = makeApp();
  World& world = app->world();
  Soup groove;
  addQuad(groove, {0, 0, -2}, {0, 0, 2}, {2, 2, 2}, {2, 2, -2});
  addQuad(groove, {-2, 2, -2}, {-2, 2, 2}, {0, 0, 2}, {0, 0, -2});
  const Entity body = world.spawn(at({0, 0, 0}), MeshInstance{addMesh(world, groove)}, MeshCollider{.friction = 0.5f}, LoadSensor{});
  double weight = 0;
  constexpr uint32_t kGrains = 8;
  for (uint32_t k = 0; k < kGrains; ++k) {
    addGrain(world, {0, 0.09f, 0.3f * static_cast<float>(k) - 1});
    weight += static_cast<double>(grainMass(0.05f, 1000)) * 9.81;
  }
  run(*app, 200);
  const auto sensed = [&] { return *world.peek<LoadSensor>(body); };
  EXPECT_EQ(world.singleton<const GrainStats>().asleep, kGrains);
  EXPECT_EQ(sensed().contacts, kGrains);
  EXPECT_NEAR(-static_cast<double>(sensed().impulse.y) * 60, weight, 0.005 * weight);
  for (int k = 0; k < 20; ++k) {
    world.find<Transform>(body)->position.y += 0.002;
    app->tick();
  }
  EXPECT_EQ(world.singleton<const GrainStats>().asleep, 0u);
  EXPECT_EQ(sensed().contacts, kGrains);
  for (const vec3 p : places(world)) EXPECT_NEAR(p.y, 0.04 + 0.05 * std::sqrt(2.0), 2e-3);
  run(*app, 120);
  EXPECT_EQ(world.singleton<const GrainStats>().asleep, kGrains);
  world.find<Transform>(body)->position.y -= 5;  // it goes away from under them
  run(*app, 10);
  EXPECT_EQ(world.singleton<const GrainStats>().asleep, 0u);
  for (const vec3 p : places(world)) EXPECT_LT(p.y, 0.05);
}

// In a groove a grain touches one mesh at two points: of one strike, the mesh is told once.
TEST(Shapes, AStrikeInAGrooveNamesTheMesh) {
  auto app = makeApp();
  World& world = app->world();
  GrainStrikes& strikes = world.singleton<GrainStrikes>();
  strikes.least_speed = 1;
  const uint32_t mesh = addMesh(world, floorSoup(1, 2, [](float x, float) { return std::abs(x); }));
  const Entity groove = world.spawn(at({0, 0, 0}), MeshInstance{mesh}, MeshCollider{});
  addGrain(world, {0, 1, 0});
  size_t told = 0;
  for (int tick = 0; tick < 60; ++tick) {
    app->tick();
    for (const GrainStrike& strike : strikes.list) {
      EXPECT_TRUE(strike.collider);
      EXPECT_EQ(strike.b, groove);
      ++told;
    }
    EXPECT_LE(strikes.list.size(), 1u);
  }
  EXPECT_GE(told, 1u);
}

}  // namespace
}  // namespace scree::grains::test
