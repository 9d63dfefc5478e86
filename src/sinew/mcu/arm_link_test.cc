#include "sinew/mcu/arm_link.h"

#include <gtest/gtest.h>

#include <cstring>
#include <span>
#include <vector>

#include "sinew/mcu/bytes.h"
#include "sinew/mcu/kept_positions.h"
#include "sinew/wire/crc32c.h"
#include "support/property.h"

namespace sinew::mcu::arm_link {
namespace {

TEST(ArmLink, its_checksum_is_the_one_of_the_other_wires) {
  test::for_random_cases(500, [](test::Random& random) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(random.integer(0, 200)));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    EXPECT_EQ(mcu::crc32c(bytes.data(), static_cast<std::uint8_t>(bytes.size())),
              sinew::crc32c(bytes));
  });
}

Request random_request(test::Random& random) {
  Request request = {};
  request.kind = static_cast<Kind>(random.integer(0, kKinds - 1));
  request.session = static_cast<std::uint8_t>(random.bits());
  request.sequence = static_cast<std::uint16_t>(random.bits());
  switch (request.kind) {
    case Kind::kHello:
      request.deadline_ms = static_cast<std::uint16_t>(random.integer(kDeadlineMin, kDeadlineMax));
      for (auto& braking : request.brakings) braking = static_cast<std::uint16_t>(random.bits());
      break;
    case Kind::kSegment:
      request.segment.ms = static_cast<std::uint8_t>(random.bits());
      request.segment.begin = random.chance(0.5);
      request.segment.gripper = static_cast<std::uint16_t>(random.bits());
      for (auto& target : request.segment.targets) {
        target = static_cast<std::int32_t>(random.bits());
      }
      for (auto& velocity : request.segment.velocities) {
        velocity = static_cast<std::int16_t>(random.bits());
      }
      break;
    case Kind::kGripper:
      request.gripper_on = random.chance(0.5);
      request.gripper = static_cast<std::uint16_t>(random.bits());
      request.gripper_ms = static_cast<std::uint16_t>(random.bits());
      break;
    case Kind::kPositions:
      for (auto& position : request.positions) position = static_cast<std::int32_t>(random.bits());
      break;
    default:
      break;
  }
  return request;
}

TEST(ArmLink, any_request_comes_back_and_with_a_flipped_bit_none) {
  test::for_random_cases(300, [](test::Random& random) {
    const Request request = random_request(random);
    std::uint8_t bytes[kRequestMax];
    const std::uint8_t size = encode(request, bytes);
    ASSERT_LE(size, kRequestMax);
    Request back = {};
    ASSERT_TRUE(decode(bytes, size, back));
    std::uint8_t again[kRequestMax];
    ASSERT_EQ(encode(back, again), size);
    EXPECT_EQ(std::memcmp(bytes, again, size), 0);
    for (unsigned bit = 0; bit < 8U * size; ++bit) {
      bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
      EXPECT_FALSE(decode(bytes, size, back)) << bit;
      bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
    }
    for (std::uint8_t cut = 0; cut < size; ++cut) EXPECT_FALSE(decode(bytes, cut, back)) << cut;
    Reply reply = {};
    EXPECT_FALSE(decode(bytes, size, reply));
  });
}

TEST(ArmLink, any_reply_comes_back) {
  test::for_random_cases(300, [](test::Random& random) {
    Reply reply = {};
    reply.kind = static_cast<Kind>(random.integer(0, kKinds - 1));
    reply.session = static_cast<std::uint8_t>(random.bits());
    reply.moving = random.chance(0.5);
    reply.stop_line = random.chance(0.5);
    reply.gripper_moves = random.chance(0.5);
    reply.fault = static_cast<Fault>(random.integer(0, kFaults - 1));
    reply.reference = static_cast<Reference>(random.integer(0, 3));
    reply.queued_ms = static_cast<std::uint16_t>(random.bits());
    reply.queue_room = static_cast<std::uint8_t>(random.bits());
    for (auto& position : reply.positions) position = static_cast<std::int32_t>(random.bits());
    reply.gripper = static_cast<std::uint16_t>(random.bits());
    for (auto& byte : reply.identity) byte = static_cast<std::uint8_t>(random.bits());
    reply.stack_free = static_cast<std::uint16_t>(random.bits());
    reply.bytes_lost = static_cast<std::uint32_t>(random.bits());
    std::uint8_t bytes[kReplyMax];
    const std::uint8_t size = encode(reply, bytes);
    ASSERT_LE(size, kReplyMax);
    Reply back = {};
    ASSERT_TRUE(decode(bytes, size, back));
    std::uint8_t again[kReplyMax];
    ASSERT_EQ(encode(back, again), size);
    EXPECT_EQ(std::memcmp(bytes, again, size), 0);
  });
}

TEST(KeptPositions, a_restart_at_any_byte_of_a_writing_leaves_one_whole) {
  KeptPositions kept = {};
  EXPECT_EQ(kept.find(), nullptr);
  KeptPositions::Slot slot = {};
  slot.steps[1] = -77;
  kept.keep(slot);
  const KeptPositions before = kept;
  slot.steps[1] = 5;
  kept.keep(slot);
  const auto* const written = reinterpret_cast<const std::uint8_t*>(&kept);
  for (std::size_t cut = 0; cut <= sizeof kept; ++cut) {
    KeptPositions torn = before;
    std::memcpy(&torn, written, cut);
    const KeptPositions::Slot* const found = torn.find();
    ASSERT_NE(found, nullptr) << cut;
    EXPECT_TRUE(found->steps[1] == -77 || found->steps[1] == 5) << cut;
  }
}

TEST(KeptPositions, what_power_up_leaves_is_nothing) {
  test::for_random_cases(2000, [](test::Random& random) {
    KeptPositions kept;
    auto* const bytes = reinterpret_cast<std::uint8_t*>(&kept);
    for (std::size_t i = 0; i < sizeof kept; ++i)
      bytes[i] = static_cast<std::uint8_t>(random.bits());
    EXPECT_EQ(kept.find(), nullptr);
  });
}

}  // namespace
}  // namespace sinew::mcu::arm_link
