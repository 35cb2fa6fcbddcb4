// The camera of a frame: interpolation between ticks, matrices, frustum.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/frame/frame.h"
#include "modules/scene/scene.h"

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace scree {
namespace {

using rules::ViewBlock;
// std140 of the GLSL struct: matrices and vec4 at multiples of 16, vec2 at multiples of 8.
static_assert(offsetof(ViewBlock, relative_from_clip) == 64);
static_assert(offsetof(ViewBlock, steady_clip_from_relative) == 128);
static_assert(offsetof(ViewBlock, previous_clip_from_relative) == 192);
static_assert(offsetof(ViewBlock, camera_delta) == 256);
static_assert(offsetof(ViewBlock, frustum_planes) == 272);
static_assert(offsetof(ViewBlock, rotation) == 352);
static_assert(offsetof(ViewBlock, size_px) == 368);
static_assert(offsetof(ViewBlock, jitter_px) == 376);
static_assert(offsetof(ViewBlock, near_m) == 384);
static_assert(offsetof(ViewBlock, tan_half_fov_x) == 396);
static_assert(offsetof(ViewBlock, frame) == 400);
static_assert(sizeof(ViewBlock) == 416);

glm::dquat toDouble(const quat& q) {
  return glm::normalize(glm::dquat(q));
}

// Fields that a file or a rule may have set to anything.
Camera soundCamera(Camera camera) {
  if (!std::isfinite(camera.fov_y_rad)) camera.fov_y_rad = Camera{}.fov_y_rad;
  if (!std::isfinite(camera.near_m)) camera.near_m = Camera{}.near_m;
  camera.fov_y_rad = std::clamp(camera.fov_y_rad, 1e-4f, 3.1415f);
  camera.near_m = std::clamp(camera.near_m, 1e-6f, 1e6f);
  return camera;
}

// Reversed depth, infinite far plane: depth = near / -z. Reed 2015, "Depth Precision Visualized";
// Lengyel 2011, "Foundations of Game Engine Development 2", 6.3.
glm::dmat4 clipFromView(const Camera& camera, double aspect) {
  const double scale = 1.0 / std::tan(0.5 * static_cast<double>(camera.fov_y_rad));
  glm::dmat4 clip(0.0);
  clip[0][0] = scale / aspect;
  clip[1][1] = scale;
  clip[2][3] = -1;
  clip[3][2] = camera.near_m;
  return clip;
}

glm::dmat4 viewFromRelative(const glm::dquat& rotation) {
  return glm::dmat4(glm::mat3_cast(glm::conjugate(rotation)));
}

// Rows of the clip matrix, combined; Gribb and Hartmann 2001. The distance is in metres only
// because the normals are made unit vectors.
void setPlanes(ViewBlock& block, const glm::dmat4& clip_from_relative) {
  const glm::dmat4 rows = glm::transpose(clip_from_relative);
  const glm::dvec4 planes[5] = {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
                                rows[3] - rows[1], rows[3] - rows[2]};
  for (int i = 0; i < 5; ++i)
    block.frustum_planes[i] = vec4(planes[i] / glm::length(dvec3(planes[i])));
}

}  // namespace

PreviousTransform previousOf(const Transform& transform) {
  return {transform.position, transform.rotation, transform.scale};
}

Transform interpolate(const PreviousTransform& previous, const Transform& current, double t) {
  if (t == 1) return current;
  Transform between;
  between.position = previous.position + (current.position - previous.position) * t;
  between.scale = vec3(dvec3(previous.scale) + (dvec3(current.scale) - dvec3(previous.scale)) * t);
  glm::dquat from = toDouble(previous.rotation), to = toDouble(current.rotation);
  if (glm::dot(from, to) < 0) to = -to;
  // Chord and half-angle keep their precision for small angles, where acos of the dot does not.
  const double angle = 2 * std::atan2(glm::length(to - from), glm::length(to + from));
  glm::dquat mixed = angle < 1e-9 ? from * (1 - t) + to * t
                                  : (from * std::sin((1 - t) * angle) + to * std::sin(t * angle));
  between.rotation = quat(glm::normalize(mixed));
  return between;
}

mat4 relativeFromLocal(const Transform& transform, const dvec3& camera_position) {
  const mat3 rotation = glm::mat3_cast(transform.rotation);
  mat4 relative_from_local(1.0f);
  for (int axis = 0; axis < 3; ++axis)
    relative_from_local[axis] = vec4(rotation[axis] * transform.scale[axis], 0);
  relative_from_local[3] = vec4(vec3(transform.position - camera_position), 1);
  return relative_from_local;
}

View computeView(const PreviousTransform& previous, const Transform& current, const Camera& given,
                 const FrameInput& input) {
  const Camera camera = soundCamera(given);
  const dvec3 size(std::max(input.size.x, 1), std::max(input.size.y, 1), 1);
  const double aspect = size.x / size.y;
  const double alpha = input.alpha;
  const Transform now = interpolate(previous, current, alpha);
  const Transform before =
      interpolate(previous, current, alpha - static_cast<double>(input.motion_scale));
  const glm::dquat rotation = toDouble(now.rotation);

  const glm::dmat4 projection = clipFromView(camera, aspect);
  const glm::dmat4 steady = projection * viewFromRelative(rotation);
  // The picture moves against the sample's offset, so that the sample comes to the pixel's centre.
  glm::dmat4 jitter(1.0);
  jitter[3][0] = -2.0 * input.jitter_px.x / size.x;
  jitter[3][1] = -2.0 * input.jitter_px.y / size.y;
  const glm::dmat4 jittered = jitter * steady;

  View view;
  view.position = now.position;
  view.previous_position = before.position;
  view.rotation = now.rotation;
  ViewBlock& block = view.block;
  block.clip_from_relative = mat4(jittered);
  block.relative_from_clip = mat4(glm::inverse(jittered));
  block.steady_clip_from_relative = mat4(steady);
  block.previous_clip_from_relative =
      mat4(projection * viewFromRelative(toDouble(before.rotation)));
  block.camera_delta = vec4(vec3(now.position - before.position), 0);
  setPlanes(block, jittered);
  block.rotation = vec4(rotation.x, rotation.y, rotation.z, rotation.w);
  block.size_px = vec2(size.x, size.y);
  block.jitter_px = input.jitter_px;
  block.near_m = camera.near_m;
  const double tangent = std::tan(0.5 * static_cast<double>(camera.fov_y_rad));
  block.pixels_at_1m = static_cast<float>(size.y / (2 * tangent));
  block.tan_half_fov_y = static_cast<float>(tangent);
  block.tan_half_fov_x = static_cast<float>(tangent * aspect);
  block.frame = static_cast<uint32_t>(input.frame);
  block.sample_index = static_cast<uint32_t>(input.sample);
  return view;
}

bool sphereInView(const View& view, const vec3& center_relative, float radius) {
  // Planes and centre are rounded to float: a few units in the last place of the distance.
  const float margin = 1e-6f * (glm::length(center_relative) + radius);
  for (const vec4& plane : view.block.frustum_planes)
    if (glm::dot(vec3(plane), center_relative) + plane.w < -(radius + margin)) return false;
  return true;
}

}  // namespace scree
