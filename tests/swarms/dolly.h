// A camera that goes away from a bed of beans, step by step: what changes because of the step, and what because
// grains are drawn as something else.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/assets/image_flip.h"
#include "tests/support/law_plot.h"
#include "tests/swarms/bean_bed.h"

namespace scree::test {

struct DollyStep {
  double distance = 0, size_px = 0;   // of a bean in the bed's middle
  double moved = 0, switched = 0;     // mean absolute difference of linear colour, over the bed's pixels
  double moved_flip = 0, switched_flip = 0;
  size_t switches = 0;                // pixels that the switches changed
};

struct Picture {
  std::vector<vec3> radiance;
  images::Image image;
};

inline double meanDifference(const std::vector<vec3>& a, const std::vector<vec3>& b, size_t& differing) {
  double sum = 0;
  differing = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    const vec3 d = glm::abs(a[k] - b[k]);
    sum += static_cast<double>(d.x + d.y + d.z) / 3;
    differing += d != vec3(0);
  }
  return sum / static_cast<double>(a.size());
}

// From a size of the middle bean to another in steps of `share` of the distance. Before each step all grains are
// drawn as the router says; then they are drawn as before from the new place, and then as the router says there.
inline std::vector<DollyStep> dolly(BeanScene& scene, double from_px, double to_px, float fov, double share, bool flip) {
  const LodSettings normal = scene.settings();
  const double pixels_at_1m = 0.5 * scene.size.y / std::tan(0.5 * static_cast<double>(fov));
  const auto picture = [&] {
    scene.render();
    Picture p{scene.radiance(), {}};
    if (flip) p.image = scene.image();
    return p;
  };
  std::vector<DollyStep> steps;
  double distance = pixels_at_1m / from_px;
  scene.lookFrom(distance, fov);
  for (int settle = 0; settle < 3; ++settle) scene.render();
  Picture a = picture();
  const double factor = from_px > to_px ? 1 + share : 1 / (1 + share);
  while ((factor > 1) == (pixels_at_1m / distance > to_px)) {
    distance *= factor;
    scene.lookFrom(distance, fov);
    scene.settings().band = 0.5f;  // none goes so far in a step
    const Picture held = picture();
    scene.settings() = normal;
    Picture routed = picture();
    DollyStep step{.distance = distance, .size_px = pixels_at_1m / distance};
    size_t ignored = 0;
    step.moved = meanDifference(a.radiance, held.radiance, ignored);
    step.switched = meanDifference(held.radiance, routed.radiance, step.switches);
    if (flip) {
      step.moved_flip = images::flip(a.image, held.image).mean;
      step.switched_flip = images::flip(held.image, routed.image).mean;
    }
    steps.push_back(step);
    a = std::move(routed);
  }
  return steps;
}

// Expects that no step's switches change the picture by more than the step itself, and that there are some; plots both.
inline void expectNoPop(const std::vector<DollyStep>& steps, const std::string& name) {
  size_t switches = 0;
  DollyStep worst, worst_flip;
  grains::test::LawPlot plot{.name = name, .title = "Switches in a step of 1.5 %; law: the step",
                             .x = "outer radius of a bean, pixels", .y = "mean absolute difference of linear colour", .logarithmic = true};
  for (const DollyStep& s : steps) {
    switches += s.switches;
    EXPECT_LE(s.switched, s.moved) << name << " at " << s.size_px << " px";
    EXPECT_LE(s.switched_flip, s.moved_flip) << name << " at " << s.size_px << " px";
    if (s.switched * worst.moved >= worst.switched * s.moved) worst = s;
    if (s.switched_flip * worst_flip.moved_flip >= worst_flip.switched_flip * s.moved_flip) worst_flip = s;
    plot.measured.push_back({s.size_px, std::max(s.switched, 1e-7)});
    plot.law.push_back({s.size_px, std::max(s.moved, 1e-7)});
  }
  EXPECT_GT(switches, 0u) << name << ": nothing was switched";
  std::printf("%s: %zu steps; switches / step %.3f at most, at %.2f px (%.2g / %.2g); of FLIP %.3f, at %.2f px (%.2g / %.2g)\n", name.c_str(),
              steps.size(), worst.switched / worst.moved, worst.size_px, worst.switched, worst.moved,
              worst_flip.switched_flip / worst_flip.moved_flip, worst_flip.size_px, worst_flip.switched_flip, worst_flip.moved_flip);
  grains::test::plotLaw(plot);
}

// A narrow view from afar, so that all of the bed passes a threshold within few steps.
inline constexpr float kNarrow = 0.1f;
inline constexpr double kStep = 0.015;

}  // namespace scree::test
