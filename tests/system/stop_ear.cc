#include "system/stop_ear.h"

#include <algorithm>

#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"
#include "sinew/devices/feetech/feetech_wire.h"
#include "sinew/devices/grbl/grbl_wire.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/devices/lsc/lsc_wire.h"
#include "sinew/devices/maxarm/maxarm_wire.h"
#include "sinew/mcu/arm_link.h"
#include "sinew/wire/cobs.h"
#include "support/visit_kind.h"

namespace sinew::test {
namespace {

class LscEar final : public StopEar {
 public:
  std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) override {
    if (decoder_.at_boundary()) began_ = begins;
    const auto frame = decoder_.push(bytes[0]);
    constexpr std::uint8_t kMove = 3;
    if (!frame || frame->command != kMove) return std::nullopt;
    return MotionFrame{began_};
  }

 private:
  lsc::FrameDecoder decoder_;
  Instant began_{};
};

class MaxArmEar final : public StopEar {
 public:
  std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) override {
    if (decoder_.at_boundary()) began_ = begins;
    const auto request = decoder_.push(bytes[0]);
    if (!request || !std::holds_alternative<maxarm::SetAngle>(*request)) return std::nullopt;
    return MotionFrame{began_};
  }

 private:
  maxarm::RequestDecoder decoder_;
  Instant began_{};
};

/// Each step is an order of its own: the host stops by giving none any more.
class IcpEar final : public StopEar {
 public:
  std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) override {
    const auto request = decoder_.push(bytes[0]);
    const bool steps = request && *request && std::holds_alternative<icp::Step>(**request);
    if (!steps) return std::nullopt;
    return MotionFrame{begins, false};
  }

 private:
  icp::RequestDecoder decoder_;
};

class AxisLinkEar final : public StopEar {
 public:
  std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) override {
    if (bytes.size() != axis_link::kFrameSize) return std::nullopt;
    const auto request = axis_link::decode_request(bytes.first<axis_link::kFrameSize>());
    if (!request || request->mode != axis_link::Mode::kStop) return std::nullopt;
    return MotionFrame{begins};
  }
};

class ArmLinkEar final : public StopEar {
 public:
  std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) override {
    if (between_) began_ = begins;
    between_ = bytes[0] == cobs::kDelimiter;
    const auto frame = decoder_.push(bytes[0]);
    mcu::arm_link::Request request{};
    const bool stop =
        frame &&
        mcu::arm_link::decode(frame->data(), static_cast<std::uint8_t>(frame->size()), request) &&
        request.kind == mcu::arm_link::Kind::kStop;
    if (!stop) return std::nullopt;
    return MotionFrame{began_};
  }

 private:
  cobs::Decoder decoder_;
  bool between_ = true;
  Instant began_{};
};

/// A hold is one character.
class GrblEar final : public StopEar {
 public:
  std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) override {
    if (bytes[0] != static_cast<std::uint8_t>(grbl::RealTime::kHold)) return std::nullopt;
    return MotionFrame{begins};
  }
};

/// Goals for all servos: the first one behind a stop begins to brake.
class FeetechEar final : public StopEar {
 public:
  std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) override {
    if (decoder_.at_boundary()) began_ = begins;
    if (decoder_.push(bytes[0]) != feetech::PacketDecoder::Result::kPacket) return std::nullopt;
    const auto request = feetech::decode_request(decoder_.packet());
    const auto* write = request ? std::get_if<feetech::SyncWrite>(&*request) : nullptr;
    if (write == nullptr || write->address != feetech::Register::kAcceleration) return std::nullopt;
    return MotionFrame{began_};
  }

 private:
  feetech::PacketDecoder decoder_;
  Instant began_{};
};

/// A transaction is one frame in several exchanges, from its SYN on.
class AxisRegistersEar final : public StopEar {
 public:
  explicit AxisRegistersEar(std::uint16_t stop_register) : stop_register_(stop_register) {}

  std::optional<MotionFrame> hear(std::span<const std::uint8_t> bytes, Instant begins) override {
    if (bytes.size() == 1 && bytes[0] == axis_registers::kSyn) began_ = begins;
    axis_registers::HeaderBytes header{};
    if (bytes.size() != header.size()) return std::nullopt;
    std::ranges::copy(bytes, header.begin());
    const auto read = axis_registers::decode_header(header);
    constexpr auto kWrite = static_cast<std::uint8_t>(axis_registers::Operation::kWrite);
    if (!read || read->operation != kWrite || read->address != stop_register_) return std::nullopt;
    return MotionFrame{began_};
  }

 private:
  std::uint16_t stop_register_;
  Instant began_{};
};

struct EarOf {
  using Ear = std::unique_ptr<StopEar>;
  Ear operator()(const IdealDevice& /*device*/) const { return nullptr; }
  Ear operator()(const BigRobotArmDevice& /*device*/) const { return nullptr; }
  Ear operator()(const LscDevice& /*device*/) const { return std::make_unique<LscEar>(); }
  Ear operator()(const MaxArmDevice& /*device*/) const { return std::make_unique<MaxArmEar>(); }
  Ear operator()(const IcpDevice& /*device*/) const { return std::make_unique<IcpEar>(); }
  Ear operator()(const AxisLinkDevice& /*device*/) const { return std::make_unique<AxisLinkEar>(); }
  Ear operator()(const ArmLinkDevice& /*device*/) const { return std::make_unique<ArmLinkEar>(); }
  Ear operator()(const GrblDevice& /*device*/) const { return std::make_unique<GrblEar>(); }
  Ear operator()(const FeetechDevice& /*device*/) const { return std::make_unique<FeetechEar>(); }
  Ear operator()(const AxisRegistersDevice& device) const {
    return std::make_unique<AxisRegistersEar>(device.registers.emergency_stop);
  }
};

}  // namespace

std::unique_ptr<StopEar> stop_ear(const Device& device) {
  return visit_kind(EarOf{}, device.settings);
}

}  // namespace sinew::test
