// SVG plots: time against error, and what was measured over a knob.
#include "tests/bench/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>

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

struct Axis {
  double low = 0, high = 1;  // logarithmic: powers of ten
  double step = 1;
  bool logarithmic = true;
  double fraction(double value) const { return ((logarithmic ? std::log10(value) : value) - low) / (high - low); }
  std::vector<double> ticks() const {
    std::vector<double> all;
    for (double at = low; at < high + 0.5 * step; at += step) all.push_back(logarithmic ? std::pow(10.0, at) : at);
    return all;
  }
};

// Whole decades that enclose all positive values.
Axis decades(const std::vector<double>& values) {
  double low = 0, high = 0;
  for (double v : values) {
    if (!(v > 0) || !std::isfinite(v)) continue;
    low = low == 0 ? v : std::min(low, v);
    high = std::max(high, v);
  }
  if (low == 0) return {-1, 1};
  Axis axis{std::floor(std::log10(low)), std::ceil(std::log10(high))};
  if (axis.high <= axis.low) axis.high = axis.low + 1;
  return axis;
}

// Four to ten steps of 1, 2 or 5 times a power of ten that enclose all values.
Axis steps(const std::vector<double>& values) {
  if (values.empty()) return {0, 1, 0.2, false};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double span = std::max(*high - *low, 1e-3 * std::max(std::abs(*high), 1e-3));
  double step = std::pow(10.0, std::floor(std::log10(span / 4)));
  for (const double factor : {2.0, 2.5, 2.0})
    if (span / step > 9) step *= factor;
  Axis axis{step * std::floor(*low / step + 1e-9), step * std::ceil(*high / step - 1e-9), step, false};
  if (axis.high <= axis.low) axis.high = axis.low + step;
  return axis;
}

std::string fileName(const std::string& text) {
  std::string out;
  for (char c : text) out += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return out;
}

// An SVG in the making: two axes with their grid, and what is drawn on them.
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
    for (const double value : x_axis.ticks()) {
      line(x(value), kTop, x(value), kHeight - kBottom, "#ddd");
      text(x(value), kHeight - kBottom + 18, "middle", fmt::format("{:.3g}", value));
    }
    for (const double value : y_axis.ticks()) {
      line(kLeft, y(value), kWidth - kRight, y(value), "#ddd");
      text(kLeft - 8, y(value) + 4, "end", fmt::format("{:.3g}", value));
    }
    line(kLeft, kTop, kLeft, kHeight - kBottom, "black");
    line(kLeft, kHeight - kBottom, kWidth - kRight, kHeight - kBottom, "black");
    text((kLeft + kWidth - kRight) / 2, kHeight - 20, "middle", x_title);
    svg += fmt::format(
        "<text transform=\"translate(20 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
        (kTop + kHeight - kBottom) / 2, escaped(y_title));
  }
};

struct Point {
  const Row* row;
  double x, y;
};
std::vector<double> valuesOf(const std::vector<Point>& points, double Point::* which) {
  std::vector<double> values;
  for (const Point& point : points) values.push_back(point.*which);
  return values;
}
std::optional<double> numberOf(const nlohmann::ordered_json& values, const std::string& name) {
  const auto at = values.find(name);
  if (at == values.end() || !at->is_number() || !std::isfinite(at->get<double>())) return std::nullopt;
  return at->get<double>();
}

struct Titled {
  std::string title;
  Axis axis;
};
// A line a label, through its points in their order, and a legend.
std::string lineSvg(const std::string& title, const Titled& x, const Titled& y, const std::vector<Point>& points) {
  static constexpr const char* kColours[] = {"#1f77b4", "#ff7f0e", "#2ca02c", "#9467bd", "#8c564b", "#e377c2"};
  struct Line {
    std::string label, points;
    bool baseline = false;
  };
  Paper paper(title, x.axis, y.axis, kHeight - kBottom);
  paper.grid(x.title, y.title);
  std::vector<Line> lines;
  std::string dots;
  for (const Point& point : points) {
    auto line = std::find_if(lines.begin(), lines.end(), [&](const Line& l) { return l.label == point.row->label; });
    if (line == lines.end()) {
      lines.push_back({.label = point.row->label, .points = "", .baseline = point.row->baseline});
      line = std::prev(lines.end());
    }
    line->points += fmt::format("{:.1f},{:.1f} ", paper.x(point.x), paper.y(point.y));
    dots += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"/>\n", paper.x(point.x), paper.y(point.y));
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
  return paper.svg + dots + "</svg>\n";
}

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
  std::vector<Point> points;
  for (const Row& row : rows) {
    const std::optional<double> at = numberOf(row.knobs, knob);
    if (at && *at > 0 && row.time_ms > 0) points.push_back({&row, *at, row.time_ms});
  }
  return lineSvg(title, {knob, decades(valuesOf(points, &Point::x))}, {"time, ms", decades(valuesOf(points, &Point::y))}, points);
}

std::string curveSvg(const std::string& title, const Curve& curve, const std::vector<Row>& rows) {
  std::vector<Point> points;
  for (const Row& row : rows) {
    const std::optional<double> at = numberOf(row.knobs, curve.knob);
    const std::optional<double> value = curve.measured == "error" ? row.error : numberOf(row.measured, curve.measured);
    if (at && value && (curve.linear || *at > 0)) points.push_back({&row, *at, *value});
  }
  const std::vector<double> knobs = valuesOf(points, &Point::x);
  const std::string& what = curve.measured == "error" && !rows.empty() ? rows.front().error_kind : curve.measured;
  return lineSvg(title, {curve.knob, curve.linear ? steps(knobs) : decades(knobs)}, {what, steps(valuesOf(points, &Point::y))}, points);
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
  for (const Curve& curve : bench.curves()) {
    std::vector<Row> rows;
    for (const Row& row : bench.rows())
      if (row.scenario.starts_with(curve.scenarios)) rows.push_back(row);
    const std::string name = fmt::format("{}_{}_over_{}{}{}", bench.name(), fileName(curve.measured), fileName(curve.knob),
                                         curve.scenarios.empty() ? "" : "_", fileName(curve.scenarios));
    paths.push_back(directory / (name + ".svg"));
    const std::string title = fmt::format("{} {}: {} over {}", bench.name(), curve.scenarios, curve.measured, curve.knob);
    if (Status written = writeFile(paths.back(), curveSvg(title, curve, rows)); !written.ok()) return Error{written.error()};
  }
  return paths;
}

}  // namespace scree::bench
