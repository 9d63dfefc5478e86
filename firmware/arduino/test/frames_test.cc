#include <gtest/gtest.h>
#include <maxarm_frames.h>

#include "sinew/devices/maxarm/maxarm_wire.h"
#include "support/golden.h"
#include "support/property.h"

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const sinew_maxarm::Frame& frame) {
  return {frame.bytes, frame.bytes + frame.size};
}

Bytes bytes_of(const maxarm::FrameBytes& frame) {
  return {frame.begin(), frame.end()};
}

/// The frame that a line of tests/golden/maxarm.txt describes in words.
sinew_maxarm::Frame frame_of(const std::vector<std::string>& words) {
  std::vector<std::int16_t> numbers;
  for (std::size_t i = 1; i < words.size(); ++i) {
    numbers.push_back(static_cast<std::int16_t>(std::stoi(words[i])));
  }
  const auto number = [&](std::size_t i) { return static_cast<std::uint16_t>(numbers.at(i)); };
  if (words[0] == "angle") return sinew_maxarm::set_angle_frame(numbers.data(), number(3));
  if (words[0] == "xyz") return sinew_maxarm::set_xyz_frame(numbers.data(), number(3));
  if (words[0] == "pwm") return sinew_maxarm::set_pwm_servo_frame(number(0), number(1));
  if (words[0] == "suction") {
    return sinew_maxarm::set_suction_frame(static_cast<std::uint8_t>(numbers.at(0)));
  }
  if (words[0] == "read-angle") return sinew_maxarm::read_frame(sinew_maxarm::kReadAngle);
  return sinew_maxarm::read_frame(sinew_maxarm::kReadXyz);
}

TEST(ArduinoFrames, every_documented_request_is_made_byte_for_byte) {
  int count = 0;
  for (const test::Golden& golden : test::read_goldens("maxarm.txt")) {
    if (!golden.from_host()) continue;
    EXPECT_EQ(bytes_of(frame_of(test::words_in(golden.meaning))), test::from_hex(golden.bytes))
        << golden.where;
    ++count;
  }
  EXPECT_GE(count, 30);
}

TEST(ArduinoFrames, random_requests_are_those_of_the_product) {
  test::for_random_cases(2000, [](test::Random& random) {
    const auto word = [&] { return static_cast<std::int16_t>(random.integer(-32768, 32767)); };
    const auto positive = [&] { return static_cast<std::uint16_t>(random.integer(0, 65535)); };
    const std::array<std::int16_t, 3> three{word(), word(), word()};
    const std::uint16_t time = positive();
    EXPECT_EQ(bytes_of(sinew_maxarm::set_xyz_frame(three.data(), time)),
              bytes_of(maxarm::encode_request(maxarm::SetXyz{three, time})));
    const auto u16 = [&](std::size_t i) { return static_cast<std::uint16_t>(three[i]); };
    EXPECT_EQ(bytes_of(sinew_maxarm::set_angle_frame(three.data(), time)),
              bytes_of(maxarm::encode_request(maxarm::SetAngle{{u16(0), u16(1), u16(2)}, time})));
    const std::uint16_t us = positive();
    EXPECT_EQ(bytes_of(sinew_maxarm::set_pwm_servo_frame(us, time)),
              bytes_of(maxarm::encode_request(maxarm::SetPwmServo{us, time})));
  });
}

}  // namespace
}  // namespace sinew
