#include "sinew/devices/lsc/lsc_file.h"

#include "sinew/devices/lsc/lsc_settings.h"
#include "sinew/devices/table_file.h"

namespace sinew {
namespace {

constexpr std::int64_t kServoIdMax = 253;
constexpr std::int64_t kUnitsMax = 2500;  // microseconds of the longest pulse

void check_ids(TableReader& reader, const LscDevice& device) {
  for (std::size_t i = 0; i < device.servos.size(); ++i) {
    bool taken = device.servos[i].id == device.gripper.id;
    for (std::size_t k = 0; k < i; ++k) taken |= device.servos[i].id == device.servos[k].id;
    if (!taken) continue;
    reader.complain("joint", "servo " + std::to_string(device.servos[i].id) + " is named twice");
    return;
  }
}

}  // namespace

void read_lsc(TableReader& reader, RobotModel& model) {
  constexpr Named<LscProfile> kProfiles[] = {
      {"lsc6", LscProfile::kLsc6}, {"bus", LscProfile::kBus}, {"esp32", LscProfile::kEsp32}};
  constexpr Range kUnits = between(0, kUnitsMax);
  auto& device = model.device.settings.emplace<LscDevice>();
  reader.choice("profile", kProfiles, device.profile);
  model.device.capability.free_drive = device.profile == LscProfile::kBus;
  device.servos.resize(model.joints.size());
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    LscServo& servo = device.servos[i];
    table.integer("servo_id", 1, kServoIdMax, servo.id);
    table.number("centre", kUnits, servo.centre);
    read_per_angle(table, "units_per_*", servo.units_per_rad);
    table.number("trim", between(-300, 300), servo.trim);
    table.integer("lower", 0, kUnitsMax, servo.lower);
    if (table.integer("upper", 0, kUnitsMax, servo.upper) && servo.upper <= servo.lower) {
      table.complain("upper", "must be above lower");
    }
  });
  if (std::optional<TableReader> gripper = reader.table("gripper")) {
    gripper->integer("servo_id", 1, kServoIdMax, device.gripper.id);
    gripper->number("open", kUnits, device.gripper.open);
    if (gripper->number("closed", kUnits, device.gripper.closed) &&
        device.gripper.open == device.gripper.closed) {
      gripper->complain("closed", "must differ from open");
    }
    gripper->finish();
  }
  if (reader.clean()) check_ids(reader, device);
}

}  // namespace sinew
