#include "sinew/render/prints.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "sinew/core/units.h"
#include "sinew/vision/shapes.h"

namespace sinew::render {
namespace {

using vision::Picture;
using vision::Pixel;

constexpr int kSide = 256;

std::uint8_t byte(double v) {
  return static_cast<std::uint8_t>(std::clamp(255 * v, 0.0, 255.0));
}

/// Of brightness 0 to 1 for each pixel of a square.
PrintPicture grey_of(int side, const std::function<double(int, int)>& brightness) {
  Picture picture = vision::black_picture(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      std::fill_n(picture.at(x, y), 3, byte(brightness(x, y)));
    }
  }
  return std::make_shared<const Picture>(std::move(picture));
}

/// Smooth random heights, 0 to 1, that repeat themselves after the picture.
class Heights {
 public:
  Heights(SplitMix64& random, int across, int down) : across_(across), down_(down) {
    values_.resize(static_cast<std::size_t>(across * down));
    for (double& value : values_) value = random.uniform(0, 1);
  }
  double at(double x, double y) const {
    const double u = x / kSide * across_;
    const double v = y / kSide * down_;
    const auto i = static_cast<int>(u);
    const auto k = static_cast<int>(v);
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double s = smooth(u - i);
    const double t = smooth(v - k);
    return (1 - t) * ((1 - s) * knot(i, k) + s * knot(i + 1, k)) +
           t * ((1 - s) * knot(i, k + 1) + s * knot(i + 1, k + 1));
  }

 private:
  double knot(int i, int k) const {
    return values_[static_cast<std::size_t>(k % down_ * across_ + i % across_)];
  }
  int across_;
  int down_;
  std::vector<double> values_;
};

int whole(SplitMix64& random, int low, int high) {
  return static_cast<int>(random.uniform(low, high + 1));
}

/// All pixels within `radius` of a line.
void stroke(Picture& picture, Pixel from, Pixel to, double radius, const double (&ink)[3]) {
  const Pixel along = to - from;
  const double square = std::max(1e-9, dot(along, along));
  for (int y = std::max(0, static_cast<int>(std::min(from.y, to.y) - radius));
       y < std::min<double>(picture.height, std::max(from.y, to.y) + radius + 1); ++y) {
    for (int x = std::max(0, static_cast<int>(std::min(from.x, to.x) - radius));
         x < std::min<double>(picture.width, std::max(from.x, to.x) + radius + 1); ++x) {
      const Pixel p{x + 0.5, y + 0.5};
      const double share = std::clamp(dot(p - from, along) / square, 0.0, 1.0);
      if (length(p - from - share * along) > radius) continue;
      for (std::size_t c = 0; c < 3; ++c) picture.at(x, y)[c] = byte(ink[c]);
    }
  }
}

Picture white(int side) {
  Picture picture = vision::black_picture(side, side);
  std::ranges::fill(picture.rgb, 255);
  return picture;
}

PrintPicture kept(Picture picture) {
  return std::make_shared<const Picture>(std::move(picture));
}

}  // namespace

PrintPicture clouds(SplitMix64& random, double depth) {
  const Heights coarse(random, 5, 5);
  const Heights middle(random, 17, 17);
  const Heights fine(random, 90, 90);
  return grey_of(kSide, [&](int x, int y) {
    return 1 - depth * (0.5 * coarse.at(x, y) + 0.3 * middle.at(x, y) + 0.2 * fine.at(x, y));
  });
}

PrintPicture grain(SplitMix64& random, double depth) {
  const Heights bend(random, 3, 3);
  const Heights fibres(random, 4, 60);
  const Heights fine(random, 12, 128);
  return grey_of(kSide, [&](int x, int y) {
    const double rings = 0.5 + 0.5 * std::sin(2 * kPi * (6.0 * y / kSide + 2 * bend.at(x, y)));
    return 1 - depth * (0.35 * rings + 0.4 * fibres.at(x, y) + 0.25 * fine.at(x, y));
  });
}

PrintPicture layers(SplitMix64& random, double depth) {
  const Heights uneven(random, 6, 40);
  return grey_of(kSide, [&](int x, int y) {
    return 1 - depth * (0.5 + 0.5 * std::sin(2 * kPi * 24 * y / kSide)) * uneven.at(x, y);
  });
}

PrintPicture grid(SplitMix64& random, int count, double depth) {
  const int wide = whole(random, 1, 5);
  const int step = std::max(2 * wide, 2 * kSide / count);
  return grey_of(2 * kSide, [&](int x, int y) {
    return x % step < wide || y % step < wide ? 1 - depth : 1.0;
  });
}

PrintPicture stripes(int count) {
  return grey_of(kSide, [&](int x, int y) { return (x + y) * count / kSide % 2 == 0 ? 1.0 : 0.1; });
}

PrintPicture checkers(int count) {
  return grey_of(kSide, [&](int x, int y) {
    return (x * count / kSide + y * count / kSide) % 2 == 0 ? 1.0 : 0.08;
  });
}

PrintPicture tag(SplitMix64& random) {
  const int cells = whole(random, 6, 10);
  const std::uint64_t bits = random.bits();
  return grey_of(kSide, [&](int x, int y) {
    const int u = x * cells / kSide;
    const int v = y * cells / kSide;
    const int edge = std::min({u, v, cells - 1 - u, cells - 1 - v});
    if (edge == 0) return 0.95;
    if (edge == 1) return 0.04;
    return (bits >> static_cast<unsigned>((u * 7 + v * 11) % 61) & 1U) != 0 ? 0.95 : 0.04;
  });
}

PrintPicture rings() {
  return grey_of(kSide, [](int x, int y) {
    const double r = 2 * std::hypot(x - kSide / 2.0, y - kSide / 2.0) / kSide;
    return r < 0.95 && static_cast<int>(r * 6) % 2 == 1 ? 0.06 : 0.95;
  });
}

PrintPicture writing(SplitMix64& random) {
  Picture picture = white(kSide);
  const double size = random.uniform(14, 50);
  const double ink = random.uniform(0, 0.5);
  for (double y = size; y < kSide; y += 1.6 * size) {
    for (double x = 0.4 * size; x < kSide - size; x += random.uniform(0.5, 1.1) * size) {
      const auto point = [&] {
        return Pixel{x + random.uniform(0, 0.5) * size, y - random.uniform(0, 1) * size};
      };
      for (int k = whole(random, 0, 3); k > 0; --k) {
        stroke(picture, point(), point(), 0.07 * size, {ink, ink, ink});
      }
    }
  }
  return kept(std::move(picture));
}

PrintPicture fields(SplitMix64& random) {
  Picture picture = white(kSide);
  for (int count = whole(random, 2, 4); count > 0; --count) {
    const double ink[3] = {random.uniform(0.05, 1), random.uniform(0.05, 1),
                           random.uniform(0.05, 1)};
    const Pixel middle{random.uniform(0, kSide), random.uniform(0, kSide)};
    const double turn = random.uniform(0, 2 * kPi);
    const Pixel normal{std::cos(turn), std::sin(turn)};
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        if (dot(Pixel{x + 0.5, y + 0.5} - middle, normal) < 0) continue;
        for (std::size_t c = 0; c < 3; ++c) picture.at(x, y)[c] = byte(ink[c]);
      }
    }
  }
  return kept(std::move(picture));
}

PrintPicture blots(SplitMix64& random) {
  Picture picture = white(kSide);
  for (int count = whole(random, 20, 90); count > 0; --count) {
    const double ink[3] = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
    const Pixel from{random.uniform(0, kSide), random.uniform(0, kSide)};
    const Pixel to =
        from + random.uniform(0, 60) * Pixel{random.uniform(-1, 1), random.uniform(-1, 1)};
    stroke(picture, from, to, random.uniform(2, 40), ink);
  }
  return kept(std::move(picture));
}

PrintPicture framed(double share) {
  return grey_of(kSide, [&](int x, int y) {
    const int edge = std::min({x, y, kSide - 1 - x, kSide - 1 - y});
    return edge < share * kSide ? 0.05 : 1.0;
  });
}

PrintPicture screw(SplitMix64& random, double share) {
  const double ink = random.uniform(0.05, 0.8);
  return grey_of(kSide, [&](int x, int y) {
    return std::hypot(x - kSide / 2.0, y - kSide / 2.0) < share * kSide / 2 ? ink : 1.0;
  });
}

}  // namespace sinew::render
