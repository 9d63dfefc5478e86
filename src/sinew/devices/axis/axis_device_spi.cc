#include "sinew/devices/axis/axis_device_spi.h"

namespace sinew {

AxisSpiSlave::AxisSpiSlave(Axis& axis, const AxisLinkNodeSettings& link,
                           const AxisRegisterSlaveSettings& registers, SetupStore* setup)
    : node_(axis, link, setup), slave_(registers, AxisRegisterProfile::kDocument, axis) {}

void AxisSpiSlave::transfer(std::span<const std::uint8_t> mosi) {
  if (wire_ != Wire::kRegisters) {
    const std::uint64_t before = node_.good_frames();
    node_.select(true);
    for (const std::uint8_t byte : mosi) static_cast<void>(node_.shift(byte));
    node_.select(false);
    if (node_.good_frames() != before) wire_ = Wire::kLink;
  }
  if (wire_ != Wire::kLink) {
    slave_.select(true);
    for (const std::uint8_t byte : mosi) static_cast<void>(slave_.shift(byte));
    slave_.select(false);
    using State = AxisRegisterSlave::State;
    const bool accepted = slave_.state() == State::kWaitData || slave_.state() == State::kSendData;
    if (accepted) wire_ = Wire::kRegisters;
  }
}

void AxisSpiSlave::next_answer(std::span<std::uint8_t> miso) const {
  const bool registers = wire_ == Wire::kRegisters || (wire_ == Wire::kUndecided && slave_.sends());
  if (registers) return slave_.next_answer(miso);
  const axis_link::Frame& frame = node_.next_answer();
  for (std::size_t i = 0; i < miso.size(); ++i) miso[i] = i < frame.size() ? frame[i] : 0;
}

void AxisSpiSlave::advance(Instant now) {
  if (wire_ != Wire::kRegisters) node_.advance(now);
}

}  // namespace sinew
