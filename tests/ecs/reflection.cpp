// Component types describe themselves at run time.
#include <gtest/gtest.h>

#include <cstring>

#include "tests/ecs/components.h"

namespace scree {
namespace {

TEST(Reflection, EveryFieldTypeIsDescribed) {
  const ComponentInfo* info = findComponent("Everything");
  ASSERT_NE(info, nullptr);
  EXPECT_EQ(info->size, sizeof(Everything));
  EXPECT_EQ(info->alignment, alignof(Everything));
  EXPECT_EQ(info->id, componentId<Everything>());
  EXPECT_TRUE(info->has_entities);
  EXPECT_FALSE(info->transient);
  struct Expected {
    const char* name;
    FieldType type;
    size_t offset;
    uint32_t count;
    const char* unit;
  };
  const Expected expected[] = {
      {"flag", FieldType::Bool, offsetof(Everything, flag), 1, ""},
      {"i32", FieldType::Int32, offsetof(Everything, i32), 1, ""},
      {"flags_behind", FieldType::Bool, offsetof(Everything, flags_behind), 1, ""},
      {"i64", FieldType::Int64, offsetof(Everything, i64), 1, ""},
      {"u32", FieldType::Uint32, offsetof(Everything, u32), 1, ""},
      {"u64", FieldType::Uint64, offsetof(Everything, u64), 1, ""},
      {"f32", FieldType::Float, offsetof(Everything, f32), 1, "kg"},
      {"f64", FieldType::Double, offsetof(Everything, f64), 1, "s"},
      {"v2", FieldType::Vec2, offsetof(Everything, v2), 1, ""},
      {"v3", FieldType::Vec3, offsetof(Everything, v3), 1, "m"},
      {"v4", FieldType::Vec4, offsetof(Everything, v4), 1, ""},
      {"d3", FieldType::DVec3, offsetof(Everything, d3), 1, "m"},
      {"rotation", FieldType::Quat, offsetof(Everything, rotation), 1, ""},
      {"other", FieldType::Entity, offsetof(Everything, other), 1, ""},
      {"mood", FieldType::Enum, offsetof(Everything, mood), 1, ""},
      {"text", FieldType::Text, offsetof(Everything, text), 13, ""},
      {"floats", FieldType::Float, offsetof(Everything, floats), 3, "N"},
      {"pair", FieldType::Entity, offsetof(Everything, pair), 2, ""},
      {"last", FieldType::Bool, offsetof(Everything, last), 1, ""},
  };
  ASSERT_EQ(info->fields.size(), std::size(expected));
  const Everything sample;
  for (size_t i = 0; i < std::size(expected); ++i) {
    const FieldInfo& field = info->fields[i];
    EXPECT_EQ(field.name, expected[i].name);
    EXPECT_EQ(field.type, expected[i].type) << field.name;
    EXPECT_EQ(field.offset, expected[i].offset) << field.name;
    EXPECT_EQ(field.count, expected[i].count) << field.name;
    EXPECT_EQ(field.unit, expected[i].unit) << field.name;
  }
  EXPECT_EQ(info->findField("floats")->size(), 12u);
  EXPECT_EQ(info->findField("text")->size(), 13u);
  EXPECT_EQ(info->findField("pair")->size(), sizeof sample.pair);
  EXPECT_EQ(info->findField("d3")->size(), sizeof sample.d3);
  EXPECT_EQ(info->findField("rotation")->size(), sizeof sample.rotation);
  EXPECT_EQ(info->findField("nothing"), nullptr);
}

TEST(Reflection, ByteRunsCoverTheValuesAndLeaveOutPaddingAndText) {
  const ComponentInfo& info = *findComponent("Everything");
  std::vector<int> covered(sizeof(Everything));
  for (const ByteRun& run : info.runs)
    for (uint32_t i = 0; i < run.size; ++i) ++covered[run.offset + i];
  std::vector<int> expected(sizeof(Everything));
  for (const FieldInfo& field : info.fields)
    for (size_t i = 0; i < field.size() && field.type != FieldType::Text; ++i)
      ++expected[field.offset + i];
  EXPECT_EQ(covered, expected);
  EXPECT_EQ(findComponent("Position")->runs.size(), 1u) << "adjacent fields are one run";
}

TEST(Reflection, LooksTypesUpByName) {
  EXPECT_EQ(findComponent("Nothing"), nullptr);
  EXPECT_EQ(findComponent(""), nullptr);
  EXPECT_TRUE(findComponent("Cached")->transient);
  EXPECT_EQ(findComponent("Asleep")->size, 0u);
  EXPECT_EQ(findComponent("Wide")->alignment, 128u);
  std::string_view previous;
  for (const ComponentInfo* info : components()) {
    EXPECT_LT(previous, info->name) << "sorted, and unique";
    previous = info->name;
    EXPECT_EQ(&componentInfo(info->id), info);
    EXPECT_EQ(findComponent(info->name), info);
  }
}

TEST(Reflection, FieldTypesHaveNamesAndSizes) {
  EXPECT_EQ(fieldTypeName(FieldType::Vec3), "vec3");
  EXPECT_EQ(fieldTypeName(FieldType::Text), "text");
  EXPECT_EQ(fieldTypeName(FieldType::Entity), "Entity");
  EXPECT_EQ(fieldTypeSize(FieldType::Bool), sizeof(bool));
  EXPECT_EQ(fieldTypeSize(FieldType::DVec3), sizeof(dvec3));
  EXPECT_EQ(fieldTypeSize(FieldType::Enum), 4u);
}

TEST(Reflection, AddDefaultAddsOrFinds) {
  World world;
  const Entity entity = world.spawn();
  const ComponentInfo& info = *findComponent("Velocity");
  auto* velocity = static_cast<Velocity*>(info.addDefault(world, entity));
  ASSERT_NE(velocity, nullptr);
  EXPECT_EQ(*velocity, Velocity{});
  velocity->drag = 9;
  EXPECT_EQ(static_cast<Velocity*>(info.addDefault(world, entity))->drag, 9)
      << "must not reset a component that is there";
  world.destroy(entity);
  EXPECT_EQ(info.addDefault(world, entity), nullptr);
}

TEST(Reflection, WritesFieldsByOffset) {
  World world;
  const Entity entity = world.spawn();
  const ComponentInfo& info = *findComponent("Everything");
  auto* bytes = static_cast<std::byte*>(info.addDefault(world, entity));
  const vec3 value{1, 2, 3};
  std::memcpy(bytes + info.findField("v3")->offset, &value, sizeof value);
  EXPECT_EQ(world.peek<Everything>(entity)->v3, value);
  EXPECT_EQ(world.componentIds(entity)[0], info.id);
}

TEST(Reflection, AMissingOrExtraFieldIsSeenAtCompileTime) {
  struct Three {
    float a;
    char text[4];
    bool b;
  };
  static_assert(detail::listsEveryField<Three, float, char[4], bool>());
  static_assert(!detail::listsEveryField<Three, float, char[4]>());
  static_assert(!detail::listsEveryField<Three, float, bool>());
  static_assert(detail::listsEveryField<Asleep>());
  static_assert(!detail::listsEveryField<Asleep, float>());
  static_assert(!Component<Three>);
  static_assert(Component<Asleep> && Component<Everything>);
}

}  // namespace
}  // namespace scree
