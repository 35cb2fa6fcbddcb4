// What a level may not put alone, twice, or outside the field's bounds: each is one line, and nothing is spawned.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "modules/grains/grains.h"
#include "modules/scene/scene.h"
#include "tests/grains/meshes.h"

namespace scree::grains::test {
namespace {

using nlohmann::json;

class Standing : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "scree_standing_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Mesh 0 is mesh_, or a triangle.
  Status load(World& world, const json& nodes) {
    json doc = json::parse(R"({"asset": {"version": "2.0"},
      "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
      "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
      "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.25}}]})");
    if (!mesh_.empty()) {
      std::ofstream(folder_ / "mesh.bin", std::ios::binary)
          .write(reinterpret_cast<const char*>(mesh_.data()), static_cast<std::streamsize>(mesh_.size() * sizeof(vec3)));
      const size_t bytes = mesh_.size() * sizeof(vec3);
      doc["buffers"][0] = {{"byteLength", bytes}, {"uri", "mesh.bin"}};
      doc["bufferViews"][0]["byteLength"] = bytes;
      doc["accessors"][0]["count"] = mesh_.size();
    }
    doc["nodes"] = nodes;
    doc["nodes"].push_back({{"name", "eye"}, {"camera", 0}});
    const std::filesystem::path path = folder_ / "level.gltf";
    std::ofstream(path) << doc.dump();
    return loadScene(world, path);
  }
  void refused(const std::string& nodes, const std::vector<std::string>& expected) {
    World world;
    const Entity before = world.spawn(Transform{});
    const Status status = load(world, json::parse(nodes));
    ASSERT_FALSE(status.ok()) << nodes;
    for (const std::string& text : expected)
      EXPECT_NE(status.error().find(text), std::string::npos) << "lacks '" << text << "': " << status.error();
    EXPECT_NE(status.error().find("level.gltf: node "), std::string::npos) << status.error();
    EXPECT_EQ(std::count(status.error().begin(), status.error().end(), '\n'), 0) << status.error();
    EXPECT_EQ(world.entityCount(), 1u) << nodes;
    EXPECT_TRUE(world.alive(before));
    EXPECT_EQ(world.singleton<ActiveCamera>().entity, Entity::kNone);
  }
  void taken(const std::string& nodes) {
    World world;
    const Status status = load(world, json::parse(nodes));
    EXPECT_TRUE(status.ok()) << nodes << ": " << status.error();
  }

  std::filesystem::path folder_;
  Soup mesh_;
};

std::string alone(const std::string& extras) { return R"([{"name": "thing", "extras": {)" + extras + "}}]"; }

TEST_F(Standing, WhatDoesNothingAlone) {
  const auto lacks = [&](const std::string& extras, const std::string& component, const std::string& what) {
    refused(alone(extras), {"\"thing\": extras: " + component + ": ", what});
  };
  lacks(R"("ClumpShape": {"name": "bean"})", "ClumpShape", "GrainBlock or a GrainEmitter");
  lacks(R"("LoadSensor": {})", "LoadSensor", "collider");
  lacks(R"("BodyHinge": {}, "BoxCollider": {})", "BodyHinge", "RigidBody");
  lacks(R"("BodySlider": {}, "BoxCollider": {})", "BodySlider", "RigidBody");
  lacks(R"("BodyHinge": {}, "BodySlider": {}, "RigidBody": {}, "BoxCollider": {})", "BodySlider", "both");
  lacks(R"("RigidBody": {})", "RigidBody", "0 colliders; a body has one");
  lacks(R"("RigidBody": {}, "BoxCollider": {}, "SphereCollider": {})", "RigidBody", "2 colliders; a body has one");
  lacks(R"("RigidBody": {}, "PlaneCollider": {})", "RigidBody", "plane");
  lacks(R"("HullCollider": {})", "HullCollider", "no mesh");
  lacks(R"("MeshCollider": {})", "MeshCollider", "no mesh");
  lacks(R"("SdfCollider": {})", "SdfCollider", "no mesh");
  refused(R"([{"name": "thing", "mesh": 0, "extras": {"RigidBody": {}, "MeshCollider": {}}}])", {"RigidBody: ", "sheet"});
}

TEST_F(Standing, WhatHasItsPartner) {
  taken(alone(R"("ClumpShape": {"name": "bean"}, "GrainBlock": {})"));
  taken(alone(R"("ClumpShape": {"name": "bean"}, "GrainEmitter": {})"));
  for (const char* collider : {"PlaneCollider", "BoxCollider", "CapsuleCollider", "SphereCollider"})
    taken(alone(std::string(R"("LoadSensor": {}, ")") + collider + R"(": {})"));
  for (const char* collider : {"HullCollider", "MeshCollider", "SdfCollider"})
    taken(std::string(R"([{"mesh": 0, "extras": {"LoadSensor": {}, ")") + collider + R"(": {}}}])");
  taken(alone(R"("SdfCollider": {"field": 1})"));
  taken(alone(R"("BodyHinge": {}, "RigidBody": {}, "BoxCollider": {})"));
  taken(alone(R"("BodySlider": {}, "RigidBody": {}, "BoxCollider": {})"));
}

TEST_F(Standing, ASecondField) {
  refused(R"([{"name": "one", "extras": {"GrainField": {}}}, {"name": "two", "extras": {"GrainField": {}}}])",
          {"\"two\": extras: GrainField: ", "\"one\" has it"});
  World world;
  ASSERT_TRUE(load(world, json::parse(alone(R"("GrainField": {})"))).ok());
  const size_t entities = world.entityCount();
  EXPECT_FALSE(load(world, json::parse(alone(R"("GrainField": {})"))).ok()) << "of another file";
  EXPECT_EQ(world.entityCount(), entities);
}

// A plate 1 m wide; of a plate, twice the volume over the area is its thickness.
TEST_F(Standing, ABodyOfAMeshThatIsTooThin) {
  for (const char* collider : {R"("HullCollider": {})", R"("MeshCollider": {"solid": true})"}) {
    const auto nodes = [&](const char* more) {
      return std::string(R"([{"name": "plate", "mesh": 0, "scale": [1, 0.5, 1], "extras": {)") + collider + more + "}}]";
    };
    mesh_ = boxSoup({-0.5f, -9e-6f, -0.5f}, {0.5f, 9e-6f, 0.5f});
    refused(nodes(R"(, "RigidBody": {})"), {"\"plate\": extras: RigidBody: ", "9e-06 m thick", "1e-05 m or more"});
    taken(nodes(""));
    mesh_ = boxSoup({-0.5f, -11e-6f, -0.5f}, {0.5f, 11e-6f, 0.5f});
    taken(nodes(R"(, "RigidBody": {})"));
  }
  mesh_ = boxSoup(vec3(-0.5f), vec3(0.5f));
  for (size_t k = 0; k < mesh_.size(); k += 3) std::swap(mesh_[k], mesh_[k + 1]);
  refused(R"([{"mesh": 0, "extras": {"RigidBody": {}, "MeshCollider": {"solid": true}}}])", {"-0.333 m thick"});
  mesh_.resize(9);
  refused(R"([{"mesh": 0, "extras": {"RigidBody": {}, "MeshCollider": {"solid": true}}}])", {"not closed"});
}

// The field is 18 x 11 x 18 m, 1,000 m from the world's origin.
std::string within(const std::string& node) {
  return R"([{"extras": {"GrainField": {"placed": true, "origin": [1000, 0, 0], "bounds_min": [-9, -2, -9],
             "bounds_max": [9, 9, 9]}}}, {"name": "thing", )" + node + "}]";
}

TEST_F(Standing, OutsideTheBounds) {
  const std::string block = R"("extras": {"GrainBlock": {"count": [4, 2, 2], "radius": 0.5, "spacing": 1}})";
  refused(within(R"("translation": [1100, 1, 0], )" + block),
          {"\"thing\": extras: GrainBlock: ", "x = 98.5 to 101.5", "bounds_min.x = -9", "bounds_max.x = 9"});
  refused(within(R"("translation": [1000, -3, 0], )" + block), {"y = -3.5 to -2.5", "bounds_min.y = -2"});
  // The outermost centres are 1.5 m from the middle, along x, or turned, along z.
  taken(within(R"("translation": [1007.49, 1, 0], )" + block));
  refused(within(R"("translation": [1007.51, 1, 0], )" + block), {"x = "});
  taken(within(R"("translation": [1008.49, 1, 0], "rotation": [0, 0.70710678, 0, 0.70710678], )" + block));
  refused(within(R"("translation": [1000, 1, 8], "rotation": [0, 0.70710678, 0, 0.70710678], )" + block), {"z = "});
  taken(within(R"("translation": [1100, 1, 0], "extras": {"GrainBlock": {"count": [4, 0, 2]}})"));

  const std::string emitter = R"("extras": {"GrainEmitter": {"mouth": 2}})";
  taken(within(R"("translation": [1006.99, 1, 0], )" + emitter));
  refused(within(R"("translation": [1007.01, 1, 0], )" + emitter), {"GrainEmitter: ", "x = 5.01 to 9.01"});
  taken(within(R"("translation": [1000, -1.99, 0], )" + emitter));
  refused(within(R"("translation": [1000, -1.99, 0], "rotation": [0.70710678, 0, 0, 0.70710678], )" + emitter), {"y = "});
  taken(within(R"("translation": [1100, 0, 0], "extras": {"GrainEmitter": {"on": false}})"));

  const std::string body = R"("extras": {"RigidBody": {}, "BoxCollider": {}})";
  taken(within(R"("translation": [1008.9, 1, 0], )" + body));
  refused(within(R"("translation": [1009.1, 1, 0], )" + body), {"RigidBody: ", "x = 9.1 from"});
}

// Members of a clump may be farther out than its centre.
TEST_F(Standing, ClumpsOutsideTheBounds) {
  const std::string rod = R"("ClumpShape": {"count": 2, "offset": [[-4, 0, 0], [4, 0, 0], [0, 0, 0], [0, 0, 0]]})";
  const std::string emitter = R"("extras": {"GrainEmitter": {"mouth": 0, "radius": 0.5}, )" + rod + "}";
  taken(within(R"("translation": [1006.99, 1, 0], )" + emitter));
  refused(within(R"("translation": [1007.01, 1, 0], )" + emitter), {"GrainEmitter: "});
  const std::string block = R"("extras": {"GrainBlock": {"count": [1, 1, 1], "radius": 0.5}, )" + rod + "}";
  refused(within(R"("translation": [1007.01, 1, 0], )" + block), {"GrainBlock: "});
  refused(alone(R"("GrainBlock": {"spacing": 0.12}, "ClumpShape": {"name": "bean"})"), {"GrainBlock: spacing = 0.12"});
}

TEST_F(Standing, AFieldThatTheFirstBlockPlaces) {
  const auto nodes = [](const char* second) {
    return std::string(R"([{"extras": {"GrainField": {"bounds_min": [-9, -2, -9], "bounds_max": [9, 9, 9]}}},
        {"translation": [5000.2, 0, 0], "extras": {"GrainBlock": {}}},
        {"name": "second", "translation": [)") + second + R"(, 0, 0], "extras": {"GrainEmitter": {}}}])";
  };
  taken(nodes("5008"));
  refused(nodes("5009"), {"\"second\": extras: GrainEmitter: ", "x = 8.75 to 9.25"});
  taken(R"([{"translation": [0, 0, 1e7], "extras": {"GrainEmitter": {}}}])");
}

}  // namespace
}  // namespace scree::grains::test
