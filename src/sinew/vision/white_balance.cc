#include "sinew/vision/white_balance.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sinew/vision/srgb.h"

namespace sinew::vision {
namespace {

using Channels = std::array<double, 3>;

constexpr int kSmall = 400;  ///< px, the longer side of the picture that the light is taken from
constexpr double kShareLeast = 0.15;  ///< of the pixels, that say what the light is
constexpr double kLightMost = 2;      ///< of a channel against all three, and its inverse
constexpr double kLightLeast = 1e-6;
/// Share of a tint that is taken away, by its logarithm. All of it is too much on tables that have
/// a color themselves.
constexpr double kCorrected = 0.7;

/// Neither clipped nor too dark.
bool tells_of_light(const std::uint8_t* rgb) {
  constexpr std::uint8_t kDark = 10;
  constexpr std::uint8_t kClipped = 250;
  const std::uint8_t most = std::max({rgb[0], rgb[1], rgb[2]});
  return most > kDark && most < kClipped;
}

/// One channel in linear light, smoothed with a standard deviation of 1 px.
std::vector<float> smooth_light(const Picture& picture, std::size_t channel) {
  constexpr std::array<float, 5> kBinomial{1.0F / 16, 4.0F / 16, 6.0F / 16, 4.0F / 16, 1.0F / 16};
  const auto& linear = linear_light();
  const int width = picture.width;
  std::vector<float> rows(picture.rgb.size() / 3);
  std::vector<float> smooth(rows.size());
  std::vector<float> line(static_cast<std::size_t>(width) + 4);
  const auto clamped = [](int i, int size) { return std::clamp(i, 0, size - 1); };
  for (int y = 0; y < picture.height; ++y) {
    for (int x = -2; x < width + 2; ++x) {
      line[static_cast<std::size_t>(x + 2)] = linear[picture.at(clamped(x, width), y)[channel]];
    }
    float* row = &rows[static_cast<std::size_t>(y * width)];
    for (int x = 0; x < width; ++x) {
      row[x] = 0;
      for (std::size_t k = 0; k < 5; ++k) {
        row[x] += kBinomial[k] * line[static_cast<std::size_t>(x) + k];
      }
    }
  }
  for (int y = 0; y < picture.height; ++y) {
    float* to = &smooth[static_cast<std::size_t>(y * width)];
    for (int k = -2; k <= 2; ++k) {
      const float* from = &rows[static_cast<std::size_t>(clamped(y + k, picture.height) * width)];
      const float share = kBinomial[static_cast<std::size_t>(k + 2)];
      for (int x = 0; x < width; ++x) to[x] += share * from[x];
    }
  }
  return smooth;
}

Channels normalised(Channels light) {
  double product = 1;
  for (double& one : light) {
    one = std::max(one, kLightLeast);
    product *= one;
  }
  for (double& one : light) one = std::clamp(one / std::cbrt(product), 1 / kLightMost, kLightMost);
  return light;
}

bool are_too_few(std::size_t pixels, const Picture& picture) {
  return static_cast<double>(pixels) < kShareLeast * static_cast<double>(picture.rgb.size() / 3);
}

/// Minkowski mean of all pixels that tell of the light.
Channels by_shades(const Picture& picture) {
  constexpr double kPower = 6;
  std::array<double, 256> powers{};
  for (std::size_t i = 0; i < powers.size(); ++i) powers[i] = std::pow(linear_light()[i], kPower);
  Channels sums{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
    if (!tells_of_light(&picture.rgb[i])) continue;
    for (std::size_t c = 0; c < 3; ++c) sums[c] += powers[picture.rgb[i + c]];
    ++count;
  }
  if (are_too_few(count, picture)) return {1, 1, 1};
  for (double& one : sums) one = std::pow(one / static_cast<double>(count), 1 / kPower);
  return normalised(sums);
}

/// Minkowski mean of the gradients where all neighbours tell of the light.
Channels by_edges(const Picture& picture) {
  constexpr double kPower = 5;
  const auto width = static_cast<std::size_t>(picture.width);
  std::vector<std::size_t> at;
  for (int y = 1; y + 1 < picture.height; ++y) {
    int run = 0;  // of columns that tell of it in all three rows
    for (int x = 0; x < picture.width; ++x) {
      const bool all = tells_of_light(picture.at(x, y - 1)) && tells_of_light(picture.at(x, y)) &&
                       tells_of_light(picture.at(x, y + 1));
      run = all ? run + 1 : 0;
      if (run < 3) continue;
      at.push_back(static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x - 1));
    }
  }
  if (are_too_few(at.size(), picture)) return {1, 1, 1};
  Channels light{};
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float> smooth = smooth_light(picture, c);
    for (const std::size_t i : at) {
      const double across = smooth[i] - smooth[i - 1];
      const double down = smooth[i] - smooth[i - width];
      const double square = across * across + down * down;
      light[c] += square * square * std::sqrt(square);
    }
    light[c] = std::pow(light[c] / static_cast<double>(at.size()), 1 / kPower);
  }
  return normalised(light);
}

/// Factor that brings nearly the brightest values of a dim picture to those of a well exposed one.
double brightening(const Picture& picture, const Channels& light) {
  constexpr double kBright = 0.61;  // in linear light
  constexpr double kShare = 0.995;  // of the pixels are darker
  constexpr double kMost = 4;
  constexpr std::size_t kBins = 1024;
  const double weakest = std::ranges::min(light);
  std::array<std::array<std::uint16_t, 256>, 3> bins{};  // of what a byte is under white light
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < 256; ++i) {
      const double share = linear_light()[i] / light[c] * weakest;  // 0 to 1
      bins[c][i] = static_cast<std::uint16_t>(std::lround(share * (kBins - 1)));
    }
  }
  std::array<std::size_t, kBins> counts{};
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
    ++counts[std::max(
        {bins[0][picture.rgb[i]], bins[1][picture.rgb[i + 1]], bins[2][picture.rgb[i + 2]]})];
  }
  auto left = static_cast<double>(picture.rgb.size() / 3) * kShare;
  std::size_t bin = 0;
  while (bin + 1 < kBins && (left -= static_cast<double>(counts[bin])) > 0) ++bin;
  const double bright = static_cast<double>(std::max<std::size_t>(bin, 1)) / (kBins - 1) / weakest;
  return std::clamp(kBright / bright, 1.0, kMost);
}

std::uint8_t srgb_byte(double light) {
  return static_cast<std::uint8_t>(std::lround(255 * srgb_of_light(std::clamp(light, 0.0, 1.0))));
}

}  // namespace

std::array<double, 3> light_of(const Picture& picture) {
  const Picture small = shrunk(picture, kSmall);
  const Channels shades = by_shades(small);
  const Channels edges = by_edges(small);
  Channels light{};
  for (std::size_t c = 0; c < 3; ++c) light[c] = std::sqrt(shades[c] * edges[c]);
  return light;
}

WhiteBalance::WhiteBalance(const Picture& picture) {
  Channels light = light_of(picture);
  for (double& one : light) one = std::pow(one, kCorrected);
  const double factor = brightening(picture, light);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < 256; ++i) {
      curves_[c][i] = srgb_byte(factor / light[c] * linear_light()[i]);
    }
  }
}

}  // namespace sinew::vision
