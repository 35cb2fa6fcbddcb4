// The order at which the error of a short impact falls with the substeps.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/grains/law.h"

namespace scree::grains::test {
namespace {

// Where the grains of a short, not yet chaotic, fall of a cluster onto a plane are, by substeps.
std::vector<vec3> clusterAfter(int substeps) {
  Field field;
  field.parameters.substeps = substeps;
  field.parameters.passes = 8;
  field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.4f);
  for (int y = 0; y < 3; ++y)
    for (int z = 0; z < 3; ++z)
      for (int x = 0; x < 3; ++x) {
        const uint64_t k = field.grain.size();
        field.add(vec3(x, y, z) * 0.13f + vec3(0, 0.2f, 0) + unitCube(71, k) * 0.02f, 0.05f, {1000, 0.4f, 0, 0});
      }
  field.step(18);
  std::vector<vec3> all;
  for (const Grain& g : field.grain) all.push_back(g.position);
  return all;
}

TEST(Convergence, ErrorFallsWithSubsteps) {
  const std::vector<vec3> exact = clusterAfter(64);
  std::vector<Point> errors, logs;
  for (const int substeps : {1, 2, 4, 8, 16}) {
    const std::vector<vec3> now = clusterAfter(substeps);
    double error = 0;
    for (size_t k = 0; k < now.size(); ++k)
      error += static_cast<double>(glm::length(now[k] - exact[k])) / static_cast<double>(now.size());
    std::printf("%d substeps: %.6f m from 64\n", substeps, error);
    errors.push_back({static_cast<double>(substeps), error});
    logs.push_back({std::log(static_cast<double>(substeps)), std::log(error)});
  }
  const Fit order = fitLine(logs);
  std::printf("order %.2f, R^2 %.3f\n", -order.slope, order.r2);
  std::vector<Point> law;
  for (const Point& p : errors) law.push_back({p.x, std::exp(order.offset) * std::pow(p.x, order.slope)});
  plotLaw({.name = "convergence",
           .title = "Error of a short impact by substeps",
           .x = "substeps a tick",
           .y = "mean distance from 64 substeps, m (line: power law fitted)",
           .measured = errors,
           .law = law,
           .logarithmic = true});
  EXPECT_GT(-order.slope, 0.8);  // contacts are met within a substep: first order
  EXPECT_LT(errors.back().y, 0.25 * errors.front().y);
}

}  // namespace
}  // namespace scree::grains::test
