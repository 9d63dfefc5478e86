#include "sinew/devices/maxarm/maxarm_file.h"

#include "sinew/devices/maxarm/maxarm_settings.h"
#include "sinew/devices/table_file.h"

namespace sinew {

void read_maxarm(TableReader& reader, RobotModel& model) {
  auto& device = model.device.settings.emplace<MaxArmDevice>();
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    table.number("pulse_offset", between(-10'000, 10'000), device.servos[i].offset);
    read_per_angle(table, "pulses_per_*", device.servos[i].pulses_per_rad);
  });
}

}  // namespace sinew
