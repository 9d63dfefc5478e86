#include "sinew/vision/picture_file.h"

#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>

#include "sinew/vision/exif.h"
#include "support/property.h"

namespace sinew::vision {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Four plain quarters, so that a turned picture differs from an upright one.
Picture quarters(int width, int height) {
  Picture picture = black_picture(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool right = 2 * x >= width;
      const bool low = 2 * y >= height;
      std::uint8_t* pixel = picture.at(x, y);
      pixel[0] = right ? 220 : 30;
      pixel[1] = low ? 200 : 40;
      pixel[2] = right == low ? 180 : 60;
    }
  }
  return picture;
}

Bytes jpeg_of(const Picture& picture, int format, int sampling) {
  Bytes pixels = picture.rgb;
  if (format == TJPF_CMYK) {
    pixels.clear();
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
      pixels.push_back(picture.rgb[i]);
      if (i % 3 == 2) pixels.push_back(255);
    }
  }
  tjhandle jpeg = tjInitCompress();
  unsigned char* out = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(jpeg, pixels.data(), picture.width, 0, picture.height, format, &out, &size,
                        sampling, 95, 0),
            0);
  Bytes file(out, out + size);
  tjFree(out);
  tjDestroy(jpeg);
  return file;
}

/// Behind the first two bytes of a JPEG.
Bytes with_orientation(Bytes file, std::uint8_t orientation, bool little) {
  Bytes tiff = little ? Bytes{'I', 'I', 42, 0, 8, 0,           0, 0, 1, 0, 0x12, 1, 3,
                              0,   1,   0,  0, 0, orientation, 0, 0, 0, 0, 0,    0, 0}
                      : Bytes{'M', 'M', 0, 42, 0, 0, 0,           8, 0, 1, 1, 0x12, 0,
                              3,   0,   0, 0,  1, 0, orientation, 0, 0, 0, 0, 0,    0};
  Bytes segment{0xFF, 0xE1, 0, static_cast<std::uint8_t>(8 + tiff.size()), 'E', 'x', 'i',
                'f',  0,    0};
  segment.insert(segment.end(), tiff.begin(), tiff.end());
  file.insert(file.begin() + 2, segment.begin(), segment.end());
  return file;
}

/// The largest difference of a channel, in the middles of the quarters.
int worst(const Picture& seen, const Picture& meant) {
  EXPECT_EQ(seen.width, meant.width);
  EXPECT_EQ(seen.height, meant.height);
  int most = 0;
  for (const int x : {meant.width / 4, 3 * meant.width / 4}) {
    for (const int y : {meant.height / 4, 3 * meant.height / 4}) {
      for (std::size_t c = 0; c < 3; ++c) {
        most = std::max(most, std::abs(seen.at(x, y)[c] - meant.at(x, y)[c]));
      }
    }
  }
  return most;
}

std::string sentence_of(const Bytes& file) {
  const auto picture = decode_picture(file);
  return picture ? "fine" : picture.error();
}

TEST(PictureFile, png_comes_back_as_it_was) {
  const Picture picture = quarters(31, 17);
  const auto back = decode_picture(encode_png(picture));
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ(back->width, 31);
  EXPECT_EQ(back->rgb, picture.rgb);
  EXPECT_EQ(decode_picture(encode_png(black_picture(1, 1)))->rgb, Bytes(3));
}

TEST(PictureFile, jpeg_comes_back_nearly_as_it_was) {
  const Picture picture = quarters(64, 48);
  const auto back = decode_picture(encode_jpeg(picture));
  ASSERT_TRUE(back) << back.error();
  ASSERT_EQ(back->rgb.size(), picture.rgb.size());
  for (const int x : {8, 56}) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(back->at(x, 8)[c], picture.at(x, 8)[c], 6);
  }
  EXPECT_TRUE(decode_picture(encode_jpeg(black_picture(1, 1))));
}

TEST(PictureFile, png_of_16_bits_with_alpha_is_white_where_nothing_is) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = 2;
  image.height = 1;
  image.format = PNG_FORMAT_LINEAR_RGB_ALPHA;
  const std::array<std::uint16_t, 8> pixels{65535, 0, 0, 65535, 0, 0, 0, 0};
  Bytes file(PNG_IMAGE_PNG_SIZE_MAX(image));
  png_alloc_size_t size = file.size();
  ASSERT_TRUE(png_image_write_to_memory(&image, file.data(), &size, 0, pixels.data(), 0, nullptr));
  file.resize(size);
  const auto picture = decode_picture(file);
  ASSERT_TRUE(picture) << picture.error();
  EXPECT_EQ(picture->rgb, (Bytes{255, 0, 0, 255, 255, 255}));
}

TEST(PictureFile, jpeg_of_every_kind_shows_the_same) {
  const Picture picture = quarters(64, 48);
  for (const int sampling : {TJSAMP_444, TJSAMP_420}) {
    const auto back = decode_picture(jpeg_of(picture, TJPF_RGB, sampling));
    ASSERT_TRUE(back) << back.error();
    EXPECT_LE(worst(*back, picture), 6);
  }
  const auto inks = decode_picture(jpeg_of(picture, TJPF_CMYK, TJSAMP_444));
  ASSERT_TRUE(inks) << inks.error();
  EXPECT_LE(worst(*inks, picture), 8);
  const auto grey = decode_picture(jpeg_of(picture, TJPF_RGB, TJSAMP_GRAY));
  ASSERT_TRUE(grey) << grey.error();
  EXPECT_EQ(grey->at(5, 5)[0], grey->at(5, 5)[2]);
}

TEST(PictureFile, photo_that_was_taken_aslant_stands_upright) {
  const Picture upright_one = quarters(64, 48);
  for (std::uint8_t orientation = 1; orientation <= 8; ++orientation) {
    // As the camera stored it: turned back by what the tag says.
    constexpr std::array<int, 8> kBack{1, 2, 3, 4, 5, 8, 7, 6};
    const Picture stored = upright(upright_one, kBack[orientation - 1U]);
    const Bytes plain = jpeg_of(stored, TJPF_RGB, TJSAMP_444);
    for (const bool little : {true, false}) {
      const auto seen = decode_picture(with_orientation(plain, orientation, little));
      ASSERT_TRUE(seen) << seen.error();
      EXPECT_LE(worst(*seen, upright_one), 8) << int{orientation};
    }
  }
  EXPECT_EQ(exif_orientation(Bytes{'I', 'I', 42, 0, 255, 255, 255, 255}), 1);
  EXPECT_EQ(exif_orientation({}), 1);
}

TEST(PictureFile, what_is_no_picture_is_said_in_a_sentence) {
  EXPECT_EQ(sentence_of({}), "an empty file");
  EXPECT_EQ(sentence_of({'h', 'e', 'l', 'l', 'o'}), "no picture; JPEG and PNG files are read");
  EXPECT_EQ(sentence_of({'B', 'M', 0, 0}),
            "a picture of the kind BMP; JPEG and PNG files are read");
  EXPECT_EQ(sentence_of({0, 0, 0, 24, 'f', 't', 'y', 'p', 'h', 'e', 'i', 'c'}),
            "a picture of the kind HEIC; JPEG and PNG files are read");
}

TEST(PictureFile, half_a_picture_is_none_and_one_of_a_gigapixel_is_not_made) {
  Bytes jpeg = jpeg_of(quarters(200, 200), TJPF_RGB, TJSAMP_444);
  Bytes half(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(jpeg.size() / 2));
  EXPECT_NE(sentence_of(half).find("a JPEG file that is broken: "), std::string::npos)
      << sentence_of(half);
  // The frame header: height and width stand behind its length and precision.
  for (std::size_t at = 2; at + 9 < jpeg.size(); ++at) {
    if (jpeg[at] != 0xFF || jpeg[at + 1] != 0xC0) continue;
    for (std::size_t i = 5; i <= 8; ++i) jpeg[at + i] = i % 2 == 1 ? 0xFF : 0xDC;
    break;
  }
  EXPECT_EQ(sentence_of(jpeg), "a picture of 65500 x 65500 pixels; at most 64 million are read");
  Bytes png = encode_png(quarters(40, 40));
  png.resize(png.size() / 2);
  EXPECT_NE(sentence_of(png).find("a PNG file that is broken: "), std::string::npos);
}

TEST(PictureFile, spoiled_files_are_refused_or_read_and_never_more) {
  const std::array files{jpeg_of(quarters(40, 24), TJPF_RGB, TJSAMP_420),
                         with_orientation(jpeg_of(quarters(24, 40), TJPF_RGB, TJSAMP_444), 6, true),
                         encode_png(quarters(40, 24))};
  test::for_random_cases(1000, [&](test::Random& random) {
    Bytes file = files[static_cast<std::size_t>(random.integer(0, 2))];
    for (std::int64_t i = random.integer(1, 6); i > 0; --i) {
      const auto at =
          static_cast<std::size_t>(random.integer(0, static_cast<std::int64_t>(file.size()) - 1));
      file[at] = static_cast<std::uint8_t>(random.integer(0, 255));
    }
    if (random.chance(0.3)) file.resize(static_cast<std::size_t>(random.integer(0, 300)));
    const auto picture = decode_picture(file);
    if (!picture) {
      EXPECT_FALSE(picture.error().empty());
      return;
    }
    EXPECT_EQ(picture->rgb.size(), 3U * static_cast<std::size_t>(picture->width) *
                                       static_cast<std::size_t>(picture->height));
  });
}

}  // namespace
}  // namespace sinew::vision
