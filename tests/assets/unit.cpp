// Good files: what is in them comes out, in every encoding that glTF has for it.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine/assets/extras.h"
#include "engine/assets/gltf.h"
#include "engine/core/random.h"
#include "tests/assets/gltf_builder.h"

#include <glm/geometric.hpp>

namespace scree::test {

enum class Mood : uint32_t { Calm, Wild };
struct AssetProbe {
  bool flag = false;
  int32_t whole = -7;
  uint32_t natural = 7;
  int64_t big = 0;
  uint64_t huge = 0;
  float real = 0.5f;
  double precise = 0;
  vec2 two{0};
  vec3 three{0};
  vec4 four{0};
  dvec3 place{0};
  quat turn{1, 0, 0, 0};
  Entity friend_of = Entity::kNone;
  Mood mood = Mood::Calm;
  char text[8] = {};
  std::array<float, 3> list{};
};
SCREE_COMPONENT(AssetProbe, (flag, ""), (whole, ""), (natural, ""), (big, ""), (huge, ""),
                (real, "m"), (precise, "s"), (two, ""), (three, ""), (four, ""), (place, "m"),
                (turn, ""), (friend_of, ""), (mood, ""), (text, ""), (list, ""));
struct AssetTag {};
SCREE_COMPONENT(AssetTag);

namespace {

SceneData load(const std::filesystem::path& path) {
  Result<SceneData> scene = loadGltf(path);
  EXPECT_TRUE(scene.ok()) << (scene.ok() ? "" : scene.error());
  return scene.ok() ? std::move(*scene) : SceneData{};
}

void expectNear(const vec3& a, const vec3& b, float bound = 1e-6f) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], bound) << "component " << i;
}

// What fullFile() describes, however it was saved.
void expectFull(const SceneData& scene) {
  ASSERT_EQ(scene.meshes.size(), 1u);
  const MeshData& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.name, "floor");
  ASSERT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{0, 2, 1, 0, 3, 2}));
  EXPECT_EQ(mesh.vertices[1].position, vec3(1, 0, -1));
  EXPECT_EQ(mesh.vertices[2].position, vec3(1, 0.5f, 1)) << "the sparse element";
  EXPECT_EQ(mesh.vertices[2].uv, vec2(1, 1));
  EXPECT_EQ(mesh.vertices[0].normal, vec3(0, 1, 0));
  EXPECT_EQ(mesh.min, vec3(-1, 0, -1));
  EXPECT_EQ(mesh.max, vec3(1, 0.5f, 1));
  EXPECT_EQ(mesh.material, 0);

  ASSERT_EQ(scene.materials.size(), 1u);
  const MaterialData& material = scene.materials[0];
  EXPECT_EQ(material.name, "tiles");
  EXPECT_EQ(material.base_color, vec4(1, 0.5f, 0.25f, 1));
  EXPECT_EQ(material.metallic, 0.25f);
  EXPECT_EQ(material.roughness, 0.75f);
  EXPECT_EQ(material.emissive, vec3(4, 0, 0)) << "factor times strength";
  EXPECT_EQ(material.normal_scale, 2);
  EXPECT_EQ(material.alpha_mode, AlphaMode::Mask);
  EXPECT_EQ(material.alpha_cutoff, 0.25f);
  EXPECT_TRUE(material.double_sided);
  EXPECT_EQ(material.base_color_map.wrap_u, TextureWrap::ClampToEdge);
  EXPECT_EQ(material.base_color_map.wrap_v, TextureWrap::Repeat);
  EXPECT_TRUE(material.base_color_map.nearest);
  EXPECT_EQ(material.emissive_map.image, -1);

  // The same image is a colour for one use and numbers for the other.
  ASSERT_EQ(scene.images.size(), 2u);
  const ImageData& color = scene.images[static_cast<size_t>(material.base_color_map.image)];
  const ImageData& bumps = scene.images[static_cast<size_t>(material.normal_map.image)];
  EXPECT_EQ(color.encoding, ColorEncoding::Srgb);
  EXPECT_EQ(bumps.encoding, ColorEncoding::Linear);
  EXPECT_EQ(color.name, "checks");
  EXPECT_EQ(color.bytes,
            (Bytes{255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 128}));
  EXPECT_EQ(bumps.bytes, color.bytes);

  ASSERT_EQ(scene.nodes.size(), 3u);
  const NodeData& table = scene.nodes[0];
  EXPECT_EQ(table.name, "table");
  EXPECT_EQ(table.first_mesh, 0);
  EXPECT_EQ(table.mesh_count, 1);
  EXPECT_EQ(table.extras.at("artist"), "nobody");
  expectNear(table.scale, vec3(2));
  const NodeData& eye = scene.nodes[1];
  EXPECT_EQ(eye.parent, 0);
  // Turned a quarter about +Y, +Z becomes +X; scaled by 2.
  expectNear(vec3(eye.position), vec3(12, 0, 0));
  expectNear(eye.rotation * vec3(0, 0, 1), vec3(1, 0, 0));
  ASSERT_EQ(eye.camera, 0);
  EXPECT_EQ(scene.cameras[0].fov_y_rad, 0.75f);
  EXPECT_EQ(scene.cameras[0].near_m, 0.125f);
  const NodeData& lamp = scene.nodes[2];
  EXPECT_EQ(lamp.position, dvec3(4, 5, 6));
  expectNear(lamp.scale, vec3(-1, 1, 3));
  expectNear(lamp.rotation * vec3(1, 2, 3), vec3(1, 2, 3));
  ASSERT_EQ(lamp.light, 0);
  const LightData& light = scene.lights[0];
  EXPECT_EQ(light.kind, LightData::Kind::Spot);
  EXPECT_EQ(light.color, vec3(1, 0.5f, 0));
  EXPECT_EQ(light.intensity, 100);
  EXPECT_EQ(light.range_m, 20);
  EXPECT_EQ(light.inner_cone_rad, 0.25f);
  EXPECT_EQ(light.outer_cone_rad, 0.5f);
}

TEST(Gltf, EverythingComesOutOfEveryContainer) {
  const TemporaryFolder folder;
  fullFile(folder).saveGlb(folder / "a.glb");
  expectFull(load(folder / "a.glb"));
  fullFile(folder).saveGltf(folder / "a.gltf");
  expectFull(load(folder / "a.gltf"));
  fullFile(folder).saveGltf(folder / "b.gltf", true);
  expectFull(load(folder / "b.gltf"));
}

// A mesh of one accessor type, read back as floats.
template <class T>
std::vector<float> readPositions(const std::vector<T>& values, bool normalized) {
  const TemporaryFolder folder;
  GltfBuilder b;
  std::vector<T> padded;  // vertex attributes begin at multiples of 4 bytes
  for (size_t i = 0; i < values.size(); i += 3) {
    padded.insert(padded.end(), values.begin() + static_cast<ptrdiff_t>(i),
                  values.begin() + static_cast<ptrdiff_t>(i) + 3);
    while (padded.size() * sizeof(T) % 4 != 0) padded.push_back(T{99});
  }
  const size_t stride = padded.size() * sizeof(T) / (values.size() / 3);
  const int view = b.addView(padded.data(), padded.size() * sizeof(T), {{"byteStride", stride}});
  b.add("accessors", {{"bufferView", view},
                      {"componentType", componentType<T>()},
                      {"count", values.size() / 3},
                      {"type", "VEC3"},
                      {"normalized", normalized}});
  b.add("meshes", {{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}});
  b.add("nodes", {{"mesh", 0}});
  b.saveGlb(folder / "types.glb");
  std::vector<float> read;
  for (const MeshData& mesh : load(folder / "types.glb").meshes)
    for (const Vertex& vertex : mesh.vertices)
      for (int c = 0; c < 3; ++c) read.push_back(vertex.position[c]);
  return read;
}

// glTF 2.0, 3.6.2.2, in double precision.
template <class T>
void expectType() {
  std::vector<T> values;
  for (int i = 0; i < 9; ++i)
    values.push_back(static_cast<T>(i == 0   ? std::numeric_limits<T>::min()
                                    : i == 1 ? std::numeric_limits<T>::max()
                                             : i * i * 3));
  const std::vector<float> plain = readPositions(values, false);
  const std::vector<float> normal = readPositions(values, true);
  ASSERT_EQ(plain.size(), values.size());
  ASSERT_EQ(normal.size(), values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const double value = values[i];
    EXPECT_EQ(plain[i], static_cast<float>(value));
    const double scaled = std::max(value / std::numeric_limits<T>::max(), -1.0);
    EXPECT_NEAR(normal[i], scaled, 6e-8);
  }
}

TEST(Gltf, IntegerAttributesOfAllTypes) {
  expectType<int8_t>();
  expectType<uint8_t>();
  expectType<int16_t>();
  expectType<uint16_t>();
}

TEST(Gltf, StridedFloatsAndEveryIndexType) {
  const TemporaryFolder folder;
  GltfBuilder b;
  // position and a decoy, interleaved
  const std::vector<float> data = {0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9};
  const int view = b.addView(data.data(), data.size() * 4, {{"byteStride", 16}});
  b.add("accessors",
        {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  b.addAccessor<uint8_t>({2, 1, 0}, "SCALAR");
  b.addAccessor<uint16_t>({2, 1, 0}, "SCALAR");
  b.addAccessor<uint32_t>({2, 1, 0}, "SCALAR");
  b.addAccessor<float>({0, 0, -1, 0, 0, -1, 0, 0, -1}, "VEC3");
  json primitives;
  for (int indices = 1; indices <= 3; ++indices)
    primitives.push_back({{"attributes", {{"POSITION", 0}, {"NORMAL", 4}}}, {"indices", indices}});
  b.add("meshes", {{"primitives", primitives}});
  b.add("nodes", {{"mesh", 0}});
  b.saveGltf(folder / "indices.gltf");
  const SceneData scene = load(folder / "indices.gltf");
  ASSERT_EQ(scene.meshes.size(), 3u);
  for (const MeshData& mesh : scene.meshes) {
    EXPECT_EQ(mesh.indices, (std::vector<uint32_t>{2, 1, 0}));
    EXPECT_EQ(mesh.vertices[1].position, vec3(1, 0, 0));
    EXPECT_EQ(mesh.vertices[2].position, vec3(0, 1, 0));
    EXPECT_EQ(mesh.material, -1);
  }
  EXPECT_EQ(scene.nodes[0].mesh_count, 3);
}

TEST(Gltf, StripsAndFansKeepTheirWinding) {
  const TemporaryFolder folder;
  for (int mode : {5, 6}) {
    GltfBuilder b;
    // a strip goes zigzag, a fan round its first corner; both face +Z
    b.addAccessor<float>(mode == 5
                             ? std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}
                             : std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 1, 0},
                         "VEC3");
    b.add("meshes", {{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"mode", mode}}}}});
    b.add("nodes", {{"mesh", 0}});
    b.saveGlb(folder / "strip.glb");
    const SceneData scene = load(folder / "strip.glb");
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].indices.size(), 9u);
    for (const Vertex& vertex : scene.meshes[0].vertices) EXPECT_EQ(vertex.normal, vec3(0, 0, 1));
  }
}

TEST(Gltf, PointsAreLeftOutAndLinesToo) {
  const TemporaryFolder folder;
  GltfBuilder b = fullFile(folder);
  json primitives = json::array();
  for (int mode : {0, 1, 2, 3})
    primitives.push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
  primitives.push_back(b.doc["meshes"][0]["primitives"][0]);
  b.doc["meshes"][0]["primitives"] = primitives;
  b.add("meshes", {{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"mode", 0}}}}});
  b.doc["nodes"][1]["mesh"] = 1;
  b.saveGlb(folder / "points.glb");
  const SceneData scene = load(folder / "points.glb");
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_EQ(scene.nodes[0].first_mesh, 0);
  EXPECT_EQ(scene.nodes[1].first_mesh, -1);
  EXPECT_EQ(scene.nodes[1].mesh_count, 0);
}

TEST(Gltf, UsesTheDefaultSceneOnly) {
  const TemporaryFolder folder;
  GltfBuilder b;
  for (int i = 0; i < 4; ++i)
    b.add("nodes", {{"name", std::string(1, static_cast<char>('a' + i))}});
  b.add("scenes", {{"nodes", {0}}});
  b.add("scenes", {{"nodes", {3, 1, 3}}});
  b.doc.erase("buffers");
  b.doc["scene"] = 1;
  saveText(folder / "scenes.gltf", b.doc.dump());
  SceneData scene = load(folder / "scenes.gltf");
  ASSERT_EQ(scene.nodes.size(), 2u);
  EXPECT_EQ(scene.nodes[0].name, "d");
  EXPECT_EQ(scene.nodes[1].name, "b");
  EXPECT_EQ(scene.nodes[1].index, 1);
  b.doc.erase("scene");
  b.doc.erase("scenes");
  saveText(folder / "scenes.gltf", b.doc.dump());
  EXPECT_EQ(load(folder / "scenes.gltf").nodes.size(), 4u);
}

TEST(Gltf, DeepTreesComposeLikeMatrices) {
  const TemporaryFolder folder;
  GltfBuilder b;
  glm::dmat4 expected(1.0);
  const int depth = 200;
  for (int i = 0; i < depth; ++i) {
    const double angle = randomUnit(7, static_cast<uint64_t>(i), 0, 0) * 6.0;
    const dvec3 axis =
        glm::normalize(dvec3(randomUnit(7, static_cast<uint64_t>(i), 0, 1) - 0.5,
                             randomUnit(7, static_cast<uint64_t>(i), 0, 2) - 0.5, 0.3));
    const glm::dquat q = glm::angleAxis(angle, axis);
    const double scale = i % 2 == 0 ? 1.5 : 1 / 1.5;
    json node = {{"translation", {1, 2, 3}},
                 {"rotation", {q.x, q.y, q.z, q.w}},
                 {"scale", {scale, scale, scale}}};
    if (i + 1 < depth) node["children"] = {i + 1};
    b.add("nodes", node);
    glm::dmat4 local = glm::mat4_cast(q);
    for (int c = 0; c < 3; ++c) local[c] *= scale;
    local[3] = glm::dvec4(1, 2, 3, 1);
    expected = expected * local;
  }
  b.doc.erase("buffers");
  saveText(folder / "deep.gltf", b.doc.dump());
  const SceneData scene = load(folder / "deep.gltf");
  ASSERT_EQ(scene.nodes.size(), static_cast<size_t>(depth));
  const NodeData& last = scene.nodes.back();
  EXPECT_LT(glm::length(last.position - dvec3(expected[3])), 1e-9);
  const dvec3 point(0.3, -0.2, 0.9);
  const dvec3 placed = last.position + glm::dquat(last.rotation) * (dvec3(last.scale) * point);
  EXPECT_LT(glm::length(placed - dvec3(expected * glm::dvec4(point, 1))), 1e-5);
}

TEST(Gltf, FarPositionsKeepTheirMillimetres) {
  const TemporaryFolder folder;
  GltfBuilder b;
  b.add("nodes", {{"translation", {1e6, 0, -1e6}}, {"children", {1}}});
  b.add("nodes", {{"translation", {0.001, 0.002, 0.003}}});
  b.doc.erase("buffers");
  saveText(folder / "far.gltf", b.doc.dump());
  const SceneData scene = load(folder / "far.gltf");
  EXPECT_NEAR(scene.nodes[1].position.x, 1e6 + 0.001, 1e-9);
  EXPECT_NEAR(scene.nodes[1].position.z, -1e6 + 0.003, 1e-9);
}

TEST(Gltf, NonUniformScaleWithoutShearIsFine) {
  const TemporaryFolder folder;
  GltfBuilder b;
  const double h = std::sqrt(0.5);
  b.add("nodes", {{"scale", {1, 2, 4}}, {"children", {1}}});
  b.add("nodes",
        {{"rotation", {0, 0, h, h}}, {"scale", {1, 1, 1}}});  // a quarter turn permutes axes
  b.doc.erase("buffers");
  saveText(folder / "scale.gltf", b.doc.dump());
  const SceneData scene = load(folder / "scale.gltf");
  expectNear(scene.nodes[1].scale, vec3(2, 1, 4), 1e-5f);
}

TEST(Gltf, ImagesBesideTheFileAndInTextWork) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "maps and more");
  const Bytes png = smallPng(folder);
  saveBytes(folder / "maps and more" / "a b.png", png);
  for (const std::string& uri :
       {std::string("maps%20and%20more/a%20b.png"), std::string("small.png"),
        std::string("maps and more/../small.png"), "data:image/png;base64," + base64(png)}) {
    GltfBuilder b = fullFile(folder);
    b.doc["images"][0] = {{"uri", uri}};
    b.saveGlb(folder / "uris.glb");
    EXPECT_EQ(load(folder / "uris.glb").images.size(), 2u) << uri;
  }
}

TEST(Gltf, MissingNormalsAreFlatAndZeroNormalsRepaired) {
  const TemporaryFolder folder;
  GltfBuilder b;
  // two triangles at a right angle that share an edge
  b.addAccessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3");
  b.addAccessor<uint8_t>({0, 1, 2, 0, 2, 3}, "SCALAR");
  b.addAccessor<float>({0, 0, 0, 0, 0, 2, 0, 0, 1, 0, 0, 1}, "VEC3");
  b.add("meshes", {{"primitives",
                    {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}},
                     {{"attributes", {{"POSITION", 0}, {"NORMAL", 2}}}, {"indices", 1}}}}});
  b.add("nodes", {{"mesh", 0}});
  b.saveGlb(folder / "flat.glb");
  const SceneData scene = load(folder / "flat.glb");
  ASSERT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.meshes[0].vertices.size(), 6u);
  for (size_t i = 0; i < 6; ++i)
    expectNear(scene.meshes[0].vertices[i].normal, i < 3 ? vec3(0, 0, 1) : vec3(1, 0, 0));
  ASSERT_EQ(scene.meshes[1].vertices.size(), 4u);
  expectNear(scene.meshes[1].vertices[0].normal, glm::normalize(vec3(1, 0, 1)));
  expectNear(scene.meshes[1].vertices[1].normal, vec3(0, 0, 1));
}

// A sphere of latitudes and longitudes, mapped like a globe.
MeshData globe(int n) {
  MeshData mesh;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= 2 * n; ++x) {
      const double theta = M_PI * y / n, phi = M_PI * x / n;
      Vertex vertex;
      vertex.position =
          vec3(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
      vertex.uv = vec2(0.5 * x / n, 1.0 * y / n);
      mesh.vertices.push_back(vertex);
    }
  const auto at = [&](int x, int y) { return static_cast<uint32_t>(y * (2 * n + 1) + x); };
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < 2 * n; ++x)
      mesh.indices.insert(mesh.indices.end(), {at(x, y), at(x, y + 1), at(x + 1, y), at(x + 1, y),
                                               at(x, y + 1), at(x + 1, y + 1)});
  return mesh;
}

TEST(MeshData, NormalsAndTangentsOfASphere) {
  MeshData mesh = globe(64);
  computeNormals(mesh);
  computeTangents(mesh);
  for (const Vertex& v : mesh.vertices) {
    EXPECT_NEAR(glm::length(v.normal), 1, 1e-5);
    EXPECT_NEAR(glm::length(vec3(v.tangent)), 1, 1e-5);
    EXPECT_NEAR(glm::dot(v.normal, vec3(v.tangent)), 0, 1e-5);
    if (std::abs(v.position.y) > 0.98f) continue;  // the poles have no east
    EXPECT_GT(glm::dot(v.normal, v.position), 0.998f);
    const vec3 east = glm::normalize(vec3(v.position.z, 0, -v.position.x));
    EXPECT_GT(glm::dot(vec3(v.tangent), east), 0.999f);
    // bitangent = w * cross(n, t) points against v, which grows southwards
    EXPECT_GT(v.tangent.w * glm::cross(v.normal, vec3(v.tangent)).y, 0.1f);
  }
}

TEST(MeshData, MirroredUvTurnsTheBitangent) {
  MeshData mesh = globe(16);
  for (Vertex& v : mesh.vertices) v.uv.x = -v.uv.x;
  computeNormals(mesh);
  computeTangents(mesh);
  const Vertex& v = mesh.vertices[8 * 33 + 5];
  const vec3 west = -glm::normalize(vec3(v.position.z, 0, -v.position.x));
  EXPECT_GT(glm::dot(vec3(v.tangent), west), 0.99f);
  EXPECT_GT(v.tangent.w * glm::cross(v.normal, vec3(v.tangent)).y, 0.1f);
}

TEST(MeshData, HostileTrianglesStayFinite) {
  MeshData mesh;
  const float tiny = 1e-30f, far = 1e18f;
  for (const vec3& p :
       {vec3(0), vec3(tiny, 0, 0), vec3(0, tiny, 0), vec3(far, 0, 0), vec3(0, far, 0), vec3(1)})
    mesh.vertices.push_back({p, vec3(0), vec4(0), vec2(p)});
  mesh.indices = {0, 1, 2, 0, 3, 4, 5, 5, 5, 0, 0, 1, 3, 4, 5};
  computeNormals(mesh);
  computeTangents(mesh);
  computeBounds(mesh);
  for (const Vertex& v : mesh.vertices) {
    EXPECT_NEAR(glm::length(v.normal), 1, 1e-4);
    EXPECT_NEAR(glm::length(vec3(v.tangent)), 1, 1e-4);
    EXPECT_EQ(std::abs(v.tangent.w), 1);
  }
  MeshData empty;
  computeNormals(empty);
  computeTangents(empty);
  computeBounds(empty);
  EXPECT_EQ(empty.max, vec3(0));
}

TEST(Image, PngRoundTripInBothRowOrders) {
  const TemporaryFolder folder;
  for (int channels : {1, 3, 4}) {
    Bytes pixels;
    for (size_t i = 0; i < 5u * 7u * static_cast<size_t>(channels); ++i)
      pixels.push_back(static_cast<uint8_t>(randomBits(1, i, 0, 0)));
    ASSERT_TRUE(writePng(folder / "x.png", 5, 7, channels, pixels).ok());
    Result<ImageData> image = loadImage(folder / "x.png", ColorEncoding::Srgb);
    ASSERT_TRUE(image.ok()) << image.error();
    EXPECT_EQ(image->width, 5);
    EXPECT_EQ(image->height, 7);
    EXPECT_EQ(image->channels, channels);
    EXPECT_EQ(image->encoding, ColorEncoding::Srgb);
    EXPECT_EQ(image->bytes, pixels) << "transparent pixels keep their colour";
    ASSERT_TRUE(writePng(folder / "y.png", 5, 7, channels, pixels, RowOrder::BottomUp).ok());
    image = loadImage(folder / "y.png", ColorEncoding::Linear);
    ASSERT_TRUE(image.ok());
    EXPECT_EQ(image->encoding, ColorEncoding::Linear);
    const size_t row = 5 * static_cast<size_t>(channels);
    for (size_t y = 0; y < 7; ++y)
      for (size_t x = 0; x < row; ++x)
        ASSERT_EQ(image->bytes[y * row + x], pixels[(6 - y) * row + x]);
  }
}

TEST(Image, ExrRoundTripKeepsEveryFloat) {
  const TemporaryFolder folder;
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> values = {0,      -0.0f, 1.5f, 1e-30f, 65504, 1e30f,
                                     -3.25f, inf,   -inf, 0.1f,   7,     std::nanf("")};
  const std::vector<std::string> rgb = {"R", "G", "B"};
  ASSERT_TRUE(writeExr(folder / "x.exr", 2, 2, rgb, values).ok());
  Result<ImageData> image = loadImage(folder / "x.exr", ColorEncoding::Srgb);
  ASSERT_TRUE(image.ok()) << image.error();
  EXPECT_EQ(image->encoding, ColorEncoding::Linear);
  ASSERT_EQ(image->floats.size(), values.size());
  EXPECT_EQ(std::memcmp(image->floats.data(), values.data(), 11 * 4), 0);
  EXPECT_TRUE(std::isnan(image->floats[11]));

  ASSERT_TRUE(writeExr(folder / "z.exr", 2, 6, std::vector<std::string>{"Z"}, values,
                       ExrPrecision::Half, RowOrder::BottomUp)
                  .ok());
  image = loadImage(folder / "z.exr", ColorEncoding::Linear);
  ASSERT_TRUE(image.ok()) << image.error();
  EXPECT_EQ(image->channels, 1);
  EXPECT_EQ(image->floats[0], 7) << "the last row comes first";
  EXPECT_EQ(image->floats[10], 0);
  EXPECT_EQ(image->floats[6], 65504);
}

TEST(Image, WritersRefuseAndLeaveTheOldFile) {
  const TemporaryFolder folder;
  const Bytes pixels(12);
  ASSERT_TRUE(writePng(folder / "x.png", 2, 2, 3, pixels).ok());
  const Bytes before = readAll(folder / "x.png");
  const auto refused = [&](const Status& status) {
    EXPECT_FALSE(status.ok());
    if (!status.ok()) {
      EXPECT_NE(status.error().find("x."), std::string::npos) << status.error();
    }
  };
  refused(writePng(folder / "x.png", 2, 2, 4, pixels));
  refused(writePng(folder / "x.png", 0, 2, 3, {}));
  refused(writePng(folder / "x.png", 6, 1, 2, pixels));
  refused(writePng(folder / "x.bmp", 2, 2, 3, pixels));
  refused(writePng(folder / "nowhere" / "x.png", 2, 2, 3, pixels));
  refused(writeExr(folder / "x.exr", 2, 2, std::vector<std::string>{}, {}));
  refused(writeExr(folder / "nowhere" / "x.exr", 1, 1, std::vector<std::string>{"R"},
                   std::vector<float>{1}));
  EXPECT_EQ(readAll(folder / "x.png"), before);
  size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    files += entry.exists();
  EXPECT_EQ(files, 1u) << "no temporary file is left";
}

TEST(Extras, EveryFieldTypeIsRead) {
  World world;
  const Entity entity = world.spawn(AssetTag{});
  const Entity other = world.spawn();
  const json extras = json::parse(R"({"AssetProbe": {"flag": true, "whole": -2147483648,
    "natural": 4294967295, "big": -9000000000, "huge": 18446744073709551615, "real": 2,
    "precise": 0.1, "two": [1, 2], "three": [1, 2, 3], "four": [1, 2, 3, 4],
    "place": [1e6, 0.1, -3], "turn": [0, 0, 3, 4], "friend_of": "bob", "mood": 1,
    "text": "seven77", "list": [7, 8, 9]}, "AssetTag": false, "artist": 7})");
  const Status status =
      attachExtras(world, entity, extras, "x.glb: node 0",
                   [&](std::string_view name) { return name == "bob" ? other : Entity::kNone; });
  ASSERT_TRUE(status.ok()) << status.error();
  EXPECT_FALSE(world.has<AssetTag>(entity));
  const AssetProbe* probe = world.peek<AssetProbe>(entity);
  ASSERT_NE(probe, nullptr);
  EXPECT_TRUE(probe->flag);
  EXPECT_EQ(probe->whole, std::numeric_limits<int32_t>::min());
  EXPECT_EQ(probe->natural, 4294967295u);
  EXPECT_EQ(probe->big, -9000000000);
  EXPECT_EQ(probe->huge, std::numeric_limits<uint64_t>::max());
  EXPECT_EQ(probe->real, 2);
  EXPECT_EQ(probe->precise, 0.1);
  EXPECT_EQ(probe->two, vec2(1, 2));
  EXPECT_EQ(probe->three, vec3(1, 2, 3));
  EXPECT_EQ(probe->four, vec4(1, 2, 3, 4));
  EXPECT_EQ(probe->place, dvec3(1e6, 0.1, -3));
  EXPECT_NEAR(probe->turn.z, 0.6, 1e-7);
  EXPECT_NEAR(probe->turn.w, 0.8, 1e-7);
  EXPECT_EQ(probe->friend_of, other);
  EXPECT_EQ(probe->mood, Mood::Wild);
  EXPECT_STREQ(probe->text, "seven77");
  EXPECT_EQ(probe->list[2], 9);
}

TEST(Extras, OneFieldLeavesTheOthersAtTheirValues) {
  World world;
  const Entity entity = world.spawn();
  ASSERT_TRUE(
      attachExtras(world, entity, {{"AssetProbe", {{"real", 3}}}, {"AssetTag", true}}, "x").ok());
  EXPECT_TRUE(world.has<AssetTag>(entity));
  EXPECT_EQ(world.peek<AssetProbe>(entity)->whole, -7);
  world.find<AssetProbe>(entity)->whole = 5;
  ASSERT_TRUE(attachExtras(world, entity, {{"AssetProbe", {{"natural", 3}}}}, "x").ok());
  EXPECT_EQ(world.peek<AssetProbe>(entity)->whole, 5);
  EXPECT_EQ(world.peek<AssetProbe>(entity)->real, 3);
  EXPECT_EQ(world.peek<AssetProbe>(entity)->natural, 3u);
}

TEST(Extras, WrongValuesAreRefusedWithOneLine) {
  const auto refused = [](const std::string& text, const std::string& expected) {
    World world;
    const Entity entity = world.spawn();
    const Status status =
        attachExtras(world, entity, json::parse(text), "level.glb: node 4 \"scale\"");
    ASSERT_FALSE(status.ok()) << text;
    EXPECT_EQ(status.error().find("level.glb: node 4 \"scale\": extras: AssetProbe"), 0u)
        << status.error();
    EXPECT_NE(status.error().find(expected), std::string::npos) << status.error();
    EXPECT_EQ(status.error().find('\n'), std::string::npos);
    EXPECT_FALSE(world.has<AssetProbe>(entity));
  };
  refused(R"({"AssetProbe": 3})", "= 3: must be an object");
  refused(R"({"AssetProbe": {"fleg": true}})",
          "fleg = true: no such field; its fields are flag, whole");
  refused(R"({"AssetProbe": {"flag": 1}})", "flag = 1: must be true or false");
  refused(R"({"AssetProbe": {"whole": 2147483648}})", "whole = 2147483648");
  refused(R"({"AssetProbe": {"whole": 1.5}})", "whole = 1.5");
  refused(R"({"AssetProbe": {"natural": -1}})",
          "natural = -1: must be a whole number from 0 to 4294967295");
  refused(R"({"AssetProbe": {"big": 9223372036854775808}})", "big = 9223372036854775808");
  refused(R"({"AssetProbe": {"huge": -1}})", "huge = -1");
  refused(R"({"AssetProbe": {"real": "3"}})", "real = \"3\": must be a finite number (m)");
  refused(R"({"AssetProbe": {"real": 1e39}})", "real = 1e+39");
  refused(R"({"AssetProbe": {"three": [1, 2]}})", "three = [1,2]: must be 3 finite numbers");
  refused(R"({"AssetProbe": {"three": [1, 2, null]}})", "three");
  refused(R"({"AssetProbe": {"turn": [0, 0, 0, 0]}})", "turn");
  refused(R"({"AssetProbe": {"friend_of": "alice"}})",
          "friend_of = \"alice\": 0 nodes have that name");
  refused(R"({"AssetProbe": {"friend_of": 3}})", "friend_of = 3: must be the name of one node");
  refused(R"({"AssetProbe": {"mood": "wild"}})", "mood");
  refused(R"({"AssetProbe": {"text": "eight888"}})",
          "text = \"eight888\": must be a text of at most 7");
  refused(R"({"AssetProbe": {"list": [1, 2, 3, 4]}})", "list = [1,2,3,4]: must be an array of 3");
}

}  // namespace
}  // namespace scree::test
