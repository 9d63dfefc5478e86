#include "sinew/vision/net_layers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sinew/core/dispatch.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

/// Halves of small whole numbers: half floats hold them exactly.
struct File {
  std::vector<std::uint8_t> bytes;
  std::vector<double> values;

  void add(std::size_t count, test::Random& random) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto quarters = static_cast<int>(random.integer(-12, 12));
      values.push_back(quarters / 4.0);
      int exponent = 0;
      const double fraction = std::frexp(std::abs(values.back()), &exponent);
      unsigned half = quarters < 0 ? 0x8000U : 0U;
      if (quarters != 0) {
        half |= static_cast<unsigned>(exponent + 14) << 10U;
        half |= static_cast<unsigned>(std::lround((2 * fraction - 1) * 1024));
      }
      bytes.push_back(static_cast<std::uint8_t>(half & 0xFFU));
      bytes.push_back(static_cast<std::uint8_t>(half >> 8U));
    }
  }
};

Maps some_maps(int channels, int height, int width, test::Random& random) {
  Maps maps(channels, height, width);
  for (float& value : maps.values) value = static_cast<float>(random.uniform(-1, 1));
  return maps;
}

double or_zero(const Maps& maps, int channel, int x, int y) {
  const bool inside = x >= 0 && y >= 0 && x < maps.width && y < maps.height;
  return inside ? maps.at(channel, x, y) : 0;
}

/// Each case with another version of the loops; those that this processor has not are the next
/// narrower ones.
class NetLayers : public ::testing::Test {
 protected:
  ~NetLayers() override { take_vectors(Vectors::kWidest); }
};
Vectors any_vectors(test::Random& random) {
  return static_cast<Vectors>(random.integer(0, 2));
}

TEST_F(NetLayers, halves_are_what_filters_of_all_channels_give_at_every_second_place) {
  test::for_random_cases(40, [](test::Random& random) {
    take_vectors(any_vectors(random));
    const int inside = static_cast<int>(random.integer(1, 5));
    const int outside = static_cast<int>(random.integer(1, 9));
    const Maps in = some_maps(inside, 2 * static_cast<int>(random.integer(1, 9)),
                              2 * static_cast<int>(random.integer(1, 40)), random);
    File file;
    file.add(static_cast<std::size_t>(outside * (9 * inside + 1)), random);
    Weights weights(file.bytes);
    const Maps out = halved(in, outside, weights);
    EXPECT_TRUE(weights.is_empty());
    for (int m = 0; m < outside; ++m) {
      for (int y = 0; y < out.height; ++y) {
        for (int x = 0; x < out.width; ++x) {
          double sum = file.values[static_cast<std::size_t>(9 * inside * outside + m)];
          for (int k = 0; k < 9 * inside; ++k) {
            sum += file.values[static_cast<std::size_t>(9 * inside * m + k)] *
                   or_zero(in, k / 9, 2 * x + k % 3 - 1, 2 * y + k / 3 % 3 - 1);
          }
          ASSERT_NEAR(out.at(m, x, y), std::max(0.0, sum), 1e-4) << m << " " << x << " " << y;
        }
      }
    }
  });
}

TEST_F(NetLayers, filters_and_mixes_are_sums_over_neighbours_and_over_channels) {
  test::for_random_cases(40, [](test::Random& random) {
    take_vectors(any_vectors(random));
    const int inside = static_cast<int>(random.integer(1, 6));
    const int outside = static_cast<int>(random.integer(1, 9));
    const Maps in = some_maps(inside, static_cast<int>(random.integer(1, 9)),
                              static_cast<int>(random.integer(1, 70)), random);
    File file;
    file.add(static_cast<std::size_t>(10 * inside), random);
    Weights weights(file.bytes);
    const Maps out = filtered(in, weights);
    File mix;
    mix.add(static_cast<std::size_t>(outside * (inside + 1)), random);
    Weights mix_weights(mix.bytes);
    const Maps mixture = mixed(in, outside, Clip::kNone, mix_weights);
    for (int y = 0; y < in.height; ++y) {
      for (int x = 0; x < in.width; ++x) {
        for (int c = 0; c < inside; ++c) {
          double sum = file.values[static_cast<std::size_t>(9 * inside + c)];
          for (int k = 0; k < 9; ++k) {
            sum += file.values[static_cast<std::size_t>(9 * c + k)] *
                   or_zero(in, c, x + k % 3 - 1, y + k / 3 - 1);
          }
          ASSERT_NEAR(out.at(c, x, y), std::max(0.0, sum), 1e-4);
        }
        for (int m = 0; m < outside; ++m) {
          double sum = mix.values[static_cast<std::size_t>(inside * outside + m)];
          for (int c = 0; c < inside; ++c) {
            sum += mix.values[static_cast<std::size_t>(inside * m + c)] * in.at(c, x, y);
          }
          ASSERT_NEAR(mixture.at(m, x, y), sum, 1e-4);
        }
      }
    }
  });
}

TEST_F(NetLayers, refined_maps_are_a_mix_of_filtered_ones_and_what_came_in) {
  test::for_random_cases(40, [](test::Random& random) {
    take_vectors(any_vectors(random));
    const int channels = static_cast<int>(random.integer(1, 14));
    const Maps in = some_maps(channels, static_cast<int>(random.integer(1, 9)),
                              static_cast<int>(random.integer(1, 70)), random);
    File file;
    file.add(static_cast<std::size_t>((10 + channels + 1) * channels), random);
    Weights weights(file.bytes);
    Maps out = in;
    refine(out, weights);
    EXPECT_TRUE(weights.is_empty());
    Weights again(file.bytes);
    const Maps inner = filtered(in, again);
    const Maps mix = mixed(inner, channels, Clip::kNone, again);
    for (int c = 0; c < channels; ++c) {
      for (int y = 0; y < in.height; ++y) {
        for (int x = 0; x < in.width; ++x) {
          ASSERT_NEAR(out.at(c, x, y), std::max(0.0F, mix.at(c, x, y) + in.at(c, x, y)), 1e-4);
        }
      }
    }
  });
}

TEST_F(NetLayers, what_is_added_is_doubled) {
  test::Random random(5);
  const Maps small = some_maps(2, 3, 4, random);
  const Maps before = some_maps(2, 6, 8, random);
  Maps sum = before;
  add_doubled(small, sum);
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 8; ++x) {
      EXPECT_FLOAT_EQ(sum.at(1, x, y), before.at(1, x, y) + small.at(1, x / 2, y / 2));
    }
  }
}

TEST_F(NetLayers, half_floats_of_all_kinds_are_read) {
  const std::vector<std::uint8_t> bytes{0x00, 0x3C, 0x00, 0xC0, 0x01, 0x00, 0xFF, 0x7B, 0x00, 0x80};
  Weights weights(bytes);
  EXPECT_EQ(weights.take(5), (std::vector<float>{1, -2, 0x1p-24F, 65504, -0.0F}));
}

}  // namespace
}  // namespace sinew::vision
