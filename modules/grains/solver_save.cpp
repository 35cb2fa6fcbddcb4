// The solver to bytes and back: see saved.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "modules/grains/rest.h"
#include "modules/grains/saved.h"
#include "modules/grains/solver.h"

namespace scree::grains {
namespace {

// Slabs of a grid: a power of two from 4 on.
constexpr uint32_t kMostSlabs = 1024;
// A larger age decides nothing more.
constexpr int kOld = 1 << 20;

}  // namespace

std::string GrainSolver::saved() const {
  if (last_h_ == 0) return {};  // no tick yet: there is nothing but the rows
  ByteWriter out;
  out.number(kSavedVersion);
  out.number(last_gravity_);
  out.number(last_h_);
  out.number(drift_);
  out.number(drift_time_);
  out.number(lifetime_);
  out.number(least_margin_);
  out.number(least_margin_way_);
  out.number(listed_awake_);
  out.number(std::min(age_, kOld));
  out.number(static_cast<uint8_t>(calm_));
  out.number(static_cast<uint8_t>(search_due_));
  out.number(static_cast<uint8_t>(pairs_.rolling));
  out.number(static_cast<uint8_t>(pairs_.bouncing));
  out.number(static_cast<uint8_t>(pairs_.cohesive));

  std::vector<uint32_t> saved_berth;
  sleepers_.save(out, saved_berth);
  out.number(static_cast<uint32_t>(waiting_.size()));
  for (const uint32_t berth : waiting_) out.number(saved_berth[berth]);
  out.number(bodies_.count);
  for (uint32_t k = 0; k < bodies_.count; ++k) {
    const uint32_t berth = bodies_.berth[k];
    out.number(isAsleep(bodies_, k) ? saved_berth[berth] : berth);
    out.number(grid_.referenceOf(bodies_, k));
    if (berth != kAwake) continue;
    out.number(bodies_.entity[k]);
    out.number(bodies_.body[k].radius);
    out.number(bodies_.materialOf(k));
  }
  out.number(static_cast<uint32_t>(woken_pairs_.size()));
  for (const WokenPair& pair : woken_pairs_) out.number(pair);
  out.number(static_cast<uint32_t>(woken_walls_.size()));
  for (const WokenWall& wall : woken_walls_) out.number(wall);

  out.number(pairs_.slab_count);
  for (uint32_t s = 0; s < pairs_.slab_count; ++s) out.number(grid_.slabEnd(s));
  pairs_.save(out);
  walls_.save(out);
  rigids_.save(out);
  return std::move(out.content);
}

Result<GrainSolver> GrainSolver::restored(std::string_view bytes, uint32_t handles) {
  GrainSolver solver;
  if (bytes.empty()) return solver;
  ByteReader in(bytes);
  for (const auto part : {&GrainSolver::restoreScalars, &GrainSolver::restoreBodies,
                          &GrainSolver::restoreWoken, &GrainSolver::restoreLists}) {
    const std::string wrong = (solver.*part)(in, handles);
    if (in.failed()) return Error{fmt::format("{} bytes, which end too early", bytes.size())};
    if (!wrong.empty()) return Error{wrong};
  }
  if (!in.atEnd()) return Error{fmt::format("unknown content at byte {}", in.offset())};
  return solver;
}

std::string GrainSolver::restoreScalars(ByteReader& in, uint32_t) {
  const auto version = in.number<uint32_t>();
  if (version != kSavedVersion)
    return fmt::format("version {}; this program reads {}", version, kSavedVersion);
  last_gravity_ = in.number<vec3>();  // any: it is compared only
  last_h_ = in.number<float>();
  drift_ = in.number<vec3>();
  drift_time_ = in.number<float>();
  lifetime_ = in.number<float>();
  least_margin_ = in.number<float>();
  least_margin_way_ = in.number<float>();
  listed_awake_ = in.number<uint32_t>();
  age_ = in.number<int32_t>();
  calm_ = in.number<uint8_t>();
  search_due_ = in.number<uint8_t>() != 0;
  pairs_.rolling = in.number<uint8_t>() != 0;
  pairs_.bouncing = in.number<uint8_t>() != 0;
  pairs_.cohesive = in.number<uint8_t>() != 0;
  if (!(last_h_ > 0 && last_h_ <= kLongestTick))
    return fmt::format("a substep of {} s; allowed is up to {}", last_h_, kLongestTick);
  if (!finite(drift_) || !(drift_time_ >= 0) || !finite(drift_time_) || age_ < 0 || age_ > kOld || calm_ > kCalm ||
      !(lifetime_ > 0 && lifetime_ < 100) || !(least_margin_ > 0 && least_margin_ < 100) ||
      !(least_margin_way_ >= 0))
    return fmt::format("age {}, calm {}, margins of {} substeps and {} radii, or a drift that is not allowed",
                       age_, calm_, lifetime_, least_margin_);
  if ((pairs_.bouncing || pairs_.cohesive) && !pairs_.rolling)
    return "contacts that bounce or hold, but do not roll";
  return {};
}

std::string GrainSolver::restoreBodies(ByteReader& in, uint32_t handles) {
  if (std::string wrong = sleepers_.restore(in, handles); !wrong.empty()) return wrong;
  place_.assign(handles, kNoSlot);
  const auto settles = [&](Entity entity, uint32_t place) {
    if (entity.index >= handles || place_[entity.index] != kNoSlot) return false;
    place_[entity.index] = place;
    return true;
  };
  for (uint32_t berth = 0; berth < sleepers_.count(); ++berth)
    if (const Entity entity = sleepers_[berth].entity; !settles(entity, berth | kBerthBit))
      return fmt::format("sleeper {}: entity {} is out of range or there twice", berth, entity.index);

  const auto waiting = in.number<uint32_t>();
  if (!in.has(waiting, 4)) return fmt::format("{} sleepers out of balance reach beyond the end", waiting);
  for (uint32_t k = 0; k < waiting; ++k) {
    const auto berth = in.number<uint32_t>();
    if (berth >= sleepers_.count()) return fmt::format("out of balance: sleeper {} of {}", berth, sleepers_.count());
    waiting_.push_back(berth);
  }

  const auto count = in.number<uint32_t>();
  if (!in.has(count, 20)) return fmt::format("{} bodies reach beyond the end", count);
  for (uint32_t k = 0; k < count; ++k) {
    const auto berth = in.number<uint32_t>();
    const auto reference = in.number<Reference>();
    Entity entity;
    GrainMaterial material;
    vec3 position(0);
    float radius = 1;
    if (berth == kAwake) {
      entity = in.number<Entity>();
      radius = in.number<float>();
      material = in.number<GrainMaterial>();
      if (!allowed(radius, material) || !settles(entity, k))
        return fmt::format("body {}: entity {} is out of range or there twice, or radius {} m or material "
                           "is not allowed", k, entity.index, radius);
    } else if (berth == kGone) {
      if (!search_due_) return fmt::format("body {} has gone without a search", k);
    } else {
      if (berth >= sleepers_.count() || sleepers_[berth].slot != kNoSlot)
        return fmt::format("body {}: sleeper {} of {} is not there, or there twice", k, berth,
                           sleepers_.count());
      Sleeper& sleeper = sleepers_[berth];
      sleeper.slot = k;
      entity = sleeper.entity;
      position = sleeper.position;
      radius = sleeper.radius;
      material = sleepers_.materialOf(berth);
    }
    if (berth != kGone && !finite(reference.position))
      return fmt::format("body {}: a place that is not finite", k);
    // A grain awake is given 4 radii at most; of one that has gone nothing is known any more.
    if (berth != kGone && !(reference.margin >= 0 && reference.margin <= 4.001f * radius))
      return fmt::format("body {}: a margin of {} m; allowed are 0 to 4 radii", k, reference.margin);
    // Of a grain awake that is not listed yet the reference is where it is.
    appendBody(entity, material, berth == kAwake ? reference.position : position, radius);
    bodies_.margin[k] = reference.margin;
    grid_.restore(k, reference.position);
    bodies_.berth[k] = berth;
    if (berth != kAwake) bodies_.body[k].inverse_mass = bodies_.body[k].gravity_scale = 0;
  }
  return {};
}

std::string GrainSolver::restoreWoken(ByteReader& in, uint32_t) {
  const auto pairs = in.number<uint32_t>();
  if (!in.has(pairs, sizeof(WokenPair))) return fmt::format("{} woken pairs reach beyond the end", pairs);
  for (uint32_t k = 0; k < pairs; ++k) {
    const auto pair = in.number<WokenPair>();
    if (!finite(pair.impulse) || !finite(pair.rolling) || pair.a == pair.b)
      return fmt::format("woken pair {}: an impulse that is not finite, or one grain", k);
    woken_pairs_.push_back(pair);
  }
  const auto walls = in.number<uint32_t>();
  if (!in.has(walls, sizeof(WokenWall)))
    return fmt::format("{} woken contacts with colliders reach beyond the end", walls);
  for (uint32_t k = 0; k < walls; ++k) {
    const auto wall = in.number<WokenWall>();
    if (!finite(wall.impulse) || !finite(wall.rolling) || !finite(wall.normal))
      return fmt::format("woken contact {} with a collider: an impulse that is not finite", k);
    woken_walls_.push_back(wall);
  }
  return {};
}

std::string GrainSolver::restoreLists(ByteReader& in, uint32_t) {
  const auto slabs = in.number<uint32_t>();
  if (slabs != 0 && (slabs < 4 || slabs > kMostSlabs || (slabs & (slabs - 1)) != 0))
    return fmt::format("{} slabs; allowed is a power of two from 4 to {}, or none", slabs, kMostSlabs);
  std::vector<uint32_t> begin;
  if (slabs > 0) begin.push_back(0);
  for (uint32_t s = 0; s < slabs; ++s) {
    begin.push_back(in.number<uint32_t>());
    if (begin[s + 1] < begin[s] || begin[s + 1] > bodies_.count)
      return fmt::format("slab {} ends at body {} of {}", s, begin[s + 1], bodies_.count);
  }
  const uint32_t listed = slabs > 0 ? begin.back() : 0;
  if (!search_due_ && (slabs == 0 || listed != bodies_.count))
    return fmt::format("{} of {} bodies are listed, and no search is due", listed, bodies_.count);
  if (std::string wrong = pairs_.restore(in, begin, bodies_, !search_due_); !wrong.empty()) return wrong;
  if (std::string wrong = walls_.restore(in, begin, bodies_, !search_due_); !wrong.empty()) return wrong;
  if (std::string wrong = rigids_.restore(in); !wrong.empty()) return wrong;
  if (slabs > 0) grid_.restore(begin, bodies_);
  if (!search_due_) padBodies();
  return {};
}

}  // namespace scree::grains
