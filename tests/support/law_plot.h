// A picture and a table of a law and of what was measured for it: NAME.png and NAME.csv in the folder that
// the environment variable SCREE_PLOTS names. Without it nothing is written.
#pragma once

#include <gtest/gtest.h>
#include <stb/stb_easy_font.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "engine/assets/image.h"
#include "engine/core/math.h"

namespace scree::grains::test {

struct Point {
  double x, y;
};

struct LawPlot {
  std::string name;  // of the files
  std::string title, x, y;  // with units
  std::vector<Point> measured, law;
  double tolerance = 0, share = 0;  // the band around the law is tolerance + share |y| wide on each side
  bool logarithmic = false;         // both axes
};

class LawCanvas {
 public:
  explicit LawCanvas(const LawPlot& plot) : plot_(plot), rgb_(size_t{kWidth} * kHeight * 3, 255) {
    for (const Point& p : plot.measured) include(p.x, p.y);
    for (const Point& p : plot.law) {
      include(p.x, p.y - band(p.y));
      include(p.x, p.y + band(p.y));
    }
    if (!plot.logarithmic) include(x_.low, 0);
    for (Range* range : {&x_, &y_}) {
      const double spread = range->high - range->low;
      const double room = spread > 0 ? 0.04 * spread : 0.5;
      if (range->low != 0 || plot.logarithmic) range->low -= room;
      range->high += room;
    }
    fillBand();
    axis(x_, true);
    axis(y_, false);
    for (size_t k = 0; k + 1 < plot.law.size(); ++k) line(plot.law[k], plot.law[k + 1]);
    for (const Point& p : plot.measured) box(atX(p.x), atY(p.y), 4, kRed);
    text(kLeft, 10, 2, plot.title);
    text(kLeft, 34, 1.5f, plot.y);
    text(kWidth - 20 - 1.5f * width(plot.x), kHeight - 24, 1.5f, plot.x);
    legend();
  }
  Status write(const std::filesystem::path& path) const { return writePng(path, kWidth, kHeight, 3, rgb_); }

 private:
  static constexpr int kWidth = 800, kHeight = 520, kLeft = 90, kRight = 30, kTop = 60, kBottom = 64;
  static constexpr vec3 kBlue{0.12f, 0.47f, 0.71f}, kRed{0.84f, 0.15f, 0.16f}, kGrey{0.87f, 0.91f, 0.95f},
      kBlack{0}, kFaint{0.8f};
  struct Range {
    double low = 1e300, high = -1e300;
    void include(double v) {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  };
  double onAxis(double v) const { return plot_.logarithmic ? std::log10(std::max(v, 1e-30)) : v; }
  void include(double x, double y) {
    x_.include(onAxis(x));
    y_.include(onAxis(y));
  }
  double band(double y) const { return plot_.tolerance + plot_.share * std::abs(y); }
  double atX(double x) const {
    return kLeft + (onAxis(x) - x_.low) / (x_.high - x_.low) * (kWidth - kLeft - kRight);
  }
  double atY(double y) const {
    return kHeight - kBottom - (onAxis(y) - y_.low) / (y_.high - y_.low) * (kHeight - kTop - kBottom);
  }
  void put(int x, int y, vec3 color) {
    if (x < 0 || y < 0 || x >= kWidth || y >= kHeight) return;
    for (int c = 0; c < 3; ++c)
      rgb_[(static_cast<size_t>(y) * kWidth + static_cast<size_t>(x)) * 3 + static_cast<size_t>(c)] =
          static_cast<uint8_t>(255 * color[c]);
  }
  void fill(double x0, double y0, double x1, double y1, vec3 color) {
    for (int y = static_cast<int>(std::lround(y0)); y < static_cast<int>(std::lround(y1)); ++y)
      for (int x = static_cast<int>(std::lround(x0)); x < static_cast<int>(std::lround(x1)); ++x) put(x, y, color);
  }
  void box(double x, double y, double half, vec3 color) { fill(x - half, y - half, x + half, y + half, color); }
  void line(const Point& a, const Point& b) {
    const double x0 = atX(a.x), y0 = atY(a.y), x1 = atX(b.x), y1 = atY(b.y);
    const int steps = 1 + static_cast<int>(std::hypot(x1 - x0, y1 - y0));
    for (int s = 0; s <= steps; ++s) box(x0 + s * (x1 - x0) / steps, y0 + s * (y1 - y0) / steps, 1, kBlue);
  }
  void fillBand() {
    if (!(plot_.tolerance > 0 || plot_.share > 0)) return;
    for (size_t k = 0; k + 1 < plot_.law.size(); ++k) {
      const Point &a = plot_.law[k], &b = plot_.law[k + 1];
      const double x0 = atX(a.x), x1 = atX(b.x);
      for (double x = x0; x <= x1; x += 1) {
        const double t = x1 > x0 ? (x - x0) / (x1 - x0) : 0;
        const auto between = [&](double side) {
          return (1 - t) * atY(a.y + side * band(a.y)) + t * atY(b.y + side * band(b.y));
        };
        fill(x, between(1) - 1, x + 1, between(-1) + 1, kGrey);
      }
    }
  }
  static float width(const std::string& what) {
    std::string copy = what;
    return static_cast<float>(stb_easy_font_width(copy.data()));
  }
  void text(double x, double y, float scale, const std::string& what) {
    struct Corner {
      float x, y, z;
      uint8_t color[4];
    };
    std::string copy = what;
    std::vector<Corner> corners(copy.size() * 70 + 4);
    const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, corners.data(),
                                          static_cast<int>(corners.size() * sizeof(Corner)));
    for (size_t k = 0; k < static_cast<size_t>(quads); ++k) {
      const Corner &a = corners[4 * k], &b = corners[4 * k + 2];
      const auto at = [&](double from, float v) { return from + static_cast<double>(scale * v); };
      fill(at(x, a.x), at(y, a.y), at(x, b.x), at(y, b.y), kBlack);
    }
  }
  static std::string number(double v) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.4g", std::abs(v) < 1e-12 ? 0 : v);
    return buffer;
  }
  void tick(double value, bool horizontal) {
    const std::string label = number(value);
    if (horizontal) {
      const double x = atX(value);
      fill(x, kTop, x + 1, kHeight - kBottom, kFaint);
      text(x - 0.75 * static_cast<double>(width(label)), kHeight - kBottom + 8, 1.5f, label);
    } else {
      const double y = atY(value);
      fill(kLeft, y, kWidth - kRight, y + 1, kFaint);
      text(kLeft - 8 - 1.5 * static_cast<double>(width(label)), y - 5, 1.5f, label);
    }
  }
  void axis(const Range& range, bool horizontal) {
    if (plot_.logarithmic) {
      for (int decade = static_cast<int>(std::floor(range.low)); decade <= range.high; ++decade)
        for (const double digit : {1.0, 2.0, 5.0})
          if (const double v = digit * std::pow(10.0, decade); onAxis(v) >= range.low && onAxis(v) <= range.high)
            tick(v, horizontal);
    } else {
      const double raw = (range.high - range.low) / 6, decade = std::pow(10.0, std::floor(std::log10(raw)));
      const double step = decade * (raw < 2 * decade ? 2 : raw < 5 * decade ? 5 : 10);
      for (double v = std::ceil(range.low / step) * step; v <= range.high; v += step) tick(v, horizontal);
    }
    if (horizontal) {
      fill(kLeft, kHeight - kBottom, kWidth - kRight, kHeight - kBottom + 2, kBlack);
    } else {
      fill(kLeft, kTop, kLeft + 2, kHeight - kBottom, kBlack);
    }
  }
  void legend() {
    double x = kLeft;
    const double y = kHeight - 20;
    const auto entry = [&](double half, vec3 color, const std::string& what) {
      fill(x, y - half, x + 16, y + half, color);
      text(x + 22, y - 4, 1.5f, what);
      x += 40 + 1.5 * static_cast<double>(width(what));
    };
    if (!plot_.measured.empty()) entry(4, kRed, "measured");
    if (!plot_.law.empty()) entry(1, kBlue, "law");
    std::string band = plot_.tolerance > 0 ? number(plot_.tolerance) : "";
    if (plot_.share > 0) band += (band.empty() ? "" : " + ") + number(100 * plot_.share) + " %";
    if (!band.empty()) entry(6, kGrey, "law +- " + band);
  }

  const LawPlot& plot_;
  std::vector<uint8_t> rgb_;
  Range x_, y_;
};

inline void plotLaw(const LawPlot& plot) {
  const char* wanted = std::getenv("SCREE_PLOTS");
  if (wanted == nullptr || *wanted == 0) return;
  const std::filesystem::path folder(wanted);
  std::filesystem::create_directories(folder);
  const Status written = LawCanvas(plot).write(folder / (plot.name + ".png"));
  EXPECT_TRUE(written.ok());
  std::ofstream csv(folder / (plot.name + ".csv"));
  csv << '"' << plot.x << "\",\"" << plot.y << "\",kind,tolerance\n";
  for (const Point& p : plot.measured) csv << p.x << ',' << p.y << ",measured,\n";
  for (const Point& p : plot.law)
    csv << p.x << ',' << p.y << ",law," << plot.tolerance + plot.share * std::abs(p.y) << '\n';
  EXPECT_TRUE(csv.good());
}

}  // namespace scree::grains::test
