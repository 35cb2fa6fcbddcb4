// The picture of a bench: run time against error, with the Pareto front.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/result.h"
#include "tests/bench/bench.h"

namespace scree::bench {

// Indices of the rows that no other row beats: none is at most as slow and at most as wrong and
// better in one of both. By ascending time; of equal rows the first only.
std::vector<size_t> paretoFront(const std::vector<Row>& rows);

// SVG of one scenario's rows (not empty): logarithmic axes, time to the right, error upwards; rows
// without error lie on a line of their own below the axis's end.
std::string plotSvg(const std::string& title, const std::vector<Row>& rows);

// SVG of time over a knob, a line a label, through all scenarios in the order of the rows; logarithmic axes. Rows
// without that knob, or where it is not above 0, are left out.
std::string sweepSvg(const std::string& title, const std::string& knob, const std::vector<Row>& rows);

// SVG of a curve: what was measured upwards, linear. Rows without it, or the knob, are left out.
std::string curveSvg(const std::string& title, const Curve& curve, const std::vector<Row>& rows);

// DIR/<bench>_<scenario>.svg for every scenario, DIR/<bench>_over_<knob>.svg if one is swept, and
// DIR/<bench>_<measured>_over_<knob>[_<scenarios>].svg for every curve; makes DIR. Returns the paths.
Result<std::vector<std::filesystem::path>> writePlots(const Bench& bench,
                                                      const std::filesystem::path& directory);

}  // namespace scree::bench
