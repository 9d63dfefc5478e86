#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "sinew/devices/feetech/feetech_settings.h"
#include "sinew/devices/feetech/feetech_wire.h"

/// Servos set up one by one, before they are an arm: which numbers reply on a bus, another number
/// for one, its middle. These are the only settings that are written, and they outlive the power.
namespace sinew {

/// A bus whose servos are asked one at a time, by whoever waits for the replies.
class FeetechLine {
 public:
  virtual ~FeetechLine() = default;
  /// Nothing where none came in time.
  virtual std::optional<feetech::Reply> ask(const feetech::Read& read) = 0;
  /// Returns when the wire is free again, whatever replies.
  virtual void write(const feetech::Request& request) = 0;
  /// Bytes that were no reply came behind the last question.
  virtual bool garbled() const = 0;
};

/// One servo as it reports itself.
struct FoundServo {
  std::uint8_t id = 0;
  std::uint16_t model = 0;
  std::uint8_t firmware_major = 0;
  std::uint8_t firmware_minor = 0;
  FeetechSeries series = FeetechSeries::kSts;
  bool holds_positions = true;
  int lowest = 0;
  int highest = 0;
  int offset = 0;
  int position = 0;
  bool motor_on = false;
  double load = 0;  ///< share of its voltage
  double volts = 0;
  double heat = 0;  ///< deg C
  std::uint8_t trouble = 0;
};

struct FoundServos {
  std::vector<FoundServo> servos;     ///< by their numbers
  std::vector<std::uint8_t> garbled;  ///< numbers that more than one servo seems to have
};

/// Every number from 0 to `last` is asked.
/// @param each  called before each, for whoever waits; false ends it
FoundServos find_servos(FeetechLine& line, std::uint8_t last, bool (*each)(std::uint8_t));
/// @error  a sentence: no such servo, garbled replies
std::expected<FoundServo, std::string> find_servo(FeetechLine& line, std::uint8_t id);

/// @return  the servo by its new number
/// @error  a sentence; its number is as it was, unless it says otherwise
std::expected<FoundServo, std::string> change_id(FeetechLine& line, std::uint8_t from,
                                                 std::uint8_t to);
/// Where the servo is becomes its middle, 2048, its motor off.
/// @error  a sentence
std::expected<FoundServo, std::string> set_middle(FeetechLine& line, std::uint8_t id);

}  // namespace sinew
