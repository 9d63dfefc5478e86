#include "sinew/vision/camera_jpeg.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "sinew/vision/picture_file.h"
#include "support/property.h"
#include "support/video_files.h"

namespace sinew::vision {
namespace {

using test::ByteList;

Picture gradient() {
  Picture picture = black_picture(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      picture.at(x, y)[0] = static_cast<std::uint8_t>(4 * x);
      picture.at(x, y)[1] = static_cast<std::uint8_t>(5 * y);
      picture.at(x, y)[2] = static_cast<std::uint8_t>((x * y) % 256);
    }
  }
  return picture;
}

TEST(CameraJpeg, frame_without_huffman_tables_is_the_same_picture) {
  // The tables of annex K are what an encoder writes that does not optimise its own.
  const ByteList whole = encode_jpeg(gradient());
  const ByteList bare = test::without_huffman_tables(whole);
  ASSERT_LT(bare.size() + 300, whole.size());
  const auto a = decode_camera_jpeg(whole);
  const auto b = decode_camera_jpeg(bare);
  ASSERT_TRUE(a) << a.error();
  ASSERT_TRUE(b) << b.error();
  EXPECT_EQ(a->rgb, b->rgb);
}

TEST(CameraJpeg, padding_behind_the_end_is_of_no_account) {
  ByteList frame = encode_jpeg(gradient());
  const auto meant = decode_camera_jpeg(frame);
  frame.resize(frame.size() + 5000);
  const auto seen = decode_camera_jpeg(frame);
  ASSERT_TRUE(seen) << seen.error();
  EXPECT_EQ(seen->rgb, meant->rgb);
}

TEST(CameraJpeg, frame_that_lost_its_end_is_refused_at_every_length) {
  const ByteList frame = encode_jpeg(gradient());
  for (std::size_t size = 0; size + 2 < frame.size(); size += 7) {
    EXPECT_FALSE(decode_camera_jpeg(std::span(frame).first(size))) << size;
  }
}

TEST(CameraJpeg, frame_that_lost_bytes_before_its_end_is_refused) {
  // As a lost USB packet leaves it: the scan ends early, and the end mark is there.
  ByteList frame = encode_jpeg(gradient());
  frame.erase(frame.end() - 500, frame.end() - 2);
  const auto picture = decode_camera_jpeg(frame);
  ASSERT_FALSE(picture);
  EXPECT_NE(picture.error().find("a JPEG frame that is damaged: "), std::string::npos);
}

TEST(CameraJpeg, what_is_no_jpeg_is_refused) {
  EXPECT_EQ(decode_camera_jpeg({}).error(), "a frame that is no JPEG");
  EXPECT_EQ(decode_camera_jpeg(encode_png(gradient())).error(), "a frame that is no JPEG");
  EXPECT_FALSE(decode_camera_jpeg(ByteList{0xFF, 0xD8, 0xFF, 0xD9}));
}

TEST(CameraJpeg, spoiled_frames_are_refused_or_read_and_never_more) {
  const ByteList whole = encode_jpeg(gradient());
  const ByteList bare = test::without_huffman_tables(whole);
  test::for_random_cases(2'000, [&](test::Random& random) {
    ByteList frame = random.chance(0.5) ? whole : bare;
    for (int i = 0; i < 10; ++i) {
      const auto at = static_cast<std::size_t>(random.bits() % frame.size());
      frame[at] = static_cast<std::uint8_t>(random.bits());
    }
    if (random.chance(0.3)) frame.resize(static_cast<std::size_t>(random.bits() % frame.size()));
    const auto picture = decode_camera_jpeg(frame);
    if (picture) {
      EXPECT_EQ(picture->rgb.size(), 3U * static_cast<std::size_t>(picture->width) *
                                         static_cast<std::size_t>(picture->height));
    } else {
      EXPECT_FALSE(picture.error().empty());
    }
  });
}

}  // namespace
}  // namespace sinew::vision
