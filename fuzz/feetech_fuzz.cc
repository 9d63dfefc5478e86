// Bytes of a bus, from both sides: servos and a driver that hear them keep their promises.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sinew/core/assert.h"
#include "sinew/devices/feetech/feetech_device.h"
#include "sinew/devices/feetech/feetech_driver.h"
#include "sinew/devices/feetech/feetech_listener.h"

namespace {

using namespace sinew;

/// What was decoded is encoded to the same bytes.
void check_packets(std::span<const std::uint8_t> bytes) {
  feetech::PacketDecoder decoder;
  for (const std::uint8_t byte : bytes) {
    if (decoder.push(byte) != feetech::PacketDecoder::Result::kPacket) continue;
    const feetech::Packet& packet = decoder.packet();
    feetech::PacketDecoder again;
    if (const auto request = feetech::decode_request(packet)) {
      for (const std::uint8_t one : feetech::encode(*request)) again.push(one);
      SINEW_ASSERT(again.packet() == packet);
    }
    if (const auto reply = feetech::decode_reply(packet)) {
      feetech::PacketDecoder other;
      for (const std::uint8_t one : feetech::encode(*reply)) other.push(one);
      SINEW_ASSERT(other.packet() == packet);
    }
  }
}

void check_servos(std::span<const std::uint8_t> bytes, FeetechSeries series) {
  constexpr std::uint8_t kIds[] = {1, 2};
  Instant now{};
  sim::FeetechBusDevice bus(series, kIds, now);
  std::uint8_t out[512];
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bus.receive(bytes.subspan(i, 1), now);
    static_cast<void>(bus.take_output(out));
    if (i % 8 != 0) continue;
    now += std::chrono::milliseconds(1);
    for (std::size_t k = 0; k < 2; ++k) {
      bus.servo(k).advance(now);
      const double units = bus.servo(k).command().units;
      SINEW_ASSERT(std::isfinite(units));
      bus.servo(k).sense({.units = std::clamp(units, 0.0, 4095.0), .volts = 7.4, .heat = 30});
    }
  }
}

/// A driver that hears these bytes, and is asked for something now and then.
void check_driver(std::span<const std::uint8_t> bytes, FeetechSeries series) {
  Joint joint;
  joint.name = "a";
  joint.lower = -1;
  joint.upper = 1;
  joint.velocity_max = 3;
  joint.acceleration_max = 10;
  FeetechDevice device;
  device.series = series;
  device.servos.push_back({1, 512, 1, 1});
  device.gripper = {2, 800, 510, 0.5};
  FeetechDriver driver(device, {&joint, 1}, JawGripper{0.05, 0.1, 0.1});
  Instant now{};
  driver.open(now);
  std::uint8_t out[512];
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    now += std::chrono::microseconds(100 + 500 * (bytes[i] & 7U));
    driver.receive(bytes.subspan(i, 1), now);
    static_cast<void>(driver.take_output(out));
    if (i % 32 == 31)
      static_cast<void>(driver.move({{0.2}, {0}, std::chrono::seconds(1), {}}, now));
    if (i % 64 == 63) static_cast<void>(driver.tool(JawsTo{0.02}, now));
    if (i % 50 == 49) static_cast<void>(driver.service(DeviceService::kFree, now));
    if (i % 97 == 96) driver.stop(now);
    if (i % 128 == 127) static_cast<void>(driver.clear_fault(now));
    while (driver.take_event()) {
    }
    const auto due = driver.next_deadline();
    SINEW_ASSERT(!due || *due > now);
    for (const JointPosition& one : driver.positions()) SINEW_ASSERT(one.lower <= one.upper);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const auto series = (data[0] & 1) != 0 ? FeetechSeries::kScs : FeetechSeries::kSts;
  const std::span bytes(data + 1, size - 1);
  check_packets(bytes);
  check_servos(bytes, series);
  check_driver(bytes, series);
  FeetechDevice device;
  device.series = series;
  const auto reader = wires::feetech_reader(device);
  std::vector<WireMessage> messages;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    WirePiece piece;
    piece.way = (i / 16) % 2 == 0 ? WireWay::kToDevice : WireWay::kToHost;
    piece.bytes = {bytes[i]};
    reader->read(piece, messages);
  }
  return 0;
}
