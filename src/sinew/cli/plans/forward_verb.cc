#include "sinew/cli/plans/forward_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "sinew/cli/output/frames_text.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/core/units.h"
#include "sinew/kinematics/hexapod.h"
#include "sinew/kinematics/ik.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_arm.h"

namespace sinew::cli {
namespace {

using PoseBT = Pose<frame::Base, frame::Tool>;

/// Pose, joints and their verdict: what the answers of all robots share.
Outcome answer(const RobotModel& model, const PoseBT& X, const JointVector& q,
               std::span<const Error> violations) {
  Outcome outcome;
  outcome.json = {{"robot", model.id},
                  {"pose", pose_json(X.p, X.R)},
                  {joints_key(model), joints_json(q, model)},
                  {"within_limits", violations.empty()},
                  {"violations", Json::array()}};
  outcome.text = pose_text(X.p, X.R);
  for (const Error& violation : violations) {
    outcome.json["violations"].push_back(error_json(violation, model));
    outcome.text += "  outside its limits: " + error_text(violation, model) + "\n";
  }
  return outcome;
}

Outcome forward_serial(const ForwardRequest& request, const RobotModel& model,
                       const SerialGeometry& geometry, const JointVector& q) {
  const auto jaw_width = parse_jaw_width(request.gripper_mm, &geometry);
  if (!jaw_width) return bad_input(jaw_width.error());
  const kinematics::SerialArm arm(geometry, model.joints,
                                  kinematics::tool_pose(geometry, *jaw_width));
  kinematics::Jacobian J;
  const PoseBT X = arm.chain().forward(q, J) * arm.tool();
  Outcome outcome = answer(model, X, q, kinematics::limit_violations(model.joints, q));
  const auto dexterity = kinematics::dexterity(J, arm.chain().reach(model.joints));
  outcome.json["manipulability"] = dexterity.manipulability;
  outcome.json["singular_value_min"] = dexterity.singular_value_min;
  outcome.text += fmt::format("  manipulability {:.3g}, smallest singular value {:.3g}{}\n",
                              dexterity.manipulability, dexterity.singular_value_min,
                              dexterity.singular_value_min < 1e-4 ? "  (singular)" : "");
  if (request.frames) add_frames(outcome, model, arm, q);
  return outcome;
}

Outcome forward_hexapod(const ForwardRequest& request, const RobotModel& model,
                        const HexapodGeometry& geometry) {
  const auto legs = parse_joints("--legs-mm", *request.legs_mm, model);
  if (!legs) return bad_input(legs.error());
  kinematics::PoseBP X_near = geometry.X_BP_home;
  if (request.near_pose_mm_deg) {
    const auto near = parse_pose("--near-pose-mm-deg", *request.near_pose_mm_deg);
    if (!near) return bad_input(near.error());
    X_near = relabel<frame::Base, frame::Platform>(*near);
  }
  const kinematics::Hexapod hexapod(geometry);
  const auto solution = hexapod.forward(*legs, X_near);
  if (!solution) {
    Outcome refusal{ExitCode::kCouldNot, {}, "", error_text(solution.error(), model)};
    refusal.json = {{"robot", model.id}, {"refusal", error_json(solution.error(), model)}};
    return refusal;
  }
  const PoseBT X = relabel<frame::Base, frame::Tool>(solution->X_BP);
  Outcome outcome = answer(model, X, *legs, hexapod.check(solution->X_BP, model.joints));
  const auto dexterity = hexapod.dexterity(solution->X_BP);
  outcome.json["condition"] = dexterity.condition;
  outcome.json["iterations"] = solution->iterations;
  outcome.text += fmt::format("  condition number {:.3g}; found in {} iterations\n",
                              dexterity.condition, solution->iterations);
  return outcome;
}

}  // namespace

Outcome forward(const ForwardRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  const auto* serial = std::get_if<SerialGeometry>(&model.geometry);
  if (request.frames && serial == nullptr) {
    return bad_input("--frames: only serial arms have a DH table; " + model.id + " is none");
  }
  if (const auto* hexapod = std::get_if<HexapodGeometry>(&model.geometry)) {
    if (!request.legs_mm || request.joints_deg || request.gripper_mm) {
      return bad_input(model.id + " has legs: give --legs-mm with six lengths, anchor to anchor");
    }
    return forward_hexapod(request, model, *hexapod);
  }
  if (request.legs_mm || request.near_pose_mm_deg) {
    return bad_input(model.id + " has joints: give --joints-deg");
  }
  JointVector q;
  if (request.joints_deg) {
    const auto joints = parse_joints("--joints-deg", *request.joints_deg, model);
    if (!joints) return bad_input(joints.error());
    q = *joints;
  } else if (request.frames) {
    q.resize(model.joints.size());
  } else {
    return bad_input(fmt::format("--joints-deg is missing: {} numbers with commas between them",
                                 model.joints.size()));
  }
  if (serial != nullptr) return forward_serial(request, model, *serial, q);
  const auto jaw_width = parse_jaw_width(request.gripper_mm, nullptr);
  if (!jaw_width) return bad_input(jaw_width.error());
  return answer(model, kinematics::forward(std::get<PalletizerGeometry>(model.geometry), q), q,
                kinematics::limit_violations(model.joints, q));
}

void add_forward(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<ForwardRequest>();
  ForwardRequest& request = *own;
  CLI::App* verb =
      add_verb(app, call, "fk", "forward kinematics: where the tool is at given joints",
               "sinew fk learm --joints-deg 0,90,0,0,0");
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--joints-deg", request.joints_deg, "one angle a joint: a,b,...");
  verb->add_option("--legs-mm", request.legs_mm, "hexapod: six lengths, anchor to anchor");
  verb->add_option("--near-pose-mm-deg", request.near_pose_mm_deg,
                   "hexapod: the last pose x,y,z,rx,ry,rz; home where left out");
  verb->add_option("--gripper-mm", request.gripper_mm,
                   "width between the jaws; open where left out");
  verb->add_flag("--frames", request.frames, "the DH table and every link's matrix");
  verb->callback([&call, own] { call.verb = [own] { return forward(*own); }; });
}

}  // namespace sinew::cli
