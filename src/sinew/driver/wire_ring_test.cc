#include "sinew/driver/wire_ring.h"

#include <gtest/gtest.h>

#include <thread>

#include "support/allocation_guard.h"

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

Instant at_ms(int ms) {
  return Instant{std::chrono::milliseconds(ms)};
}

TEST(WireRing, gives_back_what_passed_in_its_order_with_its_time_its_way_and_its_axis) {
  WireRing ring;
  ring.add(WireWay::kToDevice, Bytes{1, 2, 3}, at_ms(5));
  ring.add(WireWay::kToHost, Bytes{0xFF}, at_ms(7), 0x20);
  WireRing::Place place = 0;
  std::vector<WirePiece> pieces;
  EXPECT_EQ(ring.read(place, pieces), 0U);
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_EQ(pieces[0].at, at_ms(5));
  EXPECT_EQ(pieces[0].way, WireWay::kToDevice);
  EXPECT_EQ(pieces[0].bytes, (Bytes{1, 2, 3}));
  EXPECT_EQ(pieces[1].at, at_ms(7));
  EXPECT_EQ(pieces[1].way, WireWay::kToHost);
  EXPECT_EQ(pieces[1].select, 0x20);
  EXPECT_EQ(pieces[1].bytes, Bytes{0xFF});
  pieces.clear();
  EXPECT_EQ(ring.read(place, pieces), 0U);
  EXPECT_TRUE(pieces.empty()) << "once";
}

TEST(WireRing, a_long_piece_is_one_piece_again) {
  WireRing ring;
  for (const std::size_t size : {31, 32, 33, 64, 65, 512}) {
    Bytes bytes;
    for (std::size_t i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(i * 7));
    ring.add(WireWay::kToHost, bytes, at_ms(1));
    ring.add(WireWay::kToHost, Bytes{42}, at_ms(2));
    WireRing fresh;
    fresh.add(WireWay::kToHost, bytes, at_ms(1));
    fresh.add(WireWay::kToHost, Bytes{42}, at_ms(2));
    WireRing::Place place = 0;
    std::vector<WirePiece> pieces;
    fresh.read(place, pieces);
    ASSERT_EQ(pieces.size(), 2U) << size;
    EXPECT_EQ(pieces[0].bytes, bytes);
    EXPECT_EQ(pieces[1].bytes, Bytes{42});
  }
}

TEST(WireRing, says_how_much_a_slow_reader_has_lost_and_keeps_the_rest) {
  WireRing ring;
  constexpr int kAll = static_cast<int>(WireRing::kSlots) + 100;
  for (int i = 0; i < kAll; ++i) ring.add(WireWay::kToDevice, Bytes{7}, at_ms(i));
  WireRing::Place place = 0;
  std::vector<WirePiece> pieces;
  EXPECT_EQ(ring.read(place, pieces), 100U);
  ASSERT_EQ(pieces.size(), WireRing::kSlots);
  EXPECT_EQ(pieces.front().at, at_ms(100));
  EXPECT_EQ(pieces.back().at, at_ms(kAll - 1));
}

TEST(WireRing, writing_takes_nothing_from_the_heap) {
  WireRing ring;
  const Bytes bytes(100, 1);
  const sinew::test::AllocationCounter counter;
  for (int i = 0; i < 10'000; ++i) ring.add(WireWay::kToDevice, bytes, at_ms(i));
  EXPECT_EQ(counter.count(), 0U);
}

/// A writer as fast as it can, overtaking its reader again and again: whatever is read is a piece
/// as it was written, none twice, and those lost are counted.
TEST(WireRing, a_reader_beside_the_writer_sees_whole_pieces_only) {
  WireRing ring;
  constexpr std::uint32_t kPieces = 300'000;
  std::thread writer([&] {
    for (std::uint32_t i = 0; i < kPieces; ++i) {
      Bytes bytes;
      for (std::uint32_t k = 0; k < 16; ++k) {
        bytes.push_back(static_cast<std::uint8_t>((i + k) >> (8 * (k % 4))));
      }
      ring.add(i % 2 == 0 ? WireWay::kToDevice : WireWay::kToHost, bytes, Instant{Duration{i}});
    }
  });
  WireRing::Place place = 0;
  std::vector<WirePiece> pieces;
  std::uint64_t lost = 0;
  std::uint64_t seen = 0;
  std::int64_t last = -1;
  while (seen + lost < kPieces) {
    pieces.clear();
    lost += ring.read(place, pieces);
    for (const WirePiece& piece : pieces) {
      const auto i = piece.at.time_since_epoch().count();
      ASSERT_GT(i, last);
      last = i;
      ASSERT_EQ(piece.way, i % 2 == 0 ? WireWay::kToDevice : WireWay::kToHost);
      ASSERT_EQ(piece.bytes.size(), 16U);
      for (std::uint32_t k = 0; k < 16; ++k) {
        const auto wanted = (static_cast<std::uint32_t>(i) + k) >> (8 * (k % 4));
        ASSERT_EQ(piece.bytes[k], static_cast<std::uint8_t>(wanted));
      }
    }
    seen += pieces.size();
  }
  writer.join();
  EXPECT_EQ(seen + lost, kPieces);
}

}  // namespace
}  // namespace sinew
