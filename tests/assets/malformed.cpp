// Broken files: each ends in one line that names the file and the field, and nothing else happens.
#include <gtest/gtest.h>

#include <OpenImageIO/imageio.h>

#include <functional>
#include <limits>

#include "engine/assets/gltf.h"
#include "tests/assets/gltf_builder.h"

namespace scree::test {
namespace {

// One line, the file's name first, then what is wrong.
void expectLine(const std::string& message, const std::string& file, const std::string& expected) {
  EXPECT_NE(message.find(file), std::string::npos) << message;
  EXPECT_NE(message.find(expected), std::string::npos)
      << "expected: " << expected << "\n  got: " << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_LT(message.size(), 600u) << message;
}

struct Case {
  const char* name;
  std::function<void(GltfBuilder&)> break_it;
  const char* expected;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class Malformed : public ::testing::TestWithParam<Case> {};

TEST_P(Malformed, GltfIsRefusedWithOneLine) {
  const TemporaryFolder folder;
  for (const bool binary : {false, true}) {
    GltfBuilder b = fullFile(folder);
    b.setBuffer(binary ? json::object()
                       : json{{"uri", "data:application/octet-stream;base64," + base64(b.bin)}});
    GetParam().break_it(b);
    const std::string name = binary ? "broken.glb" : "broken.gltf";
    if (binary)
      b.saveGlb(folder / name);
    else
      saveText(folder / name, b.doc.dump());
    const Result<SceneData> scene = loadGltf(folder / name);
    ASSERT_FALSE(scene.ok());
    expectLine(scene.error(), name, GetParam().expected);
  }
}

void setFloat(GltfBuilder& b, size_t accessor, size_t at, float value) {
  const json& view = b.doc["bufferViews"][b.doc["accessors"][accessor]["bufferView"].get<size_t>()];
  std::memcpy(b.bin.data() + view["byteOffset"].get<size_t>() + at * 4, &value, 4);
  if (b.doc["buffers"][0].contains("uri"))
    b.doc["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(b.bin);
}

const float kNan = std::numeric_limits<float>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    Document, Malformed,
    ::testing::Values(
        Case{"NoAsset", [](GltfBuilder& b) { b.doc.erase("asset"); }, "asset: missing"},
        Case{"OldVersion", [](GltfBuilder& b) { b.doc["asset"]["version"] = "1.0"; },
             "asset: version = \"1.0\": only 2.x"},
        Case{"VersionIsNumber", [](GltfBuilder& b) { b.doc["asset"]["version"] = 2; },
             "asset: version = 2: must be a text"},
        Case{"NewerMinVersion", [](GltfBuilder& b) { b.doc["asset"]["minVersion"] = "2.1"; },
             "minVersion = \"2.1\""},
        Case{"UnknownRequiredExtension",
             [](GltfBuilder& b) { b.doc["extensionsRequired"] = {"KHR_draco_mesh_compression"}; },
             "extensionsRequired = [\"KHR_draco_mesh_compression\"]"},
        Case{"SectionIsObject",
             [](GltfBuilder& b) {
               b.doc["meshes"] = {{"a", 1}};
             },
             "meshes = object of 1: must be an array"},
        Case{"EntryIsNumber", [](GltfBuilder& b) { b.doc["nodes"][1] = 7; },
             "nodes[1]: 7: must be an object"},
        Case{"NameIsNumber", [](GltfBuilder& b) { b.doc["nodes"][1]["name"] = 7; },
             "node 1: name = 7: must be a text"},
        Case{"SceneOutOfRange", [](GltfBuilder& b) { b.doc["scene"] = 1; },
             "scene = 1: must be an index into scenes, which has 1"},
        Case{"SceneIsText", [](GltfBuilder& b) { b.doc["scene"] = "0"; }, "scene = \"0\""},
        Case{"SceneNodeOutOfRange",
             [](GltfBuilder& b) {
               b.doc["scenes"][0]["nodes"] = {0, 9};
             },
             "scene 0: nodes[1] = 9"}));

INSTANTIATE_TEST_SUITE_P(
    Storage, Malformed,
    ::testing::Values(
        Case{"BufferTooLong", [](GltfBuilder& b) { b.doc["buffers"][0]["byteLength"] = 1000000; },
             "buffer 0: byteLength = 1000000"},
        Case{"TwoGigabytesClaimed",
             [](GltfBuilder& b) { b.doc["buffers"][0]["byteLength"] = 2147483648u; },
             "buffer 0: byteLength = 2147483648"},
        Case{"LengthNegative", [](GltfBuilder& b) { b.doc["buffers"][0]["byteLength"] = -4; },
             "buffer 0: byteLength = -4"},
        Case{"LengthZero", [](GltfBuilder& b) { b.doc["buffers"][0]["byteLength"] = 0; },
             "buffer 0: byteLength = 0"},
        Case{"LengthFraction", [](GltfBuilder& b) { b.doc["buffers"][0]["byteLength"] = 12.5; },
             "buffer 0: byteLength = 12.5"},
        Case{"LengthHuge", [](GltfBuilder& b) { b.doc["buffers"][0]["byteLength"] = 1e300; },
             "buffer 0: byteLength = 1e+300"},
        Case{"MissingFile", [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "nowhere.bin"; },
             "buffer 0: uri = \"nowhere.bin\""},
        Case{"FolderAsFile", [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "."; },
             "buffer 0: uri = \".\""},
        Case{"EmptyUri", [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = ""; },
             "buffer 0: uri = \"\": must not be empty"},
        Case{"UriClimbsOut",
             [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "../../etc/passwd"; },
             "buffer 0: uri = \"../../etc/passwd\": lies outside the file's folder"},
        Case{"UriClimbsOutEncoded",
             [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "%2e%2e/%2e%2e/etc/passwd"; },
             "lies outside the file's folder"},
        Case{"UriAbsolute", [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "/etc/passwd"; },
             "buffer 0: uri = \"/etc/passwd\": absolute paths are refused"},
        Case{"UriWithScheme",
             [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "file:///etc/passwd"; },
             "buffer 0: uri = \"file:///etc/passwd\": only data: URIs and relative paths"},
        Case{"UriZeroByte", [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "a%00.bin"; },
             "buffer 0: uri = \"a%00.bin\": holds a zero byte"},
        Case{"DataUriWithoutComma",
             [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "data:application/octet-stream"; },
             "buffer 0: uri = "},
        Case{"DataUriNotBase64",
             [](GltfBuilder& b) { b.doc["buffers"][0]["uri"] = "data:text/plain,hello"; },
             "data URI that is not base64"},
        Case{"DataUriBadDigit",
             [](GltfBuilder& b) {
               b.doc["buffers"][0]["uri"] = "data:application/octet-stream;base64,AAA!";
             },
             "byte 3 of the base64 text"},
        Case{"DataUriTooShort",
             [](GltfBuilder& b) {
               b.doc["buffers"][0]["uri"] = "data:application/octet-stream;base64,AAAA";
             },
             "buffer 0: byteLength = "},
        Case{"ViewBufferOutOfRange", [](GltfBuilder& b) { b.doc["bufferViews"][2]["buffer"] = 1; },
             "bufferView 2: buffer = 1: must be an index into buffers, which has 1"},
        Case{"ViewBufferMissing", [](GltfBuilder& b) { b.doc["bufferViews"][2].erase("buffer"); },
             "bufferView 2: buffer: missing"},
        Case{"ViewTooLong", [](GltfBuilder& b) { b.doc["bufferViews"][0]["byteLength"] = 100000; },
             "bufferView 0: byteLength = 100000"},
        Case{"ViewOffsetWraps",
             [](GltfBuilder& b) { b.doc["bufferViews"][1]["byteOffset"] = 9007199254740992; },
             "bufferView 1: byteLength"},
        Case{"ViewOffsetHuge",
             [](GltfBuilder& b) { b.doc["bufferViews"][1]["byteOffset"] = 18446744073709551615u; },
             "bufferView 1: byteOffset = 18446744073709551615"},
        Case{"StrideOdd", [](GltfBuilder& b) { b.doc["bufferViews"][0]["byteStride"] = 13; },
             "bufferView 0: byteStride = 13: must be a multiple of 4"},
        Case{"StrideHuge", [](GltfBuilder& b) { b.doc["bufferViews"][0]["byteStride"] = 256; },
             "bufferView 0: byteStride = 256"},
        Case{"StrideBelowElement",
             [](GltfBuilder& b) { b.doc["bufferViews"][0]["byteStride"] = 8; },
             "accessor 0 \"corners\": bufferView = 0: its byteStride 8"},
        Case{"StridePassesView",
             [](GltfBuilder& b) { b.doc["bufferViews"][0]["byteStride"] = 252; },
             "accessor 0 \"corners\": count = 4"}));

INSTANTIATE_TEST_SUITE_P(
    Accessors, Malformed,
    ::testing::Values(
        Case{"CountTooLarge", [](GltfBuilder& b) { b.doc["accessors"][0]["count"] = 5; },
             "accessor 0 \"corners\": count = 5: 60 bytes at byteOffset 0"},
        Case{"CountZero", [](GltfBuilder& b) { b.doc["accessors"][0]["count"] = 0; },
             "accessor 0 \"corners\": count = 0"},
        Case{"CountWraps",
             [](GltfBuilder& b) { b.doc["accessors"][0]["count"] = 4294967296u * 1431655766u; },
             "accessor 0 \"corners\": count"},
        Case{"OffsetTooLarge", [](GltfBuilder& b) { b.doc["accessors"][0]["byteOffset"] = 4; },
             "at byteOffset 4"},
        Case{"ViewOutOfRange", [](GltfBuilder& b) { b.doc["accessors"][0]["bufferView"] = 99; },
             "bufferView = 99"},
        Case{"UnknownComponentType",
             [](GltfBuilder& b) { b.doc["accessors"][0]["componentType"] = 5130; },
             "componentType = 5130: must be one of 5120"},
        Case{"DoubleComponentType",
             [](GltfBuilder& b) { b.doc["accessors"][1]["componentType"] = 5124; },
             "accessor 1: componentType = 5124"},
        Case{"UnknownType", [](GltfBuilder& b) { b.doc["accessors"][0]["type"] = "VEC5"; },
             "type = \"VEC5\""},
        Case{"NormalizedIsNumber", [](GltfBuilder& b) { b.doc["accessors"][0]["normalized"] = 1; },
             "normalized = 1: must be true or false"},
        Case{"SparseCountTooLarge",
             [](GltfBuilder& b) { b.doc["accessors"][0]["sparse"]["count"] = 5; },
             "sparse: count = 5: must be a whole number from 1 to 4"},
        Case{"SparseIndexOutOfRange",
             [](GltfBuilder& b) {
               b.doc["accessors"][0]["sparse"]["indices"]["bufferView"] = 2;  // uv: 255 follows
               b.doc["accessors"][0]["sparse"]["indices"]["byteOffset"] = 2;
             },
             "POSITION: sparse index 0 = 255; the accessor has 4 elements"},
        Case{"SparseIndicesMissing",
             [](GltfBuilder& b) { b.doc["accessors"][0]["sparse"].erase("indices"); },
             "sparse: indices: missing"},
        Case{"SparseFloatIndices",
             [](GltfBuilder& b) {
               b.doc["accessors"][0]["sparse"]["indices"]["componentType"] = 5126;
             },
             "sparse.indices: componentType = 5126"},
        Case{"SparseValuesTooShort",
             [](GltfBuilder& b) { b.doc["accessors"][0]["sparse"]["values"]["byteOffset"] = 4; },
             "sparse: count = 1: 12 bytes at byteOffset 4"},
        Case{"SparseIsArray", [](GltfBuilder& b) { b.doc["accessors"][0]["sparse"] = {1}; },
             "sparse = [1]: must be an object"},
        Case{"BigWithoutView",
             [](GltfBuilder& b) {
               b.doc["accessors"][1].erase("bufferView");
               b.doc["accessors"][1]["count"] = 60000000;
             },
             "accessor 1: count = 60000000"}));

INSTANTIATE_TEST_SUITE_P(
    Meshes, Malformed,
    ::testing::Values(
        Case{"NoPrimitives",
             [](GltfBuilder& b) { b.doc["meshes"][0]["primitives"] = json::array(); },
             "mesh 0 \"floor\": primitives"},
        Case{"PrimitiveIsText", [](GltfBuilder& b) { b.doc["meshes"][0]["primitives"][0] = "a"; },
             "mesh 0 \"floor\": primitive 0"},
        Case{"NoPosition",
             [](GltfBuilder& b) {
               b.doc["meshes"][0]["primitives"][0]["attributes"].erase("POSITION");
             },
             "mesh 0 \"floor\": primitive 0: POSITION: missing"},
        Case{"PositionOutOfRange",
             [](GltfBuilder& b) {
               b.doc["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 40;
             },
             "POSITION = 40: must be an index into accessors, which has 4"},
        Case{"PositionNegative",
             [](GltfBuilder& b) {
               b.doc["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = -1;
             },
             "POSITION = -1"},
        Case{"PositionOfTwo",
             [](GltfBuilder& b) {
               b.doc["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 2;
             },
             "POSITION = 2: its accessor must be VEC3"},
        Case{"CountsDiffer", [](GltfBuilder& b) { b.doc["accessors"][1]["count"] = 3; },
             "NORMAL = 1: its accessor has 3 elements; POSITION has 4"},
        Case{"IndexOutOfRange",
             [](GltfBuilder& b) {
               b.doc["accessors"][0]["count"] = 3;
               b.doc["accessors"][1]["count"] = 3;
               b.doc["accessors"][2]["count"] = 3;
             },
             "mesh 0 \"floor\" primitive 0: indices[4] = 3; POSITION has 3 elements"},
        Case{"IndicesFloat",
             [](GltfBuilder& b) { b.doc["meshes"][0]["primitives"][0]["indices"] = 0; },
             "indices = 0: its accessor must be SCALAR of an unsigned type"},
        Case{"IndicesNotThrees", [](GltfBuilder& b) { b.doc["accessors"][3]["count"] = 5; },
             "indices: count = 5; must be a multiple of 3"},
        Case{"UnknownMode", [](GltfBuilder& b) { b.doc["meshes"][0]["primitives"][0]["mode"] = 7; },
             "mode = 7"},
        Case{"MaterialOutOfRange",
             [](GltfBuilder& b) { b.doc["meshes"][0]["primitives"][0]["material"] = 1; },
             "material = 1: must be an index into materials, which has 1"},
        Case{"PositionNan", [](GltfBuilder& b) { setFloat(b, 0, 4, kNan); },
             "mesh 0 \"floor\" primitive 0: POSITION[1]: component 1 = nan"},
        Case{"PositionInfinite",
             [](GltfBuilder& b) { setFloat(b, 0, 0, std::numeric_limits<float>::infinity()); },
             "POSITION[0]: component 0 = inf"},
        Case{"PositionFar", [](GltfBuilder& b) { setFloat(b, 0, 0, 1e30f); },
             "POSITION[0]: component 0 = 1e+30"},
        Case{"NormalNan", [](GltfBuilder& b) { setFloat(b, 1, 2, kNan); },
             "NORMAL[0]: component 2 = nan"}));

INSTANTIATE_TEST_SUITE_P(
    Materials, Malformed,
    ::testing::Values(
        Case{"TextureOutOfRange",
             [](GltfBuilder& b) {
               b.doc["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 3;
             },
             "material 0 \"tiles\": baseColorTexture: index = 3"},
        Case{"TextureIsNumber", [](GltfBuilder& b) { b.doc["materials"][0]["normalTexture"] = 0; },
             "material 0 \"tiles\": normalTexture = 0: must be an object"},
        Case{"SecondUvSet",
             [](GltfBuilder& b) { b.doc["materials"][0]["normalTexture"]["texCoord"] = 1; },
             "normalTexture: texCoord = 1: only TEXCOORD_0"},
        Case{"SourceOutOfRange", [](GltfBuilder& b) { b.doc["textures"][0]["source"] = 5; },
             "texture 0: source = 5"},
        Case{"SourceMissing", [](GltfBuilder& b) { b.doc["textures"][0].erase("source"); },
             "index = 0: this texture has no source"},
        Case{"SamplerOutOfRange", [](GltfBuilder& b) { b.doc["textures"][0]["sampler"] = 5; },
             "texture 0: sampler = 5"},
        Case{"UnknownWrap", [](GltfBuilder& b) { b.doc["samplers"][0]["wrapS"] = 1; },
             "sampler 0: wrapS = 1: must be one of"},
        Case{"ColorOfThree",
             [](GltfBuilder& b) {
               b.doc["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1};
             },
             "baseColorFactor = [1,1,1]: must be 4 numbers from 0 to 1"},
        Case{"ColorOverOne",
             [](GltfBuilder& b) {
               b.doc["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 2, 1, 1};
             },
             "baseColorFactor = [1,2,1,1]"},
        Case{"MetallicIsText",
             [](GltfBuilder& b) {
               b.doc["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = "1";
             },
             "metallicFactor = \"1\""},
        Case{"AlphaMode", [](GltfBuilder& b) { b.doc["materials"][0]["alphaMode"] = "GLASS"; },
             "alphaMode = \"GLASS\": must be one of OPAQUE, MASK, BLEND"},
        Case{"NegativeStrength",
             [](GltfBuilder& b) {
               b.doc["materials"][0]["extensions"]["KHR_materials_emissive_strength"]
                    ["emissiveStrength"] = -1;
             },
             "emissiveStrength = -1"},
        Case{"ImageTwice", [](GltfBuilder& b) { b.doc["images"][0]["uri"] = "a.png"; },
             "image 0 \"checks\": uri = \"a.png\": exactly one of uri and bufferView"},
        Case{"ImageNowhere", [](GltfBuilder& b) { b.doc["images"][0].erase("bufferView"); },
             "image 0 \"checks\": uri: missing; exactly one"},
        Case{"ImageFileMissing",
             [](GltfBuilder& b) {
               b.doc["images"][0] = {{"name", "checks"}, {"uri", "no.png"}};
             },
             "image 0 \"checks\": uri = \"no.png\""},
        Case{"ImageIsNoImage", [](GltfBuilder& b) { b.doc["images"][0]["bufferView"] = 0; },
             "image 0 \"checks\": content: neither PNG, JPEG nor EXR"},
        Case{"ImageCut",
             [](GltfBuilder& b) {
               auto& view = b.doc["bufferViews"][b.doc["images"][0]["bufferView"].get<size_t>()];
               view["byteLength"] = 50;
             },
             "image 0 \"checks\": PNG"},
        Case{"ImageUriOutside",
             [](GltfBuilder& b) {
               b.doc["images"][0] = {{"uri", "../x.png"}};
             },
             "image 0: uri = \"../x.png\": lies outside"}));

INSTANTIATE_TEST_SUITE_P(
    Nodes, Malformed,
    ::testing::Values(
        Case{"ChildOutOfRange",
             [](GltfBuilder& b) {
               b.doc["nodes"][0]["children"] = {1, 3};
             },
             "node 0 \"table\": children[1] = 3"},
        Case{"OwnChild", [](GltfBuilder& b) { b.doc["nodes"][1]["children"] = {1}; },
             "node 1 \"eye\": children: node 1 is a child of node 0 already"},
        Case{"Cycle",
             [](GltfBuilder& b) {
               b.doc["nodes"][0].erase("children");
               b.doc["nodes"][1]["children"] = {2};
               b.doc["nodes"][2]["children"] = {1};
             },
             "node 1 \"eye\": children: the node is its own ancestor"},
        Case{"SelfCycle", [](GltfBuilder& b) { b.doc["nodes"][2]["children"] = {2}; },
             "node 2 \"lamp\": children: the node is its own ancestor"},
        Case{"TwoParents", [](GltfBuilder& b) { b.doc["nodes"][2]["children"] = {1}; },
             "node 2 \"lamp\": children: node 1 is a child of node 0 already"},
        Case{"SceneNamesAChild",
             [](GltfBuilder& b) {
               b.doc["scenes"][0]["nodes"] = {0, 1};
             },
             "node 1 \"eye\": children: a node of a scene must not be a child"},
        Case{"MeshOutOfRange", [](GltfBuilder& b) { b.doc["nodes"][0]["mesh"] = 1; },
             "node 0 \"table\": mesh = 1"},
        Case{"CameraOutOfRange", [](GltfBuilder& b) { b.doc["nodes"][1]["camera"] = 1; },
             "node 1 \"eye\": camera = 1"},
        Case{"LightOutOfRange",
             [](GltfBuilder& b) {
               b.doc["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 1;
             },
             "node 2 \"lamp\": KHR_lights_punctual: light = 1"},
        Case{"LightsMissing", [](GltfBuilder& b) { b.doc.erase("extensions"); },
             "light = 0: must be an index into lights, which has 0"},
        Case{"ZeroScale",
             [](GltfBuilder& b) {
               b.doc["nodes"][0]["scale"] = {1, 0, 1};
             },
             "node 0 \"table\": scale: world scale y = 0"},
        Case{"ZeroRotation",
             [](GltfBuilder& b) {
               b.doc["nodes"][0]["rotation"] = {0, 0, 0, 0};
             },
             "node 0 \"table\": rotation"},
        Case{"Shear",
             [](GltfBuilder& b) {
               b.doc["nodes"][0]["scale"] = {1, 1, 5};
               b.doc["nodes"][1]["rotation"] = {0, 0.38268343, 0, 0.92387953};
             },
             "node 1 \"eye\": scale: axes"},
        Case{"SingularMatrix",
             [](GltfBuilder& b) {
               b.doc["nodes"][2]["matrix"] = {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
             },
             "node 2 \"lamp\": scale: axes x and y are not perpendicular"},
        Case{"MatrixOfFifteen", [](GltfBuilder& b) { b.doc["nodes"][2]["matrix"].erase(15); },
             "node 2 \"lamp\": matrix"},
        Case{"MatrixAndScale",
             [](GltfBuilder& b) {
               b.doc["nodes"][2]["scale"] = {1, 1, 1};
             },
             "node 2 \"lamp\": matrix"},
        Case{"TranslationFar",
             [](GltfBuilder& b) {
               b.doc["nodes"][0]["translation"] = {1e12, 0, 0};
             },
             "node 0 \"table\": translation = [1000000000000.0,0,0]"},
        Case{"WorldTooFar",
             [](GltfBuilder& b) {
               b.doc["nodes"][0]["scale"] = {1e6, 1e6, 1e6};
               b.doc["nodes"][1]["translation"] = {0, 0, 1e6};
             },
             "node 1 \"eye\": translation: world position"},
        Case{"FlatFieldOfView",
             [](GltfBuilder& b) { b.doc["cameras"][0]["perspective"]["yfov"] = 3.2; },
             "camera 0: yfov = 3.2"},
        Case{"NearZero", [](GltfBuilder& b) { b.doc["cameras"][0]["perspective"]["znear"] = 0; },
             "camera 0: znear = 0"},
        Case{"NoPerspective", [](GltfBuilder& b) { b.doc["cameras"][0].erase("perspective"); },
             "camera 0: perspective: missing"},
        Case{"LightType",
             [](GltfBuilder& b) {
               b.doc["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = "laser";
             },
             "light 0: type = \"laser\""},
        Case{"SpotInsideOut",
             [](GltfBuilder& b) {
               b.doc["extensions"]["KHR_lights_punctual"]["lights"][0]["spot"]["innerConeAngle"] =
                   0.6;
             },
             "light 0: spot: innerConeAngle = 0.6: must be below outerConeAngle"},
        Case{"NegativeIntensity",
             [](GltfBuilder& b) {
               b.doc["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = -1;
             },
             "light 0: intensity = -1"}));

void expectGltfError(const Bytes& bytes, const std::string& name, const std::string& expected) {
  const TemporaryFolder folder;
  saveBytes(folder / name, bytes);
  const Result<SceneData> scene = loadGltf(folder / name);
  ASSERT_FALSE(scene.ok()) << expected;
  expectLine(scene.error(), name, expected);
}

void setWord(Bytes& bytes, size_t at, uint32_t value) {
  std::memcpy(bytes.data() + at, &value, 4);
}

TEST(MalformedGlb, Container) {
  const TemporaryFolder folder;
  const Bytes good = fullFile(folder).glb();
  const auto broken = [&](const std::function<void(Bytes&)>& break_it, const char* expected) {
    Bytes bytes = good;
    break_it(bytes);
    expectGltfError(bytes, "bad.glb", expected);
  };
  broken([](Bytes& b) { b.clear(); }, "empty file");
  broken([](Bytes& b) { b.resize(3); }, "GLB header: magic");
  broken([](Bytes& b) { b.resize(13); }, "GLB header: 13 bytes");
  broken([](Bytes& b) { b[0] = 'G'; }, "GLB header: magic");
  broken([](Bytes& b) { setWord(b, 4, 1); }, "GLB header: version = 1");
  broken([](Bytes& b) { b.resize(b.size() - 1); }, "GLB header: length = ");
  broken([](Bytes& b) { setWord(b, 8, 0x80000000u); }, "GLB header: length = 2147483648");
  broken([](Bytes& b) { setWord(b, 12, 0xfffffff0u); }, "GLB chunk 0: length = 4294967280");
  broken([](Bytes& b) { setWord(b, 16, 0x004e4942); }, "GLB chunk 0: type");
  broken([](Bytes& b) { setWord(b, 12, 0); }, "GLB chunk 1: length");
  broken(
      [](Bytes& b) {
        b.resize(20);
        setWord(b, 8, 20);
        setWord(b, 12, 0);
      },
      "JSON: ");
  broken(
      [](Bytes& b) {
        const size_t json_bytes = b[12] | size_t{b[13]} << 8 | size_t{b[14]} << 16;
        b.resize(20 + json_bytes);
        setWord(b, 8, static_cast<uint32_t>(b.size()));
      },
      "buffer 0: uri: missing");
  broken(
      [](Bytes& b) {
        b.resize(b.size() + 5);
        setWord(b, 8, static_cast<uint32_t>(b.size()));
      },
      "GLB chunk 2: header cut off");
  broken(
      [](Bytes& b) {
        const size_t json_bytes = b[12] | size_t{b[13]} << 8 | size_t{b[14]} << 16;
        setWord(b, 20 + json_bytes, static_cast<uint32_t>(b.size()));
      },
      "GLB chunk 1: length = ");
}

TEST(MalformedGltf, Text) {
  const auto broken = [](const std::string& text, const char* expected) {
    expectGltfError(Bytes(text.begin(), text.end()), "bad.gltf", expected);
  };
  broken("", "empty file");
  broken("x", "JSON: ");
  broken("{", "JSON: ");
  broken("[]", "must be an object");
  broken("null", "must be an object");
  broken("{\"asset\": {\"version\": \"2.0\"", "JSON: ");
  broken("{\"asset\": {\"version\": \"2.0\"}, \"a\": 1e999}", "JSON: ");
  broken("{\"asset\": {\"version\": \"2.0\xff\"}}", "JSON: ");
  broken("{\"asset\": {\"version\": \"2.0\"}, \"a\": NaN}", "JSON: ");
  broken(std::string(1000000, '['), "JSON: nested deeper than 64");
  std::string objects;
  for (int i = 0; i < 100000; ++i) objects += "{\"a\":";
  broken(objects, "JSON: nested deeper than 64");
  broken("{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"name\": \"a\\nb\", \"mesh\": 0}]}",
         "node 0 \"a b\": mesh = 0");
}

TEST(MalformedGltf, FilesThatAreNone) {
  const TemporaryFolder folder;
  Result<SceneData> scene = loadGltf(folder / "none.gltf");
  ASSERT_FALSE(scene.ok());
  expectLine(scene.error(), "none.gltf", "no such file");
  scene = loadGltf(folder.path());
  ASSERT_FALSE(scene.ok());
  expectLine(scene.error(), folder.path().string(), "not a regular file");
  scene = loadGltf("/dev/zero");
  ASSERT_FALSE(scene.ok());
}

TEST(MalformedGltf, LinksOutOfTheFolderAreRefused) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "inner");
  saveText(folder / "secret.bin", std::string(1000, 's'));
  std::filesystem::create_symlink(folder / "secret.bin", folder / "inner" / "data.bin");
  GltfBuilder b = fullFile(folder);
  b.setBuffer({{"uri", "data.bin"}});
  saveText(folder / "inner" / "link.gltf", b.doc.dump());
  const Result<SceneData> scene = loadGltf(folder / "inner" / "link.gltf");
  ASSERT_FALSE(scene.ok());
  expectLine(scene.error(), "link.gltf",
             "buffer 0: uri = \"data.bin\": lies outside the file's folder");
}

TEST(MalformedGltf, LimitsHold) {
  const TemporaryFolder folder;
  fullFile(folder).saveGlb(folder / "full.glb");
  const auto limited = [&](const std::function<void(GltfLimits&)>& limit, const char* expected) {
    GltfLimits limits;
    limit(limits);
    const Result<SceneData> scene = loadGltf(folder / "full.glb", limits);
    ASSERT_FALSE(scene.ok()) << expected;
    expectLine(scene.error(), "full.glb", expected);
  };
  limited([](GltfLimits& l) { l.max_file_bytes = 100; }, "at most 100 are read");
  limited([](GltfLimits& l) { l.max_total_bytes = 100; }, "byteLength");
  limited([](GltfLimits& l) { l.max_json_depth = 3; }, "nested deeper than 3");
  limited([](GltfLimits& l) { l.max_objects = 2; }, "at most 2 entries");
  limited([](GltfLimits& l) { l.max_vertices = 3; }, "POSITION");
  limited([](GltfLimits& l) { l.max_indices = 5; }, "count = 6");
  limited([](GltfLimits& l) { l.max_node_depth = 1; },
          "node 1 \"eye\": children: nested deeper than 1");
  limited([](GltfLimits& l) { l.max_coordinate = 3; }, "translation");
  limited([](GltfLimits& l) { l.image.max_side = 1; }, "image 0 \"checks\": size = 2x2");
  limited([](GltfLimits& l) { l.image.max_pixels = 3; }, "size = 2x2");
}

// Many primitives that share one accessor may not multiply it beyond the limit.
TEST(MalformedGltf, SharedAccessorsCountEveryTime) {
  const TemporaryFolder folder;
  GltfBuilder b;
  b.addAccessor<float>(std::vector<float>(3 * 300), "VEC3");
  json primitives;
  for (int i = 0; i < 100; ++i) primitives.push_back({{"attributes", {{"POSITION", 0}}}});
  b.add("meshes", {{"primitives", primitives}});
  b.saveGlb(folder / "many.glb");
  GltfLimits limits;
  limits.max_vertices = 10000;
  const Result<SceneData> scene = loadGltf(folder / "many.glb", limits);
  ASSERT_FALSE(scene.ok());
  expectLine(scene.error(), "many.glb",
             "primitive 16: POSITION: 300 more vertices pass the limit of 10000");
}

}  // namespace
}  // namespace scree::test
