#include "sinew/vision/cube_detection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/units.h"
#include "sinew/vision/detection_picture.h"
#include "sinew/vision/picture_file.h"
#include "sinew/vision/shapes.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

using Ink = std::array<double, 3>;

struct Paint {
  ColorName name;
  Ink ink;
};
/// As toys and prints have them, in daylight.
const std::array<Paint, 7> kPaints{{{ColorName::kRed, {190, 30, 35}},
                                    {ColorName::kYellow, {230, 205, 40}},
                                    {ColorName::kGreen, {40, 130, 60}},
                                    {ColorName::kBlue, {35, 75, 165}},
                                    {ColorName::kOrange, {235, 120, 30}},
                                    {ColorName::kPurple, {105, 50, 140}},
                                    {ColorName::kPink, {235, 110, 170}}}};

/// A table from above, painted with soft edges; a shadow beside each cube, light from one side,
/// noise.
class Scene {
 public:
  Scene(int width, int height, const Ink& table, test::Random& random)
      : random_(random), picture_(black_picture(width, height)) {
    for (std::size_t i = 0; i < picture_.rgb.size(); ++i) picture_.rgb[i] = byte(table[i % 3]);
  }

  void polygon(const std::vector<Pixel>& corners, const Ink& ink, double cover = 1) {
    double top = picture_.height;
    double bottom = 0;
    for (const Pixel p : corners) {
      top = std::min(top, p.y);
      bottom = std::max(bottom, p.y);
    }
    constexpr int kFine = 3;
    for (int y = std::max(0, static_cast<int>(top) - 1);
         y < std::min<double>(picture_.height, bottom + 1); ++y) {
      for (int x = 0; x < picture_.width; ++x) {
        double inside = 0;
        for (int i = 0; i < kFine * kFine; ++i) {
          const Pixel p{x + (i % kFine + 0.5) / kFine, y + (i / kFine + 0.5) / kFine};
          inside += is_inside(corners, p) ? cover / (kFine * kFine) : 0;
        }
        if (inside == 0) continue;
        for (std::size_t c = 0; c < 3; ++c) {
          std::uint8_t& value = picture_.at(x, y)[c];
          value = byte(value * (1 - inside) + ink[c] * inside);
        }
      }
    }
  }

  Quad cube(Pixel middle, double edge, double turn, const Ink& ink) {
    Quad quad;
    for (std::size_t i = 0; i < 4; ++i) {
      const double angle = turn + from_deg(45 + 90.0 * static_cast<double>(i));
      quad[i] = middle + (edge / std::sqrt(2.0)) * Pixel{std::cos(angle), std::sin(angle)};
    }
    std::vector<Pixel> shadow(quad.begin(), quad.end());
    for (Pixel& p : shadow) p = p + Pixel{0.2 * edge, 0.12 * edge};
    polygon(shadow, {20, 20, 25}, 0.45);
    polygon({quad.begin(), quad.end()}, ink);
    return quad;
  }

  void disc(Pixel middle, double radius, const Ink& ink) {
    std::vector<Pixel> corners;
    for (int i = 0; i < 40; ++i) {
      corners.push_back(middle + radius * Pixel{std::cos(i * kPi / 20), std::sin(i * kPi / 20)});
    }
    polygon(corners, ink);
  }

  Picture taken(double noise) {
    for (std::size_t i = 0; i < picture_.rgb.size(); ++i) {
      const auto column = static_cast<double>(i / 3 % static_cast<std::size_t>(picture_.width));
      const double light = 0.85 + 0.2 * column / picture_.width;
      picture_.rgb[i] =
          byte(picture_.rgb[i] * light + noise * (random_.uniform(-1, 1) + random_.uniform(-1, 1)));
    }
    return picture_;
  }

 private:
  static std::uint8_t byte(double value) {
    return static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0));
  }

  test::Random& random_;
  Picture picture_;
};

TEST(CubeDetection, finds_cubes_of_all_colors_on_tables_and_says_where_and_how_turned) {
  test::for_random_cases(12, [](test::Random& random) {
    const std::array<Ink, 3> tables{{{215, 212, 205}, {120, 95, 70}, {60, 62, 66}}};
    Scene scene(640, 480, tables[static_cast<std::size_t>(random.integer(0, 2))], random);
    struct Put {
      ColorName name;
      Quad top;
    };
    std::vector<Put> all;
    const double edge = random.uniform(34, 56);
    for (std::size_t i = 0; i < kPaints.size(); ++i) {
      const Pixel middle{90 + 150.0 * static_cast<double>(i % 4) + random.uniform(-20, 20),
                         130 + 210.0 * static_cast<double>(i / 4) + random.uniform(-25, 25)};
      all.push_back(
          {kPaints[i].name, scene.cube(middle, edge, random.uniform(0, kPi / 2), kPaints[i].ink)});
    }
    const Detection detection = detect_cubes(scene.taken(4));
    EXPECT_EQ(detection.cubes.size(), all.size());
    for (const Put& put : all) {
      const auto seen = std::ranges::find_if(detection.cubes, [&](const SeenCube& cube) {
        return length(cube.center - middle_of(put.top)) < 0.2 * edge;
      });
      ASSERT_NE(seen, detection.cubes.end()) << name(put.name);
      EXPECT_EQ(seen->color, put.name);
      EXPECT_LT(length(seen->center - middle_of(put.top)), 0.04 * edge);
      EXPECT_NEAR(std::remainder(seen->yaw - yaw(put.top), kPi / 2), 0, from_deg(4));
      EXPECT_NEAR(seen->size, edge, 0.08 * edge);
    }
  });
}

TEST(CubeDetection, what_is_no_cube_is_none_and_what_looks_like_one_says_why) {
  test::Random random(7);
  Scene scene(640, 480, {215, 212, 205}, random);
  scene.cube({120, 120}, 50, 0.3, kPaints[0].ink);
  scene.cube({300, 120}, 50, 1.1, kPaints[3].ink);
  scene.disc({450, 120}, 30, kPaints[1].ink);
  scene.polygon({{80, 260}, {220, 260}, {220, 305}, {80, 305}}, kPaints[2].ink);    // a brick
  scene.polygon({{300, 250}, {420, 250}, {420, 370}, {300, 370}}, kPaints[4].ink);  // a box
  // A tag: white around black around white.
  scene.polygon({{480, 250}, {560, 250}, {560, 330}, {480, 330}}, {20, 20, 20});
  scene.polygon({{500, 270}, {520, 270}, {520, 310}, {500, 310}}, {240, 240, 240});
  scene.polygon({{525, 270}, {545, 270}, {545, 290}, {525, 290}}, {240, 240, 240});
  const Picture picture = scene.taken(3);
  const Detection detection = detect_cubes(picture);
  ASSERT_EQ(detection.cubes.size(), 2U);
  EXPECT_NE(detection.cubes[0].color, detection.cubes[1].color);
  const auto refused = [&](Pixel near) {
    const auto found = std::ranges::find_if(detection.refused, [&](const RefusedShape& shape) {
      return length(middle_of(shape.outline) - near) < 20;
    });
    return found != detection.refused.end() ? found->why : std::string();
  };
  EXPECT_EQ(refused({360, 310}), "it is larger than the other cubes");
  EXPECT_NE(refused({520, 290}), "") << "the tag, or a white part of it";

  const Detection blue = detect_cubes(picture, {.colors = {ColorName::kBlue}});
  ASSERT_EQ(blue.cubes.size(), 1U);
  EXPECT_EQ(blue.cubes[0].color, ColorName::kBlue);

  // All of it is drawn, and nothing else of the picture is touched.
  const Picture drawn = detection_picture(picture, detection);
  EXPECT_EQ(drawn.width, picture.width);
  const Pixel center = detection.cubes[0].center;
  const auto* pixel = drawn.at(static_cast<int>(center.x), static_cast<int>(center.y));
  EXPECT_EQ(pixel[1], 255);
  EXPECT_TRUE(std::equal(drawn.at(5, 5), drawn.at(5, 5) + 3, picture.at(5, 5)));
}

TEST(CubeDetection, empty_table_and_the_smallest_pictures_have_no_cubes) {
  test::Random random(3);
  Scene scene(320, 240, {130, 110, 90}, random);
  EXPECT_TRUE(detect_cubes(scene.taken(6)).cubes.empty());
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(1, 400), std::pair(400, 1)}) {
    EXPECT_TRUE(detect_cubes(black_picture(width, height)).cubes.empty());
  }
}

TEST(CubeDetection, large_picture_has_the_same_cubes_as_a_small_one) {
  test::Random random(11);
  Scene scene(1800, 1350, {215, 212, 205}, random);
  const Quad top = scene.cube({700, 620}, 150, 0.5, kPaints[2].ink);
  const Picture large = scene.taken(4);
  for (const Picture& picture : {large, shrunk(large, 640)}) {
    const double scale = 1800.0 / picture.width;
    const Detection detection = detect_cubes(picture);
    ASSERT_EQ(detection.cubes.size(), 1U);
    EXPECT_LT(length(scale * detection.cubes[0].center - middle_of(top)), 4);
    EXPECT_NEAR(scale * detection.cubes[0].size, 150, 8);
  }
}

}  // namespace
}  // namespace sinew::vision
