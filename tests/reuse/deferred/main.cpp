// Draws a lit square against the sky, without a window, and reads the picture back from its file.
#include <cstdio>
#include <filesystem>

#include "engine/app/app.h"
#include "engine/assets/image.h"
#include "engine/core/file.h"
#include "modules/deferred/deferred.h"
#include "modules/scene/scene.h"

namespace {

scree::MeshData square() {
  scree::MeshData mesh;
  for (const scree::vec2 corner : {scree::vec2{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})
    mesh.vertices.push_back({.position = {corner.x, corner.y, 0}, .normal = {0, 0, 1}});
  mesh.indices = {0, 1, 2, 0, 2, 3};
  scree::computeBounds(mesh);
  return mesh;
}

}  // namespace

int main() {
  scree::setDataRoot(SCREE_DATA_DIR);
  const auto folder = std::filesystem::temp_directory_path() / "scree_reuse_deferred";
  scree::App app({.context = scree::ContextKind::Egl,
                  .size = {64, 64},
                  .capture = folder,
                  .capture_frames = {1},
                  .max_ticks = 1});
  scree::addScene(app);
  scree::addDeferred(app);
  scree::World& world = app.world();
  const uint32_t mesh = world.singleton<scree::MeshStore>().add(square());
  scree::Transform ahead, toward_the_square;
  ahead.position = {0, 0, -5};
  world.spawn(ahead, scree::previousOf(ahead), scree::MeshInstance{.mesh = mesh});
  world.spawn(toward_the_square, scree::previousOf(toward_the_square),
              scree::Light{.intensity = 2});
  if (scree::Status status = app.run(); !status.ok()) {
    std::fprintf(stderr, "%s\n", status.error().c_str());
    return 1;
  }
  auto picture = scree::loadImage(folder / "frame_000001.png", scree::ColorEncoding::Srgb);
  std::filesystem::remove_all(folder);
  if (!picture.ok()) {
    std::fprintf(stderr, "%s\n", picture.error().c_str());
    return 1;
  }
  // White and lit from the front in the middle; the blue of the sky in the top left corner.
  const auto red = [&](int x, int y) {
    return picture->bytes[static_cast<size_t>((y * picture->width + x) * picture->channels)];
  };
  std::printf("red of the square %d, of the sky %d; shaders of %s\n", red(32, 32), red(0, 0),
              scree::shaderRoot().c_str());
  return red(32, 32) > red(0, 0) + 20 ? 0 : 1;
}
