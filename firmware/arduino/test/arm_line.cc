#include "arm_line.h"

#include <algorithm>

#include "sinew/devices/maxarm/maxarm_test_model.h"
#include "virtual_clock.h"

namespace sinew::arduino {
namespace {

using namespace std::chrono_literals;

constexpr Duration kByteTime = std::chrono::nanoseconds(1041667);
constexpr Duration kSinceBoot = 20s;

}  // namespace

ArmLine::ArmLine(MaxArmChecksum checksum, MaxArmVariant variant, std::uint64_t seed) {
  set_clock(Instant{} + kSinceBoot, 0);
  machine_ = std::make_unique<sim::MaxArmMachine>(test::maxarm_model(), checksum, variant, seed,
                                                  Instant{});
  machine_->advance(machine_now_ = now());
}

void ArmLine::exchange(MaxArmChecksum checksum, MaxArmVariant variant) {
  machine_ = std::make_unique<sim::MaxArmMachine>(test::maxarm_model(), checksum, variant, 4,
                                                  now() - kSinceBoot);
  machine_->advance(machine_now_ = now());
}

double ArmLine::pulse(std::size_t servo) const {
  static const RobotModel model = test::maxarm_model();
  const MaxArmServo& drive = model.device.settings.get<MaxArmDevice>().servos[servo];
  return drive.offset + drive.pulses_per_rad * machine_->truth().joints[servo].q;
}

size_t ArmLine::write(const uint8_t* bytes, size_t count) {
  pump();
  writes.push_back({now(), {bytes, bytes + count}});
  Chunk chunk;
  sent_until_ = std::max(sent_until_, now());
  for (size_t i = 0; i < count; ++i) chunk.push_back({bytes[i], sent_until_ += kByteTime});
  if (blocking) pass(sent_until_ - now());
  if (to_arm) to_arm(chunk);
  outgoing_.insert(outgoing_.end(), chunk.begin(), chunk.end());
  return count;
}

int ArmLine::available() {
  pump();
  return static_cast<int>(
      std::ranges::count_if(incoming_, [](const TimedByte& timed) { return timed.due <= now(); }));
}

int ArmLine::peek() {
  pump();
  return incoming_.empty() || incoming_.front().due > now() ? -1 : incoming_.front().byte;
}

int ArmLine::read() {
  if (babble) {
    pass(kByteTime);
    return *babble;
  }
  const int byte = peek();
  if (byte >= 0) incoming_.pop_front();
  return byte;
}

void ArmLine::put_unsolicited(const std::vector<std::uint8_t>& bytes) {
  for (const std::uint8_t byte : bytes) incoming_.push_back({byte, now()});
}

void ArmLine::wait(Duration time) {
  pass(time);
  pump();
}

void ArmLine::pump() {
  Instant at{};
  do {
    at = now();
    if (const auto event = machine_->next_event()) at = std::min(at, *event);
    if (!outgoing_.empty()) at = std::min(at, outgoing_.front().due);
    at = std::max(at, machine_now_);
    machine_->advance(machine_now_ = at);
    while (!outgoing_.empty() && outgoing_.front().due <= at) {
      machine_->receive({&outgoing_.front().byte, 1}, at);
      outgoing_.pop_front();
    }
    take_replies(at);
  } while (at < now());
}

void ArmLine::take_replies(Instant at) {
  std::array<std::uint8_t, 64> bytes{};
  const std::size_t count = machine_->take_output(bytes);
  if (count == 0) return;
  Chunk chunk;
  for (std::size_t i = 0; i < count; ++i) chunk.push_back({bytes[i], at += kByteTime});
  if (from_arm) from_arm(chunk);
  // A line keeps the order of its bytes, however late they are.
  for (TimedByte& timed : chunk) {
    if (!incoming_.empty()) timed.due = std::max(timed.due, incoming_.back().due);
    incoming_.push_back(timed);
  }
}

}  // namespace sinew::arduino
