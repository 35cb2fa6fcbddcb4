// Rigid bodies to bytes and back: what the rows do not say. See saved.h.
#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "modules/grains/rigid.h"
#include "modules/grains/saved.h"

namespace scree::grains {
namespace {

bool allFinite(const dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool allFinite(const quat& q) { return std::isfinite(q.w + q.x + q.y + q.z); }

// Calls visit(field) for each field of a row.
template <class AnyRow, class Visit>
void eachSavedField(AnyRow& row, const Visit& visit) {
  auto& [key, position, rotation, velocity, spin, density, mass, damping, freedom, pivot, line, line_local,
         point_local, stiffness, resistance, low, high, asleep, lost] = row;
  visit(key);
  visit(position);
  visit(rotation);
  visit(velocity);
  visit(spin);
  visit(density);
  visit(mass);
  visit(damping);
  visit(freedom);
  visit(pivot);
  visit(line);
  visit(line_local);
  visit(point_local);
  visit(stiffness);
  visit(resistance);
  visit(low);
  visit(high);
  static_cast<void>(asleep);  // the body says
  static_cast<void>(lost);
}

}  // namespace

void Rigids::save(ByteWriter& out) const {
  out.number(static_cast<uint32_t>(body_.size()));
  for (const Rigid& body : body_) {
    eachSavedField(body.row, [&](const auto& field) { out.number(field); });
    out.number(static_cast<uint8_t>(body.asleep));
    out.number(static_cast<uint8_t>(body.rouse));
    out.number(body.still);
    out.number(body.anchor);
    out.number(body.anchor_rotation);
    out.number(body.borne);
    out.number(body.borne_size);
    out.number(body.listed_position);
    out.number(body.listed_rotation);
    out.number(body.slack);
  }
  out.number(static_cast<uint32_t>(contact_.size()));
  for (const RigidContact& contact : contact_) {
    out.number(contact.key_a);
    out.number(contact.key_b);
    out.number(contact.feature);
    out.number(contact.impulse);
    out.number(contact.normal);
    out.number(static_cast<uint8_t>(contact.trusted));
  }
}

std::string Rigids::restore(ByteReader& in) {
  const auto count = in.number<uint32_t>();
  if (!in.has(count, 100)) return fmt::format("{} rigid bodies reach beyond the end", count);
  for (uint32_t k = 0; k < count; ++k) {
    Rigid body;
    eachSavedField(body.row, [&]<class T>(T& field) { field = in.number<T>(); });
    body.key = body.row.key;
    body.asleep = in.number<uint8_t>() != 0;
    body.rouse = in.number<uint8_t>() != 0;
    body.still = in.number<float>();
    body.anchor = in.number<dvec3>();
    body.anchor_rotation = in.number<dquat>();
    body.borne = in.number<dvec3>();
    body.borne_size = in.number<double>();
    body.listed_position = in.number<vec3>();
    body.listed_rotation = in.number<quat>();
    body.slack = in.number<float>();
    if (body.key >= kKeyLimit || (k > 0 && body_.back().key >= body.key) || !(body.still >= 0) ||
        !allFinite(body.anchor) || !allFinite(body.borne) || !(body.borne_size >= 0) || !finite(body.listed_position) ||
        !allFinite(body.listed_rotation) || !(body.slack >= 0) || !(body.slack < 1e9f))
      return fmt::format("rigid body {}: its key comes before the last one, or numbers that are not allowed", k);
    awake_ += body.asleep ? 0 : 1;
    body_.push_back(std::move(body));
  }
  const auto contacts = in.number<uint32_t>();
  if (!in.has(contacts, 61)) return fmt::format("{} contacts of rigid bodies reach beyond the end", contacts);
  for (uint32_t k = 0; k < contacts; ++k) {
    RigidContact contact;
    contact.key_a = in.number<uint32_t>();
    contact.key_b = in.number<uint32_t>();
    contact.feature = in.number<uint32_t>();
    contact.impulse = in.number<dvec3>();
    contact.normal = in.number<dvec3>();
    contact.trusted = in.number<uint8_t>() != 0;
    const auto place = [](const RigidContact& c) { return std::tuple(c.key_a, c.key_b, c.feature); };
    constexpr double kMostImpulse = 1e30;  // N s: what it gives to velocities stays finite
    if (!(glm::dot(contact.impulse, contact.impulse) <= kMostImpulse * kMostImpulse) || !allFinite(contact.normal) ||
        (k > 0 && place(contact_.back()) >= place(contact)))
      return fmt::format("contact {} of rigid bodies: out of order, or not finite", k);
    contact_.push_back(contact);
  }
  return {};
}

}  // namespace scree::grains
