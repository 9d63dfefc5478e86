#include "sinew/devices/axis_link/axis_link_driver_setup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "sinew/core/error_code.h"
#include "sinew/devices/axis/axis_device_controller.h"
#include "sinew/devices/axis/axis_device_setup_model.h"
#include "sinew/devices/axis/axis_device_unset.h"
#include "sinew/devices/axis_link/axis_link_device.h"
#include "sinew/wire/little_words.h"
#include "support/property.h"
#include "support/robots.h"

namespace sinew::axis_link {
namespace {

using namespace std::chrono_literals;

class Flash : public SetupMemory {
 public:
  std::span<const std::uint8_t> place(int which) const override { return places_[which]; }
  bool erase(int which) override {
    ++erased;
    places_[which].assign(1024, 0xFF);
    return works;
  }
  bool append(int which, std::span<const std::uint8_t> bytes) override {
    std::ranges::copy(bytes, places_[which].begin());
    return true;
  }
  int erased = 0;
  bool works = true;

 private:
  std::vector<std::uint8_t> places_[2]{std::vector<std::uint8_t>(1024, 0xFF),
                                       std::vector<std::uint8_t>(1024, 0xFF)};
};

/// A board with its flash, on a line that may lose frames.
struct Board {
  explicit Board(const std::optional<AxisSetup>& setup = std::nullopt) {
    EXPECT_TRUE(!setup || SetupStore(flash).keep(*setup));
    flash.erased = 0;
    boot();
  }
  void boot() {
    store.emplace(flash);
    AxisLinkNodeSettings settings = axis_link_node_settings(store->setup(), ++boots);
    settings.image = image;
    node.emplace(unset, settings, &*store);
    node->advance(now);
  }
  SetupLine line() {
    return {.exchange =
                [this](std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso) {
                  const auto mode = static_cast<Mode>(mosi[1] & 0x0F);
                  const bool lost = loses == mode || (random != nullptr && random->chance(0.2));
                  node->select(true);
                  for (std::size_t i = 0; i < mosi.size(); ++i) {
                    miso[i] = node->shift(lost ? 0 : mosi[i]);
                  }
                  node->select(false);
                  if (random != nullptr && random->chance(0.2)) miso[5] ^= 0x10;
                  if (mute) std::ranges::fill(miso, std::uint8_t{0xFF});
                  return true;
                },
            .wait =
                [this](Duration time) {
                  now += time;
                  node->advance(now);
                  if (node->restart_due()) boot();
                }};
  }
  std::optional<AxisSetup> kept() { return SetupStore(flash).setup(); }

  Flash flash;
  UnsetAxis unset;
  std::optional<BoardImage> image;  ///< from the next boot() on
  std::optional<SetupStore> store;
  std::optional<AxisLinkNode> node;
  Instant now{};
  std::uint16_t boots = 0;
  bool mute = false;
  std::optional<Mode> loses;  ///< no frame of this kind arrives
  test::Random* random = nullptr;
};

AxisSetup setup_of(std::size_t joint) {
  return axis_setup(test::robot("ar4-axis-link"), joint);
}

std::expected<SetupReport, Error> write(std::int8_t joint, Board& board) {
  return write_setup(encode_setup(setup_of(static_cast<std::size_t>(joint))), joint, board.line());
}
/// Which axis it was.
std::optional<int> was(const SetupReport& report) {
  const auto setup = decode_setup(report.before);
  return setup ? std::optional<int>(setup->axis_number) : std::nullopt;
}

TEST(AxisLinkSetup, makes_a_new_board_an_axis_and_leaves_one_that_is_it_alone) {
  Board board;
  const auto first = write(2, board);
  ASSERT_TRUE(first) << describe(first.error());
  EXPECT_TRUE(first->written);
  EXPECT_FALSE(was(*first));
  EXPECT_EQ(board.boots, 2);
  ASSERT_TRUE(board.kept());
  EXPECT_EQ(encode_setup(*board.kept()), encode_setup(setup_of(2)));
  const int erased = board.flash.erased;
  const auto again = write(2, board);
  ASSERT_TRUE(again) << describe(again.error());
  EXPECT_FALSE(again->written);
  EXPECT_EQ(was(*again), 2);
  EXPECT_EQ(board.flash.erased, erased);
  EXPECT_EQ(board.boots, 2);
}

TEST(AxisLinkSetup, takes_a_board_of_another_axis) {
  Board board(setup_of(4));
  const auto report = write(1, board);
  ASSERT_TRUE(report) << describe(report.error());
  EXPECT_TRUE(report->written);
  EXPECT_EQ(was(*report), 4);
  EXPECT_EQ(board.kept()->axis_number, 1);
}

TEST(AxisLinkSetup, comes_through_a_line_that_loses_and_damages_frames) {
  test::for_random_cases(200, [](test::Random& random) {
    Board board(setup_of(0));
    board.random = &random;
    const auto report = write(5, board);
    ASSERT_TRUE(report) << describe(report.error());
    ASSERT_TRUE(report->written);
    ASSERT_EQ(encode_setup(*board.kept()), encode_setup(setup_of(5)));
  });
}

/// What a host before had written and not stored, or could not store, is not kept.
TEST(AxisLinkSetup, takes_nothing_for_kept_that_was_only_written) {
  Board board(setup_of(4));
  const SetupBytes bytes = encode_setup(setup_of(2));
  for (std::size_t i = 0; i < kSetupWords; ++i) {
    ASSERT_TRUE(board.store->set_word(i, little_word(bytes, i)));
  }
  board.loses = Mode::kStoreSetup;
  EXPECT_EQ(write(2, board).error().code, ErrorCode::kUnexpectedReply);
  EXPECT_EQ(board.kept()->axis_number, 4);
  board.loses.reset();
  const auto report = write(2, board);
  ASSERT_TRUE(report) << describe(report.error());
  EXPECT_TRUE(report->written);
  EXPECT_EQ(was(*report), 4);
  EXPECT_EQ(board.kept()->axis_number, 2);
}

TEST(AxisLinkSetup, says_why_not) {
  Board mute;
  mute.mute = true;
  EXPECT_EQ(write(0, mute).error().code, ErrorCode::kDeviceSilent);
  Board worn_out;
  worn_out.flash.works = false;
  EXPECT_EQ(write(0, worn_out).error().code, ErrorCode::kBusy);
  EXPECT_EQ(write(3, worn_out).error().index, 3);
}

TEST(AxisLinkSetup, a_board_tells_its_image_over_a_line_that_loses_frames) {
  test::for_random_cases(200, [](test::Random& random) {
    Board board;
    board.image = BoardImage{image_text<24>("axis-stm32f401"), image_text<16>("1.2.3"), 55'000,
                             static_cast<std::uint32_t>(random.bits())};
    board.boot();
    board.random = &random;
    const auto image = read_board_image(0, board.line());
    ASSERT_TRUE(image.has_value());
    ASSERT_EQ(*image, board.image);
  });
}

TEST(AxisLinkSetup, a_board_that_knows_no_image_is_no_error_and_one_that_is_silent_is) {
  Board board;
  const auto none = read_board_image(2, board.line());
  ASSERT_TRUE(none.has_value());
  EXPECT_FALSE(none->has_value());
  board.mute = true;
  const auto silent = read_board_image(2, board.line());
  ASSERT_FALSE(silent.has_value());
  EXPECT_EQ(silent.error().code, ErrorCode::kDeviceSilent);
  EXPECT_EQ(silent.error().index, 2);
}

}  // namespace
}  // namespace sinew::axis_link
