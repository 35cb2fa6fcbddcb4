// tinygltf as Scree uses it: a parser only. No image library, no file access of its own. Private to
// assets; the implementation is in gltf_parse.cpp.
#pragma once

#include <fstream>  // tiny_gltf.h uses it without including it when it has no file access
#include <nlohmann/json.hpp>

#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>
