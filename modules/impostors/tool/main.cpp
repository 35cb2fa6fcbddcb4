// scree_bake: makes the files that a scene loads instead of computing them.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <memory>

#include "engine/core/file.h"
#include "engine/core/log.h"
#include "engine/core/parallel.h"
#include "modules/impostors/sheet.h"
#include "modules/impostors/tool/report.h"

namespace {

namespace fs = std::filesystem;
using scree::Error;
using scree::Result;
using scree::Status;

constexpr int kFine = 0, kFailed = 1, kBadInput = 2;

struct Arguments {
  fs::path mesh, out, picture;
  scree::BakeParameters parameters;
  scree::ImpostorWish wish;
  double memory_mib = 32;
  bool choose = false;     // --error is given
  bool has_size = false;   // --views or --texels is
  int threads = 0;
};

// What --error chooses by.
Status checkWish(const Arguments& a) {
  struct Range {
    const char* flag;
    double value, least, most;
  };
  constexpr double kMostDiameterPx = 1024;  // memory grows with its square: 0.4 GiB
  for (const Range& r : {Range{"--error", static_cast<double>(a.wish.max_flip), 0, 1},
                         Range{"--size", static_cast<double>(a.wish.diameter_px), 1, kMostDiameterPx},
                         Range{"--memory", a.memory_mib, 0, 768}})
    if (!(r.value >= r.least && r.value <= r.most))
      return Error{fmt::format("{} {:g}: allowed is {:g} to {:g}", r.flag, r.value, r.least, r.most)};
  if (a.has_size) return Error{"--error chooses --views and --texels: allowed is either it or these"};
  if (a.parameters.directions < 1)
    return Error{fmt::format("--error beside --directions {}: errors are measured from some; allowed are 1 to 1024", a.parameters.directions)};
  return scree::Done{};
}

Error sameFile(const char* one, const char* other, const fs::path& path) {
  return Error{fmt::format("{} and {} name the same file '{}'", one, other, path.string())};
}

Status checkArguments(Arguments& a) {
  if (a.out.empty()) a.out = fs::path(a.mesh).replace_extension(".impostor");
  if (Status fine = scree::checkParameters(a.parameters); !fine.ok()) return fine;
  if (Status fine = scree::checkOutputPath(a.out, "--out"); !fine.ok()) return fine;
  if (a.choose)
    if (Status fine = checkWish(a); !fine.ok()) return fine;
  if (scree::areSameFile(a.mesh, a.out)) return sameFile("the mesh", "--out", a.out);
  if (a.picture.empty()) return scree::Done{};
  if (scree::areSameFile(a.mesh, a.picture)) return sameFile("the mesh", "--picture", a.picture);
  if (scree::areSameFile(a.out, a.picture)) return sameFile("--out", "--picture", a.picture);
  if (Status fine = scree::checkOutputPath(a.picture, "--picture"); !fine.ok()) return fine;
  if (a.picture.extension() != ".png")
    return Error{fmt::format("--picture: '{}': allowed is a .png", a.picture.string())};
  return scree::Done{};
}

Error inFile(const fs::path& path, const Error& error) {
  return Error{fmt::format("{}: {}", path.string(), error.message), error.kind};
}

Status run(Arguments& a) {
  if (Status fine = checkArguments(a); !fine.ok()) return fine;
  scree::setThreadCount(a.threads);
  Result<scree::SceneData> scene = scree::loadGltf(a.mesh);
  if (!scene.ok()) return scene.takeError();
  Result<scree::GrainMesh> grain = scree::grainFromScene(std::move(scene).value());
  if (!grain.ok()) return grain.takeError();
  const auto start = std::chrono::steady_clock::now();
  auto bar = std::make_unique<scree::tool::ProgressBar>();
  const auto show = [&](double done) { bar->show(done); };
  if (a.choose) {
    a.wish.supersample = a.parameters.supersample;
    a.wish.max_bytes = static_cast<uint64_t>(a.memory_mib * (1 << 20));
    Result<scree::ImpostorChoice> choice =
        scree::chooseImpostor(*grain, a.wish, a.parameters.directions, show);
    if (!choice.ok()) return inFile(a.mesh, choice.takeError());
    a.parameters.edge = choice->edge;
    a.parameters.texels = choice->texels;
    if (!choice->good)
      scree::logWarning(
          "no size within {:g} MiB has an error of {:g} or less at {:g} px; the best has {:.4f}",
          a.memory_mib, a.wish.max_flip, a.wish.diameter_px, choice->flip);
  }
  Result<scree::ImpostorAtlas> atlas = scree::bake(*grain, a.parameters, show);
  if (!atlas.ok()) return inFile(a.mesh, atlas.takeError());
  if (Status written = scree::writeAtlas(a.out, *atlas); !written.ok()) return written;
  if (!a.picture.empty())
    if (Status written = scree::writeContactSheet(a.picture, *atlas); !written.ok()) return written;
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  bar.reset();
  fmt::print("{}: ", a.out.string());
  scree::tool::printAtlas(*atlas, seconds.count());
  scree::tool::printErrors(atlas->errors);
  return scree::Done{};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli{
      "scree_bake: computes ahead of time what a scene would have to compute while it loads."};
  cli.set_version_flag("--version", SCREE_VERSION);
  cli.require_subcommand(1);
  Arguments a;
  CLI::App* impostor = cli.add_subcommand("impostor",
                                          "Bakes a mesh into an atlas of views, and measures what "
                                          "drawing that instead costs in accuracy.");
  impostor->add_option("mesh", a.mesh, "glTF file; all its meshes together are one grain")
      ->required()
      ->type_name("MESH.glb");
  impostor->add_option("--out", a.out, "Atlas to write (default: the mesh's name with .impostor)")
      ->type_name("FILE");
  impostor->add_option("--picture", a.picture, "Contact sheet of the views to write")
      ->type_name("FILE.png");
  const CLI::Option* views =
      impostor
          ->add_option("--views", a.parameters.edge,
                       fmt::format("Vertices along an edge of the view octahedron, n: 4 (n - 1)^2 + 2 "
                                   "views (default {}; {} to {}); not with --error",
                                   a.parameters.edge, scree::rules::kImpostorMinEdge,
                                   scree::kImpostorMaxBakedEdge))
          ->type_name("N");
  const CLI::Option* texels =
      impostor
          ->add_option("--texels", a.parameters.texels,
                       fmt::format("Texels along a view's side: 16, 32, 64, 128 or 256 (default {}); not with --error",
                                   a.parameters.texels))
          ->type_name("P");
  impostor
      ->add_option("--supersample", a.parameters.supersample,
                   fmt::format("Samples along a texel's side (default {}; 1 to 8)",
                               a.parameters.supersample))
      ->type_name("N");
  impostor
      ->add_option("--directions", a.parameters.directions,
                   fmt::format("Random directions to measure from (default {}; 0: none, not with --error)",
                               a.parameters.directions))
      ->type_name("N");
  CLI::Option* error =
      impostor
          ->add_option(
              "--error", a.wish.max_flip,
              "Choose --views and --texels, in their place: the smallest atlas with at most this mean FLIP")
          ->type_name("E");
  impostor
      ->add_option("--size", a.wish.diameter_px,
                   fmt::format("With --error: the largest diameter drawn, pixels (default {:g})",
                               a.wish.diameter_px))
      ->type_name("PX")
      ->needs(error);
  impostor
      ->add_option("--memory", a.memory_mib,
                   fmt::format("With --error: at most so much on the GPU, MiB (default {:g})", a.memory_mib))
      ->type_name("MIB")
      ->needs(error);
  impostor->add_option("--threads", a.threads, "Threads (default 0: one a core)")
      ->type_name("N")
      ->check(CLI::Range(0, 256));
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return cli.exit(success);
  } catch (const CLI::ParseError& fault) {
    scree::logError("{} (see --help)", fault.what());
    return kBadInput;
  }
  a.choose = error->count() > 0;
  a.has_size = views->count() + texels->count() > 0;
  try {
    const Status status = run(a);
    if (status.ok()) return kFine;
    scree::logError("{}", status.error());
    return status.errorKind() == scree::ErrorKind::Failure ? kFailed : kBadInput;
  } catch (const std::exception& fault) {
    scree::logError("{}", fault.what());
    return kFailed;
  }
}
