// The gate's checks in their order, and the handling of golden files.
#include "tests/support/image_gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "engine/core/log.h"

namespace scree::images {
namespace {

constexpr double kStep = 1.0 / 255.0;
// Floats of 8-bit values differ from exact multiples of a step by rounding only.
constexpr double kSlack = 1e-6;

bool updating() {
  const char* value = std::getenv("SCREE_UPDATE_GOLDENS");
  return value && std::string(value) == "1";
}

std::optional<std::string> sizeFault(const char* which, const Image& image) {
  const bool whole = image.width > 0 && image.height > 0 &&
                     image.rgb.size() == image.pixels() * 3 &&
                     (image.ids.empty() || image.ids.size() == image.pixels());
  if (whole && image.width >= kSsimWindow && image.height >= kSsimWindow) return std::nullopt;
  return fmt::format(
      "{} is {}x{} with {} colours and {} ids; must be at least {}x{}, 3 and 0 or 1 a pixel", which,
      image.width, image.height, image.rgb.size(), image.ids.size(), kSsimWindow, kSsimWindow);
}

std::optional<std::string> finiteFault(const char* which, const Image& image) {
  size_t count = 0, first = 0;
  for (size_t i = 0; i < image.rgb.size(); ++i) {
    if (std::isfinite(image.rgb[i])) continue;
    if (count++ == 0) first = i;
  }
  if (count == 0) return std::nullopt;
  return fmt::format(
      "{}: {} values are not finite, the first is {} in channel {} of pixel ({}, {})", which, count,
      image.rgb[first], first % 3, first / 3 % image.width, first / 3 / image.width);
}

// Share of pixels that stand out from the median colour.
double contentOf(const Image& image) {
  std::array<float, 3> median;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<float> channel(image.pixels());
    for (size_t i = 0; i < channel.size(); ++i) channel[i] = image.rgb[i * 3 + c];
    const auto middle = channel.begin() + static_cast<std::ptrdiff_t>(channel.size() / 2);
    std::nth_element(channel.begin(), middle, channel.end());
    median[c] = *middle;
  }
  size_t standing_out = 0;
  for (size_t i = 0; i < image.pixels(); ++i) {
    bool differs = false;
    for (size_t c = 0; c < 3; ++c) {
      differs = differs || std::abs(image.rgb[i * 3 + c] - median[c]) > 2 * kStep + kSlack;
    }
    standing_out += differs;
  }
  return static_cast<double>(standing_out) / static_cast<double>(image.pixels());
}

// Size of the largest 8-connected group of set pixels.
int largestGroup(std::vector<uint8_t> set, int width, int height) {
  int largest = 0;
  std::vector<size_t> open;
  for (size_t start = 0; start < set.size(); ++start) {
    if (!set[start]) continue;
    int size = 0;
    set[start] = 0;
    open.push_back(start);
    while (!open.empty()) {
      const size_t at = open.back();
      open.pop_back();
      ++size;
      const int x = static_cast<int>(at % width), y = static_cast<int>(at / width);
      for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, height - 1); ++ny) {
        for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, width - 1); ++nx) {
          uint8_t& neighbour = set[static_cast<size_t>(ny) * width + nx];
          if (neighbour) {
            neighbour = 0;
            open.push_back(static_cast<size_t>(ny) * width + nx);
          }
        }
      }
    }
    largest = std::max(largest, size);
  }
  return largest;
}

// Notes the first failure; later ones change nothing.
struct Verdict {
  GateResult& result;
  void require(bool holds, const char* check, const std::string& what) {
    if (holds || !result.check.empty()) return;
    result.check = check;
    result.message = fmt::format("{}: {}", check, what);
  }
};

std::string figures(const GateResult& r) {
  if (r.stray_pixels < 0) return "";
  std::string text = fmt::format(
      " [content {:.4f}, stray pixels {} (largest group {}), ids {}, max {:.2f}/255, p99.9 "
      "{:.2f}/255",
      r.content, r.stray_pixels, r.largest_stray_group, r.different_ids, r.max_difference / kStep,
      r.p999 / kStep);
  if (r.means.absolute >= 0) {
    text += fmt::format(
        ", SSIM {:.5f} (local {:.4f}), FLIP {:.5f} (local {:.4f}), mean {:.3f}/255, bias "
        "{:.3f}/255",
        r.similarity.mean, r.similarity.local, r.mean_flip, r.local_flip, r.means.absolute / kStep,
        r.means.bias / kStep);
  }
  return text + "]";
}

struct Box {
  int left, top, right, bottom;  // pixels, right and bottom exclusive
  bool empty() const { return left >= right; }
};

// Around all pixels that differ, with `margin` pixels on every side, inside the image.
Box differingBox(const Image& a, const Image& b, int margin) {
  Box box{a.width, a.height, 0, 0};
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      const size_t at = (static_cast<size_t>(y) * a.width + x) * 3;
      if (std::equal(&a.rgb[at], &a.rgb[at] + 3, &b.rgb[at])) continue;
      box = {std::min(box.left, x), std::min(box.top, y), std::max(box.right, x + 1), y + 1};
    }
  }
  if (box.empty()) return box;
  return {std::max(box.left - margin, 0), std::max(box.top - margin, 0),
          std::min(box.right + margin, a.width), std::min(box.bottom + margin, a.height)};
}

Image cropped(const Image& image, const Box& box) {
  Image out{box.right - box.left, box.bottom - box.top, {}, {}};
  for (int y = box.top; y < box.bottom; ++y) {
    const auto row =
        image.rgb.begin() + (static_cast<std::ptrdiff_t>(y) * image.width + box.left) * 3;
    out.rgb.insert(out.rgb.end(), row, row + static_cast<std::ptrdiff_t>(out.width) * 3);
  }
  return out;
}

// SSIM and FLIP of the whole images, computed only where a filter reaches a differing pixel:
// elsewhere they are 1 and 0 exactly.
void measurePerception(const Image& a, const Image& b, double pixels_per_degree,
                       GateResult& result) {
  result.similarity = {1, 1};
  result.mean_flip = result.local_flip = 0;
  const int reach = std::max(flipReach(pixels_per_degree), kSsimWindow / 2);
  const Box box = differingBox(a, b, 2 * reach);
  if (box.empty()) return;
  const Image part_a = cropped(a, box), part_b = cropped(b, box);
  const auto windows = [](const Image& image) {
    return (image.width - kSsimWindow + 1.0) * (image.height - kSsimWindow + 1.0);
  };
  const Similarity part = ssim(part_a, part_b);
  result.similarity = {1 - (1 - part.mean) * windows(part_a) / windows(a), part.local};
  const Flip seen = flip(part_a, part_b, pixels_per_degree);
  result.mean_flip =
      seen.mean * static_cast<double>(part_a.pixels()) / static_cast<double>(a.pixels());
  result.local_flip = seen.local;
}

void checkPixels(const Image& actual, const Image& golden, const GateBounds& bounds,
                 GateResult& result) {
  Verdict verdict{result};
  Plane differences = pixelDifferences(actual, golden);
  std::vector<uint8_t> stray(actual.pixels());
  size_t first_stray = 0;
  result.different_ids = 0;
  result.stray_pixels = 0;
  for (size_t i = 0; i < stray.size(); ++i) {
    const bool other_id = !actual.ids.empty() && actual.ids[i] != golden.ids[i];
    result.different_ids += other_id;
    stray[i] = other_id || differences[i] > bounds.max_difference + kSlack;
    if (stray[i] && result.stray_pixels++ == 0) first_stray = i;
  }
  result.largest_stray_group = largestGroup(stray, actual.width, actual.height);
  result.max_difference = *std::max_element(differences.begin(), differences.end());

  const bool too_many = result.stray_pixels > bounds.max_stray_pixels;
  const bool too_large = result.largest_stray_group > bounds.max_stray_group;
  const std::string where = fmt::format(
      "{} pixels in groups of up to {}, the first at ({}, {}); allowed: {} in groups of up to {}",
      result.stray_pixels, result.largest_stray_group, first_stray % actual.width,
      first_stray / actual.width, bounds.max_stray_pixels, bounds.max_stray_group);
  verdict.require(result.different_ids == 0 || !(too_many || too_large), "id",
                  fmt::format("{} ids differ; with colours {}", result.different_ids, where));
  verdict.require(!(too_many || too_large), "max",
                  fmt::format("colours differ by up to {:.2f}/255 (allowed {:.2f}/255) in {}",
                              result.max_difference / kStep, bounds.max_difference / kStep, where));

  // Allowed stray pixels are left out of what follows.
  Image cleaned = actual;
  if (result.check.empty() && result.stray_pixels > 0) {
    for (size_t i = 0; i < stray.size(); ++i) {
      if (!stray[i]) continue;
      differences[i] = 0;
      std::copy_n(&golden.rgb[i * 3], 3, &cleaned.rgb[i * 3]);
    }
  }
  result.p999 = percentile(differences, 0.999);
  verdict.require(
      result.p999 <= bounds.max_p999 + kSlack, "p999",
      fmt::format("the 99.9th percentile of the differences is {:.2f}/255, allowed {:.2f}/255",
                  result.p999 / kStep, bounds.max_p999 / kStep));
  if (!result.check.empty()) return;
  measurePerception(cleaned, golden, bounds.pixels_per_degree, result);
  result.means = meanDifferences(cleaned, golden);
  verdict.require(
      result.similarity.mean >= bounds.min_ssim - kSlack &&
          result.similarity.local >= bounds.min_local_ssim - kSlack,
      "ssim",
      fmt::format("SSIM is {:.5f} with {:.4f} in its worst window, allowed {:.5f} and {:.4f}",
                  result.similarity.mean, result.similarity.local, bounds.min_ssim,
                  bounds.min_local_ssim));
  verdict.require(
      result.mean_flip <= bounds.max_flip + kSlack &&
          result.local_flip <= bounds.max_local_flip + kSlack,
      "flip",
      fmt::format("FLIP is {:.5f} with {:.4f} in its worst pixel, allowed {:.5f} and {:.4f}",
                  result.mean_flip, result.local_flip, bounds.max_flip, bounds.max_local_flip));
  verdict.require(
      result.means.absolute <= bounds.max_mean_difference + kSlack &&
          result.means.bias <= bounds.max_bias + kSlack,
      "mean",
      fmt::format(
          "the mean difference is {:.3f}/255 with a bias of {:.3f}/255, allowed {:.3f} and {:.3f}",
          result.means.absolute / kStep, result.means.bias / kStep,
          bounds.max_mean_difference / kStep, bounds.max_bias / kStep));
}

// What an image must be before it is compared, or becomes a golden.
void checkAlone(const char* which, const Image& image, const GateBounds& bounds,
                GateResult& result) {
  Verdict verdict{result};
  const auto size_fault = sizeFault(which, image);
  verdict.require(!size_fault, "size", size_fault.value_or(""));
  if (!result.check.empty()) return;
  const auto finite_fault = finiteFault(which, image);
  verdict.require(!finite_fault, "finite", finite_fault.value_or(""));
  if (!result.check.empty()) return;
  const double content = contentOf(image);
  result.content = result.content < 0 ? content : std::min(result.content, content);
  const bool black =
      std::all_of(image.rgb.begin(), image.rgb.end(), [](float v) { return v <= 2 * kStep; });
  verdict.require(content >= bounds.min_content, "content",
                  fmt::format("{} is {}: {:.5f} of its pixels stand out, at least {:.5f} must",
                              which, black ? "black" : "uniform", content, bounds.min_content));
}

}  // namespace

GateBounds exactBounds() {
  return {};
}

GateBounds crossMachineBounds(int stray_pixels) {
  GateBounds bounds;
  bounds.max_stray_pixels = stray_pixels;
  bounds.max_difference = 2 * kStep;
  bounds.max_p999 = 1 * kStep;
  bounds.min_ssim = 0.98;
  bounds.min_local_ssim = 0.95;
  bounds.max_flip = 0.02;
  bounds.max_local_flip = 0.08;
  bounds.max_mean_difference = 0.75 * kStep;
  bounds.max_bias = 0.25 * kStep;
  return bounds;
}

GateResult compareImages(const Image& actual, const Image& golden, const GateBounds& bounds) {
  GateResult result;
  Verdict verdict{result};
  checkAlone("the image", actual, bounds, result);
  if (result.check.empty()) checkAlone("the golden", golden, bounds, result);
  verdict.require(actual.width == golden.width && actual.height == golden.height, "size",
                  fmt::format("the image is {}x{}, the golden {}x{}", actual.width, actual.height,
                              golden.width, golden.height));
  verdict.require(
      actual.ids.size() == golden.ids.size(), "id",
      fmt::format("the image has {} ids, the golden {}", actual.ids.size(), golden.ids.size()));
  if (!result.check.empty()) return result;
  checkPixels(actual, golden, bounds, result);
  result.passed = result.check.empty();
  if (result.passed) result.message = "equal within bounds";
  result.message += figures(result);
  return result;
}

std::filesystem::path goldenPath(const std::string& name) {
  const std::filesystem::path path(name);
  return std::filesystem::path(SCREE_TESTS_DIR) / path.parent_path() / "golden" /
         (path.filename().string() + ".png");
}

std::filesystem::path failureFolder() {
  const char* chosen = std::getenv("SCREE_FAILURES");
  return chosen && *chosen ? std::filesystem::path(chosen)
                           : std::filesystem::path(SCREE_FAILURE_DIR);
}

GateResult gate(const Image& actual, const std::filesystem::path& golden_path,
                const GateBounds& bounds) {
  // tests/grains/golden/heap.png -> grains_heap
  const std::string name = golden_path.parent_path().parent_path().filename().string() + "_" +
                           golden_path.stem().string();
  const std::filesystem::path base = failureFolder() / name;
  const auto beside = [&](const char* suffix) {
    return std::filesystem::path(base.string() + suffix);
  };

  GateResult result;
  if (updating()) {
    checkAlone("the image", actual, bounds, result);
    if (result.check.empty()) {
      auto before = readImage(golden_path);
      const Image now = quantised(actual);
      if (before.ok() && before->rgb == now.rgb && before->ids == now.ids) {
        result.message = golden_path.string() + ": golden unchanged";
      } else if (Status written = writeImage(golden_path, now); written.ok()) {
        result.message = golden_path.string() + ": golden written";
      } else {
        result.check = "golden";
        result.message = written.error();
      }
    }
    result.passed = result.check.empty();
    logInfo("{}", result.message);
    return result;
  }

  auto golden = readImage(golden_path);
  if (golden.ok()) {
    GateResult alone;
    checkAlone("the image", actual, bounds, alone);
    result = compareImages(alone.check.empty() ? quantised(actual) : actual, *golden, bounds);
  } else {
    checkAlone("the image", actual, bounds, result);
    if (result.check.empty()) {
      result.check = "golden";
      result.message =
          fmt::format("golden: {}; tests/run.sh --update-goldens writes it", golden.error());
    }
  }
  std::error_code ignored;
  for (const char* suffix :
       {".actual.png", ".actual.id.png", ".golden.png", ".golden.id.png", ".difference.png"}) {
    std::filesystem::remove(beside(suffix), ignored);
  }
  if (result.passed) return result;
  result.message = name + ": " + result.message;
  if (sizeFault("", actual)) return result;
  Status written = writeImage(beside(".actual.png"), actual);
  if (written.ok() && golden.ok()) {
    written = writeImage(beside(".golden.png"), *golden);
    if (written.ok()) {
      result.picture = beside(".difference.png");
      written = writeImage(result.picture, differencePicture(actual, *golden));
    }
  }
  result.message +=
      written.ok()
          ? fmt::format("; see {}", (golden.ok() ? result.picture : beside(".actual.png")).string())
          : fmt::format("; {}", written.error());
  return result;
}

}  // namespace scree::images
