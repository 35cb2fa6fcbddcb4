// loadGltf: document, check, resources, parse, convert.
#include "engine/assets/gltf.h"

#include "engine/assets/gltf_convert.h"

namespace scree {

Result<SceneData> loadGltf(const std::filesystem::path& path, const GltfLimits& limits) {
  Result<gltf::Document> document = gltf::readDocument(path, limits);
  if (!document.ok()) return document.takeError();
  if (Status checked = gltf::checkDocument(*document, limits); !checked.ok())
    return checked.takeError();
  if (Status read = gltf::readResources(*document, limits); !read.ok()) return read.takeError();
  Result<tinygltf::Model> model = gltf::parseModel(*document);
  if (!model.ok()) return model.takeError();

  SceneData scene;
  scene.path = path;
  std::vector<gltf::MeshRange> ranges;
  if (Status done = gltf::convertMeshes(*model, limits, scene, ranges); !done.ok())
    return done.takeError();
  if (Status done = gltf::convertMaterials(*model, limits, scene); !done.ok())
    return done.takeError();
  if (Status done = gltf::convertNodes(*model, *document, limits, ranges, scene); !done.ok())
    return done.takeError();
  return scene;
}

}  // namespace scree
