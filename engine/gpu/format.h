// Facts about the sized texture formats that the engine uses.
#pragma once

namespace scree::gpu {

enum class Component : unsigned char { Float, Int, Uint, Depth };

struct FormatInfo {
  unsigned format;   // sized internal format: GL_RGBA8, ...
  const char* name;  // "RGBA8"
  int channels;
  int bytes;            // a texel
  Component component;  // how a shader reads it
  bool srgb;
};

// Ends the program for a format that is not in the table (format.cpp).
const FormatInfo& formatInfo(unsigned format);
bool isDepth(unsigned format);

}  // namespace scree::gpu
