#include "sinew/devices/axis/axis_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/core/quantity.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/devices/axis/axis_device_settings.h"
#include "sinew/devices/axis/axis_verb_plot.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"

namespace sinew::cli {
namespace {

constexpr double kStep = from_deg(1.5);  // the largest following error that boards tolerate
constexpr double kTrack = from_deg(40);  // long enough to come to the joint's speed
constexpr double kAxisPayloadMax = 50;   // kg, more than any such arm weighs

template <class T>
using Parsed = std::expected<T, std::string>;

/// The request in SI.
struct Trials {
  std::vector<std::size_t> axes;
  JointVector pose;
  double payload = 0;
  double step = kStep;
  double track = kTrack;
};

Parsed<std::vector<std::size_t>> parse_axes(const std::optional<std::string>& text,
                                            const RobotModel& model) {
  if (!text) {
    std::vector<std::size_t> axes(model.joints.size());
    std::iota(axes.begin(), axes.end(), 0U);
    return axes;
  }
  if (const auto joint = joint_named(model, *text)) return std::vector{*joint};
  return std::unexpected(fmt::format("--axis: {} has no axis '{}'; its axes are {}", model.id,
                                     printable(*text), joined(joint_names(model), ", ")));
}

Parsed<double> parse_size(const std::string& option, const std::optional<std::string>& text,
                          double otherwise) {
  if (!text) return otherwise;
  const auto size = parse_quantity(*text, Measure::kAngle, UnitRule::kOptional);
  if (!size) return std::unexpected(option + ": " + size.error());
  if (!(*size > 0 && *size <= 2 * kPi)) {
    return std::unexpected(option +
                           ": must be above 0 and at most a turn; both directions are tried");
  }
  return *size;
}

/// Every joint must have room for both jumps and for the move.
std::optional<std::string> leaves_limits(const Trials& trials, const RobotModel& model) {
  for (const std::size_t i : trials.axes) {
    const Joint& joint = model.joints[i];
    const double q = trials.pose[i];
    if (q - trials.step >= joint.lower && q + std::max(trials.step, trials.track) <= joint.upper) {
      continue;
    }
    return fmt::format(
        "{} stands at {:.4g} deg and has no room there: its limits are {:.4g} and "
        "{:.4g} deg; --joints-deg says where it stands, --step and --track how far "
        "it goes",
        joint.name, to_deg(q), to_deg(joint.lower), to_deg(joint.upper));
  }
  return std::nullopt;
}

Parsed<Trials> parse(const AxisRequest& request, const RobotModel& model) {
  Trials trials;
  const auto axes = parse_axes(request.axis, model);
  if (!axes) return std::unexpected(axes.error());
  trials.axes = *axes;
  const auto step = parse_size("--step", request.step, kStep);
  if (!step) return std::unexpected(step.error());
  trials.step = *step;
  const auto track = parse_size("--track", request.track, kTrack);
  if (!track) return std::unexpected(track.error());
  trials.track = *track;
  if (request.joints_deg) {
    const auto pose = parse_joints("--joints-deg", *request.joints_deg, model);
    if (!pose) return std::unexpected(pose.error());
    trials.pose = *pose;
  } else {
    trials.pose = home_joints(model);
  }
  if (request.payload) {
    const auto payload = parse_quantity(*request.payload, Measure::kMass, UnitRule::kOptional);
    if (!payload) return std::unexpected("--payload-kg: " + payload.error());
    if (!(*payload >= 0 && *payload <= kAxisPayloadMax)) {
      return std::unexpected(fmt::format("--payload-kg: must be 0 to {} kg", kAxisPayloadMax));
    }
    trials.payload = *payload;
  }
  if (const auto leaves = leaves_limits(trials, model)) return std::unexpected(*leaves);
  return trials;
}

AxisCurves run_trials(const RobotModel& model, std::size_t joint, const Trials& trials) {
  const AxisSettings settings = axis_settings(model, joint);
  sim::LoopTrial trial{.pose = trials.pose, .payload = trials.payload, .step = trials.step};
  AxisCurves curves;
  curves.name = fmt::format("J{} {}", joint + 1, model.joints[joint].name);
  curves.up = sim::step_trial(model, joint, settings, trial);
  trial.step = -trials.step;
  curves.down = sim::step_trial(model, joint, settings, trial);
  trial.step = trials.track;
  trial.seconds = 0;
  curves.tracking = sim::tracking_trial(model, joint, settings, trial);
  trial.feed_forward = false;
  curves.blind = sim::tracking_trial(model, joint, settings, trial);
  return curves;
}

Json step_json(const sim::LoopRecord& record) {
  const sim::StepFigures figures = sim::step_figures(record);
  return {{"rise_s", figures.rise},
          {"overshoot_deg", to_deg(figures.overshoot)},
          {"settling_s", figures.settling},
          {"steady_error_deg", to_deg(figures.steady)},
          {"loses_steps", record.stalled}};
}

Json axis_json(const AxisCurves& curves, const motion::CascadeSettings& gains) {
  const auto track = [](const sim::LoopRecord& record) {
    return Json{{"error_max_deg", to_deg(sim::tracking_error(record))},
                {"loses_steps", record.stalled}};
  };
  return {{"axis", curves.name},
          {"load_nm", curves.up.load_torque},
          {"inertia_kgm2", curves.up.load_inertia},
          {"position_gain_per_s", gains.position_gain},
          {"velocity_gain", gains.velocity_gain},
          {"integral_gain_per_s", gains.integral_gain},
          {"step_up", step_json(curves.up)},
          {"step_down", step_json(curves.down)},
          {"tracking", track(curves.tracking)},
          {"tracking_without_feed_forward", track(curves.blind)}};
}

void add_rows(Table& table, const AxisCurves& curves) {
  for (const bool up : {true, false}) {
    const sim::LoopRecord& record = up ? curves.up : curves.down;
    const sim::StepFigures figures = sim::step_figures(record);
    table.add({up ? curves.name : "", up ? number(record.load_torque, 2) : "",
               up ? number(record.load_inertia, 4) : "", up ? "up" : "down",
               record.stalled ? "-" : number(figures.rise, 3),
               record.stalled ? "-" : number(to_deg(figures.overshoot), 3),
               record.stalled ? "-" : number(figures.settling, 3),
               number(to_deg(figures.steady), 3),
               up ? number(to_deg(sim::tracking_error(curves.tracking)), 3) : "",
               up ? number(to_deg(sim::tracking_error(curves.blind)), 3) : "",
               record.stalled ? "loses steps" : ""});
  }
}

}  // namespace

Outcome try_axis(const AxisRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  if (!std::holds_alternative<SerialGeometry>(model.geometry) || model.dynamics.drives.empty()) {
    return could_not(model.id + " is no arm with a stepper on each joint ([drive] tables)");
  }
  for (const StepperDrive& drive : model.dynamics.drives) {
    if (drive.joint_encoder != JointEncoder::kNone) continue;
    return could_not(model.id +
                     " has no encoders on its joints: its motors run open loop, and "
                     "there is no loop to look at");
  }
  const auto trials = parse(request, model);
  if (!trials) return bad_input(trials.error());
  if (request.plot) {
    if (const auto place = io::check_place(*request.plot); !place) {
      return bad_input("--plot: " + place.error().sentence);
    }
  }

  Outcome outcome;
  outcome.json = {{"robot", model.id},
                  {"joints_deg", joints_json(trials->pose, model)},
                  {"payload_kg", trials->payload},
                  {"step_deg", to_deg(trials->step)},
                  {"track_deg", to_deg(trials->track)},
                  {"axes", Json::array()}};
  Table table({"axis", "load Nm", "kg m2", "step", "rise s", "over deg", "settles s", "off deg",
               "track deg", "without ff", ""});
  table.left(3);
  std::vector<AxisCurves> all;
  for (const std::size_t joint : trials->axes) {
    all.push_back(run_trials(model, joint, *trials));
    add_rows(table, all.back());
    outcome.json["axes"].push_back(axis_json(all.back(), axis_settings(model, joint).cascade));
  }
  outcome.text = table.text();
  outcome.text += fmt::format(
      "  A jump of {:.4g} deg each way, and a move of {:.4g} deg there and back, of the joint "
      "itself;\n  what it is off at rest is play and give that the motor's encoder cannot see.\n",
      to_deg(trials->step), to_deg(trials->track));
  if (request.plot) {
    const std::string picture = axis_plot(model.title, all);
    if (const auto written = io::replace_file(*request.plot, picture); !written) {
      return could_not("--plot: " + written.error().sentence);
    }
    outcome.json["plot"] = *request.plot;
    outcome.text += "  " + *request.plot + "\n";
  }
  return outcome;
}

void add_axis(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<AxisRequest>();
  AxisRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "axis",
                            "how each axis answers a jump and follows a move, simulated with load",
                            "sinew axis robot-arm-2 --axis J2 --plot shoulder.svg");
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--axis", request.axis, "J1.. or its name; all where left out");
  verb->add_option("--step", request.step, "size of the jump, 1.5deg where left out");
  verb->add_option("--track", request.track, "length of the move, 40deg where left out");
  verb->add_option("--joints-deg", request.joints_deg, "where the arm stands; home where left out");
  verb->add_option("--payload-kg", request.payload, "at the tool; none where left out");
  verb->add_option("--plot", request.plot, "SVG file: step responses and tracking errors");
  verb->callback([&call, own] { call.verb = [own] { return try_axis(*own); }; });
}

}  // namespace sinew::cli
