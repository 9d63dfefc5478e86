#include "sinew/vision/cube_net.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/vision/net_layers.h"

// The weights are part of the program: an installed one needs no data directory.
asm(".section .rodata\n"
    "sinew_cube_net_begin:\n"
    ".incbin \"" SINEW_CUBE_NET
    "\"\n"
    "sinew_cube_net_end:\n"
    ".text\n");
// NOLINTBEGIN(readability-identifier-naming): of the assembler
extern "C" {
extern const std::uint8_t sinew_cube_net_begin[];
extern const std::uint8_t sinew_cube_net_end[];
}
// NOLINTEND(readability-identifier-naming)

namespace sinew::vision {
namespace {

constexpr int kCell = 4;          ///< px, of a cell of what the network says
constexpr int kStep = 32;         ///< px, of which its pictures are multiples
constexpr double kEdge = 32;      ///< px, an edge whose logarithm it calls 0
constexpr float kMiddle = 0.45F;  ///< of a picture's values
constexpr int kColors = kColorNames + 1;
/// Where its results stand; tools/cube_net/train.py says what they are.
constexpr int kShape = 3;
constexpr int kColor = 8;
constexpr int kOther = kColor + kColors;
constexpr int kKind = kOther + 1;
constexpr std::array<std::string_view, 5> kWhy{"it is longer than wide", "it is round",
                                               "it has not four sides",
                                               "it is much larger than a cube", kIsFlat};
constexpr int kFlat = 4;  ///< of kWhy
constexpr int kResults = kKind + static_cast<int>(kWhy.size());

/// A balanced picture up to a multiple of what the network halves; the last row and column are
/// repeated.
Maps maps_of(const Picture& picture, const WhiteBalance& balance) {
  const auto whole = [](int size) { return (size + kStep - 1) / kStep * kStep; };
  Maps maps(3, whole(picture.height), whole(picture.width));
  for (int c = 0; c < 3; ++c) {
    const auto& curve = balance.curve(static_cast<std::size_t>(c));
    std::array<float, 256> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = static_cast<float>(curve[i]) / 255 - kMiddle;
    }
    for (int y = 0; y < maps.height; ++y) {
      const std::uint8_t* from = picture.at(0, std::min(y, picture.height - 1)) + c;
      float* to = maps.row(c, y);
      for (int x = 0; x < picture.width; ++x) to[x] = values[from[3 * x]];
      std::fill(to + picture.width, to + maps.width, to[picture.width - 1]);
    }
  }
  return maps;
}

void refine(Maps& maps, int count, Weights& weights) {
  for (int i = 0; i < count; ++i) refine(maps, weights);
}

/// The network: four levels down, three up. A row of train.py's CubeNet each.
Maps results_of(const Picture& picture, const WhiteBalance& balance) {
  struct Level {
    int channels;
    int blocks_down;
    int blocks_up;
  };
  constexpr std::array<Level, 4> kLevels{{{24, 1, 1}, {40, 3, 2}, {64, 4, 2}, {96, 4, 0}}};
  constexpr int kStem = 12;
  constexpr int kLast = 32;
  Weights weights({sinew_cube_net_begin, sinew_cube_net_end});
  const Maps stem = halved(maps_of(picture, balance), kStem, weights);
  std::vector<Maps> levels;
  for (const Level& level : kLevels) {
    levels.push_back(halved(levels.empty() ? stem : levels.back(), level.channels, weights));
    refine(levels.back(), level.blocks_down, weights);
  }
  Maps maps = std::move(levels.back());
  for (std::size_t i = kLevels.size() - 1; i-- > 0;) {
    add_doubled(mixed(maps, kLevels[i].channels, Clip::kZero, weights), levels[i]);
    maps = std::move(levels[i]);
    refine(maps, kLevels[i].blocks_up, weights);
  }
  maps = mixed(maps, kLast, Clip::kZero, weights);
  refine(maps, 1, weights);
  maps = mixed(maps, kResults, Clip::kNone, weights);
  SINEW_ASSERT(weights.is_empty());
  return maps;
}

/// 0 to 1 where no neighbour has more; else 0.
double peak(const Maps& maps, int channel, int x, int y) {
  const float here = maps.at(channel, x, y);
  for (int v = std::max(0, y - 1); v <= std::min(maps.height - 1, y + 1); ++v) {
    for (int u = std::max(0, x - 1); u <= std::min(maps.width - 1, x + 1); ++u) {
      if (maps.at(channel, u, v) > here) return 0;
    }
  }
  return 1 / (1 + std::exp(-static_cast<double>(here)));
}

int largest(const Maps& maps, int from, int count, int x, int y) {
  int best = 0;
  for (int i = 1; i < count; ++i) {
    if (maps.at(from + i, x, y) > maps.at(from + best, x, y)) best = i;
  }
  return best;
}

/// px
double edge_of(const Maps& maps, int x, int y) {
  return kEdge * std::exp(std::clamp(static_cast<double>(maps.at(kShape, x, y)), -2.0, 2.5));
}

/// The color of a top, by all cells around its middle that are trained to know it: a screw or a
/// letter there hides it from one.
int color_of(const Maps& maps, int x, int y) {
  constexpr double kShare = 0.2;  // of an edge
  constexpr int kMost = 2;
  const double edge = edge_of(maps, x, y);
  const int reach = std::clamp(static_cast<int>(kShare * edge / kCell), 0, kMost);
  std::array<float, kColors> sums{};
  for (int v = std::max(0, y - reach); v <= std::min(maps.height - 1, y + reach); ++v) {
    for (int u = std::max(0, x - reach); u <= std::min(maps.width - 1, x + reach); ++u) {
      for (int c = 0; c < kColors; ++c) {
        sums[static_cast<std::size_t>(c)] += maps.at(kColor + c, u, v);
      }
    }
  }
  // As often as another color in training, and far less often on tables.
  constexpr float kPlainWood = 1.1F;
  sums[static_cast<std::size_t>(ColorName::kWood)] -=
      kPlainWood * static_cast<float>((2 * reach + 1) * (2 * reach + 1));
  return static_cast<int>(std::ranges::max_element(sums) - sums.begin());
}

/// The quad of a cell: a square of its edge and turn, stretched by the root of a matrix that has
/// the determinant 1 and the two numbers of its shape.
Quad quad_of(const Maps& maps, int x, int y) {
  const auto value = [&](int channel) { return static_cast<double>(maps.at(channel, x, y)); };
  const Pixel middle{kCell * (x + 0.5 + value(1)), kCell * (y + 0.5 + value(2))};
  const double edge = edge_of(maps, x, y);
  Pixel shape{value(kShape + 1), value(kShape + 2)};
  constexpr double kFlattest = 0.95;
  if (length(shape) > kFlattest) shape = kFlattest / length(shape) * shape;
  const double turn = std::atan2(value(kShape + 4), value(kShape + 3)) / 4;
  // The root of [[1 + a, b], [b, 1 - a]] / sqrt(1 - a^2 - b^2).
  const double norm = std::sqrt(1 - dot(shape, shape));
  const double xx = (1 + shape.x) / norm;
  const double yy = (1 - shape.x) / norm;
  const double xy = shape.y / norm;
  const double root = std::sqrt(xx + yy + 2);
  Quad quad;
  for (std::size_t i = 0; i < 4; ++i) {
    const double angle = turn + std::numbers::pi * (0.25 + 0.5 * static_cast<double>(i));
    const Pixel p = edge / std::numbers::sqrt2 * Pixel{std::cos(angle), std::sin(angle)};
    quad[i] = middle + 1 / root * Pixel{(xx + 1) * p.x + xy * p.y, xy * p.x + (yy + 1) * p.y};
  }
  return quad;
}

}  // namespace

Likely likely_things(const Picture& picture, const WhiteBalance& balance, double least) {
  const Maps maps = results_of(picture, balance);
  Likely found;
  const auto enough = static_cast<float>(std::log(least / (1 - least)));
  for (int y = 0; y < maps.height; ++y) {
    for (int x = 0; x < maps.width; ++x) {
      if (maps.at(0, x, y) < enough && maps.at(kOther, x, y) < enough) continue;
      if (const double sure = peak(maps, 0, x, y); sure > least) {
        const int color = color_of(maps, x, y);
        found.tops.push_back({quad_of(maps, x, y), sure,
                              color < static_cast<int>(kColorNames)
                                  ? std::optional(static_cast<ColorName>(color))
                                  : std::nullopt});
      }
      if (const double sure = peak(maps, kOther, x, y); sure > least) {
        const int kind = largest(maps, kKind, static_cast<int>(kWhy.size()), x, y);
        found.others.push_back({Pixel{kCell * (x + 0.5), kCell * (y + 0.5)}, sure,
                                kWhy[static_cast<std::size_t>(kind)], kind == kFlat});
      }
    }
  }
  return found;
}

}  // namespace sinew::vision
