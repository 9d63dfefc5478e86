#include "sinew/devices/feetech/feetech_file.h"

#include "sinew/devices/feetech/feetech_settings.h"
#include "sinew/devices/table_file.h"

namespace sinew {
namespace {

void read_torque(TableReader& table, const FeetechDevice& device, double& share) {
  double percent = 100 * share;
  if (!table.optional().number("torque_limit_percent", between(1, 100), percent)) return;
  if (device.series == FeetechSeries::kScs) {
    table.complain("torque_limit_percent", "only STS servos can be told");
  }
  share = percent / 100;
}

}  // namespace

void read_feetech(TableReader& reader, RobotModel& model) {
  constexpr Named<FeetechSeries> kSeries[] = {{"sts", FeetechSeries::kSts},
                                              {"scs", FeetechSeries::kScs}};
  constexpr Named<double> kTurns[] = {{"same", 1}, {"other", -1}};
  if (!std::holds_alternative<SerialGeometry>(model.geometry) ||
      model.joints.size() >= FeetechDevice::kServosMax) {
    reader.complain("protocol", "this wire drives arms of up to 7 joints that turn");
    return reader.ignore_rest();
  }
  constexpr std::uint32_t kBaudLeast = 38'400;
  if (model.device.baud < kBaudLeast) {
    reader.complain("baud",
                    "has to be 38400 at least: all servos are told and asked in each cycle");
  }
  auto& device = model.device.settings.emplace<FeetechDevice>();
  device.servos.resize(model.joints.size());
  model.device.capability.free_drive = true;
  reader.choice("series", kSeries, device.series);
  const Range units = between(0, device.units_max());
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    FeetechDevice::Servo& servo = device.servos[i];
    table.integer("servo_id", 0, FeetechDevice::kIdMax, servo.id);
    table.number("centre", units, servo.centre);
    table.optional().choice("turn", kTurns, servo.sign);
    read_torque(table, device, servo.torque_limit);
  });
  if (std::optional<TableReader> gripper = reader.table("gripper", Presence::kOptional)) {
    gripper->integer("servo_id", 0, FeetechDevice::kIdMax, device.gripper.id);
    gripper->number("open", units, device.gripper.open);
    if (gripper->number("closed", units, device.gripper.closed) &&
        device.gripper.open == device.gripper.closed) {
      gripper->complain("closed", "must differ from open");
    }
    read_torque(*gripper, device, device.gripper.torque_limit);
    gripper->finish();
  } else {
    model.device.capability.hand = HandDrive::kNone;
  }
}

void check_feetech(TableReader& root, const RobotModel& model) {
  const std::string why = model.device.settings.get<FeetechDevice>().contradiction(model);
  if (!why.empty()) root.complain("device", why);
}

}  // namespace sinew
