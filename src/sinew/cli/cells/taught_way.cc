#include "sinew/cli/cells/taught_way.h"

#include <fmt/format.h>

#include <cmath>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/program_format.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/plans/program_check.h"
#include "sinew/runtime/records/mcap_reader.h"

namespace sinew::cli {
namespace {

constexpr std::size_t kFileMax = std::size_t{1} << 30;

/// One joint's place, where it is known for sure.
std::optional<double> known_joint(const Json& joint, const Joint& model) {
  if (!joint.is_object()) return std::nullopt;
  const bool leg = model.slides();
  const auto value = joint.find(leg ? "position_m" : "position_rad");
  const auto quality = joint.find("quality");
  if (value == joint.end() || quality == joint.end() || !value->is_number()) return std::nullopt;
  if (*quality != "measured" && *quality != "commanded") return std::nullopt;
  const double q = value->get<double>();
  return std::isfinite(q) ? std::optional(q) : std::nullopt;
}

std::string outside_note(const program::WayRows& rows, const RobotModel& robot) {
  const double most = rows.outside_max;
  std::string by = number(to_deg(most), 2) + " deg";
  if (all_slide(robot)) {
    by = number(to_mm(most), 2) + " mm";
  } else if (prismatic_joints(robot) != 0) {
    by += " or " + number(to_mm(most), 2) + " mm";
  }
  return fmt::format(
      "{} of its places lay outside the limits, by {} at most, and were moved to them",
      rows.outside, by);
}

/// A machine may have been led, or left, to where no program goes.
std::optional<std::string> first_refusal(const std::string& rows, const RobotModel& robot) {
  const auto program = program::parse(rows, "the way", robot);
  if (!program) return std::nullopt;
  const auto checked = program::check(*program, robot, home_joints(robot));
  for (const program::RowVerdict& row : checked.rows) {
    if (!row.refusal) continue;
    return fmt::format("from home, its row {} is refused: {}", row.refusal->line,
                       error_text(row.refusal->error, robot));
  }
  return std::nullopt;
}

}  // namespace

std::optional<JointVector> known_joints(const Json& joints, const RobotModel& robot) {
  JointVector q;
  for (std::size_t j = 0; j < robot.joints.size(); ++j) {
    const Joint& model = robot.joints[j];
    const bool there = joints.is_array() ? j < joints.size() : joints.contains(model.name);
    if (!there) return std::nullopt;
    const auto value = known_joint(joints.is_array() ? joints[j] : joints[model.name], model);
    if (!value) return std::nullopt;
    q.push_back(*value);
  }
  return q;
}

std::expected<std::vector<program::WaySample>, Outcome> way_of_record(const std::string& file,
                                                                      const RobotModel& robot) {
  const auto text = io::read_file(file, kFileMax);
  if (!text) return std::unexpected(bad_input(text.error().sentence));
  const auto content =
      runtime::read_mcap({reinterpret_cast<const std::uint8_t*>(text->data()), text->size()});
  if (content.trouble && !content.trouble->cut) {
    return std::unexpected(bad_input(fmt::format(
        "{}: at byte {}: {}", file, content.trouble->offset, content.trouble->sentence)));
  }
  std::vector<program::WaySample> way;
  std::size_t unknown = 0;
  std::optional<std::uint64_t> begin;
  for (const runtime::McapMessage& message : content.messages) {
    if (!content.channels.at(message.channel).topic.ends_with("/joint_states")) continue;
    const Json json = Json::parse(message.data, nullptr, false);
    const auto joints = json.is_object() ? json.find("joints") : json.end();
    const auto q =
        json.is_object() && joints != json.end() ? known_joints(*joints, robot) : std::nullopt;
    if (!begin) begin = message.time;
    const double t = 1e-9 * static_cast<double>(message.time - *begin);
    if (q && message.time >= *begin && (way.empty() || t > way.back().t)) {
      way.push_back({t, *q});
    } else {
      ++unknown;
    }
  }
  if (way.size() >= 2) return way;
  return std::unexpected(bad_input(fmt::format(
      "{}: has no way of {} in it ({} samples without its joints)", file, robot.id, unknown)));
}

std::expected<TaughtProgram, Outcome> program_of_way(std::span<const program::WaySample> way,
                                                     const RobotModel& robot) {
  const program::WayRows rows = program::rows_of_way(way, robot);
  if (rows.text.empty()) {
    return std::unexpected(could_not("nothing moved, so there is no way to go"));
  }
  TaughtProgram taught;
  if (rows.outside > 0) taught.notes.push_back(outside_note(rows, robot));
  if (const auto refused = first_refusal(rows.text, robot)) taught.notes.push_back(*refused);
  std::string text;
  for (const std::string& note : taught.notes) text += "# " + note + "\n";
  auto formatted = program::format(text + rows.text, "the way");
  if (!formatted) return std::unexpected(complaints_outcome(formatted.error()));
  taught.text = std::move(*formatted);
  return taught;
}

}  // namespace sinew::cli
