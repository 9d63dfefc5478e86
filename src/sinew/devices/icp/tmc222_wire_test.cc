#include "sinew/devices/icp/tmc222_wire.h"

#include <gtest/gtest.h>

#include <map>
#include <stdexcept>
#include <vector>

#include "support/allocation_guard.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew::tmc222 {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// The numbers of a golden's meaning, from the given word on.
std::vector<int> numbers(const std::vector<std::string>& words, std::size_t from) {
  std::vector<int> all;
  for (std::size_t i = from; i < words.size(); ++i) all.push_back(std::stoi(words[i]));
  return all;
}

std::uint8_t code(int value) {
  return static_cast<std::uint8_t>(value);
}

Command command_of(const std::string& meaning) {
  const auto words = test::words_in(meaning);
  const std::map<std::string, Command> plain{{"get-full-status-1", GetFullStatus1{}},
                                             {"get-full-status-2", GetFullStatus2{}},
                                             {"get-otp-param", GetOtpParam{}},
                                             {"goto-secure-position", GotoSecurePosition{}},
                                             {"hard-stop", HardStop{}},
                                             {"soft-stop", SoftStop{}},
                                             {"reset-position", ResetPosition{}},
                                             {"reset-to-default", ResetToDefault{}}};
  if (const auto found = plain.find(words[0]); found != plain.end()) return found->second;
  const auto n = numbers(words, 1);
  if (words[0] == "set-position") return SetPosition{static_cast<std::int16_t>(n.at(0))};
  if (words[0] == "run-init") {
    return RunInit{code(n.at(0)), code(n.at(1)), static_cast<std::int16_t>(n.at(2)),
                   static_cast<std::int16_t>(n.at(3))};
  }
  if (words[0] != "set-motor-param") throw std::runtime_error("no such command: " + meaning);
  return SetMotorParam{{code(n.at(0)), code(n.at(1)), code(n.at(2)), code(n.at(3)),
                        static_cast<std::uint16_t>(n.at(4)), n.at(5) != 0, code(n.at(6)),
                        n.at(7) != 0, code(n.at(8))}};
}

Answer answer_of(const test::Golden& golden) {
  const Bytes bytes = test::from_hex(golden.bytes);
  if (bytes.size() != kAnswerSize) throw std::runtime_error(golden.where + ": not 8 bytes");
  Answer answer{};
  std::copy(bytes.begin(), bytes.end(), answer.begin());
  return answer;
}

TEST(Tmc222Wire, every_golden_command_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("tmc222.txt")) {
    if (golden.who != "master") continue;
    ++count;
    const Bytes bytes = test::from_hex(golden.bytes);
    const Command meaning = command_of(golden.meaning);
    const CommandBytes written = encode_command(meaning);
    EXPECT_EQ(Bytes(written.begin(), written.end()), bytes) << golden.where;
    const auto read = decode_command(bytes);
    ASSERT_TRUE(read) << golden.where;
    EXPECT_EQ(*read, meaning) << golden.where;
  }
  EXPECT_EQ(count, 15);
}

TEST(Tmc222Wire, every_golden_refusal_is_given) {
  const std::map<std::string, Refusal> whys{{"forbidden", Refusal::kForbidden},
                                            {"length", Refusal::kLength},
                                            {"unknown", Refusal::kUnknown}};
  int count = 0;
  for (const auto& golden : test::read_goldens("tmc222.txt")) {
    if (golden.who != "refused") continue;
    ++count;
    const auto read = decode_command(test::from_hex(golden.bytes));
    ASSERT_FALSE(read) << golden.where;
    EXPECT_EQ(read.error(), whys.at(golden.meaning)) << golden.where;
  }
  EXPECT_EQ(count, 6);
}

TEST(Tmc222Wire, every_golden_answer_is_read_and_written) {
  int count = 0;
  for (const auto& golden : test::read_goldens("tmc222.txt")) {
    if (!golden.who.starts_with("status")) continue;
    ++count;
    const Answer answer = answer_of(golden);
    const auto words = test::words_in(golden.meaning);
    const auto address = code(std::stoi(words.at(0), nullptr, 16));
    if (golden.who == "status2") {
      const auto n = numbers(words, 1);
      const Status2 meaning{address, static_cast<std::int16_t>(n.at(0)),
                            static_cast<std::int16_t>(n.at(1)),
                            static_cast<std::uint16_t>(n.at(2))};
      EXPECT_EQ(decode_status2(answer).value(), meaning) << golden.where;
      EXPECT_EQ(encode_status2(meaning), answer) << golden.where;
      continue;
    }
    const auto n = numbers({words.begin() + 1, words.begin() + 9}, 0);
    const auto read = decode_status1(answer);
    ASSERT_TRUE(read) << golden.where;
    const Parameters parameters{code(n.at(0)), code(n.at(1)), code(n.at(2)), code(n.at(3)), 0,
                                n.at(4) != 0,  code(n.at(5)), n.at(6) != 0,  code(n.at(7))};
    EXPECT_EQ(read->parameters, parameters) << golden.where;
    EXPECT_EQ(read->address, address);
    EXPECT_EQ(static_cast<int>(read->motion), std::stoi(words.at(10))) << golden.where;
    const int flags = std::stoi(words.at(9), nullptr, 16);
    EXPECT_EQ(read->flags.vdd_reset, (flags & 0x80) != 0);
    EXPECT_EQ(read->flags.step_loss, (flags & 0x40) != 0);
    EXPECT_EQ(read->flags.temperature, flags & 3);
    EXPECT_EQ(encode_status1(*read), answer) << golden.where;
  }
  EXPECT_EQ(count, 5);
}

TEST(Tmc222Wire, no_command_is_ever_written_as_set_otp_param_and_none_is_read) {
  test::for_random_cases(20'000, [](test::Random& random) {
    Bytes bytes(static_cast<std::size_t>(random.integer(1, 9)));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    bytes[0] = kSetOtpParam;
    ASSERT_EQ(decode_command(bytes).error(), Refusal::kForbidden);
    bytes[0] = static_cast<std::uint8_t>(random.integer(0x80, 0x90));
    const auto read = decode_command(bytes);
    if (!read) return;
    const CommandBytes written = encode_command(*read);
    EXPECT_NE(written[0], kSetOtpParam);
    EXPECT_EQ(decode_command(written).value(), *read);
  });
}

TEST(Tmc222Wire, codes_mean_what_the_data_sheet_says) {
  const Parameters seed{.velocity_max = 15, .velocity_min = 15, .acceleration = 15, .step_mode = 3};
  EXPECT_NEAR(velocity_min(seed), 456, 0.5);
  EXPECT_EQ(velocity_min({.velocity_max = 15, .velocity_min = 0}), 973);
  const double top = kVelocityMax[15];
  const double ramp =
      (top * top - velocity_min(seed) * velocity_min(seed)) / (2 * kAcceleration[15]);
  EXPECT_NEAR(ramp, 9.2, 0.05) << "full steps";
  EXPECT_EQ(kPeakCurrent[13], 566);
  EXPECT_EQ(microsteps(0), 2);
  EXPECT_EQ(microsteps(3), 16);
}

TEST(Tmc222Wire, positions_wrap_at_the_width_of_their_step_mode) {
  EXPECT_EQ(wrapped(4095, 0), 4095);
  EXPECT_EQ(wrapped(4096, 0), -4096);
  EXPECT_EQ(wrapped(32768, 3), -32768);
  EXPECT_EQ(wrapped(-32769, 3), 32767);
  EXPECT_EQ(wrapped(std::int64_t{-20000} - 20000, 3), 25536) << "the short way round";
}

TEST(Tmc222Wire, secure_position_counts_32_microsteps) {
  EXPECT_EQ(secure_target({.secure_position = 1, .step_mode = 3}), 32);
  EXPECT_EQ(secure_target({.secure_position = 0x3FF, .step_mode = 3}), 0x3FF * 32);
  EXPECT_EQ(secure_target({.secure_position = 0x7FF, .step_mode = 3}), -32);
  EXPECT_EQ(secure_target({.secure_position = 1, .step_mode = 0}), 4);
}

TEST(Tmc222Wire, otp_shows_the_defaults_and_the_address) {
  const Answer otp = encode_otp(0x6B, {5, 10, 2, 12, 1810, true, 3, false, 2});
  EXPECT_EQ(otp, (Answer{0, 0, 5, 0x5A, 0x2C, 0xF3, 0x12, 8}));
}

TEST(Tmc222Wire, no_allocation) {
  const test::AllocationCounter allocations;
  const auto written = encode_command(RunInit{1, 2, 3, 4});
  EXPECT_TRUE(decode_command(written));
  EXPECT_TRUE(decode_status1(encode_status1({})));
  EXPECT_EQ(allocations.count(), 0U);
}

TEST(Tmc222Wire, every_code_of_the_data_sheet_means_what_it_says_there) {
  const std::map<std::string, std::span<const double, 16>> tables{
      {"current", kPeakCurrent}, {"velocity", kVelocityMax}, {"acceleration", kAcceleration}};
  std::map<std::string, int> seen;
  for (const auto& golden : test::read_goldens("tmc222_codes.txt")) {
    const auto& table = tables.at(golden.who);
    EXPECT_EQ(table[std::stoul(golden.bytes)], std::stod(golden.meaning)) << golden.where;
    seen[golden.who] |= 1 << std::stoi(golden.bytes);
  }
  EXPECT_EQ(seen, (std::map<std::string, int>{
                      {"acceleration", 0xFFFF}, {"current", 0xFFFF}, {"velocity", 0xFFFF}}));
}

TEST(Tmc222Wire, what_the_hexapods_firmware_writes_at_boot_means_what_the_document_works_out) {
  const auto command = decode_command(test::from_hex("89 ff ff dd ff 0f 00 ef"));
  ASSERT_TRUE(command);
  const Parameters p = std::get<SetMotorParam>(*command).parameters;
  EXPECT_EQ(kPeakCurrent[p.run_current], 566);
  EXPECT_EQ(kPeakCurrent[p.hold_current], 566) << "and hold";
  const double top = kVelocityMax[p.velocity_max];
  const double low = velocity_min(p);
  EXPECT_NEAR(low, 456, 0.5);
  EXPECT_NEAR((top * top - low * low) / (2 * kAcceleration[p.acceleration]), 9.2, 0.05)
      << "full steps of a ramp";
  EXPECT_EQ(microsteps(p.step_mode), 16);
}

}  // namespace
}  // namespace sinew::tmc222
