#include <cstddef>
#include <cstdint>
#include <string_view>

#include "sinew/core/assert.h"
#include "sinew/program/formats/gcode_file.h"
#include "sinew/program/formats/pose_file.h"
#include "sinew/program/formats/program_format.h"
#include "sinew/program/plans/program_check.h"

// A program file for a small arm: whatever is accepted has its loops closed and can be planned, or
// is refused, in bounded time; whatever is refused has a place and a sentence. Laid out it is the
// same once and for all, and what others write is read as a program or refused.

namespace {

using namespace sinew;

/// A small arm whose tool has somewhere to go.
const RobotModel& small_arm() {
  static const RobotModel model = [] {
    RobotModel robot;
    robot.id = "small";
    robot.geometry = PalletizerGeometry{.base_height = 0.084,
                                        .shoulder_offset = 0.008,
                                        .upper_arm = 0.128,
                                        .forearm = 0.138,
                                        .tool_offset = 0.017,
                                        .base_front = kPi * 2 / 3,
                                        .radius_min = 0.05};
    for (const char* name : {"base", "shoulder", "elbow"}) {
      robot.joints.push_back({name, JointKind::kRevolute, -1, 4, 1, 1, 1, 1.5});
    }
    robot.joints.back().home = 0.5;
    return robot;
  }();
  return model;
}

/// Its own layout stays, and takes nothing from what is read.
void look_at_layout(std::string_view text, bool is_program) {
  const auto once = program::format(text, "f");
  if (!once) return;
  const auto twice = program::format(*once, "f");
  SINEW_ASSERT(twice && *twice == *once);
  SINEW_ASSERT(!is_program || program::parse(*once, "f", small_arm()));
}

void look_at_foreign(std::string_view text) {
  const auto rows = program::rows_of_gcode(text, "f", small_arm());
  SINEW_ASSERT(rows || !rows.error().empty());
  const auto pose = program::read_pose_file(text, "f");
  SINEW_ASSERT(pose || !pose.error().empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto program = program::parse(text, "f", small_arm());
  look_at_layout(text, program.has_value());
  look_at_foreign(text);
  if (!program) {
    SINEW_ASSERT(!program.error().empty());
    for (const Complaint& complaint : program.error()) {
      SINEW_ASSERT(complaint.line >= 1 && complaint.column >= 1 && !complaint.message.empty());
    }
    return 0;
  }
  const auto plan = program::make_plan(*program, small_arm(), JointVector{1.5, 1.5, 0.5});
  const auto checked = program::check(*program, small_arm(), JointVector{1.5, 1.5, 0.5});
  SINEW_ASSERT(checked.fine() == plan.has_value());
  if (!plan) {
    SINEW_ASSERT(plan.error().line >= 1);
    return 0;
  }
  SINEW_ASSERT(plan->orders.size() <= program::kOrdersMax && plan->duration >= 0);
  return 0;
}
