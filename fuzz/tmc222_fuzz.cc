#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/devices/icp/tmc222_device.h"

// The TMC222 and its messages. For any bytes: a write that is a command has one spelling, which
// reads back as the same; SetOTPParam is never one; answers are their bytes; and a chip that is
// written anything keeps its field and its position in step and comes to rest.

namespace {

using namespace sinew;
using namespace sinew::tmc222;

void commands_have_one_spelling(std::span<const std::uint8_t> bytes) {
  const auto command = decode_command(bytes);
  if (!bytes.empty() && bytes[0] == kSetOtpParam) {
    SINEW_ASSERT(!command && command.error() == Refusal::kForbidden);
  }
  if (!command) return;
  const CommandBytes spelled = encode_command(*command);
  SINEW_ASSERT(spelled.size() == bytes.size() && spelled[0] != kSetOtpParam);
  const auto again = decode_command(spelled);
  SINEW_ASSERT(again && *again == *command);
  SINEW_ASSERT(encode_command(*again) == spelled);
}

void answers_are_their_bytes(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kAnswerSize) return;
  const auto answer = bytes.first<kAnswerSize>();
  if (const auto status = decode_status1(answer)) {
    const Answer spelled = encode_status1(*status);
    SINEW_ASSERT(std::equal(spelled.begin(), spelled.end(), answer.begin()));
  }
  if (const auto status = decode_status2(answer)) {
    const Answer spelled = encode_status2(*status);
    SINEW_ASSERT(std::equal(spelled.begin(), spelled.end(), answer.begin()));
  }
}

/// The input is a list of: length, that many bytes of a write, milliseconds until the next.
void chip_survives(std::span<const std::uint8_t> bytes) {
  Tmc222 chip(0x61, {}, 7.5, Instant{});
  Instant now{};
  chip.write(encode_command(GetFullStatus1{}), now);
  chip.write(encode_command(SetMotorParam{icp::kMotorParameters}), now);
  for (int writes = 0; writes < 64 && bytes.size() > 2; ++writes) {
    const std::size_t length = std::min<std::size_t>(bytes[0] % 10, bytes.size() - 2);
    chip.write(bytes.subspan(1, length), now);
    now += std::chrono::milliseconds(bytes[1 + length]);
    chip.advance(now);
    bytes = bytes.subspan(2 + length);
    SINEW_ASSERT(wrapped(chip.actual(), chip.parameters().step_mode) == chip.actual());
    SINEW_ASSERT(!chip.next_event() || (chip.moving() && *chip.next_event() > now));
  }
  // A RunInit that hangs, and only that, moves for ever.
  now += std::chrono::hours(1);
  chip.advance(now);
  SINEW_ASSERT(!chip.next_event());
  Answer answer{};
  chip.write(encode_command(GetFullStatus1{}), now);
  SINEW_ASSERT(chip.read(answer, now) && decode_status1(answer));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  commands_have_one_spelling(bytes);
  answers_are_their_bytes(bytes);
  chip_survives(bytes);
  return 0;
}
