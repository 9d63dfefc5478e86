#include "sinew/vision/white_balance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/vision/srgb.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

using Channels = std::array<double, 3>;

/// Grey and colored patches under a light.
Picture patches(test::Random& random, const Channels& light, double exposure) {
  Picture picture = black_picture(120, 90);
  constexpr int kPatch = 15;
  std::array<Channels, 48> colors{};
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const double grey = random.uniform(0.05, 0.9);
    const double tint = i % 4 == 0 ? 0.6 : 0.03;
    for (double& one : colors[i]) one = grey * (1 - random.uniform(0, tint));
  }
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const Channels& color = colors[static_cast<std::size_t>(x / kPatch + 8 * (y / kPatch))];
      for (std::size_t c = 0; c < 3; ++c) {
        const double linear = std::min(1.0, exposure * light[c] * color[c]);
        const auto byte = std::ranges::lower_bound(linear_light(), static_cast<float>(linear));
        picture.at(x, y)[c] =
            static_cast<std::uint8_t>(std::min<std::ptrdiff_t>(255, byte - linear_light().begin()));
      }
    }
  }
  return picture;
}

Picture balanced(Picture picture) {
  const WhiteBalance balance(picture);
  for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
    picture.rgb[i] = balance.curve(i % 3)[picture.rgb[i]];
  }
  return picture;
}

Channels mean_light(const Picture& picture) {
  Channels mean{};
  for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
    mean[i % 3] += linear_light()[picture.rgb[i]] / (static_cast<double>(picture.rgb.size()) / 3);
  }
  return mean;
}

TEST(WhiteBalance, the_light_of_a_table_is_estimated_within_a_tenth) {
  test::for_random_cases(40, [](test::Random& random) {
    Channels light{std::exp(random.uniform(-0.4, 0.4)), 1, std::exp(random.uniform(-0.4, 0.4))};
    const double norm = std::cbrt(light[0] * light[1] * light[2]);
    const Channels seen = light_of(patches(random, light, 0.6));
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen[c] * norm / light[c], 1, 0.1);
  });
}

TEST(WhiteBalance, most_of_a_tint_is_taken_away_and_a_dim_picture_is_brightened) {
  test::for_random_cases(20, [](test::Random& random) {
    const std::uint64_t seed = random.bits();
    test::Random same(seed);
    const Channels white = mean_light(balanced(patches(same, {1, 1, 1}, 0.8)));
    same = test::Random(seed);
    const Picture warm = patches(same, {1.2, 1, 0.7}, 0.2);
    const Channels before = mean_light(warm);
    const Channels after = mean_light(balanced(warm));
    const auto tint = [&](const Channels& light) {
      return std::abs(std::log(light[0] / light[2] * white[2] / white[0]));
    };
    EXPECT_LT(tint(after), 0.5 * tint(before));
    EXPECT_GT(after[1], 0.6 * white[1]);
    EXPECT_LT(before[1], 0.4 * white[1]);
  });
}

TEST(WhiteBalance, what_tells_nothing_of_the_light_gets_no_tint) {
  for (const int value : {0, 3, 40, 200, 255}) {
    Picture plain = black_picture(40, 30);
    std::ranges::fill(plain.rgb, static_cast<std::uint8_t>(value));
    for (const double one : light_of(plain)) EXPECT_NEAR(one, 1, 1e-9);
    const Picture after = balanced(plain);
    EXPECT_EQ(after.rgb[0], after.rgb[2]);
    EXPECT_GE(after.rgb[0], value);
  }
  // One cube on a table that is burnt out is no light.
  Picture burnt = black_picture(100, 75);
  std::ranges::fill(burnt.rgb, std::uint8_t{255});
  for (int y = 20; y < 40; ++y) {
    for (int x = 20; x < 40; ++x) std::ranges::copy(std::array{190, 30, 35}, burnt.at(x, y));
  }
  EXPECT_EQ(light_of(burnt), (Channels{1, 1, 1}));
  Picture dot = black_picture(1, 1);
  dot.rgb = {255, 10, 10};
  EXPECT_EQ(light_of(dot), (Channels{1, 1, 1}));
}

TEST(WhiteBalance, a_channel_that_is_missing_does_not_darken_the_picture) {
  Picture red = black_picture(80, 60);
  for (std::size_t i = 0; i < red.rgb.size(); i += 3) {
    red.rgb[i] = static_cast<std::uint8_t>(60 + i / 3 % 150);
  }
  for (const double one : light_of(red)) EXPECT_LE(std::abs(std::log(one)), std::log(2) + 1e-9);
  EXPECT_GT(mean_light(balanced(red))[0], 0.5 * mean_light(red)[0]);
}

}  // namespace
}  // namespace sinew::vision
