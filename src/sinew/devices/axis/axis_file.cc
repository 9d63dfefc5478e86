#include "sinew/devices/axis/axis_file.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/number_text.h"
#include "sinew/devices/axis_link/axis_link_settings.h"
#include "sinew/devices/axis_registers/axis_registers_settings.h"
#include "sinew/devices/table_file.h"

namespace sinew {
namespace {

constexpr std::int64_t kClockMax = 50'000'000;  // Hz, what a Raspberry Pi's header still carries
constexpr std::int64_t kGpioMax = 53;           // BCM numbers

constexpr Named<std::int8_t> kDirections[] = {{"lower", -1}, {"upper", 1}};
constexpr Named<bool> kEncoderLines[] = {{"i2c", false}, {"rs485", true}};

void read_board(TableReader& table, AxisBoard& board) {
  table.integer("spi_bus", 0, 9, board.spi_bus);
  table.integer("spi_device", 0, 9, board.spi_device);
  table.integer("select_gpio", 0, kGpioMax, board.select_gpio);
  table.integer("ready_gpio", 0, kGpioMax, board.ready_gpio);
  table.optional().integer("homing_place", 1, kMaxJoints, board.homing_place);
  table.optional().choice("homing_end", kDirections, board.homing_direction);
  table.optional().choice("encoder_by", kEncoderLines, board.encoder_node);
}

/// Two boards on one select line would both answer.
void check_selects(TableReader& reader, const AxisBoards& boards) {
  for (std::size_t i = 0; i < boards.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (boards[i].select_gpio != boards[k].select_gpio) continue;
      reader.complain("joint", "boards " + std::to_string(k + 1) + " and " + std::to_string(i + 1) +
                                   " share select_gpio " + std::to_string(boards[i].select_gpio));
      return;
    }
  }
}

/// Each joint has its turn, or none says anything of it.
void check_homing(TableReader& reader, const AxisBoards& boards) {
  std::size_t placed = 0;
  std::uint32_t places = 0;
  for (const AxisBoard& board : boards) {
    placed += board.homing_place != 0 ? 1 : 0;
    places |= 1U << board.homing_place;
  }
  const std::uint32_t all = (1U << (boards.size() + 1)) - 2;
  if (placed == 0 || (placed == boards.size() && places == all)) return;
  reader.complain("joint", "homing_place of the joints has to be each of 1 to " +
                               std::to_string(boards.size()) + " once, or to stand nowhere");
}

void read_map(TableReader& reader, AxisRegisterMap& map) {
  std::optional<TableReader> table = reader.table("register", Presence::kOptional);
  if (!table) return;
  constexpr std::int64_t kLast = 0xFFFF;
  table->integer("homing", 0, kLast, map.homing);
  table->integer("move_angle", 0, kLast, map.move_angle);
  table->integer("diag_control", 0, kLast, map.diag_control);
  table->integer("diag_status", 0, kLast, map.diag_status);
  table->integer("emergency_stop", 0, kLast, map.emergency_stop);
  table->finish();
  std::array numbers{map.homing, map.move_angle, map.diag_control, map.diag_status,
                     map.emergency_stop};
  std::ranges::sort(numbers);
  if (std::ranges::adjacent_find(numbers) != numbers.end()) {
    table->complain("two registers have the same number");
  }
}

}  // namespace

void check_axis_boards(TableReader& root, const RobotModel& model) {
  const auto boards = boards_of(model.device);
  const auto& drives = model.dynamics.drives;
  for (std::size_t i = 0; i < boards.size(); ++i) {
    const bool fitted = i < drives.size() && drives[i].joint_encoder == JointEncoder::kAs5600;
    if (!boards[i].encoder_node || fitted) continue;
    root.complain("joint", "`encoder_by` of `" + model.joints[i].name +
                               "` is how its AS5600 is read, and [drive." + model.joints[i].name +
                               "] does not say joint_encoder = \"as5600\"");
  }
  for (std::size_t i = 0; i < model.dynamics.drives.size(); ++i) {
    const double rate = model.joints[i].velocity_max * model.dynamics.drives[i].steps_per_rad();
    const double most = kStepRateShare * boards[i].step_rate_max;
    if (rate <= most) continue;
    root.complain("joint", "at its highest speed `" + model.joints[i].name + "` takes " +
                               number_text(std::round(rate)) +
                               " microsteps a second, and its board " + "makes " +
                               number_text(most) +
                               ": lower its speed, its microsteps, or say what the boards make " +
                               "(`step_rate_hz_max`, of the axis link)");
  }
}

void read_axis_registers(TableReader& reader, RobotModel& model) {
  constexpr Named<AngleEncoding> kEncodings[] = {{"deg_u32", AngleEncoding::kDegU32},
                                                 {"mdeg_i32", AngleEncoding::kMdegI32},
                                                 {"f32_be", AngleEncoding::kF32Be},
                                                 {"f32_le", AngleEncoding::kF32Le}};
  constexpr Named<bool> kStatus[] = {{"bits", true}, {"none", false}};
  model.device.capability.takes_speed = false;
  auto& device = model.device.settings.emplace<AxisRegistersDevice>();
  reader.integer("clock_hz", 1000, kClockMax, device.clock_hz);
  reader.integer("slave_id", 0, 255, device.slave_id);
  reader.choice("angle_encoding", kEncodings, device.encoding);
  reader.choice("status", kStatus, device.reports_status);
  read_map(reader, device.registers);
  device.boards.resize(model.joints.size());
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    read_board(table, device.boards[i]);
    table.quantity("zero_*", kAngle, between(from_deg(-720), from_deg(720)), device.boards[i].zero);
  });
  if (reader.clean()) check_selects(reader, device.boards);
  if (reader.clean()) check_homing(reader, device.boards);
}

void read_axis_link(TableReader& reader, RobotModel& model) {
  model.device.capability.limits_share = 0.8;
  auto& device = model.device.settings.emplace<AxisLinkDevice>();
  reader.integer("clock_hz", 1000, kClockMax, device.clock_hz);
  std::int64_t deadline_ms = 100;
  reader.integer("deadline_ms", 20, 500, deadline_ms);
  device.deadline = std::chrono::milliseconds(deadline_ms);
  device.boards.resize(model.joints.size());
  std::int64_t rate = std::lround(device.boards[0].step_rate_max);
  reader.optional().integer("step_rate_hz_max", 100, kStepRateMost, rate);
  for_each_joint(reader, model, [&](std::size_t i, TableReader& table) {
    device.boards[i].step_rate_max = static_cast<double>(rate);
    read_board(table, device.boards[i]);
  });
  if (reader.clean()) check_selects(reader, device.boards);
  if (reader.clean()) check_homing(reader, device.boards);
}

}  // namespace sinew
