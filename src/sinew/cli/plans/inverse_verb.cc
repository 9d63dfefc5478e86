#include "sinew/cli/plans/inverse_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/hexapod.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::cli {
namespace {

using kinematics::IkBranch;
using kinematics::IkBranches;
using kinematics::PoseBT;

/// A pose typed with a few decimals is bent by up to this to one that a five-joint arm can have.
constexpr double kTypedTolerance = 0.01 * kPi / 180;

Outcome refusal(const RobotModel& model, const Error& error) {
  Outcome outcome{ExitCode::kCouldNot, Json::object(), "", error_text(error, model)};
  outcome.json = {
      {"robot", model.id}, {"solutions", Json::array()}, {"refusal", error_json(error, model)}};
  return outcome;
}

std::vector<std::string> singular_names(std::uint8_t bits) {
  std::vector<std::string> names;
  if ((bits & kinematics::kShoulderBit) != 0) names.emplace_back("shoulder");
  if ((bits & kinematics::kElbowBit) != 0) names.emplace_back("elbow");
  if ((bits & kinematics::kWristBit) != 0) names.emplace_back("wrist");
  return names;
}

/// The branches as a table and as JSON; a refusal where none is inside its limits.
Outcome list_branches(const RobotModel& model, const IkBranches& branches) {
  Outcome outcome;
  outcome.json = {{"robot", model.id}, {"solutions", Json::array()}};
  std::vector<std::string> head{"#"};
  for (const Joint& joint : model.joints) head.push_back(joint.name);
  head.emplace_back("verdict");
  Table table(head);
  table.left(head.size() - 1);
  bool any_inside = false;
  for (const IkBranch& branch : branches) {
    any_inside |= branch.within_limits;
    const auto violations = kinematics::limit_violations(model.joints, branch.q);
    Json json{{joints_key(model), joints_json(branch.q, model)},
              {"within_limits", branch.within_limits},
              {"violations", Json::array()},
              {"singular", singular_names(branch.singular)}};
    std::string verdict = branch.within_limits ? "inside its limits" : "outside: ";
    for (const Error& violation : violations) {
      json["violations"].push_back(error_json(violation, model));
      const auto joint = static_cast<std::size_t>(violation.index);
      const Joint& outside = model.joints[joint];
      verdict +=
          fmt::format("{}{} by {} {}", &violation == violations.begin() ? "" : ", ", outside.name,
                      number(shown_value(excess(violation), outside), 1), shown_unit(outside));
    }
    if (branch.singular != 0) {
      verdict += "; singular: " + joined(singular_names(branch.singular), ", ");
    }
    outcome.json["solutions"].push_back(json);
    std::vector<std::string> row{fmt::format("{}", outcome.json["solutions"].size())};
    for (std::size_t i = 0; i < branch.q.size(); ++i) {
      row.push_back(joint_text(branch.q[i], model.joints[i]));
    }
    row.push_back(verdict);
    table.add(row);
  }
  outcome.text = table.text();
  if (!any_inside) {
    const Error nearest = kinematics::nearest_violation(model.joints, branches);
    outcome.exit = ExitCode::kCouldNot;
    outcome.json["refusal"] = error_json(nearest, model);
    outcome.complaint =
        "no solution is inside the limits; the nearest: " + error_text(nearest, model);
  }
  return outcome;
}

struct Solved {
  Expected<IkBranches> branches;
  std::optional<double> chosen_pitch;  ///< where nobody gave one
};

/// The branches for the one kind of target that the request names.
std::expected<Solved, Outcome> solve(const InverseRequest& request, const SerialGeometry& geometry,
                                     const kinematics::SerialArm& arm, const JointVector& near) {
  if (request.pose_mm_deg) {
    const auto X = parse_pose("--pose-mm-deg", *request.pose_mm_deg);
    if (!X) return std::unexpected(bad_input(X.error()));
    return Solved{arm.inverse(*X, near, kTypedTolerance), {}};
  }
  const auto p = parse_point("--point-mm", *request.point_mm);
  if (!p) return std::unexpected(bad_input(p.error()));
  if (request.approach) {
    const auto approach = parse_direction("--approach", *request.approach);
    if (!approach) return std::unexpected(bad_input(approach.error()));
    return Solved{arm.inverse_along(*p, *approach, near), {}};
  }
  if (request.pitch_deg) {
    const auto pitch = parse_quantity(*request.pitch_deg, Measure::kAngle, UnitRule::kOptional);
    if (!pitch || std::abs(*pitch) > 2 * kPi) {
      return std::unexpected(
          bad_input("--pitch-deg: " + (pitch ? "is beyond one turn" : pitch.error())));
    }
    return Solved{arm.inverse_at_pitch(*p, *pitch, near), {}};
  }
  auto pitched = arm.inverse_nearest_pitch(*p, geometry.pitch_preferred, near);
  if (!pitched) return Solved{std::unexpected(pitched.error()), {}};
  return Solved{pitched->branches, pitched->pitch};
}

Outcome inverse_serial(const InverseRequest& request, const RobotModel& model,
                       const SerialGeometry& geometry) {
  const auto jaw_width = parse_jaw_width(request.gripper_mm, &geometry);
  if (!jaw_width) return bad_input(jaw_width.error());
  const kinematics::SerialArm arm(geometry, model.joints,
                                  kinematics::tool_pose(geometry, *jaw_width));
  JointVector near = home_joints(model);
  if (request.near_joints_deg) {
    const auto joints = parse_joints("--near-joints-deg", *request.near_joints_deg, model);
    if (!joints) return bad_input(joints.error());
    near = *joints;
  }
  auto solved = solve(request, geometry, arm, near);
  if (!solved) return solved.error();
  auto& [branches, chosen_pitch] = *solved;
  if (!branches) {
    Outcome outcome = refusal(model, branches.error());
    if (branches.error().code == ErrorCode::kTaskNotSupported) {
      outcome.complaint =
          model.id + " cannot be asked for that: give the whole pose with --pose-mm-deg";
    }
    return outcome;
  }
  kinematics::sort_by_distance(*branches, near);
  Outcome outcome = list_branches(model, *branches);
  if (chosen_pitch) {
    outcome.json["pitch_deg"] = to_deg(*chosen_pitch);
    outcome.text += fmt::format(
        "  pitch chosen: {} deg from straight up, the smallest tilt from {} deg that is in reach\n",
        number(to_deg(*chosen_pitch)), number(to_deg(geometry.pitch_preferred)));
  }
  return outcome;
}

Outcome inverse_palletizer(const InverseRequest& request, const RobotModel& model,
                           const PalletizerGeometry& geometry) {
  if (request.gripper_mm) return bad_input("--gripper-mm: this robot has no gripper with jaws");
  if (request.pitch_deg || request.approach) {
    return bad_input(fmt::format("{}: the linkage of {} keeps its tool level",
                                 request.pitch_deg ? "--pitch-deg" : "--approach", model.id));
  }
  if (request.near_joints_deg) {
    const auto near = parse_joints("--near-joints-deg", *request.near_joints_deg, model);
    if (!near) return bad_input(near.error());
  }
  Vec3 p;
  std::optional<Rotation> R_asked;
  if (request.pose_mm_deg) {
    const auto X = parse_pose("--pose-mm-deg", *request.pose_mm_deg);
    if (!X) return bad_input(X.error());
    p = X->p;
    R_asked = X->R;
  } else {
    const auto point = parse_point("--point-mm", *request.point_mm);
    if (!point) return bad_input(point.error());
    p = *point;
  }
  const auto q = kinematics::inverse(geometry, model.joints, p);
  if (!q) return refusal(model, q.error());
  if (R_asked) {
    const double off = angle_between(kinematics::forward(geometry, *q).R, *R_asked);
    if (off > kTypedTolerance) {
      return refusal(model, {ErrorCode::kOrientationNotReachable, -1, off, kTypedTolerance});
    }
  }
  return list_branches(model, IkBranches{IkBranch{.q = *q, .within_limits = true, .singular = 0}});
}

Outcome inverse_hexapod(const InverseRequest& request, const RobotModel& model,
                        const HexapodGeometry& geometry) {
  if (!request.pose_mm_deg || request.gripper_mm || request.near_joints_deg) {
    return bad_input(model.id + " is a platform: give its pose with --pose-mm-deg x,y,z,rx,ry,rz");
  }
  const auto X = parse_pose("--pose-mm-deg", *request.pose_mm_deg);
  if (!X) return bad_input(X.error());
  const auto X_BP = relabel<frame::Base, frame::Platform>(*X);
  const kinematics::Hexapod hexapod(geometry);
  const JointVector legs = hexapod.inverse(X_BP);
  const auto violations = hexapod.check(X_BP, model.joints);
  const auto dexterity = hexapod.dexterity(X_BP);
  Outcome outcome;
  Json solution{{"legs_mm", joints_json(legs, model)},
                {"within_limits", violations.empty()},
                {"violations", Json::array()},
                {"condition", dexterity.condition}};
  Table table({"leg", "length mm", "shortest", "longest"});
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const Joint& leg = model.joints[i];
    table.add(
        {leg.name, number(to_mm(legs[i])), number(to_mm(leg.lower)), number(to_mm(leg.upper))});
  }
  outcome.text = table.text() + fmt::format("  condition number {:.3g}\n", dexterity.condition);
  for (const Error& violation : violations) {
    solution["violations"].push_back(error_json(violation, model));
    outcome.text += "  " + error_text(violation, model) + "\n";
  }
  outcome.json = {{"robot", model.id},
                  {"legs_mm", solution["legs_mm"]},
                  {"solutions", Json::array({solution})}};
  if (!violations.empty()) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.json["refusal"] = error_json(violations[0], model);
    outcome.complaint = "the platform cannot take this pose: " + error_text(violations[0], model);
  }
  return outcome;
}

}  // namespace

Outcome inverse(const InverseRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  if (request.pose_mm_deg.has_value() == request.point_mm.has_value()) {
    return bad_input("give either --pose-mm-deg x,y,z,rx,ry,rz or --point-mm x,y,z");
  }
  if (request.pose_mm_deg && (request.pitch_deg || request.approach)) {
    return bad_input("--pitch-deg and --approach go with --point-mm; a pose has its own direction");
  }
  if (request.pitch_deg && request.approach) {
    return bad_input("give either --pitch-deg or --approach, not both");
  }
  const auto* hexapod = std::get_if<HexapodGeometry>(&model.geometry);
  if (request.near_pose_mm_deg) {
    if (hexapod == nullptr) {
      return bad_input("--near-pose-mm-deg: only a hexapod has it; give --near-joints-deg");
    }
    const auto near = parse_pose("--near-pose-mm-deg", *request.near_pose_mm_deg);
    if (!near) return bad_input(near.error());
  }
  if (hexapod != nullptr) {
    return inverse_hexapod(request, model, *hexapod);
  }
  if (const auto* palletizer = std::get_if<PalletizerGeometry>(&model.geometry)) {
    return inverse_palletizer(request, model, *palletizer);
  }
  return inverse_serial(request, model, std::get<SerialGeometry>(model.geometry));
}

void add_inverse(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<InverseRequest>();
  InverseRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "ik", "inverse kinematics: all joints that reach a target",
                            "sinew ik learm --point-mm 200,0,20");
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--pose-mm-deg", request.pose_mm_deg,
                   "x,y,z,rx,ry,rz of the tool; rotation about fixed axes x, y, z");
  verb->add_option("--point-mm", request.point_mm, "x,y,z of the tool's tip");
  verb->add_option("--pitch-deg", request.pitch_deg,
                   "with --point-mm: tool from straight up (90 level, 180 down); chosen where left "
                   "out");
  verb->add_option("--approach", request.approach,
                   "with --point-mm: x,y,z of the tool's direction, of any length; the forearm "
                   "rolls as it must");
  verb->add_option("--gripper-mm", request.gripper_mm,
                   "width between the jaws; open where left out");
  verb->add_option("--near-joints-deg", request.near_joints_deg,
                   "where the arm is: sorts the answers and settles free joints");
  verb->add_option("--near-pose-mm-deg", request.near_pose_mm_deg,
                   "hexapod: accepted for symmetry with fk; legs have one answer only");
  verb->callback([&call, own] { call.verb = [own] { return inverse(*own); }; });
}

}  // namespace sinew::cli
