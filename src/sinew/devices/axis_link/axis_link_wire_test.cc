#include "sinew/devices/axis_link/axis_link_wire.h"

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

namespace sinew::axis_link {
namespace {

const std::vector<std::string> kModes{
    "read",        "hold",           "track",       "move",         "home",      "cancel",
    "stop",        "emergency-stop", "release",     "clear-faults", "self-test", "hello",
    "read-health", "read-setup",     "write-setup", "store-setup"};
const std::vector<std::string> kVerdicts{
    "accepted", "not-homed", "out-of-limits", "faulted", "emergency-stopped", "busy", "no-session"};

template <class T>
T number(const std::string& text) {
  const long long value = std::stoll(text);
  if (value < std::numeric_limits<T>::min() || value > std::numeric_limits<T>::max()) {
    throw std::runtime_error("does not fit: " + text);
  }
  return static_cast<T>(value);
}

template <class T>
T named(const std::vector<std::string>& names, const std::string& name) {
  const auto place = std::ranges::find(names, name);
  if (place == names.end()) throw std::runtime_error("no such name: " + name);
  return static_cast<T>(place - names.begin());
}

Request request_of(const std::vector<std::string>& words) {
  return {.axis = number<std::uint8_t>(words.at(1)),
          .to_all = words.size() > 6 && words[6] == "all",
          .mode = named<Mode>(kModes, words.at(0)),
          .sequence = number<std::uint16_t>(words.at(2)),
          .target = number<std::int32_t>(words.at(4)),
          .velocity = number<std::int32_t>(words.at(5)),
          .session = number<std::uint8_t>(words.at(3))};
}

State state_of(const std::vector<std::string>& words) {
  State state{.position = number<std::int32_t>(words.at(4)),
              .velocity = number<std::int16_t>(words.at(5)),
              .fault = number<std::uint8_t>(words.at(7)),
              .verdict = named<Verdict>(kVerdicts, words.at(6))};
  const std::map<std::string, bool State::*> flags{{"motor", &State::motor_ok},
                                                   {"sensor", &State::sensor_ok},
                                                   {"position", &State::position_ok},
                                                   {"communication", &State::communication_ok},
                                                   {"homed", &State::homed},
                                                   {"homing", &State::homing},
                                                   {"moving", &State::moving},
                                                   {"end-stop", &State::end_stop},
                                                   {"emergency", &State::emergency_stopped}};
  for (std::size_t i = 8; i < words.size(); ++i) state.*flags.at(words[i]) = true;
  return state;
}

Reply reply_of(const std::vector<std::string>& words) {
  Reply reply{.axis = number<std::uint8_t>(words.at(1)),
              .session = number<std::uint8_t>(words.at(2)),
              .sequence = number<std::uint16_t>(words.at(3)),
              .body = {}};
  if (words.at(0) == "state") {
    reply.body = state_of(words);
  } else if (words[0] == "identity") {
    reply.body = Identity{number<std::uint32_t>(words.at(4)), number<std::uint16_t>(words.at(5)),
                          number<std::uint16_t>(words.at(6))};
  } else if (words[0] == "health") {
    Health health;
    if (words.at(4) != "-") health.supply_mv = number<std::uint16_t>(words[4]);
    if (words.at(5) != "-") health.temperature_c01 = number<std::int16_t>(words[5]);
    reply.body = health;
  } else if (words[0] == "setup") {
    reply.body = SetupWord{number<std::uint32_t>(words.at(4)), number<std::uint16_t>(words.at(5))};
  } else {
    throw std::runtime_error("no such answer: " + words[0]);
  }
  return reply;
}

Frame frame_of(const std::string& hex) {
  const auto bytes = test::from_hex(hex);
  if (bytes.size() != kFrameSize) throw std::runtime_error("not 16 bytes: " + hex);
  Frame frame{};
  std::ranges::copy(bytes, frame.begin());
  return frame;
}

TEST(AxisLink, every_documented_frame_means_what_it_says_both_ways) {
  const std::vector<std::string> rejects{"checksum", "version", "content"};
  int count = 0;
  for (const auto& golden : test::read_goldens("axis_link.txt")) {
    SCOPED_TRACE(golden.where);
    const Frame frame = frame_of(golden.bytes);
    const auto words = test::words_in(golden.meaning);
    ++count;
    if (words.at(0) == "reject") {
      const auto why = named<Reject>(rejects, words.at(1));
      if (golden.from_host()) {
        EXPECT_EQ(decode_request(frame).error(), why);
      } else {
        EXPECT_EQ(decode_reply(frame).error(), why);
      }
    } else if (golden.from_host()) {
      EXPECT_EQ(encode(request_of(words)), frame);
      EXPECT_EQ(decode_request(frame), request_of(words));
    } else {
      EXPECT_EQ(encode(reply_of(words)), frame);
      EXPECT_EQ(decode_reply(frame), reply_of(words));
    }
  }
  EXPECT_EQ(count, 40);
}

Request random_request(test::Random& random) {
  Request request{.axis = static_cast<std::uint8_t>(random.integer(0, 7)),
                  .to_all = false,
                  .mode = static_cast<Mode>(random.integer(0, kModeLast)),
                  .sequence = static_cast<std::uint16_t>(random.bits()),
                  .target = static_cast<std::int32_t>(random.bits()),
                  .velocity = static_cast<std::int32_t>(random.integer(kVelocityMin, kVelocityMax)),
                  .session = static_cast<std::uint8_t>(random.bits())};
  const bool stops = request.mode == Mode::kStop || request.mode == Mode::kEmergencyStop;
  request.to_all = stops && random.chance(0.5);
  return request;
}

Reply random_reply(test::Random& random) {
  Reply reply{.axis = static_cast<std::uint8_t>(random.integer(0, 7)),
              .session = static_cast<std::uint8_t>(random.bits()),
              .sequence = static_cast<std::uint16_t>(random.bits()),
              .body = {}};
  switch (random.integer(0, 3)) {
    case 0:
      reply.body = State{.position = static_cast<std::int32_t>(random.bits()),
                         .velocity = static_cast<std::int16_t>(random.bits()),
                         .motor_ok = random.chance(0.5),
                         .sensor_ok = random.chance(0.5),
                         .communication_ok = random.chance(0.5),
                         .position_ok = random.chance(0.5),
                         .homed = random.chance(0.5),
                         .homing = random.chance(0.5),
                         .moving = random.chance(0.5),
                         .end_stop = random.chance(0.5),
                         .emergency_stopped = random.chance(0.5),
                         .fault = static_cast<std::uint8_t>(random.integer(0, 15)),
                         .verdict = static_cast<Verdict>(random.integer(0, 6))};
      break;
    case 1:
      reply.body = Identity{static_cast<std::uint32_t>(random.bits()),
                            static_cast<std::uint16_t>(random.bits()),
                            static_cast<std::uint16_t>(random.bits())};
      break;
    case 2:
      reply.body = SetupWord{static_cast<std::uint32_t>(random.bits()),
                             static_cast<std::uint16_t>(random.bits())};
      break;
    default: {
      Health health;
      if (random.chance(0.8)) {
        health.supply_mv = static_cast<std::uint16_t>(random.integer(0, 0xFFFE));
      }
      if (random.chance(0.8)) {
        health.temperature_c01 = static_cast<std::int16_t>(random.integer(-32767, 32767));
      }
      const auto magnet = [&] { return static_cast<Magnet>(random.integer(0, 5)); };
      health.motor_magnet = magnet();
      health.joint_magnet = magnet();
      reply.body = health;
    }
  }
  return reply;
}

TEST(AxisLink, any_message_comes_back_as_it_was_sent) {
  test::for_random_cases(100'000, [](test::Random& random) {
    const Request request = random_request(random);
    ASSERT_EQ(decode_request(encode(request)), request);
    const Reply reply = random_reply(random);
    ASSERT_EQ(decode_reply(encode(reply)), reply);
    ASSERT_FALSE(decode_reply(encode(request)));
    ASSERT_FALSE(decode_request(encode(reply)));
  });
}

void flip(Frame& frame, std::int64_t bit) {
  auto& byte = frame[static_cast<std::size_t>(bit / 8)];
  byte = static_cast<std::uint8_t>(byte ^ 1U << (bit % 8));
}

/// 2 to 7 bits anywhere, or a burst of up to 32.
void spoil(Frame& frame, test::Random& random) {
  const Frame before = frame;
  if (random.chance(0.5)) {
    const std::int64_t count = random.integer(2, 7);
    for (std::int64_t i = 0; i < count; ++i) flip(frame, random.integer(0, 127));
  } else {
    const std::int64_t length = random.integer(2, 32);
    const std::int64_t first = random.integer(0, 128 - length);
    for (std::int64_t bit = first; bit < first + length; ++bit) {
      if (random.chance(0.5)) flip(frame, bit);
    }
  }
  // Flips that undid each other are no error.
  if (frame == before) flip(frame, random.integer(0, 127));
}

TEST(AxisLink, of_a_million_random_errors_not_one_is_accepted) {
  test::for_random_cases(1000, [](test::Random& random) {
    for (int i = 0; i < 1000; ++i) {
      Frame frame = i % 2 == 0 ? encode(random_request(random)) : encode(random_reply(random));
      spoil(frame, random);
      ASSERT_FALSE(i % 2 == 0 ? decode_request(frame).has_value()
                              : decode_reply(frame).has_value());
    }
  });
}

TEST(AxisLink, a_frame_that_slipped_by_bits_is_not_accepted) {
  test::for_random_cases(2000, [](test::Random& random) {
    const Frame frame = encode(random_request(random));
    for (std::size_t slip = 1; slip < 128; ++slip) {
      Frame late{};
      for (std::size_t bit = slip; bit < 128; ++bit) {
        const auto from = bit - slip;  // as clocked: the highest bit of a byte first
        if ((frame[from / 8] >> (7 - from % 8) & 1) == 0) continue;
        late[bit / 8] = static_cast<std::uint8_t>(late[bit / 8] | 1U << (7 - bit % 8));
      }
      ASSERT_FALSE(decode_request(late)) << slip;
    }
  });
}

TEST(AxisLink, accepted_bytes_have_one_spelling) {
  // Whatever is in the twelve bytes, sealed or not: what is accepted is written the same way.
  test::for_random_cases(100'000, [](test::Random& random) {
    Frame frame =
        random.chance(0.5) ? encode(random_request(random)) : encode(random_reply(random));
    frame[0] = static_cast<std::uint8_t>((frame[0] & 0x07) | random.integer(0, 31) << 3);
    if (const auto request = decode_request(frame)) {
      ASSERT_EQ(encode(*request), frame);
    }
    if (const auto reply = decode_reply(frame)) {
      ASSERT_EQ(encode(*reply), frame);
    }
  });
}

TEST(AxisLink, units_hold_several_turns_and_are_finer_than_a_microstep) {
  EXPECT_EQ(to_units(1), 1 << 26);
  EXPECT_EQ(from_units(1 << 26), 1);
  EXPECT_TRUE(to_units(31.9));
  EXPECT_FALSE(to_units(32));
  EXPECT_FALSE(to_units(std::nan("")));
  EXPECT_FALSE(to_units(std::numeric_limits<double>::infinity()));
  EXPECT_LT(from_units(1) * 180 / M_PI, 0.0066 / 1000);
  EXPECT_EQ(to_velocity_units(-1), -(1 << 18));
  EXPECT_FALSE(to_velocity_units(32.1));
  EXPECT_FALSE(to_velocity_units(std::nan("")));
}

TEST(AxisLink, newer_is_a_window_ahead_around_the_end_of_the_numbers) {
  EXPECT_FALSE(is_newer(5, 5));
  EXPECT_TRUE(is_newer(6, 5));
  EXPECT_FALSE(is_newer(4, 5));
  EXPECT_TRUE(is_newer(5 + kSequenceWindow, 5));
  EXPECT_FALSE(is_newer(6 + kSequenceWindow, 5));
  EXPECT_TRUE(is_newer(0, 0xFFFF));
  EXPECT_FALSE(is_newer(0xFFFF, 0));
}

TEST(AxisLink, the_model_hash_tells_every_number_and_the_axis_apart) {
  const AxisModel model{1, -2.9, 2.9, 1.7, 0.17, 0.17};
  const std::uint32_t hash = model_hash(model);
  EXPECT_EQ(hash, model_hash(model));
  for (double AxisModel::* const field :
       {&AxisModel::lower, &AxisModel::upper, &AxisModel::velocity_max,
        &AxisModel::acceleration_max, &AxisModel::jerk_max}) {
    AxisModel other = model;
    other.*field += 1e-7;
    EXPECT_NE(model_hash(other), hash);
    other.*field = model.*field * (1 + 1e-16);
    EXPECT_EQ(model_hash(other), hash) << "rounding of a unit conversion is no other model";
  }
  AxisModel other = model;
  other.axis = 2;
  EXPECT_NE(model_hash(other), hash);
}

TEST(AxisLink, nothing_allocates) {
  const test::AllocationCounter counter;
  const auto request = decode_request(encode(hello(1, 2, 3, kDeadlineDefault)));
  const auto reply = decode_reply(encode(Reply{.body = Identity{}}));
  EXPECT_EQ(counter.count(), 0U);
  EXPECT_TRUE(request && reply);
}

}  // namespace
}  // namespace sinew::axis_link
