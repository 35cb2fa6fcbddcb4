// Moves and contacts with colliders, several at a time: the same bits as one after the other.
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
#include <vector>

#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

constexpr float kH = 1.0f / 240;

// All that this machine has.
std::vector<Lanes> sets() {
  std::vector<Lanes> found;
  for (const Lanes lanes : {Lanes::Baseline, Lanes::Avx2, Lanes::Avx512})
    if (kernelsOf(lanes) != nullptr) found.push_back(lanes);
  return found;
}

Body bodyAt(uint64_t k, vec3 position, float speed) {
  Body body;
  body.position = position;
  body.radius = 0.03f + 0.02f * unit(1, k, 0);
  body.inverse_mass = 1 / (4000 * body.radius * body.radius * body.radius);
  body.friction_root = 0.7f;
  body.velocity = speed * (unitCube(2, k) - 0.5f);
  body.spin = 20 * speed * (unitCube(3, k) - 0.5f);
  body.velocity_before = body.velocity + 0.05f * (unitCube(4, k) - 0.5f);
  body.gravity_scale = unit(5, k, 0) < 0.2f ? 0.1f : 1.0f;
  return body;
}

template <class T>
void expectSame(std::span<const T> got, std::span<const T> want, const char* what) {
  ASSERT_EQ(got.size(), want.size()) << what;
  for (size_t k = 0; k < got.size(); ++k)
    ASSERT_EQ(std::memcmp(&got[k], &want[k], sizeof(T)), 0) << what << ' ' << k;
}

TEST(WidePasses, PredictsAsOneGrainAtATime) {
  const Prediction settings{{0.01f, -0.04f, 0}, kH, {0.3f, -1, 0.1f}, {0.001f, -0.003f, 0}};
  int left = 0;
  for (uint32_t row = 0; row < 200; ++row) {
    std::vector<Body> want;
    std::vector<float> x, y, z, margin;
    bool leaves = false;
    for (uint64_t k = kRow * row; k < kRow * (row + 1); ++k) {
      Body body = bodyAt(k, 5.0f * unitCube(6, k), 1.0f);
      const vec3 listed = body.position + 0.02f * (unitCube(7, k) - 0.5f);
      x.push_back(listed.x);
      y.push_back(listed.y);
      z.push_back(listed.z);
      // Around what is needed, for some of the rows.
      margin.push_back(unit(8, row, 0) < 0.5f ? 0.03f : 0.014f + 0.01f * unit(9, k, 0));
      want.push_back(body);
    }
    std::vector<Body> start = want;
    for (uint32_t k = 0; k < kRow; ++k) {
      Body& body = want[k];
      body.velocity_before = body.velocity;
      body.velocity += body.gravity_scale * settings.gravity_step;
      const vec3 strayed = body.position - vec3(x[k], y[k], z[k]) - settings.drifted,
                 relative = body.velocity - settings.drift;
      const float way = glm::dot(strayed, strayed), next = kH * kH * glm::dot(relative, relative);
      leaves = leaves || !(std::sqrt(way) + std::sqrt(next) <= margin[k]);
    }
    left += leaves;
    for (const Lanes lanes : sets()) {
      SCOPED_TRACE(static_cast<int>(lanes));
      std::vector<Body> got = start;
      EXPECT_EQ(kernelsOf(lanes)->predict(got.data(), {x.data(), y.data(), z.data(), nullptr, nullptr}, margin.data(),
                                          settings),
                leaves);
      expectSame<Body>(got, want, "body");
    }
  }
  EXPECT_GT(left, 20);
  EXPECT_LT(left, 180);
}

TEST(WidePasses, MovesAsOneGrainAtATime) {
  const Motion settings{kH, 0.999f, 1.5f, 3};
  int fast_ones = 0;
  for (uint32_t row = 0; row < 200; ++row) {
    std::vector<Body> start;
    std::array<float, kRow> smooth;
    for (uint32_t k = 0; k < kRow; ++k) {
      const uint64_t which = kRow * row + k;
      start.push_back(bodyAt(which, 5.0f * unitCube(10, which), 4.0f));
      smooth[k] = unit(11, which, 0) < 0.5f ? 0.0005f : 0.01f;
    }
    std::vector<Body> want = start;
    uint32_t fast = 0;
    for (uint32_t k = 0; k < kRow; ++k) {
      Body& body = want[k];
      const vec3 change = body.velocity - body.velocity_before;
      const float half = glm::dot(change, change) <= smooth[k] ? 0.5f : 0.0f;
      body.position += kH * (body.velocity - half * change);
      body.velocity *= settings.keep;
      body.spin *= settings.keep;
      if (glm::dot(body.velocity, body.velocity) > settings.fast * settings.fast) fast |= 1u << k;
      if (glm::dot(body.spin, body.spin) * body.radius * body.radius > settings.most_speed * settings.most_speed)
        body.spin = vec3(0);
    }
    fast_ones += std::popcount(fast);
    for (const Lanes lanes : sets()) {
      SCOPED_TRACE(static_cast<int>(lanes));
      std::vector<Body> got = start;
      float from[3][kRow];
      EXPECT_EQ(kernelsOf(lanes)->move(got.data(), smooth.data(), settings, from), fast);
      expectSame<Body>(got, want, "body");
      for (uint32_t k = 0; k < kRow; ++k)
        EXPECT_EQ(vec3(from[0][k], from[1][k], from[2][k]), start[k].position) << k;
    }
  }
  EXPECT_GT(fast_ones, 500);
  EXPECT_LT(fast_ones, 3000);
}

// A box, a ball and a floor that moves, and grains with up to five contacts with them.
struct Walls {
  std::vector<PosedCollider> posed;
  std::vector<ColliderContact> contact;
  std::vector<Body> body;
  ColliderSlab slab;
};

Walls makeWalls(uint32_t grains, uint64_t seed, bool bouncing, bool cohesive) {
  Walls walls;
  Collider box, ball, floor;
  box.shape = Shape::Box;
  box.half_extent = {0.3f, 0.2f, 0.25f};
  ball.shape = Shape::Capsule;
  ball.a = ball.b = {0.2f, 0.1f, 0};
  ball.radius = 0.2f;
  floor.position1 = {0, 0.001f, 0.02f};
  for (const Collider& c : {box, ball, floor}) walls.posed.push_back(poseCollider(c, 0, 0.25f, kH));
  for (uint32_t g = 0; g < grains; ++g) {
    const uint64_t k = 1000 * seed + g;
    walls.body.push_back(bodyAt(k, 0.7f * (unitCube(20, k) - 0.5f), unit(21, k, 0) < 0.5f ? 4.0f : 0.02f));
    const Body& body = walls.body.back();
    const uint32_t contacts = static_cast<uint32_t>(unit(22, k, 0) * unit(22, k, 1) * 6);
    for (uint32_t c = 0; c < contacts; ++c) {
      const uint64_t which = 8 * k + c;
      ColliderContact contact;
      contact.grain = g;
      contact.collider = c % 3;
      contact.key = c;
      contact.gives = unit(23, which, 0) < 0.05f;
      contact.friction = 0.5f;
      contact.rolling_friction = unit(23, which, 1) < 0.3f ? 0.05f : 0.0f;
      contact.restitution = bouncing && unit(23, which, 2) < 0.5f ? 0.6f : 0.0f;
      contact.pull = cohesive && unit(23, which, 3) < 0.5f ? 20.0f : 0.0f;
      setSurface(contact, nearestSurface(walls.posed[contact.collider], body.position), body,
                 walls.posed[contact.collider]);
      // Some are so placed that they touch, or nearly do.
      if (unit(24, which, 0) < 0.8f)
        contact.offset = glm::dot(contact.normal, body.position) - body.radius * (0.95f + 0.2f * unit(24, which, 1));
      if (unit(25, which, 0) < 0.4f) {
        contact.impulse = 0.01f * (unitCube(26, which) - 0.5f);
        contact.rolling = 1e-4f * (unitCube(27, which) - 0.5f);
        contact.trust = 1;
      }
      walls.contact.push_back(contact);
    }
  }
  walls.slab.contact = walls.contact;
  return walls;
}

TEST(WidePasses, RelaxCollidersAsOneContactAtATime) {
  size_t bounces = 0, contacts = 0, carried = 0;
  for (const bool bouncing : {false, true})
    for (const bool cohesive : {false, true})
      for (uint64_t seed = 0; seed < 60; ++seed) {
        const uint32_t grains = seed < 50 ? static_cast<uint32_t>(seed) : 300;
        PassSettings settings;
        settings.h = kH;
        settings.inverse_h = 1 / kH;
        settings.gravity_step = {0, -9.81f * kH, 0};
        settings.bounce_speed = 0.1f;
        settings.cohesive = cohesive;
        const auto run = [&](Walls& walls, const auto& relax) {
          walls.slab.contact = walls.contact;
          for (int pass = 0; pass < 4; ++pass) {
            PassSettings now = settings;
            now.first_pass = pass == 0;
            if (pass == 3) now.tolerated = 0.1f;
            relax(walls.slab, walls.body.data(), walls.posed, now);
          }
          std::stable_sort(walls.slab.bounces.begin(), walls.slab.bounces.end(),
                           [](const Bounce& a, const Bounce& b) { return a.i < b.i; });
        };
        Walls want = makeWalls(grains, seed, bouncing, cohesive);
        run(want, relaxColliders);
        bounces += want.slab.bounces.size();
        contacts += want.contact.size();
        for (const ColliderContact& contact : want.contact) carried += contact.impulse != vec3(0);
        for (const Lanes lanes : sets()) {
          SCOPED_TRACE(static_cast<int>(lanes));
          Walls got = makeWalls(grains, seed, bouncing, cohesive);
          run(got, kernelsOf(lanes)->relaxWalls);
          expectSame<Body>(got.body, want.body, "body");
          for (size_t k = 0; k < want.contact.size(); ++k) {  // behind what has gaps
            const char *const g = reinterpret_cast<const char*>(&got.contact[k]),
                       *const w = reinterpret_cast<const char*>(&want.contact[k]);
            constexpr size_t kFrom = offsetof(ColliderContact, impulse);
            ASSERT_EQ(std::memcmp(g + kFrom, w + kFrom, sizeof(ColliderContact) - kFrom), 0) << "contact " << k;
          }
          expectSame<Bounce>(got.slab.bounces, want.slab.bounces, "bounce");
          EXPECT_EQ(got.slab.deepest, want.slab.deepest);
        }
      }
  EXPECT_GT(contacts, 10000u);
  EXPECT_GT(carried, contacts / 4);
  EXPECT_GT(bounces, 100u);
}

}  // namespace
}  // namespace scree::grains::test
