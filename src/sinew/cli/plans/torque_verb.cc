#include "sinew/cli/plans/torque_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/program_folder.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/plans/torque_report.h"
#include "sinew/core/quantity.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/language/program_file.h"
#include "sinew/runtime/homing_time.h"

namespace sinew::cli {
namespace {

constexpr double kPayloadMax = 1000;  // kg
constexpr int kRows = 6;              // beside the one without payload

std::expected<double, std::string> parse_payload(const std::optional<std::string>& text) {
  if (!text) return 0;
  const auto mass = parse_quantity(*text, Measure::kMass, UnitRule::kOptional);
  if (!mass) return std::unexpected("--payload-kg: " + mass.error());
  if (!(*mass >= 0 && *mass <= kPayloadMax)) {
    return std::unexpected(
        fmt::format("--payload-kg: {} kg is outside 0..{} kg", number(*mass), number(kPayloadMax)));
  }
  return *mass;
}

/// The joint of that name, or of a number as in J2.
std::expected<std::size_t, std::string> find_joint(const std::string& name,
                                                   const RobotModel& model) {
  if (const auto joint = joint_named(model, name)) return *joint;
  const std::vector<std::string> names = joint_names(model);
  const std::vector<std::string_view> known(names.begin(), names.end());
  const std::string_view meant = nearest_spelling(name, known);
  return std::unexpected(
      fmt::format("--axis: {} has no joint '{}'{}; it has {}, or J1 to J{}", model.id,
                  printable(name), meant.empty() ? "" : fmt::format(", did you mean '{}'?", meant),
                  joined(names, ", "), names.size()));
}

/// What the robot's file would have to say; empty where it says enough.
std::string missing_data(const RobotModel& model) {
  std::vector<std::string> missing;
  if (!planning::drive_train(model, 0)) {
    missing.emplace_back("its motors ([drive.NAME] or [servo.NAME] for every joint)");
  }
  if (model.dynamics.links.empty()) {
    const bool platform = std::holds_alternative<HexapodGeometry>(model.geometry);
    missing.emplace_back(platform ? "its platform's mass ([link.platform])"
                                  : "its masses ([link.NAME] for every joint)");
  }
  if (missing.empty()) return {};
  return fmt::format(
      "no torque can be told for {}: its file does not say {}; robots/README.md has "
      "the keys",
      model.id, joined(missing, " and "));
}

/// Microsteps a second that the boards of this robot can make; 0 where nobody knows.
double step_rate_max(const RobotModel& model) {
  const auto boards = boards_of(model.device);
  return boards.empty() ? 0 : boards[0].step_rate_max;
}

/// The largest of 1, 2, 5, 10 .. that is not above x.
double round_step(double x) {
  const double decade = std::pow(10, std::floor(std::log10(x)));
  const double leading = x / decade;
  return decade * (leading >= 5 ? 5 : leading >= 2 ? 2 : 1);
}

/// Payloads up to about twice of what the joint first fails with.
std::vector<double> payload_rows(const JointTorque& joint, double asked) {
  std::set<double> payloads{0, asked};
  double first = joint.fails_from.value_or(0);
  if (first < 1e-3) first = joint.fails_from_at_rest.value_or(0);
  if (first >= 1e-3) {
    const double step = round_step(first / 3);
    for (int i = 1; i <= kRows; ++i) {
      const auto same = [&](double payload) { return std::abs(payload - i * step) < step / 1e6; };
      if (std::ranges::none_of(payloads, same)) payloads.insert(i * step);
    }
  }
  return {payloads.begin(), payloads.end()};
}

void look_closely(TorqueReport& report) {
  const std::size_t i = report.weakest;
  for (const double payload : payload_rows(report.joints[i], report.payload)) {
    report.rows.push_back({payload, report.study.need(i, payload),
                           report.study.failing_acceleration(i, payload),
                           report.study.failing_reach(i, payload)});
  }
}

/// The joint that fails first as the payload grows.
std::size_t weakest_of(const std::vector<JointTorque>& joints) {
  const auto weaker = [](const JointTorque& a, const JointTorque& b) {
    const double payload_a = a.fails_from.value_or(kPayloadMax);
    const double payload_b = b.fails_from.value_or(kPayloadMax);
    return payload_a != payload_b ? payload_a < payload_b : a.need.margin() < b.need.margin();
  };
  return static_cast<std::size_t>(std::ranges::min_element(joints, weaker) - joints.begin());
}

void name_masses(const RobotFile& file, TorqueReport& report) {
  for (const Provenance& provenance : file.sources) {
    constexpr std::string_view kStart = "link.";
    const std::string& key = provenance.key;
    const std::size_t end = key.rfind(".mass_");
    if (!key.starts_with(kStart) || end == std::string::npos) continue;
    ++report.masses;
    if (!provenance.source.starts_with("assumed")) continue;
    report.assumed_masses.push_back(key.substr(kStart.size(), end - kStart.size()));
  }
}

/// The program's loads into the report; what is wrong with it where something is.
std::optional<Outcome> load_program(const std::string& path, TorqueReport& report) {
  const RobotModel& model = report.model;
  if (const auto text = io::read_file(path); !text) {
    return bad_input("--program: " + text.error().sentence);
  }
  const auto parsed = read_program(path, model);
  if (!parsed) return parsed.error();
  const auto plan =
      program::make_plan(*parsed, model, home_joints(model), runtime::homing_of(model));
  if (!plan) return plan_refusal(model, file_of(*parsed, plan.error().file, path), plan.error());
  std::vector<planning::DriveTrain> drives;
  for (std::size_t i = 0; i < model.joints.size(); ++i) drives.push_back(report.study.drive(i));
  const auto loads =
      program::load_of(*plan, model, planning::InverseDynamics(model, report.payload), drives);
  if (!loads) return plan_refusal(model, path, loads.error());
  report.program = path;
  report.program_duration = plan->duration;
  report.loads = *loads;
  return std::nullopt;
}

}  // namespace

Outcome torque(const TorqueRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  const auto payload = parse_payload(request.payload_kg);
  if (!payload) return bad_input(payload.error());
  std::optional<std::size_t> chosen;
  if (request.axis) {
    const auto joint = find_joint(*request.axis, model);
    if (!joint) return bad_input(joint.error());
    chosen = *joint;
  }
  if (const std::string missing = missing_data(model); !missing.empty()) return could_not(missing);

  const double step_rate = step_rate_max(model);
  const planning::TorqueStudy study(model, step_rate);
  TorqueReport report(model, study);
  report.payload = *payload;
  report.step_rate_max = step_rate;
  if (request.program) {
    if (auto wrong = load_program(*request.program, report)) return *wrong;
  }
  name_masses(*file, report);
  report.reach_max = study.reach_max();
  for (std::size_t i = 0; i < study.size(); ++i) {
    report.joints.push_back(
        {study.need(i, *payload), study.failing_payload(i), study.failing_payload_at_rest(i)});
  }
  report.weakest = chosen.value_or(weakest_of(report.joints));
  report.chosen = chosen.has_value();
  look_closely(report);
  Outcome outcome;
  outcome.json = torque_json(report);
  outcome.text = torque_text(report);
  return outcome;
}

void add_torque(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<TorqueRequest>();
  TorqueRequest& request = *own;
  CLI::App* verb =
      add_verb(app, call, "torque", "what each joint needs against what its motors and gear give",
               "sinew torque robot-arm-2 --payload-kg 1");
  verb->add_option("ROBOT", request.robot, "id or .toml file")->required();
  verb->add_option("--payload-kg", request.payload_kg, "at the tool; none where left out");
  verb->add_option("--program", request.program, "a .sinew file: its peaks and means, from home");
  verb->add_option("--axis", request.axis,
                   "the joint to look at closely, J1.. or its name; the weakest where left out");
  verb->callback([&call, own] { call.verb = [own] { return torque(*own); }; });
}

}  // namespace sinew::cli
