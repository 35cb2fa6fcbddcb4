// scree_bench lod --view: pictures of how the heap of beans is drawn.
#include <fmt/format.h>

#include "engine/assets/image_pixels.h"
#include "engine/gpu/readback.h"
#include "tests/bench/bean_heap.h"
#include "tests/bench/bench.h"
#include "tests/bench/gl_context.h"

namespace scree::bench {
namespace {

using Paths = std::vector<std::filesystem::path>;

struct Pictures {
  HeapScene& scene;
  std::filesystem::path directory;
  Paths paths;

  // The picture, and beside it the debug view.
  Status write(const std::string& name) {
    scene.render();
    const images::Image image =
        images::imageFromBytes(scene.size.x, scene.size.y, 4,
                               gpu::readBytes(scene.app.frame().texture(Frame::kOutput), 4), RowOrder::BottomUp);
    paths.push_back(directory / (name + ".png"));
    return images::writeImage(paths.back(), image);
  }
};

// Without the view, then with it: along the heap's foot, and from several distances.
Status writePlaces(Pictures& pictures, const std::string& view, SwarmView setting) {
  SwarmView& now = pictures.scene.world.singleton<LodSettings>().view;
  const auto write = [&](const std::string& place) -> Status {
    now = SwarmView::Off;
    if (Status done = pictures.write("lod_plain_" + place); !done.ok()) return done;
    now = setting;
    return pictures.write("lod_" + view + "_" + place);
  };
  pictures.scene.lookFrom({0.05, 0.12, 1.0}, {0, 0.15, 0});
  if (Status done = write("along"); !done.ok()) return done;
  for (const double distance : {0.1, 0.4, 1.5, 6.0, 18.0}) {
    pictures.scene.look(distance);
    if (Status done = write(fmt::format("{}m", distance)); !done.ok()) return done;
  }
  return Done{};
}

// What the camera sees; then, from its left, all that there is, and what is drawn for it.
Status writeFrozen(Pictures& pictures) {
  HeapScene& scene = pictures.scene;
  SwarmView& now = scene.world.singleton<LodSettings>().view;
  const dvec3 aside(-1.6, 1.1, 1.2), middle(0, 0.25, 0.1);
  scene.lookFrom(aside, middle);
  if (Status done = pictures.write("lod_frozen_all_from_aside"); !done.ok()) return done;
  scene.look(0.8);
  scene.render();
  if (Status done = pictures.write("lod_frozen_camera"); !done.ok()) return done;
  now = SwarmView::Frozen;
  scene.lookFrom(aside, middle);
  return pictures.write("lod_frozen_drawn_from_aside");
}

Result<Paths> draw(const std::string& view, bool quick, const std::filesystem::path& directory) {
  openContext();
  const WorkFolder folder;
  HeapScene scene(makeHeap(quick ? 100'000 : 400'000), folder.path() / "bean.impostor");
  scene.size = quick ? ivec2(640, 360) : ivec2(1280, 720);
  Pictures pictures{scene, directory, {}};
  const SwarmView setting = view == "overdraw" ? SwarmView::Overdraw : SwarmView::Representation;
  const Status done = view == "frozen" ? writeFrozen(pictures) : writePlaces(pictures, view, setting);
  if (!done.ok()) return Error{done.error()};
  return pictures.paths;
}

[[maybe_unused]] const bool registered_views = registerViews("lod", {"representation", "overdraw", "frozen"}, &draw);

}  // namespace
}  // namespace scree::bench
