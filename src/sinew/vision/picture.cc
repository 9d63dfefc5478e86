#include "sinew/vision/picture.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "sinew/core/assert.h"
#include "sinew/core/dispatch.h"

namespace sinew::vision {
namespace {

using Four [[gnu::vector_size(16)]] = float;

/// Which pixels of a row or column one of the smaller picture covers, and how much of each.
struct Cover {
  int first = 0;
  std::vector<float> shares;  ///< their sum is 1
};

std::vector<Cover> covers(int from, int to) {
  std::vector<Cover> all;
  const double step = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    const double begin = i * step;
    const double end = std::min<double>((i + 1) * step, from);
    Cover cover{static_cast<int>(begin), {}};
    for (int k = cover.first; k < end; ++k) {
      const double share = std::min<double>(k + 1, end) - std::max<double>(k, begin);
      cover.shares.push_back(static_cast<float>(share / (end - begin)));
    }
    all.push_back(std::move(cover));
  }
  return all;
}

}  // namespace

double length(Pixel a) {
  return std::hypot(a.x, a.y);
}

Pixel middle_of(const Quad& quad) {
  return 0.25 * std::accumulate(quad.begin(), quad.end(), Pixel{});
}

Picture black_picture(int width, int height) {
  SINEW_ASSERT(width > 0 && height > 0);
  return {width, height,
          std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width) *
                                    static_cast<std::size_t>(height))};
}

Picture shrunk(const Picture& picture, int longest) {
  const int side = std::max(picture.width, picture.height);
  if (side <= longest) return picture;
  const double scale = static_cast<double>(longest) / side;
  Picture small = black_picture(std::max(1, static_cast<int>(std::lround(picture.width * scale))),
                                std::max(1, static_cast<int>(std::lround(picture.height * scale))));
  const auto columns = covers(picture.width, small.width);
  const auto rows = covers(picture.height, small.height);
  // One more: pixels are read as four floats.
  std::vector<float> line(3 * static_cast<std::size_t>(picture.width) + 1);
  for (int y = 0; y < small.height; ++y) {
    const Cover& row = rows[static_cast<std::size_t>(y)];
    std::ranges::fill(line, 0.0F);
    dispatched([&] {
      for (std::size_t k = 0; k < row.shares.size(); ++k) {
        const std::uint8_t* from = picture.at(0, row.first + static_cast<int>(k));
        for (std::size_t i = 0; i + 1 < line.size(); ++i) line[i] += row.shares[k] * from[i];
      }
    });
    for (int x = 0; x < small.width; ++x) {
      const Cover& column = columns[static_cast<std::size_t>(x)];
      Four sum{};
      for (std::size_t k = 0; k < column.shares.size(); ++k) {
        Four pixel;
        std::memcpy(&pixel, &line[3 * (static_cast<std::size_t>(column.first) + k)], sizeof pixel);
        sum += column.shares[k] * pixel;
      }
      for (int c = 0; c < 3; ++c) small.at(x, y)[c] = static_cast<std::uint8_t>(sum[c] + 0.5F);
    }
  }
  return small;
}

}  // namespace sinew::vision
