#include "sinew/cli/convert_verb.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "sinew/cli/kinematics_text.h"
#include "sinew/cli/plan_report.h"
#include "sinew/cli/program_folder.h"
#include "sinew/cli/robot_argument.h"
#include "sinew/cli/run_journal.h"
#include "sinew/cli/table.h"
#include "sinew/cli/taught_way.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/gcode_file.h"
#include "sinew/program/pose_file.h"
#include "sinew/program/program_format.h"
#include "sinew/program/program_plan.h"
#include "sinew/program/sequence_convert.h"

namespace sinew::cli {
namespace {

enum class Form : std::uint8_t { kProgram, kSequence, kPose, kConfig, kGcode, kRecord };

struct Named {
  std::string_view name;
  Form form;
};
constexpr std::array<Named, 6> kForms{{{"sinew", Form::kProgram},
                                       {"sequence", Form::kSequence},
                                       {"pos", Form::kPose},
                                       {"config", Form::kConfig},
                                       {"gcode", Form::kGcode},
                                       {"record", Form::kRecord}}};
constexpr std::array<Named, 10> kEndings{{{".sinew", Form::kProgram},
                                          {".txt", Form::kSequence},
                                          {".pos", Form::kPose},
                                          {".cfg", Form::kConfig},
                                          {".gcode", Form::kGcode},
                                          {".ngc", Form::kGcode},
                                          {".nc", Form::kGcode},
                                          {".tap", Form::kGcode},
                                          {".g", Form::kGcode},
                                          {".mcap", Form::kRecord}}};

std::expected<Form, Outcome> form_of(const std::optional<std::string>& name,
                                     const std::string& file, const char* option) {
  if (name) {
    for (const Named& one : kForms) {
      if (one.name == *name) return one.form;
    }
    return std::unexpected(bad_input(std::string(option) + ": '" + printable(*name) +
                                     "' is none of sinew, sequence, pos, config, gcode, record"));
  }
  for (const Named& one : kEndings) {
    if (file.ends_with(one.name)) return one.form;
  }
  return std::unexpected(bad_input(file + ": its ending does not say what it is; write " + option +
                                   " sinew, sequence, pos, config, gcode or record"));
}

/// A text that was made, or why it was not.
using Made = std::expected<std::string, Outcome>;

Made complained(const std::vector<Complaint>& complaints) {
  return std::unexpected(complaints_outcome(complaints));
}

const HexapodGeometry* platform_of(const RobotModel& model) {
  return std::get_if<HexapodGeometry>(&model.geometry);
}

/// The pose that a file's heads mean. @param line  where its numbers begin
std::expected<program::PlatformFit, Outcome> fitted(const program::PoseFile& pose,
                                                    const RobotModel& model,
                                                    const std::string& file, int line) {
  const auto* geometry = platform_of(model);
  if (geometry == nullptr) {
    return std::unexpected(bad_input(file + ": is a platform's file; " + model.id + " is none"));
  }
  const auto fit = program::fit_platform(pose.heads, *geometry);
  if (fit.residual <= program::kPlatformResidualMax) return fit;
  return std::unexpected(complaints_outcome(
      {{file, line, 1, "",
        fmt::format("these heads are no place of {}'s platform: they are up to {} mm off, {} mm "
                    "is allowed",
                    model.id, number(to_mm(fit.residual), 3),
                    number(to_mm(program::kPlatformResidualMax), 1))}}));
}

std::string row_of(const kinematics::PoseBP& X_BP) {
  const Vec3 rpy = fixed_xyz(X_BP.R);
  return fmt::format("move x={}mm y={}mm z={}mm rx={}deg ry={}deg rz={}deg\n",
                     number(to_mm(X_BP.p.x), 6), number(to_mm(X_BP.p.y), 6),
                     number(to_mm(X_BP.p.z), 6), number(to_deg(rpy.x), 6), number(to_deg(rpy.y), 6),
                     number(to_deg(rpy.z), 6));
}

std::string triple(const Vec3& v) {
  return fmt::format("{} {} {}", number(v.x, 6), number(v.y, 6), number(v.z, 6));
}

/// One row, and what the file says beside it.
std::string program_of(const program::PoseFile& pose, const program::PlatformFit& fit) {
  return fmt::format(
      "# heads fit the platform to {} mm; totals of moves {} mm, of turns {} deg\n{}",
      number(to_mm(fit.residual), 6), triple(to_mm(1) * pose.translation_total),
      triple(to_deg(1) * pose.rotation_total), row_of(fit.X_BP));
}

Made from_program(const ConvertRequest& request, const RobotModel& model, Form to) {
  const auto program = read_program(request.in, model);
  if (!program) return std::unexpected(program.error());
  const program::Start home = home_joints(model);
  const auto plan = program::make_plan(*program, model, home);
  if (!plan) {
    const std::string file = file_of(*program, plan.error().file, request.in);
    return std::unexpected(plan_refusal(model, file, plan.error()));
  }
  if (to == Form::kSequence) {
    if (!std::holds_alternative<BigRobotArmDevice>(model.device.settings)) {
      return std::unexpected(bad_input("--robot: sequences are the BigRobotArm's"));
    }
    const auto sequence = program::sequence_of_rows(*program, model);
    if (!sequence) return complained(sequence.error());
    return sequence::to_text(*sequence);
  }
  const auto* geometry = platform_of(model);
  if (geometry == nullptr)
    return std::unexpected(bad_input("--robot: .pos files are a platform's"));
  const auto* move =
      plan->orders.size() == 1 ? std::get_if<program::MoveOrder>(&plan->orders[0].what) : nullptr;
  if (move == nullptr) {
    return std::unexpected(bad_input(request.in + ": a .pos file is one pose: it takes a program "
                                                  "of one row that moves"));
  }
  const auto pose = kinematics::Hexapod(*geometry).forward(move->q, geometry->X_BP_home);
  if (!pose) return std::unexpected(could_not(request.in + ": " + error_text(pose.error(), model)));
  return program::pose_text(
      program::pose_file(pose->X_BP, *geometry),
      request.comma ? program::DecimalMark::kComma : program::DecimalMark::kPoint);
}

Made from_pose(const ConvertRequest& request, const std::string& text, const RobotModel& model,
               Form to) {
  const auto pose = program::read_pose_file(text, request.in);
  if (!pose) return complained(pose.error());
  const auto fit = fitted(*pose, model, request.in, 1);
  if (!fit) return std::unexpected(fit.error());
  if (to == Form::kProgram) return program_of(*pose, *fit);
  return program::pose_text(
      *pose, request.comma ? program::DecimalMark::kComma : program::DecimalMark::kPoint);
}

Made from_sequence(const ConvertRequest& request, const std::string& text,
                   const RobotModel& model) {
  const auto* device = std::get_if<BigRobotArmDevice>(&model.device.settings);
  if (device == nullptr) {
    return std::unexpected(bad_input("--robot: sequences are the BigRobotArm's"));
  }
  const auto sequence = sequence::parse(text, request.in, *device);
  if (!sequence) return complained(sequence.error());
  auto rows = program::rows_of_sequence(*sequence, request.in, model);
  if (!rows) return complained(rows.error());
  return std::move(*rows);
}

/// The journal's next run begins with these positions.
/// @error  the journal cannot be used, or knows better
std::expected<std::string, Outcome> taken_over(const std::string& name, const RobotModel& model,
                                               const std::vector<JointPosition>& legs,
                                               bool replace) {
  RunRequest run;
  run.journal = name;
  const auto record = open_journal(run, model);
  if (!record) return std::unexpected(record.error());
  const auto& known = (*record)->recovery().positions;
  const bool knows = std::ranges::any_of(
      known, [](const JointPosition& leg) { return leg.quality != PositionQuality::kLost; });
  if (knows && !replace) {
    return std::unexpected(bad_input(fmt::format(
        "--journal: {}/{} knows where this machine stands; --replace takes the file's word instead",
        (*record)->folder(), name)));
  }
  const JournalTime now{io::Clock().now(), io::wall_time_ns()};
  if (const auto said = (*record)->import(model, legs, now); !said) {
    return std::unexpected(could_not(said.error().sentence));
  }
  return fmt::format(
      "\n  the journal {}/{} begins with that: before anything moves, say where the legs are "
      "(sinew recover, or sinew run --standing-at ..)\n",
      (*record)->folder(), name);
}

/// What an old config.cfg says, and that nobody should believe it unseen.
Outcome tell_config(const ConvertRequest& request, const std::string& text,
                    const RobotModel& model) {
  const auto config = program::read_platform_config(text, request.in);
  if (!config) return complaints_outcome(config.error());
  const auto fit = fitted(config->real, model, request.in, 3);
  if (!fit) return fit.error();
  Outcome outcome;
  outcome.json = {{"robot", model.id},
                  {"port", config->port},
                  {"residual_mm", to_mm(fit->residual)},
                  {"pose", pose_json(fit->X_BP.p, fit->X_BP.R)},
                  {"legs", Json::array()}};
  outcome.text = fmt::format(
      "  by this file the platform of {} stands, with its heads to {} mm, at\n{}", model.title,
      number(to_mm(fit->residual), 3), pose_text(fit->X_BP.p, fit->X_BP.R));
  Table table({"leg", "mm", "at least", "at most"});
  const auto legs = program::uncertain_legs(*fit, model);
  for (std::size_t leg = 0; leg < legs.size(); ++leg) {
    const JointPosition& at = legs[leg];
    table.add({model.joints[leg].name, number(to_mm(at.q), 3), number(to_mm(at.lower), 3),
               number(to_mm(at.upper), 3)});
    outcome.json["legs"].push_back({{"joint", model.joints[leg].name},
                                    {"quality", "uncertain"},
                                    {"q_mm", to_mm(at.q)},
                                    {"lower_mm", to_mm(at.lower)},
                                    {"upper_mm", to_mm(at.upper)}});
  }
  outcome.text += "\n" + table.text() +
                  "\n  uncertain: that file was written only when its program ended, without a "
                  "check; measure the legs before anything moves (sinew run --standing-at ..)\n";
  if (!request.journal) return outcome;
  const auto taken =
      taken_over(*request.journal, model, {legs.begin(), legs.end()}, request.replace);
  if (!taken) return taken.error();
  outcome.json["journal"] = *request.journal;
  outcome.text += *taken;
  return outcome;
}

Made converted(const ConvertRequest& request, const RobotModel& model, Form from, Form to) {
  if (from == Form::kProgram && to != Form::kProgram) return from_program(request, model, to);
  if (from == Form::kRecord && to == Form::kProgram) {
    const auto way = way_of_record(request.in, model);
    if (!way) return std::unexpected(way.error());
    auto taught = program_of_way(*way, model);
    if (!taught) return std::unexpected(taught.error());
    return std::move(taught->text);
  }
  const auto text = io::read_file(request.in);
  if (!text) return std::unexpected(bad_input(text.error().sentence));
  if (from == Form::kPose && to != Form::kSequence) return from_pose(request, *text, model, to);
  if (from == Form::kSequence && to == Form::kProgram) return from_sequence(request, *text, model);
  if (from == Form::kGcode && to == Form::kProgram) {
    auto rows = program::rows_of_gcode(*text, request.in, model);
    if (!rows) return complained(rows.error());
    return std::move(*rows);
  }
  return std::unexpected(
      bad_input("convert: from sequence, gcode, pos and record to sinew, from sinew to sequence "
                "and pos, from pos to "
                "pos; a config is only told"));
}

/// A program that was made is one, laid out.
Made laid_out(const std::string& text, const RobotModel& model, const std::string& name) {
  if (const auto program = program::parse(text, name, model); !program) {
    return complained(program.error());
  }
  auto out = program::format(text, name);
  if (!out) return complained(out.error());
  return std::move(*out);
}

}  // namespace

Outcome convert(const ConvertRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  const auto from = form_of(request.from, request.in, "--from");
  if (!from) return from.error();
  if (*from == Form::kConfig && !request.out && !request.to) {
    const auto text = io::read_file(request.in);
    return text ? tell_config(request, *text, model) : bad_input(text.error().sentence);
  }
  if (request.journal) return bad_input("--journal: only of a config that is told, without OUT");
  const bool by_name = request.to || request.out;
  const auto to = by_name ? form_of(request.to, request.out.value_or(""), "--to")
                          : std::expected<Form, Outcome>(Form::kProgram);
  if (!to) return to.error();
  if (request.comma && *to != Form::kPose) {
    return bad_input("--decimal-comma: only of a .pos file");
  }
  if (request.out && io::same_file(request.in, *request.out)) {
    return bad_input(*request.out + ": is the file that is read");
  }
  if (request.out && io::is_file(*request.out) && !request.replace) {
    return bad_input(*request.out + ": is there already; --replace writes it anew");
  }
  auto text = converted(request, model, *from, *to);
  if (text && *to == Form::kProgram) {
    text = laid_out(*text, model, request.out.value_or("the program"));
  }
  if (!text) return text.error();
  Outcome outcome;
  outcome.json = {{"robot", model.id}, {"in", request.in}};
  if (!request.out) {
    outcome.json["text"] = *text;
    outcome.text = *text;
    return outcome;
  }
  if (const auto written = io::replace_file(*request.out, *text); !written) {
    return could_not(written.error().sentence);
  }
  outcome.json["out"] = *request.out;
  outcome.text = "  " + *request.out + "\n";
  return outcome;
}

}  // namespace sinew::cli
