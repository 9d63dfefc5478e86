#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/axis_registers/axis_registers_device.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"

// The register protocol from both sides. For any bytes: what is accepted as a header, as data, as
// COMMIT, status or angle is written back as the very bytes it came from; a board that is copied in
// the middle of a frame goes on as the one that ran through; and four bursts always free it.

namespace {

using namespace sinew;
using namespace sinew::axis_registers;

/// An axis that only remembers what it was told.
class NotedAxis final : public Axis {
 public:
  AxisStatus status() const override { return told; }
  AxisVerdict home() override {
    told.homing = !told.homing;
    return AxisVerdict::kAccepted;
  }
  void cancel_homing() override { told.homing = false; }
  AxisVerdict move_to(double q) override {
    told.q_target = q;
    return AxisVerdict::kAccepted;
  }
  AxisVerdict track(double, double) override { return AxisVerdict::kBusy; }
  void stop(AxisFault why) override { told.fault = why; }
  void emergency_stop() override { told.emergency_stopped = true; }
  void release_emergency_stop() override { told.emergency_stopped = false; }
  void clear_faults() override { told.fault = AxisFault::kNone; }
  void self_test() override { told.moving = !told.moving; }

  AxisStatus told;
};

void what_is_accepted_has_one_spelling(std::span<const std::uint8_t> bytes) {
  if (bytes.size() >= kHeaderSize) {
    HeaderBytes header{};
    std::ranges::copy(bytes.first(kHeaderSize), header.begin());
    if (const auto decoded = decode_header(header)) SINEW_ASSERT(encode_header(*decoded) == header);
    const Header fields = read_header(header);
    SINEW_ASSERT(decode_header(encode_header(fields)) == fields);
    for (const Checks checks : {Checks::kDocument, Checks::kAsBuilt}) {
      const bool passes = check_header(header, {.checks = checks}) == Verdict::kOk;
      SINEW_ASSERT(!passes || decode_header(header));
    }
  }
  if (const auto data = unseal(bytes)) {
    SINEW_ASSERT(std::ranges::equal(seal({data->data(), data->size()}), bytes));
  }
  if (bytes.size() <= kDataMax) {
    const SealedData sealed = seal(bytes);
    const auto back = unseal({sealed.data(), sealed.size()});
    SINEW_ASSERT(back && std::ranges::equal(*back, bytes));
  }
  if (const auto verdict = decode_commit(bytes)) {
    SINEW_ASSERT(std::ranges::equal(encode_commit(*verdict), bytes));
  }
  if (const auto status = decode_status(bytes)) {
    SINEW_ASSERT(std::ranges::equal(encode_status(*status), bytes));
  }
  if (bytes.size() < 4) return;
  const AngleBytes angle{bytes[0], bytes[1], bytes[2], bytes[3]};
  using enum AngleEncoding;
  for (const AngleEncoding format : {kDegU32, kMdegI32, kF32Be, kF32Le}) {
    const auto angle_deg = decode_angle(format, angle);
    if (!angle_deg) continue;
    const auto again = encode_angle(format, *angle_deg);
    // The most negative number of thousandths is the one that the encoder does not say.
    const bool unsaid = format == kMdegI32 && angle == AngleBytes{0x80, 0, 0, 0};
    SINEW_ASSERT(unsaid ? !again : again == angle);
  }
}

AxisRegistersDevice device_for(std::uint8_t choice) {
  AxisRegistersDevice device;
  device.boards.push_back({});
  device.encoding = static_cast<AngleEncoding>(choice >> 1 & 3);
  if ((choice & 8) != 0) device.registers = {0, 1, 3, 4, 5};
  return device;
}

/// Frames: a byte that says how long, then the bytes of MOSI.
void a_cut_changes_nothing_and_bursts_free_it(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return;
  const auto profile =
      (bytes[0] & 1) != 0 ? AxisRegisterProfile::kDocument : AxisRegisterProfile::kAsBuilt;
  const AxisRegistersDevice device = device_for(bytes[0]);
  NotedAxis axis;
  AxisRegisterSlave board(axis_register_slave_settings(device, 0), profile, axis);
  std::span<const std::uint8_t> rest = bytes.subspan(1);
  while (!rest.empty()) {
    const std::size_t length = std::min<std::size_t>(rest[0] % 48, rest.size() - 1);
    const auto frame = rest.subspan(1, length);
    rest = rest.subspan(1 + length);
    const AxisStatus before = axis.told;
    AxisRegisterSlave first = board;
    std::vector<std::uint8_t> whole(frame.size());
    board.exchange(frame, whole);
    const AxisStatus after = axis.told;
    // Once more from where it was, in two halves and two copies.
    axis.told = before;
    std::vector<std::uint8_t> halves;
    first.select(true);
    for (const std::uint8_t byte : frame.first(length / 2)) halves.push_back(first.shift(byte));
    AxisRegisterSlave second = first;
    for (const std::uint8_t byte : frame.subspan(length / 2)) halves.push_back(second.shift(byte));
    second.select(false);
    SINEW_ASSERT(halves == whole && second.state() == board.state());
    SINEW_ASSERT(axis.told.q_target == after.q_target && axis.told.homing == after.homing);
    if (board.in_boot_loader()) return;
  }
  const std::vector<std::uint8_t> burst(kResyncSize, kResyncByte);
  std::vector<std::uint8_t> miso(kResyncSize);
  const double target = axis.told.q_target;
  for (int i = 0; i < kResyncBursts; ++i) board.exchange(burst, miso);
  SINEW_ASSERT(board.state() == AxisRegisterSlave::State::kWaitSyn);
  SINEW_ASSERT(axis.told.q_target == target);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(data, size);
  what_is_accepted_has_one_spelling(bytes);
  a_cut_changes_nothing_and_bursts_free_it(bytes);
  return 0;
}
