#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_driver_channel.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_byte.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"
#include "sinew/model/device.h"

namespace sinew {

struct BigRobotArmFound {
  BigRobotArmWire wire = BigRobotArmWire::kByte;
  BigRobotArmDialect dialect = BigRobotArmDialect::k2021;  ///< of the text wire
  friend bool operator==(const BigRobotArmFound&, const BigRobotArmFound&) = default;
};

/// Finds out which of its wires a BigRobotArm speaks, with one question: `08 0D`. On the byte wire
/// that is the status; on the text wire a line that no generation knows, which the one of 2021
/// echoes and the one of 2026 does not. No single flipped, lost or doubled bit or byte of it is a
/// command that moves anything. Only where another host left half a request behind, its `0D` ends
/// that one, as any byte would; who knows of such an end resets the board first.
///
/// It asks after a pause of `quiet`, ever more slowly while nothing comes (a device in motion is
/// deaf), and believes two equal answers in a row. @rt
class BigRobotArmProbe {
 public:
  explicit BigRobotArmProbe(const BigRobotArmChannelTiming& timing = {}) : timing_(timing) {}

  /// The port is open.
  void open(Instant now);
  void receive(std::span<const std::uint8_t> bytes, Instant now);
  void poll(Instant now);
  std::optional<Instant> next_deadline() const { return deadline_; }
  std::size_t take_output(std::span<std::uint8_t> out);
  /// Once there is one it stays until the next open().
  std::optional<BigRobotArmFound> found() const { return found_; }
  /// Bytes since open() that are part of no answer.
  std::uint64_t unexpected() const { return unexpected_; }
  /// The last byte that came.
  std::uint8_t last_byte() const { return last_byte_; }

 private:
  std::optional<BigRobotArmFound> take_byte(std::uint8_t byte);
  std::optional<BigRobotArmFound> take_line(std::string_view raw);
  void wait(Duration pause, Instant now);

  BigRobotArmChannelTiming timing_;
  std::optional<Instant> deadline_;
  bool asked_ = false;
  int silent_ = 0;
  std::uint64_t unexpected_ = 0;
  std::uint64_t unread_ = 0;  ///< bytes since the question
  std::uint8_t last_byte_ = 0;
  FixedVector<std::uint8_t, 2> output_;
  bigrobotarm::byte::ReplyDecoder byte_decoder_;
  bigrobotarm::text::Characters line_;
  bool echoed_ = false;   ///< the line before told our question
  bool invalid_ = false;  ///< and the one behind it that nobody knows it
  std::optional<BigRobotArmFound> first_;
  std::optional<BigRobotArmFound> found_;
};

}  // namespace sinew
