// The skip rule and the registration of passes, without a GL context.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <set>
#include <string>
#include <vector>

#include "engine/core/random.h"
#include "engine/frame/frame.h"
#include "engine/gpu/gl.h"

namespace scree {
namespace {

const std::string kOut(Frame::kOutput);

PassDesc pass(std::string name, Stage stage, std::vector<Use> uses,
              std::function<bool()> needs = {}, std::vector<std::string> needs_content = {}) {
  return {.name = std::move(name),
          .stage = stage,
          .needs_text = "a thing",
          .needs = std::move(needs),
          .needs_content = std::move(needs_content),
          .uses = std::move(uses),
          .run = [](PassContext&) {}};
}

std::vector<std::string> namesOfOn(const Frame& frame) {
  std::vector<std::string> names;
  for (const PassReport& report : frame.report())
    if (report.on) names.push_back(report.name);
  return names;
}

std::string whyOf(const Frame& frame, std::string_view name) {
  for (const PassReport& report : frame.report())
    if (report.name == name) return report.why;
  return "(no such pass)";
}

using Names = std::vector<std::string>;

// A deferred renderer in small, whose scene is three flags.
struct SmallRenderer {
  bool mesh = false, sun = false, text = false;
  Frame frame;
  SmallRenderer() {
    for (const char* name : {"albedo", "id"}) frame.addTarget(name, {.format = GL_RGBA8});
    frame.addTarget("depth", {.format = GL_DEPTH_COMPONENT32F});
    frame.addTarget("shadow", {.format = GL_DEPTH_COMPONENT32F, .fixed_size = {64, 64}});
    frame.addTarget("radiance", {.format = GL_RGBA16F});
    // Registered out of order: the stage decides.
    frame.addPass(
        pass("present", Stage::Present, {{"radiance", Access::Sampled}, {kOut, Access::Color}}));
    frame.addPass(pass("text", Stage::Present, {{kOut, Access::Color}}, [this] { return text; }));
    frame.addPass(
        pass("clear", Stage::Geometry,
             {{"albedo", Access::Clear}, {"id", Access::Clear}, {"depth", Access::Clear}}));
    frame.addPass(pass("opaque", Stage::Geometry,
                       {{"albedo", Access::Color}, {"id", Access::Color}, {"depth", Access::Depth}},
                       [this] { return mesh; }));
    frame.addPass(pass("shadow", Stage::Geometry, {{"shadow", Access::Depth}},
                       [this] { return mesh && sun; }));
    frame.addPass(pass(
        "light", Stage::Shade,
        {{"albedo", Access::Sampled}, {"shadow", Access::Sampled}, {"radiance", Access::Color}}, {},
        {"id"}));
    frame.addPass(
        pass("sky", Stage::Shade, {{"depth", Access::DepthTest}, {"radiance", Access::Color}}));
  }
};

TEST(SkipRule, EmptySceneClearsDrawsSkyAndPresents) {
  SmallRenderer r;
  r.frame.decide();
  EXPECT_EQ(namesOfOn(r.frame), (Names{"clear", "sky", "present"}));
  EXPECT_EQ(whyOf(r.frame, "opaque"), "needs a thing");
  EXPECT_EQ(whyOf(r.frame, "light"), "nothing is drawn to id");
  EXPECT_EQ(whyOf(r.frame, "present"), "on");
  EXPECT_FALSE(r.frame.hasContent("id"));
  EXPECT_TRUE(r.frame.hasContent("radiance"));
  EXPECT_TRUE(r.frame.hasContent(kOut));
}

TEST(SkipRule, SceneSwitchesPassesOnAndOff) {
  SmallRenderer r;
  r.mesh = true;
  r.frame.decide();
  EXPECT_EQ(namesOfOn(r.frame), (Names{"clear", "opaque", "light", "sky", "present"}));
  EXPECT_TRUE(r.frame.hasContent("id"));
  r.sun = r.text = true;
  r.frame.decide();
  EXPECT_EQ(namesOfOn(r.frame),
            (Names{"clear", "opaque", "shadow", "light", "sky", "present", "text"}));
  r.mesh = false;
  r.frame.decide();
  EXPECT_EQ(namesOfOn(r.frame), (Names{"clear", "sky", "present", "text"}));
  EXPECT_EQ(whyOf(r.frame, "light"), "nothing is drawn to id");
}

TEST(SkipRule, UnreadPassesAreOffAndKeepHoldsThem) {
  Frame frame;
  frame.addTarget("a", {.format = GL_RGBA8});
  frame.addTarget("b", {.format = GL_RGBA8});
  frame.addPass(pass("makes_a", Stage::Route, {{"a", Access::Color}}));
  frame.addPass(pass("makes_b", Stage::Shade, {{"a", Access::Sampled}, {"b", Access::Color}}));
  frame.decide();
  EXPECT_EQ(namesOfOn(frame), Names{});
  EXPECT_EQ(whyOf(frame, "makes_a"), "nobody reads a");
  frame.keep("b", true);
  frame.decide();
  EXPECT_EQ(namesOfOn(frame), (Names{"makes_a", "makes_b"}));
  frame.keep("b", false);
  frame.keep("a", true);
  frame.decide();
  EXPECT_EQ(namesOfOn(frame), Names{"makes_a"});
  EXPECT_EQ(whyOf(frame, "makes_b"), "nobody reads b");
}

// A later reader counts; an earlier one, or the writer itself, does not.
TEST(SkipRule, OnlyLaterReadersCount) {
  Frame frame;
  frame.addTarget("a", {.format = GL_RGBA8});
  frame.addExternal("list");
  frame.addPass(
      pass("early_reader", Stage::Route, {{"a", Access::Sampled}, {kOut, Access::Color}}));
  frame.addPass(pass("late_writer", Stage::Shade, {{"a", Access::Color}}));
  frame.addPass(pass("selfish", Stage::Shade, {{"list", Access::StorageWrite}}));
  frame.decide();
  EXPECT_EQ(namesOfOn(frame), Names{"early_reader"});
}

// Content that comes from a pass which is off because nobody reads it is no content.
TEST(SkipRule, ContentOfDeadPassesVanishes) {
  Frame frame;
  frame.addTarget("a", {.format = GL_RGBA8});
  frame.addTarget("b", {.format = GL_RGBA8});
  frame.addPass(pass("writes_a", Stage::Route, {{"a", Access::Color}}));
  // Needs content of a, but does not read it, so writes_a has no reader.
  frame.addPass(pass("wants_a", Stage::Shade, {{kOut, Access::Color}}, {}, {"a"}));
  frame.decide();
  EXPECT_EQ(namesOfOn(frame), Names{});
  EXPECT_EQ(whyOf(frame, "wants_a"), "nothing is drawn to a");
}

// What a pass list means, in the words of frame.h, over sets of names.
struct ListOracle {
  struct P {
    std::string name;
    bool needs = true;
    std::vector<std::string> content;
    std::vector<Use> uses;
  };
  std::vector<P> passes;  // in frame order
  std::set<std::string> read_outside;

  bool obeys(unsigned set) const {
    for (size_t i = 0; i < passes.size(); ++i) {
      if (!(set >> i & 1)) continue;
      const P& p = passes[i];
      if (!p.needs) return false;
      for (const std::string& resource : p.content) {
        bool written = false;
        for (size_t j = 0; j < i; ++j)
          for (const Use& use : passes[j].uses)
            written |= (set >> j & 1) && use.resource == resource &&
                       (use.access == Access::Color || use.access == Access::Depth ||
                        use.access == Access::StorageWrite);
        if (!written) return false;
      }
      bool wanted = false;
      for (const Use& mine : p.uses) {
        const bool write = mine.access == Access::Clear || mine.access == Access::Color ||
                           mine.access == Access::Depth || mine.access == Access::StorageWrite;
        if (!write) continue;
        wanted |= read_outside.contains(mine.resource);
        for (size_t j = i + 1; j < passes.size(); ++j)
          for (const Use& use : passes[j].uses)
            wanted |= (set >> j & 1) && use.resource == mine.resource &&
                      use.access != Access::Clear && use.access != Access::Color;
      }
      if (!wanted) return false;
    }
    return true;
  }

  // The largest obeying set; `unique` says whether it contains every other one.
  unsigned largest(bool& unique) const {
    unsigned best = 0;
    for (unsigned set = 0; set < 1u << passes.size(); ++set)
      if (obeys(set) && std::popcount(set) > std::popcount(best)) best = set;
    unique = true;
    for (unsigned set = 0; set < 1u << passes.size(); ++set)
      if (obeys(set) && (set & ~best) != 0) unique = false;
    return best;
  }
};

TEST(SkipRule, RandomListsAgreeWithBruteForce) {
  constexpr uint64_t kSeed = 20240611;
  constexpr int kLists = 500;
  std::printf("seed %llu, %d lists\n", static_cast<unsigned long long>(kSeed), kLists);
  uint64_t draw = 0;
  auto random = [&](uint64_t below) { return randomBits(kSeed, 0, 0, draw++) % below; };
  int total_on = 0, total_off = 0, total_content = 0;
  for (int list = 0; list < kLists; ++list) {
    Frame frame;
    ListOracle oracle;
    oracle.read_outside.insert(kOut);
    // Externals carry every access but attachments; targets carry attachments and sampling.
    const size_t targets = 1 + random(4), externals = random(3);
    std::vector<std::string> names;
    for (size_t i = 0; i < targets; ++i) {
      names.push_back("target" + std::to_string(i));
      frame.addTarget(names.back(), {.format = GL_RGBA8});
    }
    for (size_t i = 0; i < externals; ++i) {
      names.push_back("external" + std::to_string(i));
      frame.addExternal(names.back());
    }
    frame.addTarget("depth", {.format = GL_DEPTH_COMPONENT32F});
    for (const std::string& name : names)
      if (random(10) == 0) {
        frame.keep(name, true);
        oracle.read_outside.insert(name);
      }

    std::vector<std::pair<Stage, ListOracle::P>> registered;
    const size_t count = 1 + random(8);
    for (size_t i = 0; i < count; ++i) {
      ListOracle::P p{.name = "pass" + std::to_string(i), .needs = random(4) != 0};
      for (size_t r = 0; r < names.size(); ++r) {
        if (random(3) != 0) continue;
        const bool target = r < targets;
        constexpr Access kTarget[] = {Access::Sampled, Access::Color, Access::Clear,
                                      Access::StorageWrite, Access::StorageRead};
        constexpr Access kExternal[] = {Access::StorageRead, Access::StorageWrite, Access::Indirect,
                                        Access::Vertex,      Access::Clear,        Access::Uniform};
        p.uses.push_back({names[r], target ? kTarget[random(5)] : kExternal[random(6)]});
      }
      if (random(3) == 0)
        p.uses.push_back({"depth", std::array{Access::Depth, Access::DepthTest, Access::Clear,
                                              Access::Sampled}[random(4)]});
      const bool writes = std::any_of(p.uses.begin(), p.uses.end(),
                                      [](const Use& use) { return isWrite(use.access); });
      if (random(3) == 0 || !writes) p.uses.push_back({kOut, Access::Color});
      while (random(3) == 0) p.content.push_back(names[random(names.size())]);
      const Stage stage = static_cast<Stage>(random(8));
      frame.addPass(pass(
          p.name, stage, p.uses, [needs = p.needs] { return needs; }, p.content));
      registered.emplace_back(stage, p);
    }
    std::stable_sort(registered.begin(), registered.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [stage, p] : registered) oracle.passes.push_back(p);

    frame.decide();
    bool unique = false;
    const unsigned expected = oracle.largest(unique);
    ASSERT_TRUE(unique) << "list " << list;
    ASSERT_EQ(frame.report().size(), count);
    for (size_t i = 0; i < count; ++i) {
      const PassReport& report = frame.report()[i];
      ASSERT_EQ(report.name, oracle.passes[i].name) << "list " << list;
      ASSERT_EQ(report.on, (expected >> i & 1) != 0)
          << "list " << list << ", " << report.name << ": " << report.why << "\n"
          << frame.describe();
      ASSERT_EQ(report.why == "on", report.on);
      (report.on ? total_on : total_off) += 1;
      total_content += report.why.starts_with("nothing is drawn");
    }
    for (const std::string& name : names) {
      bool written = false;
      for (size_t i = 0; i < count; ++i)
        for (const Use& use : oracle.passes[i].uses)
          written |= (expected >> i & 1) && use.resource == name && isWrite(use.access) &&
                     use.access != Access::Clear;
      ASSERT_EQ(frame.hasContent(name), written) << "list " << list << ", " << name;
    }
  }
  // The lists are worth something: every outcome occurs often.
  EXPECT_GT(total_on, 500);
  EXPECT_GT(total_off, 500);
  EXPECT_GT(total_content, 50);
}

TEST(SkipRule, DecidingTouchesNoGpu) {
  const gpu::Counters before = gpu::counters();
  SmallRenderer r;
  r.mesh = r.sun = r.text = true;
  r.frame.decide();
  const gpu::Counters used = gpu::counters() - before;
  EXPECT_EQ(
      used.textures + used.buffers + used.programs + used.framebuffers + used.draws + used.binds,
      0u);
}

TEST(PassRegistration, MistakesEndTheProgram) {
  Frame frame;
  frame.addTarget("color", {.format = GL_RGBA8});
  frame.addTarget("depth", {.format = GL_DEPTH_COMPONENT32F});
  frame.addTarget("map", {.format = GL_DEPTH_COMPONENT32F, .fixed_size = {64, 64}});
  frame.addExternal("list");
  frame.addExternal("list");  // two modules may both declare it
  frame.addPass(pass("first", Stage::Shade, {{"color", Access::Color}}));
  auto add = [&](std::vector<Use> uses, std::vector<std::string> content = {}) {
    frame.addPass(pass("second", Stage::Shade, std::move(uses), {}, std::move(content)));
  };
  EXPECT_DEATH(frame.addPass(pass("first", Stage::Lens, {{"color", Access::Color}})),
               "'first' is added twice");
  EXPECT_DEATH(add({{"colour", Access::Color}}), "uses 'colour', which is not declared");
  EXPECT_DEATH(add({{"color", Access::Color}}, {"nowhere"}), "needs content of 'nowhere'");
  EXPECT_DEATH(add({{"color", Access::Sampled}}), "writes nothing");
  EXPECT_DEATH(add({{"color", Access::Color}, {"color", Access::Sampled}}),
               "sampled while it is drawn to");
  EXPECT_DEATH(add({{"color", Access::Color}, {"color", Access::Clear}}), "twice");
  EXPECT_DEATH(add({{"color", Access::Color}, {"map", Access::Depth}}), "differ in size");
  EXPECT_DEATH(add({{"depth", Access::Depth}, {"depth", Access::DepthTest}}), "twice");
  EXPECT_DEATH(add({{"depth", Access::Color}}), "a depth format is no color attachment");
  EXPECT_DEATH(add({{"color", Access::Depth}}), "a color format is no depth attachment");
  EXPECT_DEATH(add({{"list", Access::Color}}), "an external resource is no attachment");
  EXPECT_DEATH(frame.addTarget("color", {.format = GL_RGBA8}), "'color' is declared twice");
  EXPECT_DEATH(frame.addExternal("color"), "'color' is a target already");
  EXPECT_DEATH(frame.addTarget("odd", {.format = GL_RGBA8, .fixed_size = {64, 0}}), "size 64x0");
  EXPECT_DEATH(frame.keep("nowhere", true), "'nowhere' is not declared");
  EXPECT_DEATH(frame.addPass({.name = "lazy", .uses = {{"color", Access::Color}}}), "has no code");
  EXPECT_DEATH((void)frame.texture("color"), "does not exist");
  EXPECT_FALSE(frame.hasTexture("color"));
  EXPECT_FALSE(frame.hasTexture("nowhere"));
  EXPECT_FALSE(frame.hasContent("nowhere"));
  EXPECT_EQ(frame.runCount("nowhere"), 0u);
}

TEST(Describe, NamesStagesPassesReasonsAndResources) {
  SmallRenderer r;
  r.frame.decide();
  EXPECT_EQ(r.frame.describe(),
            "frame 0x0: 3 of 7 passes on\n"
            "Geometry\n"
            "  on   clear                            -> albedo (clear), id (clear), depth (clear)\n"
            "  off  opaque   needs a thing           -> albedo (color), id (color), depth (depth)\n"
            "  off  shadow   needs a thing           -> shadow (depth)\n"
            "Shade\n"
            "  off  light    nothing is drawn to id  albedo (sampled), shadow (sampled) -> "
            "radiance (color)\n"
            "  on   sky                              depth (depth test) -> radiance (color)\n"
            "Present\n"
            "  on   present                          radiance (sampled) -> frame.output (color)\n"
            "  off  text     needs a thing           -> frame.output (color)\n");
}

// isWanted looks at needs, not at what is on: it may be asked while that is being decided.
TEST(FrameWanted, CountsKeptResourcesAndReadersWhoseNeedsAreMet) {
  Frame frame;
  bool lens = false;
  frame.addTarget("radiance", {.format = GL_RGBA16F});
  frame.addTarget("blurred", {.format = GL_RGBA16F});
  frame.addPass(pass("shade", Stage::Shade, {{"radiance", Access::Color}}));
  frame.addPass(pass("blur", Stage::Lens, {{"radiance", Access::Sampled}, {"blurred", Access::Color}},
                     [&lens] { return lens; }));
  frame.addPass(pass("at once", Stage::Present, {{kOut, Access::Color}},
                     [&frame] { return !frame.isWanted("radiance", "present"); }));
  frame.addPass(pass("present", Stage::Present, {{"radiance", Access::Sampled}, {kOut, Access::Color}},
                     [&frame] { return frame.isWanted("radiance", "present"); }));
  EXPECT_FALSE(frame.isWanted("radiance", "present"));
  frame.decide();
  EXPECT_EQ(namesOfOn(frame), (Names{"at once"}));
  frame.keep("radiance", true);
  EXPECT_TRUE(frame.isWanted("radiance", "present"));
  frame.decide();
  EXPECT_EQ(namesOfOn(frame), (Names{"shade", "present"}));
  frame.keep("radiance", false);
  lens = true;
  EXPECT_TRUE(frame.isWanted("radiance", "present"));
  frame.decide();
  EXPECT_EQ(namesOfOn(frame), (Names{"shade", "present"}));
  EXPECT_FALSE(frame.isWanted("blurred", "present"));
}

}  // namespace
}  // namespace scree
