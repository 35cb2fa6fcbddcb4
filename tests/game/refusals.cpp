// Malformed inputs and bad flags: each ends in one clear line and exit status 2.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>

#include "engine/core/file.h"
#include "tests/game/support/program.h"

namespace scree::hourglass {
namespace {

namespace fs = std::filesystem;

const fs::path kLevel = fs::path(SCREE_SOURCE_DIR) / "content/levels/level1.glb";
const fs::path kReplay = fs::path(SCREE_SOURCE_DIR) / "tests/game/replays/level1_win.replay";

std::string readAll(const fs::path& path) {
  Result<std::string> text = readText(path);
  EXPECT_TRUE(text.ok());
  return text.ok() ? *text : std::string();
}

fs::path write(const std::string& name, const std::string& content) {
  static const fs::path folder = scratchFolder("refusals");
  const fs::path path = folder / name;
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

// The run is refused: status 2, nothing on standard output, and one line on standard error that
// names every one of `names`.
void expectRefusal(const std::vector<std::string>& arguments, const std::vector<std::string>& names) {
  const ProgramRun run = runProgram("hourglass", arguments, 120);
  const std::string command = fmt::format("hourglass {}", fmt::join(arguments, " "));
  EXPECT_EQ(run.status, 2) << command << "\n" << run.err;
  EXPECT_EQ(run.out, "") << command;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << command << "\n" << run.err;
  for (const std::string& name : names)
    EXPECT_NE(run.err.find(name), std::string::npos) << command << "\nlacks '" << name << "':\n" << run.err;
}

TEST(Refusals, Flags) {
  expectRefusal({"--no-such-flag"}, {"no-such-flag"});
  expectRefusal({"stray"}, {"stray"});
  expectRefusal({"--size", "640"}, {"--size", "640", "WIDTHxHEIGHT"});
  expectRefusal({"--size", "0x360"}, {"0x360"});
  expectRefusal({"--size", "640x-360"}, {"640x-360"});
  expectRefusal({"--size", "99999x99999"}, {"8192"});
  expectRefusal({"--size", "640x360x2"}, {"640x360x2"});
  expectRefusal({"--context", "vulkan"}, {"vulkan", "egl"});
  expectRefusal({"--threads", "-1"}, {"--threads"});
  expectRefusal({"--threads", "many"}, {"--threads", "many"});
  expectRefusal({"--threads", "100000"}, {"--threads"});
  expectRefusal({"--ticks", "0"}, {"--ticks"});
  expectRefusal({"--ticks", "1e99"}, {"--ticks"});
  expectRefusal({"--frames", "1,2,x", "--capture", "x"}, {"--frames", "1,2,x"});
  expectRefusal({"--frames", "0", "--capture", "x"}, {"--frames"});
  expectRefusal({"--every", "0", "--capture", "x"}, {"--every"});
  expectRefusal({"--truth", "0", "--capture", "x", "--every", "1"}, {"--truth"});
  expectRefusal({"--truth", "4", "--ticks", "1"}, {"--truth", "--capture"});
  expectRefusal({"--frames", "60", "--ticks", "1"}, {"--frames", "--capture"});
  expectRefusal({"--capture", "x", "--ticks", "1"}, {"--capture", "--frames", "--every"});
  expectRefusal({"--context", "egl"}, {"--replay", "--ticks"});
  expectRefusal({"--stats", "", "--ticks", "1"}, {"--stats", "empty"});
  expectRefusal({"--record", "/nowhere/at/all.replay", "--ticks", "1"}, {"--record", "/nowhere/at/all"});
  expectRefusal({"--trace", fs::temp_directory_path().string(), "--ticks", "1"}, {"--trace", "folder"});
  expectRefusal({"--stats", "same", "--trace", "same", "--ticks", "1"}, {"--stats", "--trace", "same"});
  expectRefusal({"--stats", "same", "--trace", "./same", "--ticks", "1"}, {"--stats", "--trace", "same"});
  expectRefusal({"--level", kLevel.string(), "--stats", kLevel.string(), "--ticks", "1"}, {"--level", "--stats", "same"});
  expectRefusal({"--capture", "x", "--every", "1", "--ticks", "1", "--trace", "./x/../x/contact_sheet.png"},
                {"--trace", "x"});
  expectRefusal({"--level", "", "--ticks", "1"}, {"--level", "empty"});
  expectRefusal({"--capture", kLevel.string(), "--every", "1", "--ticks", "1", "--context", "egl"},
                {"level1.glb"});
}

TEST(Refusals, Levels) {
  const auto refuse = [](const fs::path& level, const std::vector<std::string>& names) {
    expectRefusal({"--level", level.string(), "--ticks", "1", "--context", "egl"}, names);
  };
  refuse("nowhere.glb", {"nowhere.glb"});
  refuse("99", {"--level 99", "no such level", "1 to 1"});
  refuse(fs::temp_directory_path(), {fs::temp_directory_path().string()});
  refuse(write("empty.glb", ""), {"empty.glb"});
  refuse(write("text.glb", "not a model"), {"text.glb"});
  const std::string level = readAll(kLevel);
  refuse(write("cut.glb", level.substr(0, level.size() / 2)), {"cut.glb"});
  refuse(write("header.glb", level.substr(0, 12)), {"header.glb"});
  std::string huge = level;
  std::copy_n("\xff\xff\xff\x7f", 4, huge.begin() + 8);
  refuse(write("huge.glb", huge), {"huge.glb"});
  refuse(write("brace.gltf", "{\"asset\": {\"version\": \"2.0\"}"), {"brace.gltf"});
  refuse(write("version.gltf", R"({"asset": {"version": "1.0"}})"), {"version.gltf", "1.0"});
  refuse(write("index.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [7]}]})"),
         {"index.gltf", "7"});
  refuse(write("cycle.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
             "nodes": [{"children": [1]}, {"children": [0]}]})"),
         {"cycle.gltf"});
  refuse(write("type.gltf", R"({"asset": {"version": "2.0"}, "nodes": {"a": 1}})"), {"type.gltf", "nodes"});
  refuse(write("buffer.gltf", R"({"asset": {"version": "2.0"},
             "buffers": [{"uri": "gone.bin", "byteLength": 12}],
             "bufferViews": [{"buffer": 0, "byteLength": 12}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "count": 1, "type": "VEC3"}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
             "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]})"),
         {"buffer.gltf", "gone.bin"});
  refuse(write("extras.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
             "nodes": [{"name": "tray", "extras": {"Scale": {"target_kg": "heavy"}}}]})"),
         {"extras.gltf", "tray", "Scale", "target_kg", "heavy"});
  refuse(write("field.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
             "nodes": [{"name": "tray", "extras": {"Scale": {"target_lb": 3}}}]})"),
         {"field.gltf", "tray", "Scale", "target_lb"});
  const auto extras = [](const std::string& name, const std::string& json) {
    return write(name, R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
             "nodes": [{"name": "heap", "extras": )" + json + "}]}");
  };
  refuse(extras("block.gltf", R"({"GrainBlock": {"radius": -1}})"), {"block.gltf", "heap", "GrainBlock", "radius"});
  refuse(extras("many.gltf", R"({"GrainBlock": {"count": [100000, 100000, 1]}})"), {"many.gltf", "count", "4e+06"});
  refuse(extras("bounds.gltf", R"({"GrainField": {"bounds_min": [0, 600, 0]}})"), {"heap", "bounds_min.y = 600"});
  refuse(extras("origin.gltf", R"({"GrainField": {"origin": [1e15, 0, 0]}})"), {"heap", "origin.x = 1e+15"});
  refuse(extras("color.gltf", R"({"GrainBlock": {"color": [0, -1, 0]}})"), {"heap", "color.y = -1"});
  refuse(extras("box.gltf", R"({"BoxCollider": {"half_extent": [1, -2, 1]}})"), {"heap", "half_extent.y = -2"});
  refuse(extras("clock.gltf", R"({"LevelRules": {"time_limit_s": 1e10}})"), {"time_limit_s = 1e+10", "86400"});
  refuse(extras("walk.gltf", R"({"Creature": {"walk_speed_m_s": 1e38}})"), {"Creature", "walk_speed_m_s"});
  refuse(extras("own.gltf", R"({"CreatureMotion": {"velocity": [3e38, 0, 0]}})"), {"CreatureMotion", "left out"});
  refuse(write("nan.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
             "nodes": [{"translation": [0, 1e400, 0]}]})"),
         {"nan.gltf"});
  write("broken.png", "\x89PNG\r\n\x1a\nbroken");
  refuse(write("image.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
             "nodes": [{"mesh": 0}], "images": [{"uri": "broken.png"}], "textures": [{"source": 0}],
             "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
             "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
             "bufferViews": [{"buffer": 0, "byteLength": 36}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                            "min": [0, 0, 0], "max": [1, 1, 0]}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}]})"),
         {"image.gltf", "image 0", "PNG"});
}

TEST(Refusals, Replays) {
  const std::string replay = readAll(kReplay);
  const auto refuse = [](const fs::path& path, const std::vector<std::string>& names) {
    expectRefusal({"--replay", path.string(), "--context", "egl"}, names);
  };
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = replay;
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
  };
  refuse("nowhere.replay", {"nowhere.replay"});
  refuse(write("empty.replay", ""), {"empty.replay"});
  refuse(write("cut.replay", replay.substr(0, replay.size() / 2)), {"cut.replay"});
  refuse(write("version.replay", replaced("scree-replay 2", "scree-replay 1")), {"version.replay:1", "'scree-replay 2'"});
  refuse(write("level.replay", replaced("level level1.glb", "level level2.glb")), {"level.replay"});
  refuse(write("action.replay", replaced("action move_x axis", "action moonwalk axis")), {"action.replay"});
  refuse(write("flipped.replay", replaced("begin\n", "begin\n1 move_x 1\n")), {"flipped.replay"});
  // The same level but for one number.
  std::string level = readAll(kLevel);
  const size_t seed = level.find("\"seed\":7");
  ASSERT_NE(seed, std::string::npos);
  level[seed + 7] = '8';
  expectRefusal({"--replay", kReplay.string(), "--level", write("level1.glb", level).string(), "--context", "egl"},
                {"level1_win.replay", "'level1.glb' of content ", "record it anew"});
  refuse(write("binary.replay", std::string("\0\1\2\3", 4) + replay), {"binary.replay:1"});
}

TEST(Refusals, Bindings) {
  const auto refuse = [](const fs::path& path, const std::vector<std::string>& names) {
    expectRefusal({"--bindings", path.string(), "--ticks", "1", "--context", "egl"}, names);
  };
  refuse("nowhere.json", {"nowhere.json"});
  refuse(write("brace.json", "{"), {"brace.json"});
  refuse(write("array.json", "[1, 2]"), {"array.json"});
  refuse(write("action.json", R"({"version": 1, "actions": {"fly": ["key.f"]}})"), {"action.json", "fly"});
  refuse(write("key.json", R"({"version": 1, "actions": {"pause": ["key.any"]}})"),
         {"key.json", "pause", "key.any"});
  refuse(write("scale.json", R"({"version": 1, "actions": {"pause": [{"source": "key.p", "scale": "x"}]}})"),
         {"scale.json", "pause", "scale"});
}

}  // namespace
}  // namespace scree::hourglass
