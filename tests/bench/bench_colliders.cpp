// Colliders of any shape: time of a distance query against its error, for grids of several resolutions,
// exact triangles and all triangles one by one; and what a tick costs on each.
#include <algorithm>
#include <cmath>

#include "engine/core/hash.h"
#include "engine/assets/nearest_on_triangle.h"
#include "modules/grains/surface_field.h"
#include "tests/bench/bench.h"
#include "tests/bench/drop.h"
#include "tests/grains/meshes.h"

namespace scree::bench {
namespace {

using namespace scree::grains;
using grains::test::Soup;
using SharedField = std::shared_ptr<const DistanceField>;

// Points around a surface, as grains of a tenth of its size touch it.
std::vector<vec3> pointsNear(const Soup& soup, size_t count) {
  std::vector<vec3> points;
  for (uint64_t k = 0; k < count; ++k) {
    const size_t t = static_cast<size_t>(grains::test::unit(1, k, 0) * static_cast<float>(soup.size() / 3)) * 3;
    float u = grains::test::unit(1, k, 1), v = grains::test::unit(1, k, 2);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const vec3 a = soup[t], b = soup[t + 1], c = soup[t + 2];
    const vec3 n = glm::normalize(glm::cross(b - a, c - a));
    points.push_back(a + (b - a) * u + (c - a) * v + n * (0.12f * grains::test::unit(1, k, 3) - 0.01f));
  }
  return points;
}

struct Answers {
  std::vector<SurfacePoint> point;
  uint64_t hash() const { return hashBytes(point.data(), point.size() * sizeof(SurfacePoint)); }
};

void ask(const DistanceField& field, const std::vector<vec3>& points, Answers& answers) {
  answers.point.resize(points.size());
  for (size_t k = 0; k < points.size(); ++k) answers.point[k] = field.nearest(points[k]);
}

struct Contender {
  std::string label;
  SharedField field;
  double make_ms = 0;
  nlohmann::ordered_json knobs = nlohmann::ordered_json::object();
  bool baseline = false;
};

// What a user would write first: every triangle, in double.
struct AllTriangles : DistanceField {
  explicit AllTriangles(Soup soup_in) : soup(std::move(soup_in)) {}
  SurfacePoint nearest(vec3 p) const override {
    double best = 1e300;
    dvec3 at(0), normal(0);
    for (size_t k = 0; k < soup.size(); k += 3) {
      const OnTriangle on = nearestOnTriangle(p, soup[k], soup[k + 1], soup[k + 2]);
      const double square = glm::dot(dvec3(p) - on.point, dvec3(p) - on.point);
      if (square >= best) continue;
      best = square;
      at = on.point;
      normal = glm::cross(dvec3(soup[k + 1]) - dvec3(soup[k]), dvec3(soup[k + 2]) - dvec3(soup[k]));
    }
    const double sign = glm::dot(dvec3(p) - at, normal) < 0 ? -1 : 1;
    return {vec3((dvec3(p) - at) * (sign / std::sqrt(best))), static_cast<float>(sign * std::sqrt(best)), 0};
  }
  std::array<vec3, 2> bounds() const override { return {vec3(-2), vec3(2)}; }
  Soup soup;
};

void benchQueries(Bench& bench) {
  const Soup soup = grains::test::bumpySoup(bench.quick() ? 4 : 5, 3);
  const std::vector<vec3> points = pointsNear(soup, bench.quick() ? 1000 : 4000);
  std::vector<Contender> contenders;
  const auto timed = [&](std::string label, const auto& make) {
    const double begin = cpuMs();
    Result<SharedField> made = make();
    contenders.push_back({.label = std::move(label), .field = *made, .make_ms = cpuMs() - begin});
  };
  timed("mesh, exact", [&] { return makeMesh(soup, true, 0); });
  for (const int resolution : {8, 16, 32, 64, 128}) {
    if (bench.quick() && resolution == 128) continue;
    timed(fmt::format("grid {}", resolution), [&] { return bakeMesh(soup, resolution); });
    contenders.back().knobs = {{"resolution", resolution}};
  }
  contenders.push_back({.label = "all triangles", .field = std::make_shared<AllTriangles>(soup), .baseline = true});

  std::vector<Answers> answers(contenders.size());
  std::vector<Variant> variants;
  for (size_t c = 0; c < contenders.size(); ++c)
    variants.push_back({contenders[c].label, [&, c] { ask(*contenders[c].field, points, answers[c]); }});
  const Paired paired = bench.paired(variants);
  std::vector<double> error(contenders.size());
  for (size_t c = 0; c < contenders.size(); ++c) {
    double sum = 0, worst = 0, turned = 0;
    for (size_t k = 0; k < points.size(); ++k) {
      const double exact = grains::test::bruteDistance(soup, points[k]);
      const double off = std::abs(std::abs(static_cast<double>(answers[c].point[k].distance)) - exact);
      sum += off;
      worst = std::max(worst, off);
      const float along = std::clamp(glm::dot(answers[c].point[k].normal, answers[0].point[k].normal), -1.0f, 1.0f);
      turned += std::acos(static_cast<double>(along)) * 180 / grains::test::kPi;
    }
    error[c] = sum / static_cast<double>(points.size());
    bench.row({.scenario = fmt::format("{} queries near {} triangles", points.size(), soup.size() / 3),
               .label = contenders[c].label,
               .knobs = contenders[c].knobs,
               .time_ms = paired.variants[c].median_ms,
               .error = error[c],
               .error_kind = "mean error of the distance, m (the shape is 2 m wide)",
               .hash = answers[c].hash(),
               .baseline = contenders[c].baseline,
               .measured = {{"worst_m", worst},
                            {"normal_off_degrees", turned / static_cast<double>(points.size())},
                            {"make_ms", contenders[c].make_ms},
                            {"bytes", contenders[c].field->memoryBytes()}}});
  }
  const size_t last = contenders.size() - 1, finest = last - 1;
  bench.claimAtMost("mean error of the exact mesh, m", error[0], 1e-6);
  bench.claimAtLeast("time of all triangles / exact mesh", paired.ratio(last, 0).median, 20);
  bench.claimAtLeast("time of the exact mesh / finest grid", paired.ratio(0, finest).median, 3);
  bench.claimAtMost("mean error of grid 64 / grid 16", error[4] > 0 ? error[4] / error[2] : 1, 0.25);
}

// The same grains in a bowl made of planes' worth of triangles, of a grid, and of a formula's box.
void benchTicks(Bench& bench) {
  const int side = bench.quick() ? 12 : 20;
  const Soup bowl = grains::test::floorSoup(2, 64, [](float x, float z) { return 0.3f * (x * x + z * z); });
  const auto formula = [](vec3 p) {
    return (p.y - 0.3f * (p.x * p.x + p.z * p.z)) / std::sqrt(1 + 0.36f * (p.x * p.x + p.z * p.z));
  };
  struct Ground {
    std::string label;
    SharedField field;  // null: a box below all
  };
  const Ground grounds[] = {{"box", nullptr},
                            {"mesh", *makeMesh(bowl, false, 0)},
                            {"grid", *sampleDistance(formula, vec3(-2, -0.3f, -2), vec3(2), 0.0625f)}};
  std::vector<std::unique_ptr<grains::test::Field>> fields;
  for (const Ground& ground : grounds) {
    fields.push_back(std::make_unique<grains::test::Field>());
    grains::test::Field& field = *fields.back();
    if (ground.field == nullptr) {
      field.addBox({0, -0.5f, 0}, {2, 0.5f, 2}, 0.5f);
    } else {
      grains::test::addField(field, ground.field, 0.5f);
    }
    for (int k = 0; k < side * side; ++k)  // one layer: every grain touches the ground
      field.add({0.1f * static_cast<float>(k % side - side / 2), 0.8f, 0.1f * static_cast<float>(k / side - side / 2)},
                0.045f, {1000, 0.5f, 0.05f, 0});
    field.step(240);
  }
  std::vector<Variant> variants;
  for (size_t g = 0; g < fields.size(); ++g)
    variants.push_back({grounds[g].label, [&, g] { fields[g]->step(20); }});
  const Paired paired = bench.paired(variants);
  for (size_t g = 0; g < fields.size(); ++g)
    bench.row({.scenario = fmt::format("20 ticks of {} grains at rest on the ground, awake", side * side),
               .label = grounds[g].label,
               .knobs = {{"ground", grounds[g].label}},
               .time_ms = paired.variants[g].median_ms,
               .error = fields[g]->kineticEnergy() / static_cast<double>(side * side),
               .error_kind = "kinetic energy left, J a grain",
               .hash = fields[g]->hash(),
               .baseline = g == 0});
  bench.claimAtMost("time of a tick on the mesh / on a box", paired.ratio(1, 0).median, 10);
  bench.claimAtMost("time of a tick on the grid / on a box", paired.ratio(2, 0).median, 3);
}

}  // namespace

SCREE_BENCH(colliders, "distance queries: grids of several resolutions, exact mesh, all triangles; ticks on them") {
  benchQueries(bench);
  benchTicks(bench);
}

}  // namespace scree::bench
