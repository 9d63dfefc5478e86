#include "sinew/sim/spi_faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <vector>

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;

/// Answers each byte with itself, and notes what befell it and when.
class Echo : public SpiMachine {
 public:
  void advance(Instant now) override { now_ = now; }
  std::optional<Instant> next_event() const override { return std::nullopt; }
  Truth truth() const override { return {}; }
  void disturb(const Disturbance& what) override { blows_.emplace_back(now_, what.value); }
  void select(std::uint8_t mask, Instant now) override {
    now_ = now;
    selects_.push_back(mask);
  }
  void shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
             std::uint32_t /*clock_hz*/, Instant now) override {
    now_ = now;
    heard_.insert(heard_.end(), mosi.begin(), mosi.end());
    std::ranges::copy(mosi, miso.begin());
  }
  bool ready_pin(std::size_t /*axis*/) const override { return true; }

  Instant now_{};
  std::vector<std::uint8_t> heard_;
  std::vector<std::uint8_t> selects_;
  std::vector<std::pair<Instant, double>> blows_;
};

std::vector<std::uint8_t> through(SpiFaults& faults, std::size_t size, Instant now) {
  const std::vector<std::uint8_t> mosi(size, 0x5A);
  std::vector<std::uint8_t> miso(size);
  faults.shift(mosi, miso, 500'000, now);
  return miso;
}

std::unique_ptr<SpiFaults> faulty(Echo& boards, const char* text) {
  auto faults = SpiFaults::create(boards, *parse_faults(text));
  EXPECT_TRUE(faults);
  return std::move(*faults);
}

TEST(SpiFaults, without_faults_it_is_a_wire) {
  Echo boards;
  const auto faults = faulty(boards, "supply=24V@1000s");
  EXPECT_EQ(through(*faults, 200, Instant{}), std::vector<std::uint8_t>(200, 0x5A));
  EXPECT_EQ(faults->flipped(), 0U);
}

TEST(SpiFaults, flips_one_bit_of_some_bytes_in_the_direction_that_was_named) {
  Echo boards;
  const auto faults = faulty(boards, "flip=0.1:to-device,seed=3");
  const auto miso = through(*faults, 20'000, Instant{});
  std::size_t flipped = 0;
  for (const std::uint8_t byte : boards.heard_) {
    const int bits = std::popcount(static_cast<unsigned>(byte ^ 0x5A));
    EXPECT_LE(bits, 1);
    flipped += static_cast<std::size_t>(bits);
  }
  EXPECT_EQ(flipped, faults->flipped());
  EXPECT_NEAR(static_cast<double>(flipped), 2000, 200);
  EXPECT_EQ(miso, boards.heard_) << "the way back is clean";
}

TEST(SpiFaults, in_a_cut_both_sides_hear_ones_and_afterwards_all_is_well) {
  Echo boards;
  const auto faults = faulty(boards, "cut@10ms:5ms");
  EXPECT_EQ(through(*faults, 2, Instant{} + 1ms)[0], 0x5A);
  // Moments count from the first advance, which was at 1 ms.
  EXPECT_EQ(through(*faults, 2, Instant{} + 12ms)[0], 0xFF);
  EXPECT_EQ(boards.heard_.back(), 0xFF);
  EXPECT_EQ(through(*faults, 2, Instant{} + 17ms)[0], 0x5A);
}

TEST(SpiFaults, blows_fall_at_their_moments_in_their_order) {
  Echo boards;
  const auto faults = faulty(boards, "supply=24V@30ms,supply=9V@20ms");
  faults->advance(Instant{});
  faults->advance(Instant{} + 25ms);
  ASSERT_EQ(boards.blows_.size(), 1U);
  EXPECT_EQ(boards.blows_[0].first, Instant{} + 20ms);
  EXPECT_EQ(boards.blows_[0].second, 9);
  faults->select(1, Instant{} + 40ms);
  ASSERT_EQ(boards.blows_.size(), 2U);
  EXPECT_EQ(boards.blows_[1].second, 24);
}

TEST(SpiFaults, a_lost_transfer_never_reaches_the_boards_and_the_host_hears_ones) {
  Echo boards;
  const auto faults = faulty(boards, "drop@10ms");
  EXPECT_EQ(through(*faults, 4, Instant{}), std::vector<std::uint8_t>(4, 0x5A));
  EXPECT_EQ(through(*faults, 4, Instant{} + 10ms), std::vector<std::uint8_t>(4, 0xFF));
  EXPECT_EQ(boards.heard_.size(), 4U);
  EXPECT_EQ(through(*faults, 4, Instant{} + 11ms), std::vector<std::uint8_t>(4, 0x5A)) << "once";
  EXPECT_EQ(faults->dropped(), 1U);
}

TEST(SpiFaults, a_doubled_transfer_reaches_the_boards_twice_with_its_own_chip_select) {
  Echo boards;
  const auto faults = faulty(boards, "duplicate@0s");
  faults->select(4, Instant{});
  (void)through(*faults, 100, Instant{});
  EXPECT_EQ(boards.heard_.size(), 200U);
  EXPECT_EQ(boards.selects_, (std::vector<std::uint8_t>{4, 0, 4}));
  (void)through(*faults, 100, Instant{} + 1ms);
  EXPECT_EQ(boards.heard_.size(), 300U);
  EXPECT_EQ(faults->duplicated(), 1U);
}

TEST(SpiFaults, transfers_are_lost_and_doubled_as_often_as_their_chances_say) {
  Echo boards;
  const auto faults = faulty(boards, "drop=0.1,duplicate=0.2@0s..5s,seed=9");
  for (int i = 0; i < 10'000; ++i) (void)through(*faults, 1, Instant{} + 1ms * i);
  EXPECT_NEAR(static_cast<double>(faults->dropped()), 1000, 120);
  EXPECT_NEAR(static_cast<double>(faults->duplicated()), 0.9 * 1000, 120) << "5 s of 10 only";
  EXPECT_EQ(boards.heard_.size(), 10'000 - faults->dropped() + faults->duplicated());
}

TEST(SpiFaults, a_flip_at_a_moment_turns_one_bit_once) {
  Echo boards;
  const auto faults = faulty(boards, "flip@5ms:to-host");
  EXPECT_EQ(through(*faults, 100, Instant{}), std::vector<std::uint8_t>(100, 0x5A));
  const auto miso = through(*faults, 100, Instant{} + 6ms);
  EXPECT_EQ(std::ranges::count(miso, 0x5A), 99);
  EXPECT_EQ(faults->flipped(), 1U);
  EXPECT_EQ(std::ranges::count(boards.heard_, 0x5A), 200) << "the way there is clean";
  EXPECT_EQ(through(*faults, 100, Instant{} + 7ms), std::vector<std::uint8_t>(100, 0x5A));
}

TEST(SpiFaults, what_cannot_befall_a_clocked_wire_is_refused) {
  Echo boards;
  for (const char* text : {"delay=0.1:5ms", "delay@3s:5ms", "delay=0.1:5ms@1s..2s"}) {
    const auto faults = SpiFaults::create(boards, *parse_faults(text));
    ASSERT_FALSE(faults) << text;
    EXPECT_TRUE(faults.error().starts_with("delay cannot befall SPI")) << faults.error();
  }
  for (const char* text : {"drop=0.1:to-host", "duplicate@3s:to-device"}) {
    const auto faults = SpiFaults::create(boards, *parse_faults(text));
    ASSERT_FALSE(faults) << text;
    EXPECT_TRUE(faults.error().starts_with("drop and duplicate have no direction on SPI"));
  }
}

}  // namespace
}  // namespace sinew::sim
