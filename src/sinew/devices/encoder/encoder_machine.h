#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/encoder/as5600_machine.h"
#include "sinew/devices/encoder/encoder_device_i2c.h"
#include "sinew/devices/encoder/encoder_wire.h"
#include "sinew/mcu/encoder_node.h"
#include "sinew/sim/machine.h"

namespace sinew::sim {

/// The board of an encoder node: it reads its chip once a millisecond and runs the node's program
/// (mcu/encoder_node.h). @rt
class EncoderBoard {
 public:
  static constexpr Duration kSamplePeriod = std::chrono::milliseconds(1);

  /// @param bus  outlives the board.
  EncoderBoard(I2cBus& bus, Instant boot);

  void advance(Instant now);
  void receive(std::span<const std::uint8_t> bytes, Instant now);
  /// Moves replies out; how many bytes. A reply that finds no room is dropped.
  std::size_t take_output(std::span<std::uint8_t> out) { return output_.take_front(out); }
  Instant next_sample() const { return next_sample_; }

 private:
  void sample(std::uint8_t elapsed);

  I2cBus& bus_;
  EncoderNode node_;
  FixedVector<std::uint8_t, 4 * encoder_link::kReplySize> output_;
  Instant next_sample_;
};

/// An encoder node with its sensor on a shaft that turns at a constant speed. Disturbances:
/// kMagnet and kBlock of the shaft, kSupply (below 3 V the node is off). @rt
class EncoderMachine : public ByteMachine {
 public:
  /// @param speed  rad/s. The seed gives the first angle and the noise.
  EncoderMachine(double speed, std::uint64_t seed, Instant boot);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return std::nullopt; }
  Truth truth() const override;
  void disturb(const Disturbance& what) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override;

 private:
  double speed_;
  double angle_;  ///< rad
  As5600 chip_;
  As5600Bus bus_{chip_};
  std::optional<EncoderBoard> board_;  ///< nothing without its supply
  Instant now_;
  double supply_volts_ = 5;
  bool blocked_ = false;
};

}  // namespace sinew::sim
