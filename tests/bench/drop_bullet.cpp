// Bullet's world of the dropped spheres, with its defaults for all that is not named here.
#include "tests/bench/drop_bullet.h"

#include <btBulletDynamicsCommon.h>

#include <cmath>

// Bullet has no other way to set its margins: globals that every step reads.
extern btScalar gDbvtMargin;
extern btScalar gContactBreakingThreshold;

namespace scree::bench {
namespace {

constexpr float kDefaultTreeMargin = 0.05f, kDefaultBreaking = 0.02f;  // Bullet 3.24
constexpr float kWall = 1;  // half thickness of the box's walls, m

vec3 toVec3(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

struct BulletDrop::State {
  BulletSettings settings;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  btSphereShape sphere{kDropRadius};
  std::vector<std::unique_ptr<btBoxShape>> walls;
  std::vector<std::unique_ptr<btRigidBody>> bodies;  // walls, then grains
  size_t first_grain = 0;

  explicit State(const BulletSettings& s, size_t count)
      : settings(s), configuration(memoryFor(count)) {}
  // Pools that hold all pairs: when they run out, Bullet takes each from the heap.
  static btDefaultCollisionConstructionInfo memoryFor(size_t count) {
    btDefaultCollisionConstructionInfo info;
    info.m_defaultMaxPersistentManifoldPoolSize = static_cast<int>(count) * 8;
    info.m_defaultMaxCollisionAlgorithmPoolSize = static_cast<int>(count) * 12;
    return info;
  }
  void setMargins() const {
    gDbvtMargin = settings.small_margins ? 0.1f * kDropRadius : kDefaultTreeMargin;
    gContactBreakingThreshold = settings.small_margins ? 0.05f * kDropRadius : kDefaultBreaking;
  }
  void add(btCollisionShape* shape, float mass, vec3 at) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin({at.x, at.y, at.z});
    info.m_friction = std::sqrt(kDropFriction);  // Bullet multiplies the two frictions
    info.m_linearDamping = info.m_angularDamping = kDropDamping;
    bodies.push_back(std::make_unique<btRigidBody>(info));
    world.addRigidBody(bodies.back().get());
  }
  void addWall(vec3 at, vec3 half) {
    walls.push_back(std::make_unique<btBoxShape>(btVector3(half.x, half.y, half.z)));
    walls.back()->setMargin(0.1f * kDropRadius);
    add(walls.back().get(), 0, at);
  }
};

BulletDrop::BulletDrop(const Drop& drop, const BulletSettings& settings)
    : state_(std::make_unique<State>(settings, drop.position.size())) {
  State& s = *state_;
  s.setMargins();
  s.world.setGravity({0, -kDropGravity, 0});
  s.world.getSolverInfo().m_numIterations = settings.iterations;
  const float w = drop.width, h = drop.height + 2, half = 0.5f * w, far = half + 2 * kWall;
  s.addWall({half, -kWall, half}, {far, kWall, far});
  s.addWall({-kWall, 0.5f * h, half}, {kWall, 0.5f * h + kWall, far});
  s.addWall({w + kWall, 0.5f * h, half}, {kWall, 0.5f * h + kWall, far});
  s.addWall({half, 0.5f * h, -kWall}, {far, 0.5f * h + kWall, kWall});
  s.addWall({half, 0.5f * h, w + kWall}, {far, 0.5f * h + kWall, kWall});
  s.first_grain = s.bodies.size();
  const float mass = 4.18879020f * kDropRadius * kDropRadius * kDropRadius * kDropDensity;
  for (const vec3 at : drop.position) s.add(&s.sphere, mass, at);
}

BulletDrop::~BulletDrop() {
  for (const auto& body : state_->bodies) state_->world.removeRigidBody(body.get());
}

void BulletDrop::step() {
  state_->setMargins();
  const float h = kDropTick / static_cast<float>(state_->settings.substeps);
  for (int k = 0; k < state_->settings.substeps; ++k) state_->world.stepSimulation(h, 0, h);
}

std::vector<vec3> BulletDrop::positions() const {
  std::vector<vec3> all;
  for (size_t k = state_->first_grain; k < state_->bodies.size(); ++k)
    all.push_back(toVec3(state_->bodies[k]->getWorldTransform().getOrigin()));
  return all;
}

std::vector<vec3> BulletDrop::velocities() const {
  std::vector<vec3> all;
  for (size_t k = state_->first_grain; k < state_->bodies.size(); ++k)
    all.push_back(toVec3(state_->bodies[k]->getLinearVelocity()));
  return all;
}

}  // namespace scree::bench
