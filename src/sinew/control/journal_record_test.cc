#include "sinew/control/journal_record.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>

#include "sinew/wire/crc32c.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew {
namespace {

JournalRecord sample() {
  JournalRecord record;
  record.kind = JournalKind::kIntent;
  record.sequence = 0x0102030405060708;
  record.generation = 0x11121314;
  record.owner = {0x21222324, 0x31323334};
  record.time = {Instant{Duration{-2}}, 0x4142434445464748};
  record.positions = {{PositionQuality::kUncertain, 1.5, -2.0, 3.0},
                      {PositionQuality::kLost, 0, 0, 0},
                      {PositionQuality::kMeasured, 0.25, 0.25, 0.25}};
  return record;
}

std::span<const std::uint8_t> from(const JournalRecordBytes& bytes, std::size_t at,
                                   std::size_t size) {
  return std::span(bytes).subspan(at, size);
}

/// With the checksum that it needs.
JournalRecordBytes sealed(JournalRecordBytes bytes) {
  const std::uint32_t crc = crc32c(std::span(bytes).first<252>());
  for (std::size_t k = 0; k < 4; ++k) bytes[252 + k] = static_cast<std::uint8_t>(crc >> (8 * k));
  return bytes;
}

bool equal(std::span<const std::uint8_t> a, const std::vector<std::uint8_t>& b) {
  return std::ranges::equal(a, b);
}

TEST(JournalRecord, bytes_stand_where_the_table_says) {
  const JournalRecordBytes bytes = encode(sample(), {0x5152535455565758, 0x61626364});
  EXPECT_TRUE(equal(from(bytes, 0, 8), {0x53, 0x4E, 0x4A, 0x4C, 3, 5, 3, 0}));
  EXPECT_TRUE(equal(from(bytes, 8, 8), {8, 7, 6, 5, 4, 3, 2, 1}));
  EXPECT_TRUE(equal(from(bytes, 16, 8), {0x14, 0x13, 0x12, 0x11, 0x01, 0x03, 0, 0}));
  EXPECT_TRUE(equal(from(bytes, 24, 8), {0x24, 0x23, 0x22, 0x21, 0x34, 0x33, 0x32, 0x31}));
  EXPECT_TRUE(equal(from(bytes, 32, 8), {0xFE, 255, 255, 255, 255, 255, 255, 255}));
  EXPECT_TRUE(equal(from(bytes, 40, 8), {0x48, 0x47, 0x46, 0x45, 0x44, 0x43, 0x42, 0x41}));
  EXPECT_TRUE(equal(from(bytes, 48, 8), {0x58, 0x57, 0x56, 0x55, 0x54, 0x53, 0x52, 0x51}));
  EXPECT_TRUE(equal(from(bytes, 56, 8), {0, 0, 0, 0, 0, 0, 0xF8, 0x3F}));   // 1.5
  EXPECT_TRUE(equal(from(bytes, 64, 8), {0, 0, 0, 0, 0, 0, 0x00, 0xC0}));   // -2
  EXPECT_TRUE(equal(from(bytes, 72, 8), {0, 0, 0, 0, 0, 0, 0x08, 0x40}));   // 3
  EXPECT_TRUE(equal(from(bytes, 80, 24), std::vector<std::uint8_t>(24)));   // lost
  EXPECT_TRUE(equal(from(bytes, 104, 8), {0, 0, 0, 0, 0, 0, 0xD0, 0x3F}));  // 0.25
  EXPECT_TRUE(equal(from(bytes, 128, 120), std::vector<std::uint8_t>(120)));
  EXPECT_TRUE(equal(from(bytes, 248, 4), {0x64, 0x63, 0x62, 0x61}));
  EXPECT_EQ(checksum_of(bytes), crc32c(from(bytes, 0, 252)));
}

TEST(JournalRecord, any_record_comes_back_as_it_was_and_no_flipped_bit_is_accepted) {
  test::for_random_cases(200, [](test::Random& random) {
    JournalRecord record = sample();
    record.kind = static_cast<JournalKind>(random.integer(1, 8));
    record.cause = static_cast<JournalCause>(random.integer(0, 4));
    record.sequence = random.bits() | 1;
    record.positions.clear();
    for (std::int64_t k = random.integer(1, 8); k > 0; --k) {
      const double lower = random.uniform(-10, 10);
      const double upper = lower + random.uniform(0, 1);
      const double q = random.chance(0.5) ? lower : upper;
      if (random.chance(0.2)) {
        record.positions.push_back({});
      } else {
        record.positions.push_back(
            {static_cast<PositionQuality>(random.integer(1, 3)), q, lower, upper});
      }
    }
    // Up to six joints have room for what ties their counts to them; lost ones keep it too.
    const bool room = record.positions.size() <= 6;
    for (JointPosition& joint : record.positions) {
      if (random.chance(0.5)) joint.count_zero = random.uniform(-9, 9);
    }
    const JournalSeal seal{random.bits(), static_cast<std::uint32_t>(random.bits())};
    const JournalRecordBytes bytes = encode(record, seal);
    const auto back = decode_journal_record(bytes);
    ASSERT_TRUE(back);
    EXPECT_EQ(encode(back->record, back->seal), bytes);
    EXPECT_EQ(back->record.sequence, record.sequence);
    EXPECT_EQ(back->record.positions.size(), record.positions.size());
    EXPECT_EQ(back->checksum, checksum_of(bytes));
    for (std::size_t k = 0; k < record.positions.size(); ++k) {
      const auto& zero = record.positions[k].count_zero;
      EXPECT_EQ(back->record.positions[k].count_zero, room ? zero : std::nullopt);
    }
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      JournalRecordBytes hit = bytes;
      hit[bit / 8] = static_cast<std::uint8_t>(hit[bit / 8] ^ 1U << (bit % 8));
      ASSERT_FALSE(decode_journal_record(hit)) << bit;
    }
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      ASSERT_FALSE(decode_journal_record(std::span(bytes).first(size)));
    }
  });
}

TEST(JournalRecord, bytes_that_no_program_of_ours_writes_are_refused_although_sealed) {
  const JournalRecordBytes good = encode(sample(), {});
  const auto with = [&](std::size_t at, std::uint8_t value) {
    JournalRecordBytes bytes = good;
    bytes[at] = value;
    return decode_journal_record(sealed(bytes)).has_value();
  };
  EXPECT_TRUE(with(5, 6));
  EXPECT_TRUE(with(5, 9));
  EXPECT_FALSE(with(0, 0));
  EXPECT_TRUE(with(4, 1));   // the first version, without count zeros
  EXPECT_TRUE(with(4, 2));   // the version before
  EXPECT_FALSE(with(4, 0));  // version
  EXPECT_FALSE(with(4, 4));
  EXPECT_FALSE(with(5, 0));  // kind
  EXPECT_FALSE(with(5, 10));
  EXPECT_FALSE(with(6, 0));  // joints
  EXPECT_FALSE(with(6, 9));
  EXPECT_FALSE(with(6, 2));  // one fewer than stand there
  EXPECT_TRUE(with(7, 6));
  EXPECT_FALSE(with(7, 7));      // cause
  EXPECT_FALSE(with(21, 0x13));  // a quality of a joint that is not there
  EXPECT_FALSE(with(80, 1));     // a number of a lost joint
  EXPECT_FALSE(with(87, 0x80));  // -0 is one too
  EXPECT_FALSE(with(247, 1));    // unused
  EXPECT_FALSE(with(79, 0xC0));  // upper below lower
  EXPECT_FALSE(with(63, 0x7F));  // the guess outside
  JournalRecordBytes nan = good;
  for (const std::size_t at : {56U, 64U, 72U}) std::fill_n(nan.begin() + at, 8, std::uint8_t{0xFF});
  EXPECT_FALSE(decode_journal_record(sealed(nan)));
  JournalRecordBytes nothing = good;
  std::fill_n(nothing.begin() + 8, 8, std::uint8_t{0});
  EXPECT_FALSE(decode_journal_record(sealed(nothing)));
  EXPECT_FALSE(decode_journal_record(sealed({})));
}

TEST(JournalRecord, later_versions_are_known_as_such) {
  JournalRecordBytes later = encode(sample(), {});
  EXPECT_FALSE(is_newer_journal_record(later));
  later[4] = 4;
  EXPECT_FALSE(is_newer_journal_record(later));
  EXPECT_TRUE(is_newer_journal_record(sealed(later)));
  EXPECT_FALSE(is_newer_journal_record(std::span(later).first(200)));
}

TEST(JournalRecord, hashes_tell_names_apart) {
  const std::string text(300, 'x');
  EXPECT_NE(journal_hash("hexapod"), journal_hash("learm"));
  EXPECT_NE(journal_hash(text), journal_hash(text + "x"));
  EXPECT_NE(journal_hash(text), journal_hash("y" + text.substr(1)));
  EXPECT_EQ(journal_hash(text), journal_hash(text));
}

TEST(JournalRecord, coding_allocates_nothing) {
  const test::AllocationCounter allocations;
  const JournalRecordBytes bytes = encode(sample(), {});
  EXPECT_TRUE(decode_journal_record(bytes));
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew
