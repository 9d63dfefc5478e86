#include "sinew/wire/board_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "sinew/wire/crc32c.h"
#include "support/board_image_bytes.h"
#include "support/property.h"

namespace sinew {
namespace {

/// An image, and what a flash has behind it.
std::vector<std::uint8_t> image_bytes(std::size_t place, std::size_t size, std::size_t behind = 0) {
  auto bytes = test::board_image_bytes("axis-stm32f103", "0.1.0", place, size);
  bytes.resize(size + behind, 0x5A);
  return bytes;
}

TEST(BoardImage, bytes_say_which_board_they_are_for_whatever_stands_behind_them) {
  for (const std::size_t place : {0U, 64U, 332U, 968U}) {
    const auto bytes = image_bytes(place, 2000, 500);
    const auto image = read_image(bytes);
    ASSERT_TRUE(image) << place;
    EXPECT_EQ(image->board_name(), "axis-stm32f103");
    EXPECT_EQ(image->version_text(), "0.1.0");
    EXPECT_EQ(image->size, 2000U);
    EXPECT_EQ(image->checksum, crc32c(std::span(bytes).first(2000)));
  }
}

TEST(BoardImage, bytes_that_are_no_whole_image_say_nothing) {
  EXPECT_FALSE(read_image({}));
  EXPECT_FALSE(read_image(std::vector<std::uint8_t>(5000, 0xFF)));
  EXPECT_FALSE(read_image(image_bytes(1024, 2000))) << "too far behind the begin";
  EXPECT_FALSE(read_image(image_bytes(66, 2000))) << "no place of a word";
  auto cut = image_bytes(64, 2000);
  cut.resize(1999);
  EXPECT_FALSE(read_image(cut));
  auto nameless = image_bytes(64, 2000);
  nameless[72] = 0;
  EXPECT_FALSE(read_image(nameless));
  auto backwards = image_bytes(64, 2000);
  backwards[64 + 55] = 0;
  EXPECT_FALSE(read_image(backwards));
}

TEST(BoardImage, hostile_bytes_are_no_image_or_one_that_can_be_told) {
  test::for_random_cases(20'000, [](test::Random& random) {
    auto bytes = image_bytes(64, 400, 100);
    for (std::int64_t i = random.integer(1, 6); i > 0; --i) {
      bytes[static_cast<std::size_t>(random.integer(60, 130))] =
          static_cast<std::uint8_t>(random.integer(0, 255));
    }
    const auto image = read_image(bytes);
    ASSERT_TRUE(!image || image->size <= bytes.size());
    ASSERT_TRUE(!image || decode_identity(encode_identity(*image)) == image);
  });
}

TEST(BoardImage, an_identity_without_a_name_or_with_other_characters_is_none) {
  const BoardImage image{image_text<24>("axis-stm32f401"), image_text<16>("1.2.3"), 5, 6};
  ImageIdentity bytes = encode_identity(image);
  EXPECT_EQ(decode_identity(bytes), image);
  std::fill_n(bytes.begin(), 4, std::uint8_t{0});
  EXPECT_FALSE(decode_identity(bytes)) << "a board without a name";
  std::fill_n(bytes.begin(), 4, std::uint8_t{0xFF});
  EXPECT_FALSE(decode_identity(bytes));
}

}  // namespace
}  // namespace sinew
