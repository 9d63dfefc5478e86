#include "sinew/devices/ideal/ideal_file.h"

#include <algorithm>

#include "sinew/devices/table_file.h"

namespace sinew {
namespace {

/// The longest line of the ideal wire, and the pace at which a motion of such lines still streams.
constexpr double kLineBits = 264 * 10;
constexpr std::int64_t kBaudLeast = 57'600;

}  // namespace

void read_ideal(TableReader& reader, RobotModel& model) {
  Device& device = model.device;
  reader.needs_no_source();  // whoever writes the sketch chooses the pace
  reader.optional().integer("baud", kBaudLeast, 4'000'000, device.baud);
  // Three quarters of the line for the segments, whatever its pace.
  const double line_s = kLineBits / device.baud;
  device.capability.segment = std::max(device.capability.segment, from_seconds(line_s / 0.75));
}

}  // namespace sinew
