#include "sinew/wire/board_image.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sinew/wire/crc32c.h"
#include "support/property.h"

namespace sinew {
namespace {

/// An image of a board, and what a flash has behind it.
std::vector<std::uint8_t> image_bytes(std::size_t place, std::size_t size, std::size_t behind = 0) {
  std::vector<std::uint8_t> bytes(size + behind, 0x5A);
  const auto put = [&](std::size_t at, std::string_view text, std::size_t room) {
    for (std::size_t i = 0; i < room; ++i) {
      bytes[at + i] = i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0;
    }
  };
  put(place, "SINEW-FW", 8);
  put(place + 8, "axis-stm32f103", 24);
  put(place + 32, "0.1.0", 16);
  const std::uint32_t begin = 0x08000000, end = begin + static_cast<std::uint32_t>(size);
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[place + 48 + i] = static_cast<std::uint8_t>(begin >> 8 * i);
    bytes[place + 52 + i] = static_cast<std::uint8_t>(end >> 8 * i);
  }
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
    ASSERT_TRUE(!image || image_of(words_of(*image)) == image);
  });
}

TEST(BoardImage, words_that_are_no_text_are_none) {
  const BoardImage image{image_text<24>("axis-stm32f401"), image_text<16>("1.2.3"), 5, 6};
  ImageWords words = words_of(image);
  EXPECT_EQ(image_of(words), image);
  words[0] = 0;
  EXPECT_FALSE(image_of(words)) << "a board without a name";
  words[0] = 0xFFFFFFFF;
  EXPECT_FALSE(image_of(words));
}

}  // namespace
}  // namespace sinew
