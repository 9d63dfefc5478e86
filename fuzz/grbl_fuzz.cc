#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/core/units.h"
#include "sinew/devices/grbl/grbl_device.h"
#include "sinew/devices/grbl/grbl_driver.h"
#include "sinew/devices/grbl/grbl_wire.h"

// Lines of GRBL from both sides. For any bytes: a decoder that was cut off and goes on in a copy
// finds the same lines; what is read of a line is read again of what is written of it; a board
// takes them and stays inside its own limits; and a driver that hears them never claims a position
// that nobody told, and ends each command at most once.

namespace {

using namespace sinew;

std::vector<std::string> lines_of(grbl::LineDecoder& decoder, std::span<const std::uint8_t> bytes) {
  std::vector<std::string> lines;
  for (const std::uint8_t byte : bytes) {
    const auto result = decoder.push(byte);
    if (result == grbl::LineDecoder::Result::kLine) lines.emplace_back(decoder.line());
    if (result == grbl::LineDecoder::Result::kDamaged) lines.emplace_back();
  }
  return lines;
}

void same_when_cut(std::span<const std::uint8_t> bytes) {
  grbl::LineDecoder whole;
  const auto expected = lines_of(whole, bytes);
  const std::size_t cut = bytes.empty() ? 0 : bytes[0] % (bytes.size() + 1);
  grbl::LineDecoder first;
  auto lines = lines_of(first, bytes.first(cut));
  grbl::LineDecoder second = first;
  for (const std::string& line : lines_of(second, bytes.subspan(cut))) lines.push_back(line);
  SINEW_ASSERT(lines == expected);
}

void read_again(std::string_view line) {
  if (const auto reply = grbl::decode_reply(line)) {
    // A note is all that is not looked at.
    if (std::holds_alternative<grbl::Note>(*reply)) return;
    const auto said = grbl::encode(*reply);
    SINEW_ASSERT(!said.empty() && said.back() == '\n');
    SINEW_ASSERT(grbl::decode_reply({said.data(), said.size() - 1}));
  }
}

void board_takes(std::span<const std::uint8_t> bytes) {
  grbl::BoardSettings settings;
  for (int i = 0; i < 3; ++i) settings.axes.push_back({100, {90, 400}, 180, true, 0});
  settings.homing = !bytes.empty() && (bytes[0] & 1) != 0;
  grbl::GrblDevice board(settings, Instant{});
  Instant now = Instant{} + std::chrono::seconds(1);
  for (const std::uint8_t byte : bytes) {
    board.receive(byte, now += std::chrono::milliseconds(2));
    for (std::size_t i = 0; i < 3; ++i) {
      SINEW_ASSERT(std::isfinite(board.turned(i)) && std::abs(board.velocity(i)) <= 90 + 1e-6);
    }
    std::array<std::uint8_t, 512> out{};
    board.take_output(out);
  }
}

void driver_hears(std::span<const std::uint8_t> bytes) {
  GrblDevice device;
  FixedVector<Joint, 2> joints;
  for (int i = 0; i < 2; ++i) {
    Joint joint;
    joint.lower = -2, joint.upper = 2;
    joint.velocity_max = 2, joint.acceleration_max = 8, joint.jerk_max = 80;
    joints.push_back(joint);
    device.axes.push_back({5000, 0, true});
  }
  GrblDriver driver(device, {joints.data(), joints.size()}, 115'200);
  Instant now{};
  driver.open(now);
  std::size_t ends = 0, asked = 1;  // opening has one too
  for (const std::uint8_t byte : bytes) {
    now += std::chrono::milliseconds(10);
    driver.receive({&byte, 1}, now);
    for (const JointPosition& joint : driver.positions()) {
      SINEW_ASSERT(joint.quality == PositionQuality::kLost);
    }
    if (driver.state() == DriverState::kReady && driver.nudge(0, 0.01, Duration{}, now)) ++asked;
    if (driver.state() == DriverState::kFault && driver.clear_fault(now)) ++asked;
    std::array<std::uint8_t, 512> out{};
    driver.take_output(out);
    while (const auto event = driver.take_event()) {
      if (event->kind == DriverEvent::Kind::kDone) ++ends;
    }
  }
  SINEW_ASSERT(ends <= asked);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, std::min<std::size_t>(size, 4096));
  same_when_cut(bytes);
  grbl::LineDecoder decoder;
  for (const std::string& line : lines_of(decoder, bytes)) read_again(line);
  board_takes(bytes);
  driver_hears(bytes);
  return 0;
}
