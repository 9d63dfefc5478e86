#include "sinew/wire/cobs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::cobs {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes stream_of(const Bytes& frame) {
  const Stream stream = encode(frame);
  return {stream.begin(), stream.end()};
}

std::vector<Bytes> frames_in(Decoder& decoder, std::span<const std::uint8_t> stream) {
  std::vector<Bytes> frames;
  for (const std::uint8_t byte : stream) {
    if (const auto frame = decoder.push(byte)) frames.emplace_back(frame->begin(), frame->end());
  }
  return frames;
}

TEST(Cobs, the_examples_of_its_paper_come_out) {
  EXPECT_EQ(stream_of({0}), (Bytes{0, 1, 1, 0}));
  EXPECT_EQ(stream_of({0, 0}), (Bytes{0, 1, 1, 1, 0}));
  EXPECT_EQ(stream_of({0x11, 0x22, 0, 0x33}), (Bytes{0, 3, 0x11, 0x22, 2, 0x33, 0}));
  EXPECT_EQ(stream_of({0x11, 0, 0, 0}), (Bytes{0, 2, 0x11, 1, 1, 1, 0}));
}

TEST(Cobs, any_frame_comes_back_and_a_zero_stands_only_at_its_ends) {
  test::for_random_cases(2000, [](test::Random& random) {
    Bytes frame(static_cast<std::size_t>(random.integer(1, kFrameMax)));
    const double zeros = random.uniform(0, 1);
    for (auto& byte : frame) {
      byte = random.chance(zeros) ? 0 : static_cast<std::uint8_t>(random.integer(0, 255));
    }
    const Bytes stream = stream_of(frame);
    EXPECT_EQ(stream.size(), frame.size() + 3);
    EXPECT_EQ(std::count(stream.begin() + 1, stream.end() - 1, 0), 0);
    Decoder decoder;
    EXPECT_EQ(frames_in(decoder, stream), std::vector<Bytes>{frame});
    EXPECT_EQ(decoder.dropped(), 0U);
  });
}

TEST(Cobs, noise_before_a_frame_never_costs_the_frame) {
  test::for_random_cases(2000, [](test::Random& random) {
    Bytes noise(static_cast<std::size_t>(random.integer(0, 200)));
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random.integer(0, 255));
    const Bytes frame{1, 0, 2, 0, 0, 3, static_cast<std::uint8_t>(random.integer(0, 255))};
    Decoder decoder;
    frames_in(decoder, noise);
    const auto frames = frames_in(decoder, stream_of(frame));
    ASSERT_FALSE(frames.empty());
    EXPECT_EQ(frames.back(), frame);
  });
}

TEST(Cobs, a_frame_that_is_cut_short_or_too_long_is_dropped_and_counted) {
  Decoder decoder;
  EXPECT_TRUE(frames_in(decoder, Bytes{5, 1, 2, 0}).empty());
  EXPECT_EQ(decoder.dropped(), 1U);
  EXPECT_TRUE(frames_in(decoder, Bytes{0xFF, 1, 2, 0}).empty());
  EXPECT_EQ(decoder.dropped(), 2U);
  Bytes endless(1000, 1);
  endless.push_back(0);
  EXPECT_TRUE(frames_in(decoder, endless).empty());
  EXPECT_EQ(decoder.dropped(), 3U);
  EXPECT_EQ(frames_in(decoder, Bytes{0, 0, 0, 2, 9, 0}), (std::vector<Bytes>{{9}}));
}

TEST(Cobs, nothing_allocates) {
  const std::array<std::uint8_t, 16> frame{1, 0, 2};
  Decoder decoder;
  const test::AllocationCounter counter;
  for (const std::uint8_t byte : encode(frame)) decoder.push(byte);
  EXPECT_EQ(counter.count(), 0U);
}

}  // namespace
}  // namespace sinew::cobs
