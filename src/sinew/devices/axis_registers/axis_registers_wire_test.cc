#include "sinew/devices/axis_registers/axis_registers_wire.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/allocation_guard.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew::axis_registers {
namespace {

using ByteList = std::vector<std::uint8_t>;

template <class Range>
ByteList list(const Range& bytes) {
  return ByteList(bytes.begin(), bytes.end());
}

HeaderBytes header_bytes(const ByteList& bytes) {
  HeaderBytes header{};
  std::copy_n(bytes.begin(), header.size(), header.begin());
  return header;
}

const std::map<std::string, std::uint8_t> kBytes{{"syn", kSyn},     {"syn-ack", kSynAck},
                                                 {"ack", kAck},     {"commit", kCommit},
                                                 {"start", kStart}, {"end", kEnd}};
const std::map<std::string, Verdict> kVerdicts{{"ok", Verdict::kOk},
                                               {"start", Verdict::kStartByte},
                                               {"frame-id", Verdict::kFrameId},
                                               {"slave-id", Verdict::kSlaveId},
                                               {"register", Verdict::kRegister},
                                               {"size", Verdict::kSize},
                                               {"end", Verdict::kEndByte},
                                               {"crc", Verdict::kCrc},
                                               {"operation", Verdict::kOperation}};
const std::map<std::string, AngleEncoding> kFormats{{"deg_u32", AngleEncoding::kDegU32},
                                                    {"mdeg_i32", AngleEncoding::kMdegI32},
                                                    {"f32_be", AngleEncoding::kF32Be},
                                                    {"f32_le", AngleEncoding::kF32Le}};

Status status_of(const std::string& flags, const std::string& fault) {
  Status status;
  for (const std::string& flag : test::split(flags, ',')) {
    if (flag == "motor") status.motor_ok = true;
    if (flag == "sensor") status.sensor_ok = true;
    if (flag == "communication") status.communication_ok = true;
    if (flag == "position") status.position_ok = true;
    if (flag == "homed") status.homed = true;
    if (flag == "moving") status.moving = true;
    if (flag == "end-stop") status.end_stop = true;
    if (flag == "stopped") status.emergency_stop = true;
  }
  status.fault = static_cast<std::uint8_t>(std::stoi(fault));
  return status;
}

void check_golden(const std::vector<std::string>& words, const ByteList& bytes) {
  const std::string& kind = words.at(0);
  if (kind == "byte") {
    EXPECT_EQ(ByteList{kBytes.at(words.at(1))}, bytes);
  } else if (kind == "verdict") {
    EXPECT_EQ(verdict_of(bytes.at(0)), kVerdicts.at(words.at(1)));
    EXPECT_EQ(static_cast<std::uint8_t>(kVerdicts.at(words.at(1))), bytes.at(0));
  } else if (kind == "header") {
    const auto operation = words.at(1) == "read" ? Operation::kRead : Operation::kWrite;
    const auto number = [&](std::size_t i) {
      return static_cast<std::uint16_t>(std::stoi(words.at(i)));
    };
    const Header header{1, number(2), static_cast<std::uint8_t>(operation), number(3), number(4)};
    EXPECT_EQ(list(encode_header(header)), bytes);
    EXPECT_EQ(decode_header(header_bytes(bytes)).value(), header);
    EXPECT_EQ(check_header(header_bytes(bytes), {}), Verdict::kOk);
    EXPECT_EQ(check_header(header_bytes(bytes), {.checks = Checks::kAsBuilt}), Verdict::kOk);
  } else if (kind == "commit") {
    EXPECT_EQ(decode_commit(bytes), kVerdicts.at(words.at(1)));
    EXPECT_EQ(list(encode_commit(kVerdicts.at(words.at(1)))), bytes);
  } else if (kind == "sealed") {
    const ByteList data = words.size() > 1 ? test::from_hex(words.at(1)) : ByteList{};
    EXPECT_EQ(list(seal(data)), bytes);
    ASSERT_TRUE(unseal(bytes));
    EXPECT_EQ(list(*unseal(bytes)), data);
  } else if (kind == "angle") {
    const AngleEncoding format = kFormats.at(words.at(1));
    const double angle_deg = std::stod(words.at(2));
    ASSERT_TRUE(encode_angle(format, angle_deg));
    const AngleBytes encoded = *encode_angle(format, angle_deg);
    EXPECT_EQ(list(encoded), bytes);
    EXPECT_EQ(decode_angle(format, encoded), angle_deg);
  } else if (kind == "status") {
    EXPECT_EQ(decode_status(bytes), status_of(words.at(1), words.at(2)));
    EXPECT_EQ(list(encode_status(status_of(words.at(1), words.at(2)))), bytes);
  } else {
    throw std::runtime_error("no such meaning: " + kind);
  }
}

TEST(AxisRegisters, every_golden_vector_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("axis_registers.txt")) {
    SCOPED_TRACE(golden.where);
    check_golden(test::words_in(golden.meaning), test::from_hex(golden.bytes));
    ++count;
  }
  EXPECT_EQ(count, 54);
}

/// The rule as the document has it, a bit at a time.
std::uint32_t crc_by_bits(const ByteList& bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (std::size_t word = 0; word < bytes.size(); word += 4) {
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < 4 && word + k < bytes.size(); ++k) {
      value |= std::uint32_t{bytes[word + k]} << 8 * k;
    }
    crc ^= value;
    for (int bit = 0; bit < 32; ++bit) {
      crc = (crc & 0x80000000U) != 0 ? crc << 1 ^ 0x04C11DB7U : crc << 1;
    }
  }
  return crc;
}

TEST(AxisRegisters, crc_follows_the_documents_rule_for_any_bytes) {
  test::for_random_cases(20'000, [](test::Random& random) {
    ByteList bytes(static_cast<std::size_t>(random.integer(0, 20)));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.integer(0, 255));
    EXPECT_EQ(crc32(bytes), crc_by_bits(bytes));
  });
}

TEST(AxisRegisters, a_resynchronisation_is_data_of_no_length) {
  for (std::size_t size = 0; size <= kDataMax; ++size) {
    EXPECT_FALSE(unseal(ByteList(size + kCrcSize, kResyncByte))) << size;
  }
}

TEST(AxisRegisters, lines_that_are_stuck_are_no_data) {
  for (std::size_t size = 1; size <= kDataMax; ++size) {
    EXPECT_FALSE(unseal(ByteList(size + kCrcSize, 0x00))) << size;
    EXPECT_FALSE(unseal(ByteList(size + kCrcSize, 0xFF))) << size;
    EXPECT_FALSE(unseal(ByteList(size + kCrcSize, kSynAck))) << size;
  }
}

TEST(AxisRegisters, every_flip_of_up_to_three_bits_in_a_header_or_target_is_caught) {
  const HeaderBytes header = encode_header({1, 2, 2, 1, 4});
  const SealedData sealed = seal(ByteList{0, 0, 0, 90});
  const auto flip = [](auto& bytes, std::size_t bit) {
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 0x80U >> bit % 8);
  };
  for (std::size_t a = 0; a < 8 * sealed.size(); ++a) {
    for (std::size_t b = a; b < 8 * sealed.size(); ++b) {
      for (std::size_t c = b; c < 8 * sealed.size(); ++c) {
        SealedData damaged = sealed;
        flip(damaged, a), flip(damaged, b), flip(damaged, c);
        if (damaged == sealed) continue;
        ASSERT_FALSE(unseal({damaged.data(), damaged.size()})) << a << ' ' << b << ' ' << c;
      }
    }
  }
  for (std::size_t a = 0; a < 8 * header.size(); ++a) {
    for (std::size_t b = a; b < 8 * header.size(); ++b) {
      HeaderBytes damaged = header;
      flip(damaged, a);
      if (b != a) flip(damaged, b);
      ASSERT_NE(check_header(damaged, {}), Verdict::kOk) << a << ' ' << b;
      ASSERT_NE(check_header(damaged, {.checks = Checks::kAsBuilt}), Verdict::kOk);
    }
  }
}

Verdict verdict(Checks checks, const Header& header, bool bad_start = false, bool bad_end = false,
                bool bad_crc = false) {
  HeaderBytes bytes = encode_header(header);
  if (bad_start) bytes.front() = 0x54;
  if (bad_end) bytes.back() = 0xAB;
  if (bad_crc) bytes[9] ^= 0xDE;
  return check_header(bytes, {.checks = checks, .last_frame_id = 7});
}

TEST(AxisRegisters, one_fault_in_a_header_has_the_same_code_everywhere) {
  for (const Checks checks : {Checks::kDocument, Checks::kAsBuilt}) {
    EXPECT_EQ(verdict(checks, {1, 8, 2, 1, 4}), Verdict::kOk);
    EXPECT_EQ(verdict(checks, {1, 8, 2, 1, 4}, true), Verdict::kStartByte);
    EXPECT_EQ(verdict(checks, {1, 7, 2, 1, 4}), Verdict::kFrameId);
    EXPECT_EQ(verdict(checks, {2, 8, 2, 1, 4}), Verdict::kSlaveId);
    EXPECT_EQ(verdict(checks, {1, 8, 2, 5, 4}), Verdict::kRegister);
    EXPECT_EQ(verdict(checks, {1, 8, 2, 1, 5}), Verdict::kSize);
    EXPECT_EQ(verdict(checks, {1, 8, 2, 1, 0}), Verdict::kSize);
    EXPECT_EQ(verdict(checks, {1, 8, 2, 1, 4}, false, true), Verdict::kEndByte);
    EXPECT_EQ(verdict(checks, {1, 8, 2, 1, 4}, false, false, true), Verdict::kCrc);
    EXPECT_EQ(verdict(checks, {1, 8, 3, 1, 4}), Verdict::kOperation);
    EXPECT_EQ(verdict(checks, {1, 8, 0, 1, 4}), Verdict::kOperation);
    EXPECT_EQ(verdict(checks, {1, 8, 1, 2, 1}), Verdict::kOperation) << "DIAG_CONTROL is W";
    EXPECT_EQ(verdict(checks, {1, 8, 2, 3, 4}), Verdict::kOperation) << "DIAG_STATUS is R";
  }
}

TEST(AxisRegisters, two_faults_show_in_which_order_a_board_looks) {
  // Bad id and bad end, as measured on the first firmware.
  EXPECT_EQ(verdict(Checks::kDocument, {2, 8, 2, 1, 4}, false, true), Verdict::kSlaveId);
  EXPECT_EQ(verdict(Checks::kAsBuilt, {2, 8, 2, 1, 4}, false, true), Verdict::kEndByte);
  // Bad CRC and a forbidden operation.
  EXPECT_EQ(verdict(Checks::kDocument, {1, 8, 1, 2, 1}, false, false, true), Verdict::kCrc);
  EXPECT_EQ(verdict(Checks::kAsBuilt, {1, 8, 1, 2, 1}, false, false, true), Verdict::kOperation);
  // Everything at once, then one repaired after the other, in the document's order.
  EXPECT_EQ(verdict(Checks::kDocument, {2, 7, 9, 99, 9}, true, true, true), Verdict::kStartByte);
  EXPECT_EQ(verdict(Checks::kDocument, {2, 7, 9, 99, 9}, false, true, true), Verdict::kFrameId);
  EXPECT_EQ(verdict(Checks::kDocument, {2, 8, 9, 99, 9}, false, true, true), Verdict::kSlaveId);
  EXPECT_EQ(verdict(Checks::kDocument, {1, 8, 9, 99, 9}, false, true, true), Verdict::kRegister);
  EXPECT_EQ(verdict(Checks::kDocument, {1, 8, 9, 1, 9}, false, true, true), Verdict::kSize);
  EXPECT_EQ(verdict(Checks::kDocument, {1, 8, 9, 1, 4}, false, true, true), Verdict::kEndByte);
  // As built: 01 06 03 02 04 05 08 07.
  EXPECT_EQ(verdict(Checks::kAsBuilt, {2, 7, 9, 99, 9}, true, true, true), Verdict::kStartByte);
  EXPECT_EQ(verdict(Checks::kAsBuilt, {2, 7, 9, 99, 9}, false, true, true), Verdict::kEndByte);
  EXPECT_EQ(verdict(Checks::kAsBuilt, {2, 7, 9, 99, 9}, false, false, true), Verdict::kSlaveId);
  EXPECT_EQ(verdict(Checks::kAsBuilt, {1, 7, 9, 99, 9}, false, false, true), Verdict::kFrameId);
  EXPECT_EQ(verdict(Checks::kAsBuilt, {1, 8, 9, 99, 9}, false, false, true), Verdict::kRegister);
  EXPECT_EQ(verdict(Checks::kAsBuilt, {1, 8, 9, 1, 9}, false, false, true), Verdict::kSize);
  EXPECT_EQ(verdict(Checks::kAsBuilt, {1, 8, 9, 1, 4}, false, false, true), Verdict::kOperation);
}

TEST(AxisRegisters, sizes_below_the_registers_pass_only_as_built) {
  for (std::uint16_t size = 1; size < 4; ++size) {
    EXPECT_EQ(verdict(Checks::kDocument, {1, 8, 2, 1, size}), Verdict::kSize);
    EXPECT_EQ(verdict(Checks::kAsBuilt, {1, 8, 2, 1, size}), Verdict::kOk);
  }
  EXPECT_EQ(verdict(Checks::kAsBuilt, {1, 8, 2, 0, 2}), Verdict::kSize);
}

TEST(AxisRegisters, frame_ids_run_from_1_to_fffe_and_begin_again) {
  EXPECT_EQ(next_frame_id(1), 2);
  EXPECT_EQ(next_frame_id(0xFFFD), 0xFFFE);
  EXPECT_EQ(next_frame_id(0xFFFE), 1);
  EXPECT_EQ(next_frame_id(0xFFFF), 1);
  EXPECT_EQ(next_frame_id(0), 1);
  EXPECT_EQ(check_header(encode_header({1, 0, 2, 1, 4}), {}), Verdict::kFrameId);
  EXPECT_EQ(check_header(encode_header({1, 0xFFFF, 2, 1, 4}), {.last_frame_id = 3}), Verdict::kOk)
      << "the document refuses the last accepted one only";
  EXPECT_EQ(check_header(encode_header({1, 0, 2, 1, 4}), {.checks = Checks::kAsBuilt}),
            Verdict::kOk)
      << "the first firmware looks at the last one only";
}

TEST(AxisRegisters, an_angle_that_does_not_fit_is_refused_and_never_wraps) {
  using enum AngleEncoding;
  for (const AngleEncoding format : {kDegU32, kMdegI32, kF32Be, kF32Le}) {
    EXPECT_FALSE(encode_angle(format, std::nan("")));
    EXPECT_FALSE(encode_angle(format, HUGE_VAL));
    EXPECT_FALSE(encode_angle(format, -1e300));
  }
  EXPECT_FALSE(encode_angle(kDegU32, -1));
  EXPECT_FALSE(encode_angle(kDegU32, -30));
  EXPECT_FALSE(encode_angle(kDegU32, 4294967296.0));
  EXPECT_FALSE(encode_angle(kMdegI32, 2147484));
  EXPECT_FALSE(encode_angle(kMdegI32, -2147484));
  EXPECT_FALSE(decode_angle(kF32Be, {0x7F, 0xC0, 0, 0}));
  EXPECT_FALSE(decode_angle(kF32Le, {0, 0, 0x80, 0x7F}));
}

TEST(AxisRegisters, an_angle_comes_back_within_half_a_unit) {
  test::for_random_cases(50'000, [](test::Random& random) {
    const double angle_deg = random.uniform(-720, 720);
    using enum AngleEncoding;
    for (const AngleEncoding format : {kDegU32, kMdegI32, kF32Be, kF32Le}) {
      if (format == kDegU32 && angle_deg < 0) continue;
      const auto bytes = encode_angle(format, angle_deg);
      ASSERT_TRUE(bytes);
      const auto back = decode_angle(format, *bytes);
      ASSERT_TRUE(back);
      EXPECT_LE(std::abs(*back - angle_deg), 0.5000001 * angle_unit_deg(format, angle_deg));
      EXPECT_EQ(encode_angle(format, *back), bytes);
    }
  });
}

TEST(AxisRegisters, a_status_with_unknown_bits_is_none) {
  EXPECT_FALSE(decode_status(ByteList{0, 1, 0, 0x1F}));
  EXPECT_FALSE(decode_status(ByteList{0x80, 0, 0, 0x1F}));
  EXPECT_FALSE(decode_status(ByteList{0, 0, 0x1F}));
  for (unsigned word = 0; word <= 0xFFFF; ++word) {
    const ByteList bytes{0, 0, static_cast<std::uint8_t>(word >> 8),
                         static_cast<std::uint8_t>(word & 0xFF)};
    const auto status = decode_status(bytes);
    ASSERT_TRUE(status);
    ASSERT_EQ(list(encode_status(*status)), bytes);
  }
}

TEST(AxisRegisters, only_the_two_commits_are_commits) {
  for (unsigned error = 0; error < 256; ++error) {
    const auto commit =
        decode_commit(ByteList{kStart, kCommit, static_cast<std::uint8_t>(error), kEnd});
    EXPECT_EQ(commit.has_value(), error == 0 || error == 7) << error;
  }
  EXPECT_FALSE(decode_commit(ByteList{kStart, kCommit, 0}));
  EXPECT_FALSE(decode_commit(ByteList{kStart, kCommit, 0, kEnd, 0}));
  EXPECT_FALSE(decode_commit(ByteList{kEnd, kEnd, kEnd, kEnd}));
}

TEST(AxisRegisters, coding_does_not_allocate) {
  const test::AllocationCounter allocations;
  const HeaderBytes header = encode_header({1, 2, 2, 1, 4});
  EXPECT_EQ(check_header(header, {}), Verdict::kOk);
  const auto angle = encode_angle(AngleEncoding::kF32Be, 12.5);
  const SealedData sealed = seal(*angle);
  EXPECT_TRUE(unseal({sealed.data(), sealed.size()}));
  EXPECT_EQ(allocations.count(), 0U);
}

}  // namespace
}  // namespace sinew::axis_registers
