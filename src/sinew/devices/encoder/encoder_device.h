#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/axis/axis_device_i2c.h"
#include "sinew/devices/encoder/encoder_device_chip.h"
#include "sinew/devices/encoder/encoder_wire.h"

namespace sinew {

/// Position, speed and acceleration of a shaft from its 12-bit angle, one reading a sample.
///
/// A fading-memory filter of second order with theta = 15/16 (three equal poles): alpha 721/4096,
/// beta 93/8192, gamma/T^2 1/4096, so whole numbers are exact and a chip without floating point
/// does it in a few shifts. It follows constant acceleration without lag. At 1000 samples/s speed
/// is 3 dB down at 17 Hz and acceleration at 5.5 Hz, their noise below 10 ticks/s and 210 ticks/s^2
/// rms. Source: N. Morrison, Introduction to Sequential Smoothing and Prediction, 1969, ch. 13. @rt
class ShaftObserver {
 public:
  /// Forgets the past: at `position` (0..4095), at rest.
  void restart(std::uint16_t position);
  void update(std::uint16_t position);
  /// A sample without a reading: it goes on as it went.
  void coast();

  std::int64_t ticks_per_sample_q20() const { return speed_; }  ///< 2^-20 ticks/sample
  std::int64_t ticks_per_sample2_q20() const { return acceleration_; }

 private:
  std::uint32_t angle_ = 0;  ///< 2^-20 ticks: a whole turn is 2^32, so that it wraps by itself
  std::int64_t speed_ = 0;
  std::int64_t acceleration_ = 0;
};

/// The encoder node: reads an AS5600 over I2C at a fixed rate and answers on the encoder link.
///
///   state     | event                                  | next; what registers 1..3 answer
///   ----------+----------------------------------------+----------------------------------
///   kBlind    | good reading                           | kSettling; silence until then
///   kSettling | kSettleSamples good readings           | kSettled; position only until then
///   kSettled  | one to `stale` without a good reading  | kSettled; all three, coasting
///   any       | `stale` without a good reading         | kBlind
///
/// A good reading: the chip acknowledged and sees its magnet. The document has no way to say that a
/// value is none, so a value that is none is not sent; STATUS (ours) is always answered and says
/// why. POSITION is the latest reading itself, not filtered. @rt
class EncoderNode {
 public:
  struct Settings {
    Duration sample_period = std::chrono::milliseconds(1);
    Duration stale = std::chrono::milliseconds(5);
    /// A pause between bytes that ends a request; more than a byte at 9600 baud.
    Duration byte_gap = std::chrono::milliseconds(3);
  };

  /// @param bus  outlives the node.
  EncoderNode(I2cBus& bus, const Settings& settings, Instant boot);

  void advance(Instant now);
  void receive(std::span<const std::uint8_t> bytes, Instant now);
  /// Moves answers out; how many bytes. An answer that finds no room is dropped.
  std::size_t take_output(std::span<std::uint8_t> out);
  Instant next_sample() const { return next_sample_; }

 private:
  static constexpr int kSettleSamples = 128;  ///< eight times the filter's memory

  enum class State : std::uint8_t { kBlind, kSettling, kSettled };

  void sample(Instant now);
  bool read_chip(std::uint16_t& position);
  void answer(encoder_link::Register name);
  std::uint16_t status() const;
  std::int16_t per_second(std::int64_t q20, int power) const;

  I2cBus& bus_;
  Settings settings_;
  encoder_link::RequestDecoder decoder_;
  FixedVector<std::uint8_t, 4 * encoder_link::kReplySize> output_;

  State state_ = State::kBlind;
  ShaftObserver observer_;
  std::uint16_t position_ = 0;
  int good_samples_ = 0;
  Instant next_sample_;
  Instant good_at_;
  Instant byte_at_;
  As5600Reading chip_;  ///< as it last answered
  std::uint8_t bus_errors_ = 0;
  bool bus_error_ = false;
  bool restarted_ = true;
};

}  // namespace sinew
