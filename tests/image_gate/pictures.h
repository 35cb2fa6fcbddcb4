// Synthetic test pictures: a lit scene of discs over a gradient, with ids, and ways to spoil it.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/assets/image_pixels.h"
#include "engine/core/random.h"

namespace scree::images {

struct Disc {
  double x, y, radius;
};

inline void setPixel(Image& image, int x, int y, float r, float g, float b) {
  float* to = &image.rgb[(static_cast<size_t>(y) * image.width + x) * 3];
  to[0] = r;
  to[1] = g;
  to[2] = b;
}

// Shaded discs (lit from the upper left) over a sky gradient and a textured ground; id = 1 + index.
inline Image discScene(int width, int height, const std::vector<Disc>& discs) {
  Image image{width, height, std::vector<float>(static_cast<size_t>(width) * height * 3), {}};
  image.ids.assign(image.pixels(), 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float v = static_cast<float>(y) / static_cast<float>(height);
      const float checker = ((x / 16 + y / 16) & 1) ? 0.04f : 0.0f;
      if (v < 0.5f) {
        setPixel(image, x, y, 0.35f + 0.5f * v, 0.55f + 0.4f * v, 0.9f - 0.1f * v);
      } else {
        setPixel(image, x, y, 0.30f + checker, 0.24f + checker, 0.12f + checker);
      }
    }
  }
  for (size_t d = 0; d < discs.size(); ++d) {
    const auto [cx, cy, radius] = discs[d];
    for (int y = std::max(0, static_cast<int>(cy - radius));
         y <= std::min(height - 1, static_cast<int>(cy + radius)); ++y) {
      for (int x = std::max(0, static_cast<int>(cx - radius));
           x <= std::min(width - 1, static_cast<int>(cx + radius)); ++x) {
        const double nx = (x + 0.5 - cx) / radius, ny = (y + 0.5 - cy) / radius;
        const double r2 = nx * nx + ny * ny;
        if (r2 >= 1) continue;
        const float lit = static_cast<float>(
            std::clamp(0.2 + 0.6 * (-0.5 * nx - 0.7 * ny + 0.5 * std::sqrt(1 - r2)), 0.05, 1.0));
        setPixel(image, x, y, lit, 0.7f * lit, 0.4f * lit);
        image.ids[static_cast<size_t>(y) * width + x] = static_cast<uint32_t>(d + 1);
      }
    }
  }
  return image;
}

// `count` discs of `radius` px strewn over the picture, no two overlapping.
inline std::vector<Disc> strewnDiscs(int width, int height, int count, double radius,
                                     uint64_t seed) {
  std::vector<Disc> discs;
  for (uint64_t draw = 0; static_cast<int>(discs.size()) < count && draw < 100000; ++draw) {
    const Disc disc{radius + randomUnit(seed, draw, 0, 0) * (width - 2 * radius),
                    radius + randomUnit(seed, draw, 0, 1) * (height - 2 * radius), radius};
    const bool free = std::none_of(discs.begin(), discs.end(), [&](const Disc& other) {
      return std::hypot(disc.x - other.x, disc.y - other.y) < disc.radius + other.radius + 1;
    });
    if (free) discs.push_back(disc);
  }
  return discs;
}

// Every channel moves by -1, 0 or +1 step of 8 bits.
inline Image withNoise(const Image& image, uint64_t seed) {
  Image out = quantised(image);
  for (size_t i = 0; i < out.rgb.size(); ++i) {
    const float step = std::floor(randomUnit(seed, i, 0, 0) * 3) - 1;
    out.rgb[i] = std::clamp(out.rgb[i] + step / 255.0f, 0.0f, 1.0f);
  }
  return out;
}

// result(x, y) = image(map(x, y)), colours and ids.
template <class Map>
Image remapped(const Image& image, Map&& map) {
  Image out = image;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const auto [sx, sy] = map(x, y);
      const size_t to = static_cast<size_t>(y) * image.width + x;
      const size_t from = static_cast<size_t>(std::clamp(sy, 0, image.height - 1)) * image.width +
                          std::clamp(sx, 0, image.width - 1);
      std::copy_n(&image.rgb[from * 3], 3, &out.rgb[to * 3]);
      if (!image.ids.empty()) out.ids[to] = image.ids[from];
    }
  }
  return out;
}

// result channel = map(channel index, r, g, b) for every pixel.
template <class Map>
Image recoloured(const Image& image, Map&& map) {
  Image out = image;
  for (size_t i = 0; i < image.pixels(); ++i) {
    const float* rgb = &image.rgb[i * 3];
    for (int c = 0; c < 3; ++c) out.rgb[i * 3 + c] = map(c, rgb[0], rgb[1], rgb[2]);
  }
  return out;
}

inline Image withoutIds(Image image) {
  image.ids.clear();
  return image;
}

// Uniform random colours.
inline Image randomImage(int width, int height, uint64_t seed) {
  Image image{width, height, std::vector<float>(static_cast<size_t>(width) * height * 3), {}};
  for (size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = randomUnit(seed, i, 1, 0);
  return image;
}

inline Image flatImage(int width, int height, float r, float g, float b) {
  Image image{width, height, std::vector<float>(static_cast<size_t>(width) * height * 3), {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) setPixel(image, x, y, r, g, b);
  }
  return image;
}

}  // namespace scree::images
