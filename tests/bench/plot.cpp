// SVG plots of time against error on logarithmic axes.
#include "tests/bench/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <numeric>

#include "engine/core/file.h"

namespace scree::bench {
namespace {

constexpr double kWidth = 900, kHeight = 560;
constexpr double kLeft = 90, kRight = 30, kTop = 50, kBottom = 70;
// Height of the strip below the axis that holds rows without error.
constexpr double kExactStrip = 40;

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

// Whole decades that enclose all positive values.
struct Axis {
  int low = 0, high = 1;  // powers of ten
  double fraction(double value) const { return (std::log10(value) - low) / (high - low); }
};

Axis decades(const std::vector<double>& values) {
  double low = 0, high = 0;
  for (double v : values) {
    if (!(v > 0) || !std::isfinite(v)) continue;
    low = low == 0 ? v : std::min(low, v);
    high = std::max(high, v);
  }
  if (low == 0) return {-1, 1};
  Axis axis{static_cast<int>(std::floor(std::log10(low))),
            static_cast<int>(std::ceil(std::log10(high)))};
  if (axis.high <= axis.low) axis.high = axis.low + 1;
  return axis;
}

std::string fileName(const std::string& text) {
  std::string out;
  for (char c : text) out += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return out;
}

// An SVG in the making: two logarithmic axes with their grid, and what is drawn on them.
struct Paper {
  Axis x_axis, y_axis;
  double axis_bottom;
  std::string svg;

  Paper(const std::string& title, const Axis& x_in, const Axis& y_in, double bottom)
      : x_axis(x_in), y_axis(y_in), axis_bottom(bottom) {
    svg = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" "
        "height=\"{1}\" "
        "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" "
        "fill=\"white\"/>\n"
        "<text x=\"{2}\" y=\"28\" font-size=\"16\">{3}</text>\n",
        kWidth, kHeight, kLeft, escaped(title));
  }
  double x(double value) const { return kLeft + x_axis.fraction(value) * (kWidth - kLeft - kRight); }
  double y(double value) const { return axis_bottom - y_axis.fraction(value) * (axis_bottom - kTop); }
  void line(double x0, double y0, double x1, double y1, const char* colour) {
    svg += fmt::format(
        "<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x0, y0,
        x1, y1, colour);
  }
  void text(double tx, double ty, const char* anchor, const std::string& content) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", tx, ty,
                       anchor, escaped(content));
  }
  void grid(const std::string& x_title, const std::string& y_title) {
    for (int power = x_axis.low; power <= x_axis.high; ++power) {
      const double at = x(std::pow(10.0, power));
      line(at, kTop, at, kHeight - kBottom, "#ddd");
      text(at, kHeight - kBottom + 18, "middle", fmt::format("{:g}", std::pow(10.0, power)));
    }
    for (int power = y_axis.low; power <= y_axis.high; ++power) {
      const double at = y(std::pow(10.0, power));
      line(kLeft, at, kWidth - kRight, at, "#ddd");
      text(kLeft - 8, at + 4, "end", fmt::format("{:g}", std::pow(10.0, power)));
    }
    line(kLeft, kTop, kLeft, kHeight - kBottom, "black");
    line(kLeft, kHeight - kBottom, kWidth - kRight, kHeight - kBottom, "black");
    text((kLeft + kWidth - kRight) / 2, kHeight - 20, "middle", x_title);
    svg += fmt::format(
        "<text transform=\"translate(20 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
        (kTop + kHeight - kBottom) / 2, escaped(y_title));
  }
};

}  // namespace

std::vector<size_t> paretoFront(const std::vector<Row>& rows) {
  std::vector<size_t> order(rows.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return std::pair(rows[a].time_ms, rows[a].error) < std::pair(rows[b].time_ms, rows[b].error);
  });
  std::vector<size_t> front;
  for (size_t i : order) {
    if (front.empty() || rows[i].error < rows[front.back()].error) front.push_back(i);
  }
  return front;
}

std::string plotSvg(const std::string& title, const std::vector<Row>& rows) {
  std::vector<double> times, errors;
  for (const Row& row : rows) {
    times.push_back(row.time_ms);
    errors.push_back(row.error);
  }
  Paper paper(title, decades(times), decades(errors), kHeight - kBottom - kExactStrip);
  const auto y = [&](double error) { return error > 0 ? paper.y(error) : kHeight - kBottom - 8; };
  paper.grid("time, ms", rows.empty() ? "" : rows[0].error_kind);
  paper.text(kLeft - 8, y(0) + 4, "end", "exact");

  std::string front;
  for (size_t i : paretoFront(rows)) front += fmt::format("{:.1f},{:.1f} ", paper.x(rows[i].time_ms), y(rows[i].error));
  paper.svg += fmt::format(
      "<polyline points=\"{}\" fill=\"none\" stroke=\"#1f77b4\" stroke-width=\"2\"/>\n", front);
  for (const Row& row : rows) {
    const double px = paper.x(row.time_ms), py = y(row.error);
    if (row.baseline) {
      paper.svg += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"10\" height=\"10\" fill=\"#d62728\">", px - 5,
          py - 5);
    } else {
      paper.svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4.5\" fill=\"#1f77b4\">", px, py);
    }
    paper.svg += fmt::format("<title>{}: {:.4g} ms, error {:.4g}</title></{}>\n", escaped(row.label),
                             row.time_ms, row.error, row.baseline ? "rect" : "circle");
    const bool right_edge = px > kWidth - 200;
    paper.text(px + (right_edge ? -8 : 8), py - 6, right_edge ? "end" : "start",
               row.label + (row.baseline ? " (baseline)" : ""));
  }
  return paper.svg + "</svg>\n";
}

std::string sweepSvg(const std::string& title, const std::string& knob, const std::vector<Row>& rows) {
  static constexpr const char* kColours[] = {"#1f77b4", "#ff7f0e", "#2ca02c", "#9467bd", "#8c564b", "#e377c2"};
  struct Line {
    std::string label, points;
    bool baseline = false;
  };
  std::vector<const Row*> swept;
  std::vector<double> values, times;
  for (const Row& row : rows) {
    const auto at = row.knobs.find(knob);
    if (at == row.knobs.end() || !at->is_number() || !(at->get<double>() > 0) || !(row.time_ms > 0)) continue;
    swept.push_back(&row);
    values.push_back(at->get<double>());
    times.push_back(row.time_ms);
  }
  Paper paper(title, decades(values), decades(times), kHeight - kBottom);
  paper.grid(knob, "time, ms");
  std::vector<Line> lines;
  for (size_t i = 0; i < swept.size(); ++i) {
    auto line = std::find_if(lines.begin(), lines.end(), [&](const Line& l) { return l.label == swept[i]->label; });
    if (line == lines.end()) {
      lines.push_back({.label = swept[i]->label, .points = "", .baseline = swept[i]->baseline});
      line = std::prev(lines.end());
    }
    line->points += fmt::format("{:.1f},{:.1f} ", paper.x(values[i]), paper.y(times[i]));
  }
  for (size_t k = 0; k < lines.size(); ++k) {
    const char* colour = lines[k].baseline ? "#d62728" : kColours[k % std::size(kColours)];
    paper.svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"/>\n",
                             lines[k].points, colour);
    const double legend_y = kTop + 16 + 18 * static_cast<double>(k);
    paper.svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"14\" height=\"4\" fill=\"{}\"/>\n",
                             kWidth - 230, legend_y - 6, colour);
    paper.text(kWidth - 208, legend_y, "start", lines[k].label + (lines[k].baseline ? " (baseline)" : ""));
  }
  return paper.svg + "</svg>\n";
}

Result<std::vector<std::filesystem::path>> writePlots(const Bench& bench,
                                                      const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return Error{fmt::format("{}: {}", directory.string(), error.message())};
  std::vector<std::filesystem::path> paths;
  std::vector<std::string> scenarios;
  for (const Row& row : bench.rows()) {
    if (std::find(scenarios.begin(), scenarios.end(), row.scenario) == scenarios.end()) {
      scenarios.push_back(row.scenario);
    }
  }
  for (const std::string& scenario : scenarios) {
    std::vector<Row> rows;
    for (const Row& row : bench.rows()) {
      // A row that is not a number has no place on the axes; Bench::faults reports it.
      if (row.scenario == scenario && row.time_ms > 0 && std::isfinite(row.time_ms) &&
          row.error >= 0 && std::isfinite(row.error)) {
        rows.push_back(row);
      }
    }
    if (rows.empty()) continue;
    paths.push_back(directory / fmt::format("{}_{}.svg", bench.name(), fileName(scenario)));
    if (Status written = writeFile(paths.back(), plotSvg(bench.name() + ": " + scenario, rows));
        !written.ok()) {
      return Error{written.error()};
    }
  }
  if (!bench.sweptKnob().empty()) {
    paths.push_back(directory / fmt::format("{}_over_{}.svg", bench.name(), fileName(bench.sweptKnob())));
    const std::string title = fmt::format("{}: time over {}", bench.name(), bench.sweptKnob());
    if (Status written = writeFile(paths.back(), sweepSvg(title, bench.sweptKnob(), bench.rows())); !written.ok())
      return Error{written.error()};
  }
  return paths;
}

}  // namespace scree::bench
