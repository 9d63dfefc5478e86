#include "sinew/render/prints.h"

#include <algorithm>
#include <array>
#include <cmath>
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
template <class Brightness>
PrintPicture grey_of(int side, const Brightness& brightness) {
  Picture picture = vision::black_picture(side, side);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      std::fill_n(picture.at(x, y), 3, byte(brightness(x, y)));
    }
  }
  return std::make_shared<const Picture>(std::move(picture));
}

/// Smooth random heights at the pixels of a picture, 0 to 1, that repeat themselves after it.
class Heights {
 public:
  Heights(SplitMix64& random, int across, int down)
      : across_(across), columns_(between(across)), rows_(between(down)) {
    values_.resize(static_cast<std::size_t>(across * down));
    for (double& value : values_) value = random.uniform(0, 1);
  }
  double at(int x, int y) const {
    const Between& column = columns_[static_cast<std::size_t>(x)];
    const Between& row = rows_[static_cast<std::size_t>(y)];
    const double* above = &values_[static_cast<std::size_t>(row.first * across_)];
    const double* below = &values_[static_cast<std::size_t>(row.second * across_)];
    const double s = column.share;
    return (1 - row.share) * ((1 - s) * above[column.first] + s * above[column.second]) +
           row.share * ((1 - s) * below[column.first] + s * below[column.second]);
  }

 private:
  struct Between {
    int first = 0;
    int second = 0;
    double share = 0;  // of the second
  };
  static std::array<Between, kSide> between(int knots) {
    std::array<Between, kSide> all{};
    for (int i = 0; i < kSide; ++i) {
      const double u = 1.0 * i / kSide * knots;
      const int k = static_cast<int>(u);
      const double t = u - k;
      all[static_cast<std::size_t>(i)] = {k % knots, (k + 1) % knots, t * t * (3 - 2 * t)};
    }
    return all;
  }

  int across_;
  std::array<Between, kSide> columns_;
  std::array<Between, kSide> rows_;
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

constexpr int kFace = 128;  // px

/// A tag in black and white in the middle of a face, or a label of one color.
void put_cells(Picture& picture, SplitMix64& random, double size, bool is_tag,
               const double (&ink)[3]) {
  const int cells = whole(random, 6, 10);
  const std::uint64_t bits = random.bits();
  for (int y = 0; y < kFace; ++y) {
    for (int x = 0; x < kFace; ++x) {
      const double u = (x + 0.5 - kFace / 2.0) / size;
      const double v = (y + 0.5 - kFace / 2.0) / (is_tag ? size : 0.6 * size);
      if (std::max(std::abs(u), std::abs(v)) > 1) continue;
      const int i = static_cast<int>((u + 1) / 2 * cells);
      const int k = static_cast<int>((v + 1) / 2 * cells);
      const int edge = std::min({i, k, cells - 1 - i, cells - 1 - k});
      const auto bit = static_cast<unsigned>((i * 7 + k * 11) % 61);
      const bool dark = edge == 1 || (edge > 1 && (bits >> bit & 1U) != 0);
      for (std::size_t c = 0; c < 3; ++c) {
        picture.at(x, y)[c] = is_tag ? byte(dark ? 0.05 : 0.95) : byte(ink[c]);
      }
    }
  }
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

PrintPicture collage(SplitMix64& random) {
  Picture picture = white(kSide);
  const Heights shade(random, 2, 2);
  const auto color = [&](double(&ink)[3]) {
    const double grey = random.uniform(0, 1);
    const double strength = random.uniform(0, 1);
    for (double& value : ink) value = grey + strength * (random.uniform(0, 1) - grey);
  };
  double back[3];
  double other[3];
  color(back);
  color(other);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double share = shade.at(x, y);
      for (std::size_t c = 0; c < 3; ++c) {
        picture.at(x, y)[c] = byte(back[c] + share * (other[c] - back[c]));
      }
    }
  }
  const double large = random.uniform(10, 70);
  for (int count = whole(random, 5, 60); count > 0; --count) {
    double ink[3];
    color(ink);
    const Pixel middle{random.uniform(0, kSide), random.uniform(0, kSide)};
    const double turn = random.uniform(0, 1) < 0.6 ? 0 : random.uniform(0, kPi);
    const Pixel along{std::cos(turn), std::sin(turn)};
    const Pixel half{large * random.uniform(0.1, 1), large * random.uniform(0.1, 1)};
    const int kind = whole(random, 0, 5);
    if (kind == 0) {
      stroke(picture, middle, middle + 4 * half.x * along, random.uniform(0.5, 4), ink);
      continue;
    }
    const double hole = kind == 1 ? random.uniform(0.5, 0.9) : 0;
    const double reach = length(half);
    for (int y = std::max(0, static_cast<int>(middle.y - reach));
         y < std::min<double>(kSide, middle.y + reach); ++y) {
      for (int x = std::max(0, static_cast<int>(middle.x - reach));
           x < std::min<double>(kSide, middle.x + reach); ++x) {
        const Pixel p = Pixel{x + 0.5, y + 0.5} - middle;
        const double u = std::abs(dot(p, along)) / half.x;
        const double v = std::abs(cross(along, p)) / half.y;
        const double out = kind == 2 ? std::hypot(u, v) : std::max(u, v);
        if (out > 1 || out < hole) continue;
        for (std::size_t c = 0; c < 3; ++c) picture.at(x, y)[c] = byte(ink[c]);
      }
    }
  }
  return kept(std::move(picture));
}

PrintPicture mottled(SplitMix64& random, double depth, double tint) {
  const int coarse = whole(random, 3, 12);
  const int fine = whole(random, 30, 128);
  const double mix = random.uniform(0, 1);
  std::vector<Heights> heights;
  for (int i = 0; i < 4; ++i) {
    heights.emplace_back(random, coarse, coarse);
    heights.emplace_back(random, fine, fine);
  }
  Picture picture = white(kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const auto height = [&](std::size_t i) {
        return mix * heights[2 * i].at(x, y) + (1 - mix) * heights[2 * i + 1].at(x, y);
      };
      const double grey = height(0);
      for (std::size_t c = 0; c < 3; ++c) {
        picture.at(x, y)[c] = byte(1 - depth * (grey + tint * (height(c + 1) - grey)));
      }
    }
  }
  return kept(std::move(picture));
}

PrintPicture printed_face(SplitMix64& random, const double (&rgb)[3], FacePrint print) {
  Picture picture = vision::black_picture(kFace, kFace);
  double ink[3];
  const double shade = random.uniform(0, 1);
  for (double& part : ink) {
    part = shade < 0.4 ? 0.08 : shade < 0.75 ? 0.93 : random.uniform(0, 1);
  }
  for (int y = 0; y < kFace; ++y) {
    for (int x = 0; x < kFace; ++x) {
      for (std::size_t c = 0; c < 3; ++c) picture.at(x, y)[c] = byte(rgb[c]);
    }
  }
  const double size = random.uniform(0.2, 0.38) * kFace;
  const Pixel middle{kFace / 2.0, kFace / 2.0};
  const auto point = [&] {
    return middle + Pixel{random.uniform(-1, 1) * size, random.uniform(-1, 1) * size};
  };
  switch (print) {
    case FacePrint::kLetter: {
      const double thick = random.uniform(0.08, 0.25) * size;
      Pixel at = point();
      for (int count = whole(random, 2, 4); count > 0; --count) {
        const Pixel next = point();
        stroke(picture, at, next, thick, ink);
        at = next;
      }
      break;
    }
    case FacePrint::kPips: {
      const int across = whole(random, 1, 3);
      const double step = 2 * size / across;
      for (int i = 0; i < across * across; ++i) {
        const Pixel pip{(i % across - 0.5 * (across - 1)) * step,
                        (static_cast<double>(i / across) - 0.5 * (across - 1)) * step};
        stroke(picture, middle + pip, middle + pip, 0.3 * std::min(step, size), ink);
      }
      break;
    }
    case FacePrint::kTag:
    case FacePrint::kLabel:
      put_cells(picture, random, size, print == FacePrint::kTag, ink);
      break;
    case FacePrint::kScrew: {  // of metal, in a dark hole
      const double radius = random.uniform(0.05, 0.2) * kFace;
      const double dark[3] = {0.3 * rgb[0], 0.3 * rgb[1], 0.3 * rgb[2]};
      const double metal = random.uniform(0.4, 0.9);
      stroke(picture, middle, middle, random.uniform(1, 1.5) * radius, dark);
      stroke(picture, middle, middle, radius, {metal, metal, metal});
      stroke(picture, middle, middle, 0.4 * radius, dark);
      break;
    }
    case FacePrint::kScratches: {
      for (int count = whole(random, 3, 25); count > 0; --count) {
        const Pixel from{random.uniform(0, kFace), random.uniform(0, kFace)};
        const Pixel along{random.uniform(-1, 1), random.uniform(-1, 1)};
        double worn[3];
        const double strength = random.uniform(-0.25, 0.25);
        for (std::size_t c = 0; c < 3; ++c) worn[c] = std::clamp(rgb[c] + strength, 0.0, 1.0);
        stroke(picture, from, from + random.uniform(1, 30) * along, random.uniform(0.5, 3), worn);
      }
      break;
    }
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
