#include "sinew/vision/raw_frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "support/property.h"

namespace sinew::vision {
namespace {

using ByteList = std::vector<std::uint8_t>;
using Rgb = std::array<int, 3>;

Rgb pixel(const Picture& picture, int x, int y) {
  const std::uint8_t* at = picture.at(x, y);
  return {at[0], at[1], at[2]};
}

/// BT.601 in doubles.
Rgb reference(int luma, int u, int v, LumaRange range) {
  const bool full = range == LumaRange::kFull;
  const double y = full ? luma : (luma - 16) * 255.0 / 219;
  const double scale = full ? 1 : 255.0 / 224;
  const double r = y + 1.402 * scale * (v - 128);
  const double g = y - (0.344136 * (u - 128) + 0.714136 * (v - 128)) * scale;
  const double b = y + 1.772 * scale * (u - 128);
  const auto clip = [](double value) {
    return static_cast<int>(std::lround(std::clamp(value, 0.0, 255.0)));
  };
  return {clip(r), clip(g), clip(b)};
}

TEST(RawFrame, colours_of_yuyv_are_those_of_bt_601_in_both_ranges) {
  for (const LumaRange range : {LumaRange::kLimited, LumaRange::kFull}) {
    for (int luma = 0; luma < 256; luma += 15) {
      for (int u = 0; u < 256; u += 17) {
        for (int v = 0; v < 256; v += 17) {
          const auto y = static_cast<std::uint8_t>(luma);
          const ByteList bytes{y, static_cast<std::uint8_t>(u), y, static_cast<std::uint8_t>(v)};
          const auto picture = picture_from_yuyv(bytes, {2, 1, 4, range});
          ASSERT_TRUE(picture) << picture.error();
          const Rgb seen = pixel(*picture, 0, 0);
          const Rgb meant = reference(luma, u, v, range);
          for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(seen[c], meant[c], 1);
        }
      }
    }
  }
}

TEST(RawFrame, black_and_white_of_the_limited_range_are_16_and_235) {
  const ByteList bytes{16, 128, 235, 128};
  const auto limited = picture_from_yuyv(bytes, {2, 1, 4, LumaRange::kLimited});
  EXPECT_EQ(limited->rgb, (ByteList{0, 0, 0, 255, 255, 255}));
  const auto full = picture_from_yuyv(bytes, {2, 1, 4, LumaRange::kFull});
  EXPECT_EQ(full->rgb, (ByteList{16, 16, 16, 235, 235, 235}));
}

TEST(RawFrame, rows_that_a_driver_pads_are_read_from_their_beginnings) {
  // Two rows of two pixels in a stride of 10 bytes; the last row is not padded.
  ByteList bytes{50, 128, 60, 128, 99, 99, 99, 99, 99, 99, 70, 128, 80, 128};
  const auto picture = picture_from_yuyv(bytes, {2, 2, 10, LumaRange::kFull});
  ASSERT_TRUE(picture) << picture.error();
  EXPECT_EQ(pixel(*picture, 1, 0), (Rgb{60, 60, 60}));
  EXPECT_EQ(pixel(*picture, 0, 1), (Rgb{70, 70, 70}));
  bytes.pop_back();
  EXPECT_EQ(picture_from_yuyv(bytes, {2, 2, 10, LumaRange::kFull}).error(),
            "a frame cut short: 13 of 14 bytes");
  const ByteList grey{1, 2, 3, 9, 9, 4, 5, 6};
  EXPECT_EQ(picture_from_grey(grey, {3, 2, 5, LumaRange::kFull})->rgb,
            (ByteList{1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5, 5, 5, 6, 6, 6}));
}

TEST(RawFrame, odd_pixels_have_the_chroma_between_their_neighbours) {
  const ByteList bytes{100, 100, 100, 128, 100, 200, 100, 128};
  const auto picture = picture_from_yuyv(bytes, {4, 1, 8, LumaRange::kFull});
  EXPECT_EQ(pixel(*picture, 0, 0), reference(100, 100, 128, LumaRange::kFull));
  EXPECT_EQ(pixel(*picture, 1, 0), reference(100, 150, 128, LumaRange::kFull));
  EXPECT_EQ(pixel(*picture, 2, 0), reference(100, 200, 128, LumaRange::kFull));
  EXPECT_EQ(pixel(*picture, 3, 0), reference(100, 200, 128, LumaRange::kFull)) << "at the edge";
}

TEST(RawFrame, chroma_of_planes_lies_where_the_format_says) {
  // 4 x 2 pixels, u falls from 160 to 96 from left to right.
  const ByteList bytes{90, 90, 90, 90, 90, 90, 90, 90, 160, 96, 128, 128};
  const auto at = [&](Chroma chroma, int x) {
    const auto picture = picture_from_planes(bytes, {4, 2, chroma, LumaRange::kFull});
    EXPECT_TRUE(picture) << picture.error();
    return pixel(*picture, x, 0)[2];
  };
  const auto blue = [](int u) { return reference(90, u, 128, LumaRange::kFull)[2]; };
  EXPECT_EQ(at(Chroma::k420Left, 0), blue(160));
  EXPECT_EQ(at(Chroma::k420Left, 1), blue(128));
  EXPECT_EQ(at(Chroma::k420Left, 2), blue(96));
  EXPECT_EQ(at(Chroma::k420Centre, 0), blue(160));
  EXPECT_EQ(at(Chroma::k420Centre, 1), blue(144));
  EXPECT_EQ(at(Chroma::k420Centre, 2), blue(112));
  EXPECT_EQ(at(Chroma::k420Centre, 3), blue(96));
}

TEST(RawFrame, frames_in_planes_have_the_sizes_of_their_formats_with_odd_sides_too) {
  EXPECT_EQ(frame_bytes({4, 4, Chroma::k420Centre, {}}), 24U);
  EXPECT_EQ(frame_bytes({5, 3, Chroma::k420Left, {}}), 15U + 2 * 3 * 2);
  EXPECT_EQ(frame_bytes({5, 3, Chroma::k422, {}}), 15U + 2 * 3 * 3);
  EXPECT_EQ(frame_bytes({5, 3, Chroma::k444, {}}), 45U);
  EXPECT_EQ(frame_bytes({5, 3, Chroma::kNone, {}}), 15U);
  EXPECT_EQ(frame_bytes({0, 3, Chroma::kNone, {}}), std::nullopt);
  EXPECT_EQ(frame_bytes({100'000, 100'000, Chroma::kNone, {}}), std::nullopt);
  for (const Chroma chroma :
       {Chroma::k420Centre, Chroma::k420Left, Chroma::k422, Chroma::k444, Chroma::kNone}) {
    const PlaneLayout layout{5, 3, chroma, LumaRange::kFull};
    const ByteList bytes(*frame_bytes(layout), 128);
    const auto picture = picture_from_planes(bytes, layout);
    ASSERT_TRUE(picture) << picture.error();
    EXPECT_TRUE(std::ranges::all_of(picture->rgb, [](int c) { return c == 128; }));
    EXPECT_FALSE(picture_from_planes(std::span(bytes).first(bytes.size() - 1), layout));
  }
}

TEST(RawFrame, layouts_that_lie_are_refused) {
  const ByteList bytes(64, 0);
  EXPECT_EQ(picture_from_yuyv(bytes, {0, 4, 8, {}}).error(), "a frame without pixels");
  EXPECT_EQ(picture_from_yuyv(bytes, {-4, 4, 8, {}}).error(), "a frame without pixels");
  EXPECT_EQ(picture_from_yuyv(bytes, {8, 4, 8, {}}).error(), "rows of 16 bytes in a stride of 8");
  EXPECT_FALSE(picture_from_yuyv(bytes, {4, 4, ~std::size_t{0}, {}}));
  EXPECT_FALSE(picture_from_grey(bytes, {2'000'000'000, 2'000'000'000, 2'000'000'000, {}}));
  EXPECT_FALSE(picture_from_grey(bytes, {4, -1, 4, {}}));
}

TEST(RawFrame, random_layouts_over_random_bytes_read_no_byte_beyond_them) {
  test::for_random_cases(20'000, [](test::Random& random) {
    ByteList bytes(static_cast<std::size_t>(random.integer(0, 200)));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    const auto width = static_cast<int>(random.integer(-1, 20));
    const auto height = static_cast<int>(random.integer(-1, 20));
    const auto stride = static_cast<std::size_t>(random.integer(0, 50));
    const auto range = random.chance(0.5) ? LumaRange::kFull : LumaRange::kLimited;
    const FrameLayout layout{width, height, stride, range};
    const PlaneLayout planes{width, height, static_cast<Chroma>(random.integer(0, 4)), range};
    for (const auto& picture : {picture_from_yuyv(bytes, layout), picture_from_grey(bytes, layout),
                                picture_from_planes(bytes, planes)}) {
      if (picture) {
        ASSERT_EQ(picture->rgb.size(), 3U * static_cast<std::size_t>(width * height));
      } else {
        ASSERT_FALSE(picture.error().empty());
      }
    }
  });
}

}  // namespace
}  // namespace sinew::vision
