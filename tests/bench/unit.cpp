// Tests of the bench harness: timer, Pareto front, report, command line and plots.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "engine/core/file.h"
#include "tests/bench/bench.h"
#include "tests/bench/plot.h"

namespace scree::bench {
namespace {

namespace fs = std::filesystem;

SCREE_BENCH(holds, "a claim that holds") {
  bench.row({.scenario = "s",
             .label = "ours",
             .time_ms = 1,
             .error = 0.1,
             .error_kind = "px",
             .hash = 7});
  bench.row(
      {.scenario = "s", .label = "other", .time_ms = 2, .error_kind = "px", .baseline = true});
  bench.claimAtMost("ours / other", 0.5, 0.9);
}
SCREE_BENCH(fails, "a claim that fails") {
  bench.row({.scenario = "s", .label = "ours", .time_ms = 1, .error = 0.1, .error_kind = "px"});
  bench.claimAtLeast("speed", 1.0, 2.0);
}

int cli(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "scree_bench");
  return runBenches(static_cast<int>(arguments.size()), arguments.data());
}

Row point(double time_ms, double error) {
  return {.scenario = "s",
          .label = fmt::format("{}/{}", time_ms, error),
          .time_ms = time_ms,
          .error = error,
          .error_kind = "px"};
}

TEST(Spread, QuartilesOfKnownSamples) {
  EXPECT_EQ(spread({3}).median, 3);
  const Spread odd = spread({5, 1, 4, 2, 3});
  EXPECT_EQ(odd.q1, 2);
  EXPECT_EQ(odd.median, 3);
  EXPECT_EQ(odd.q3, 4);
  const Spread even = spread({4, 1, 3, 2});
  EXPECT_DOUBLE_EQ(even.q1, 1.75);
  EXPECT_DOUBLE_EQ(even.median, 2.5);
  EXPECT_DOUBLE_EQ(even.q3, 3.25);
}

// A clock that only the variants move, so that every figure is known.
TEST(Paired, InterleavesAndTakesMedians) {
  double now = 0;
  std::string order;
  int a_runs = 0;
  PairedOptions options{.rounds = 5, .warmup = 1, .now_ms = [&] { return now; }};
  const Paired result = pairedRuns({{"a",
                                     [&] {
                                       order += 'a';
                                       now += ++a_runs == 5 ? 1000 : 10;
                                     }},
                                    {"b",
                                     [&] {
                                       order += 'b';
                                       now += 20;
                                     }}},
                                   options);
  // One warm-up and one calibration run each, then five rounds.
  EXPECT_EQ(order,
            "abababababab"
            "ab");
  EXPECT_EQ(result.variants[0].median_ms, 10) << "one outlier must not move the median";
  EXPECT_EQ(result.variants[1].median_ms, 20);
  EXPECT_EQ(result.variants[0].min_ms, 10);
  EXPECT_EQ(result.ratio(0, 1).median, 0.5);
  EXPECT_EQ(result.ratio(1, 0).median, 2);
}

TEST(Paired, DriftCancelsInTheRatio) {
  double now = 0, pace = 1;
  const Paired result = pairedRuns({{"a",
                                     [&] {
                                       now += 10 * pace;
                                       pace *= 1.01;
                                     }},
                                    {"b",
                                     [&] {
                                       now += 20 * pace;
                                       pace *= 1.01;
                                     }}},
                                   {.rounds = 41, .now_ms = [&] { return now; }});
  EXPECT_NEAR(result.ratio(0, 1).median, 0.5, 0.01);
  EXPECT_NEAR(result.ratio(0, 1).q3 - result.ratio(0, 1).q1, 0, 1e-9);
}

TEST(Paired, ShortRunsAreBatchedLongOnesAreNot) {
  double now = 0;
  int short_runs = 0, long_runs = 0;
  const Paired result =
      pairedRuns({{"short",
                   [&] {
                     ++short_runs;
                     now += 0.001;
                   }},
                  {"long",
                   [&] {
                     ++long_runs;
                     now += 5;
                   }}},
                 {.rounds = 4, .warmup = 0, .min_sample_ms = 1, .now_ms = [&] { return now; }});
  EXPECT_GE(short_runs, 4 * 1000);
  EXPECT_EQ(long_runs, 5);
  EXPECT_NEAR(result.variants[0].median_ms, 0.001, 1e-9);
}

TEST(Paired, PreparesBeforeEveryTimedRunOutsideTheTime) {
  double now = 0;
  int prepared = 0, ran = 0;
  const Paired result = pairedRuns({{"a",
                                     [&] {
                                       ++ran;
                                       EXPECT_EQ(prepared, ran);
                                       now += 0.1;
                                     },
                                     [&] {
                                       ++prepared;
                                       now += 100;
                                     }}},
                                   {.rounds = 3, .warmup = 1, .now_ms = [&] { return now; }});
  EXPECT_EQ(ran, 4);
  EXPECT_NEAR(result.variants[0].median_ms, 0.1, 1e-9);
}

TEST(Paired, StopsWhenTheTimeIsUpButNotBeforeThreeRounds) {
  double now = 0;
  const Paired result =
      pairedRuns({{"a", [&] { now += 5000; }}},
                 {.rounds = 50, .warmup = 0, .max_seconds = 1, .now_ms = [&] { return now; }});
  EXPECT_EQ(result.variants[0].samples_ms.size(), 3u);
}

TEST(Pareto, KeepsWhatNobodyBeats) {
  //                            0          1          2 (beaten) 3          4 (= 1)
  const std::vector<Row> rows{point(4, 0), point(1, 9), point(3, 9), point(2, 3), point(1, 9)};
  EXPECT_EQ(paretoFront(rows), (std::vector<size_t>{1, 3, 0}));
  EXPECT_TRUE(paretoFront({}).empty());
}

TEST(Report, ClaimsCompareTheRightWayAndNanNeverHolds) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE((Claim{"", 1, 1, true}.holds()));
  EXPECT_FALSE((Claim{"", 1.01, 1, true}.holds()));
  EXPECT_TRUE((Claim{"", 1, 1, false}.holds()));
  EXPECT_FALSE((Claim{"", 0.99, 1, false}.holds()));
  for (bool at_most : {true, false}) {
    EXPECT_FALSE((Claim{"", nan, 1, at_most}.holds()));
    EXPECT_FALSE((Claim{"", 1, nan, at_most}.holds()));
  }
}

TEST(Report, FaultyReportsDoNotHold) {
  const auto faulty = [](const Row& row) {
    Bench bench("x", true);
    bench.row(row);
    bench.claimAtMost("c", 1, 2);
    return !bench.holds();
  };
  EXPECT_FALSE(faulty(point(1, 0)));
  EXPECT_TRUE(faulty(point(0, 1)));
  EXPECT_TRUE(faulty(point(std::nan(""), 1)));
  EXPECT_TRUE(faulty(point(1, std::nan(""))));
  EXPECT_TRUE(faulty(point(1, INFINITY)));
  EXPECT_TRUE(faulty(point(1, -1)));
  Bench empty("x", true);
  EXPECT_EQ(empty.faults().size(), 2u);
  Bench twice("x", true);
  twice.row(point(1, 1));
  twice.row(point(1, 1));
  twice.claimAtMost("c", 1, 2);
  EXPECT_EQ(twice.faults().size(), 1u);
}

TEST(Report, JsonHoldsWhatWasReported) {
  Bench bench("grains", true);
  bench.fact("gl_renderer", "soft");
  Row row = point(2, 0.5);
  row.knobs = {{"iterations", 8}};
  row.hash = 0xfedcba9876543210ull;
  bench.row(row);
  bench.claimAtMost("c", 1, 2);
  const auto json = bench.json();
  EXPECT_EQ(json["machine"]["gl_renderer"], "soft");
  EXPECT_GE(json["machine"]["cores"].get<int>(), 1);
  EXPECT_EQ(json["rows"][0]["knobs"]["iterations"], 8);
  EXPECT_EQ(json["rows"][0]["hash"], "fedcba9876543210");
  EXPECT_EQ(json["rows"][0]["time_ms"], 2.0);
  EXPECT_EQ(json["rows"][0]["baseline"], false);
  EXPECT_EQ(json["claims"][0]["holds"], true);
  EXPECT_NE(bench.table().find("iterations=8"), std::string::npos);
}

TEST(CommandLine, ExitStatus) {
  EXPECT_EQ(cli({"holds"}), 0);
  EXPECT_EQ(cli({"fails", "--quick"}), 1);
  EXPECT_EQ(cli({"no_such_bench"}), 2);
  EXPECT_EQ(cli({}), 2);
  EXPECT_EQ(cli({"holds", "--no-such-flag"}), 2);
  EXPECT_EQ(cli({"holds", "extra"}), 2);
  EXPECT_EQ(cli({"--list"}), 0);
  EXPECT_EQ(cli({"--help"}), 0);
  EXPECT_EQ(cli({"holds", "--json", "/no/such/folder/x.json"}), 2);
}

TEST(CommandLine, ViewsAreThoseOfTheBenchAndNeedAFolder) {
  static std::string drawn;
  registerViews("holds", {"one"}, [](const std::string& view, bool quick, const std::filesystem::path& directory) {
    drawn = fmt::format("{} {} {}", view, quick, directory.string());
    return Result<std::vector<std::filesystem::path>>(std::vector<std::filesystem::path>{directory / "one.png"});
  });
  const std::string folder = std::string(SCREE_BINARY_DIR) + "/bench_views";
  EXPECT_EQ(cli({"holds", "--view", "two", "--plot", folder.c_str()}), 2);
  EXPECT_EQ(cli({"fails", "--view", "one", "--plot", folder.c_str()}), 2);
  EXPECT_EQ(cli({"holds", "--view", "one"}), 2);
  EXPECT_EQ(drawn, "");
  EXPECT_EQ(cli({"holds", "--view", "one", "--quick", "--plot", folder.c_str()}), 0);
  EXPECT_EQ(drawn, "one true " + folder);
}

TEST(CommandLine, WritesJsonAndPlots) {
  const fs::path folder = fs::path(SCREE_BINARY_DIR) / "bench_unit";
  fs::remove_all(folder);
  fs::create_directories(folder);
  const std::string json = (folder / "x.json").string(), plots = (folder / "plots").string();
  ASSERT_EQ(cli({"holds", "--json", json.c_str(), "--plot", plots.c_str()}), 0);
  auto text = readText(json);
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(nlohmann::json::parse(text.value())["rows"].size(), 2u);
  auto svg = readText(folder / "plots" / "holds_s.svg");
  ASSERT_TRUE(svg.ok());
  EXPECT_NE(svg.value().find("(baseline)"), std::string::npos);
}

TEST(Plot, PutsPointsInsideTheFrameAndEscapesText) {
  std::vector<Row> rows{point(0.003, 1e-5), point(80, 0), point(1.5, 12)};
  rows[0].label = "<a & b>";
  const std::string svg = plotSvg("t", rows);
  EXPECT_NE(svg.find("&lt;a &amp; b&gt;"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  double last_x = 0;
  for (const Row& row : rows)
    EXPECT_NE(svg.find(fmt::format("{:.4g} ms", row.time_ms)), std::string::npos);
  size_t circles = 0;
  for (size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1)) {
    double cx = 0, cy = 0;
    ASSERT_EQ(std::sscanf(svg.c_str() + at, "<circle cx=\"%lf\" cy=\"%lf\"", &cx, &cy), 2);
    EXPECT_GE(cx, 90);
    EXPECT_LE(cx, 870);
    EXPECT_GE(cy, 50);
    EXPECT_LE(cy, 490);
    EXPECT_EQ(circles == 1, cx > last_x && circles > 0) << "the rows' times are 0.003, 80, 1.5 ms";
    last_x = cx;
    ++circles;
  }
  EXPECT_EQ(circles, 3u);
}

TEST(Plot, SweepHasALineForEachLabelWithThePointsOfItsRows) {
  std::vector<Row> rows;
  for (const double knob : {1.0, 10.0, 100.0})
    for (const char* label : {"a", "b"}) {
      rows.push_back(point(knob * (*label == 'a' ? 1 : 10), 0));
      rows.back().label = label;
      rows.back().knobs = {{"distance", knob}};
    }
  rows.push_back(point(5, 0));  // without the knob
  rows.back().label = "c";
  rows[1].baseline = true;
  const std::string svg = sweepSvg("t", "distance", rows);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find(">c<"), std::string::npos);
  EXPECT_NE(svg.find(">b (baseline)<"), std::string::npos);
  std::vector<std::vector<double>> lines;
  for (size_t at = svg.find("points=\""); at != std::string::npos; at = svg.find("points=\"", at + 1)) {
    double x[3], y[3];
    ASSERT_EQ(std::sscanf(svg.c_str() + at, "points=\"%lf,%lf %lf,%lf %lf,%lf", &x[0], &y[0], &x[1], &y[1], &x[2], &y[2]), 6);
    EXPECT_NEAR(x[0], 90, 0.1);  // 1 and 100: the ends of the axis
    EXPECT_NEAR(x[2], 870, 0.1);
    EXPECT_NEAR(x[1], 480, 0.1);
    lines.push_back({y[0], y[1], y[2]});
  }
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_NEAR(lines[0][1], lines[1][0], 0.1) << "10 ms both";
  EXPECT_NEAR(lines[0][0] - lines[0][1], lines[1][1] - lines[1][2], 0.2);
  EXPECT_GT(lines[0][0], lines[0][1] + 50) << "more time is further up";
}

TEST(Plot, CurveIsOfWhatWasMeasuredOnLinearAxes) {
  std::vector<Row> rows;
  for (const double knob : {0.0, 0.5, 1.0}) {
    rows.push_back(point(1, 0));
    rows.back().label = "a";
    rows.back().knobs = {{"share", knob}};
    rows.back().measured = {{"found", 20 + 80 * knob}};
  }
  rows.push_back(rows.front());
  rows.back().measured = {{"other", 1}};
  const std::string svg = curveSvg("t", {.knob = "share", .measured = "found", .scenarios = "", .linear = true}, rows);
  double x[3], y[3];
  ASSERT_EQ(std::sscanf(svg.c_str() + svg.find("points=\""), "points=\"%lf,%lf %lf,%lf %lf,%lf", &x[0], &y[0], &x[1], &y[1], &x[2], &y[2]), 6);
  EXPECT_NEAR(x[0], 90, 0.1);
  EXPECT_NEAR(x[1], 480, 0.1);
  EXPECT_NEAR(x[2], 870, 0.1);
  EXPECT_NEAR(y[0], 490, 0.1);
  EXPECT_NEAR(y[1], 270, 0.1);
  EXPECT_NEAR(y[2], 50, 0.1);
  EXPECT_NE(svg.find(">60<"), std::string::npos) << "the middle's tick";
  // Nothing to show, one value, values that are no numbers.
  rows.resize(1);
  for (const double value : {0.0, 7.0, std::numeric_limits<double>::quiet_NaN()}) {
    rows[0].measured = {{"found", value}};
    const std::string one = curveSvg("t", {.knob = "share", .measured = "found", .scenarios = "", .linear = true}, rows);
    EXPECT_EQ(one.find("nan"), std::string::npos) << value;
    EXPECT_EQ(one.find("inf"), std::string::npos) << value;
  }
}

}  // namespace
}  // namespace scree::bench
