#include "sinew/config/read_joints.h"

#include <algorithm>
#include <array>

#include "sinew/core/number_text.h"
#include "sinew/model/joints_moved.h"

namespace sinew {
namespace {

constexpr std::size_t kMaxNameBytes = 32;

/// What a joint of one kind is measured in, and how much of it is believable.
struct JointScale {
  Dimension position, velocity, acceleration, jerk;
  Range limits;  // rad or m
  Range velocity_max, acceleration_max, jerk_max;
  Unit shown;
};

constexpr JointScale kRevoluteScale{kAngle,
                                    kAngleRate,
                                    kAngleRate2,
                                    kAngleRate3,
                                    between(from_deg(-720), from_deg(720)),
                                    above_zero_to(from_deg(3600)),
                                    above_zero_to(from_deg(1e5)),
                                    above_zero_to(from_deg(1e7)),
                                    kAngle[0]};
/// Of legs and of joints that slide.
constexpr JointScale kPrismaticScale{
    kLength,           kLengthRate,        kLengthRate2,       kLengthRate3, between(-10, 10),
    above_zero_to(10), above_zero_to(1e3), above_zero_to(1e5), kLength[0]};

bool letter(char c) {
  return c >= 'a' && c <= 'z';
}
bool digit(char c) {
  return c >= '0' && c <= '9';
}

/// Names are typed on command lines and stand beside J1..Jn, which every robot has already.
bool good_name(std::string_view name) {
  const bool plain =
      std::ranges::all_of(name, [](char c) { return letter(c) || digit(c) || c == '_'; });
  const bool numbered =
      name.size() > 1 && name.front() == 'j' && std::ranges::all_of(name.substr(1), digit);
  return plain && letter(name.front()) && !numbered;
}

std::string shown(double q, const JointScale& scale) {
  return number_text(q / scale.shown.to_si) + " " + std::string(scale.shown.text);
}

void read_name(TableReader& reader, const std::vector<Joint>& before, Joint& joint) {
  if (!reader.text("name", kMaxNameBytes, joint.name)) return;
  if (!good_name(joint.name)) {
    reader.complain("name",
                    "must be lower-case letters, digits and _, begin with a letter, and not look "
                    "like j1, which every robot has");
    return;
  }
  const auto twin = std::ranges::find(before, joint.name, &Joint::name);
  if (twin != before.end()) {
    reader.complain("name", "joint " + std::to_string(twin - before.begin() + 1) + " is called `" +
                                joint.name + "` already");
    return;
  }
  reader.rename("joint." + joint.name);
}

/// Where a file does not say how hard a joint may be driven: s to full speed, and to full
/// acceleration.
constexpr double kAssumedSpeedUp = 0.25;
constexpr double kAssumedPushUp = 0.1;

constexpr std::array kJointKinds = std::to_array<Named<JointKind>>(
    {{"revolute", JointKind::kRevolute}, {"prismatic", JointKind::kPrismatic}});

Joint read_joint(TableReader& reader, GeometryKind geometry, const std::vector<Joint>& before) {
  const bool has_home = geometry != GeometryKind::kHexapod;
  Joint joint;
  read_name(reader, before, joint);
  if (geometry == GeometryKind::kHexapod) joint.kind = JointKind::kPrismatic;
  if (geometry == GeometryKind::kSerial) reader.optional().choice("kind", kJointKinds, joint.kind);
  const bool slides = joint.kind == JointKind::kPrismatic;
  const JointScale& scale = slides ? kPrismaticScale : kRevoluteScale;
  const bool lower = reader.quantity("lower_*", scale.position, scale.limits, joint.lower);
  const bool upper = reader.quantity("upper_*", scale.position, scale.limits, joint.upper);
  const bool ordered = lower && upper && joint.lower < joint.upper;
  if (lower && upper && !ordered) {
    reader.complain("upper_*", "limits reversed or equal: must be above the lower limit, " +
                                   shown(joint.lower, scale));
  }
  reader.quantity("velocity_*_max", scale.velocity, scale.velocity_max, joint.velocity_max);
  joint.acceleration_max = joint.velocity_max / kAssumedSpeedUp;
  if (!reader.optional().quantity("acceleration_*_max", scale.acceleration, scale.acceleration_max,
                                  joint.acceleration_max)) {
    reader.note_assumed("acceleration_max", "assumed: full speed in 0.25 s");
  }
  joint.jerk_max = joint.acceleration_max / kAssumedPushUp;
  if (!reader.optional().quantity("jerk_*_max", scale.jerk, scale.jerk_max, joint.jerk_max)) {
    reader.note_assumed("jerk_max", "assumed: full acceleration in 0.1 s");
  }
  if (ordered) joint.home = std::clamp(0.0, joint.lower, joint.upper);
  if (has_home && reader.optional().quantity("home_*", scale.position, scale.limits, joint.home) &&
      ordered) {
    if (!within_limits(joint, joint.home)) {
      reader.complain("home_*", "must be inside the joint's limits, " + shown(joint.lower, scale) +
                                    " to " + shown(joint.upper, scale));
    }
    joint.home = std::clamp(joint.home, joint.lower, joint.upper);
  }
  reader.finish();
  return joint;
}

void set_home_of_legs(TableReader& root, RobotModel& model) {
  const auto& geometry = std::get<HexapodGeometry>(model.geometry);
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    Joint& leg = model.joints[i];
    leg.home = norm(geometry.X_BP_home * geometry.p_PA[i] - geometry.p_BA[i]);
    if (!within_limits(leg, leg.home)) {
      root.complain("geometry", "the home pose needs " + shown(leg.home, kPrismaticScale) +
                                    " of `" + leg.name + "`, limits " +
                                    shown(leg.lower, kPrismaticScale) + " to " +
                                    shown(leg.upper, kPrismaticScale));
    }
  }
}

/// Tells the chain which of its rows slide.
void set_slides(RobotModel& model) {
  auto& chain = std::get<SerialGeometry>(model.geometry);
  for (std::size_t i = 0; i < model.joints.size(); ++i) chain.rows[i].kind = model.joints[i].kind;
}

}  // namespace

void read_joints(TableReader& root, GeometryKind kind, RobotModel& model) {
  const bool legs = kind == GeometryKind::kHexapod;
  std::vector<TableReader> readers = root.tables("joint");
  for (TableReader& reader : readers) {
    if (model.joints.size() == kMaxJoints) {
      reader.complain("one joint too many: a robot has at most " + std::to_string(kMaxJoints));
      return;
    }
    model.joints.push_back(read_joint(reader, kind, model.joints));
  }
  if (readers.empty()) return;
  const std::size_t wanted = joints_moved_by(model.geometry);
  if (wanted == 0) return;  // a chain without rows has been complained about
  if (readers.size() != wanted) {
    readers[std::min(readers.size() - 1, wanted)].complain(
        "the file has " + std::to_string(readers.size()) + " of the " + std::to_string(wanted) +
        " joints that the geometry moves");
  } else if (legs && root.clean()) {
    set_home_of_legs(root, model);
  } else if (kind == GeometryKind::kSerial) {
    set_slides(model);
  }
}

}  // namespace sinew
