// The bar and the tables of scree_bake.
#include "modules/impostors/tool/report.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace scree::tool {

ProgressBar::ProgressBar() : terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (shown_ >= 0) fmt::print(stderr, "\r\033[K");
}

void ProgressBar::show(double done) {
  constexpr int kWidth = 40;
  const int percent = static_cast<int>(done * 100);
  if (!terminal_ || percent == shown_) return;
  shown_ = percent;
  const auto filled = static_cast<size_t>(percent * kWidth / 100);
  fmt::print(stderr, "\r[{}{}] {:3d} %", std::string(filled, '#'),
             std::string(kWidth - filled, '.'), percent);
  std::fflush(stderr);
}

void printAtlas(const ImpostorAtlas& a, double seconds) {
  fmt::print("{} views (n = {}) of {} x {} texels, {} levels, {:.2f} MiB, {:.2f} on the GPU, in {:.1f} s\n",
             a.views(), a.edge, a.texels, a.texels, a.levels(), static_cast<double>(a.bytes()) / (1 << 20),
             static_cast<double>(impostorBytes(a.edge, a.texels)) / (1 << 20), seconds);
  fmt::print("outer radius R {:.5g} around ({:.4g}, {:.4g}, {:.4g}), inner r/R {:.3f}\n", a.outer,
             a.center.x, a.center.y, a.center.z, a.inner);
}

void printErrors(const ImpostorErrors& errors) {
  if (errors.directions == 0) return;
  const auto table = [&](const char* title, int digits, size_t schemes,
                         float ImpostorError::*member) {
    fmt::print("\n{:<24}", title);
    for (float size : kImpostorSizesPx) fmt::print("{:>8.0f}", size);
    fmt::print("\n");
    for (size_t s = 0; s < schemes; ++s) {
      fmt::print("  {:<22}", kImpostorSchemeNames[s]);
      for (const ImpostorError& e : errors.of[s]) fmt::print("{:>8.{}f}", e.*member, digits);
      fmt::print("\n");
    }
  };
  fmt::print("\nAgainst the mesh, mean of {} directions; diameters in pixels.", errors.directions);
  table("SSIM", 4, kImpostorSchemes, &ImpostorError::ssim);
  table("FLIP", 4, kImpostorSchemes, &ImpostorError::flip);
  table("silhouette, px", 3, kImpostorSchemes - 1, &ImpostorError::silhouette_px);
  table("silhouette, worst, px", 3, kImpostorSchemes - 1, &ImpostorError::worst_silhouette_px);
}

}  // namespace scree::tool
