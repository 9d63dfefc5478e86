#include "sinew/cli/cells/convert_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "sinew/cli/cells/run_journal.h"
#include "sinew/cli/cells/taught_way.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/program_folder.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/program_format.h"
#include "sinew/program/formats/text_forms.h"

namespace sinew::cli {
namespace {

/// What IN or OUT is: a program, one of the other forms of programs, or what is only read.
struct Form {
  enum class Kind : std::uint8_t { kProgram, kText, kConfig, kRecord };
  Kind kind = Kind::kProgram;
  const program::TextForm* text = nullptr;  ///< of kText
};

struct Own {
  std::string_view name;
  std::string_view ending;
  Form::Kind kind;
};
constexpr std::array<Own, 3> kOwn{{{"sinew", ".sinew", Form::Kind::kProgram},
                                   {"config", ".cfg", Form::Kind::kConfig},
                                   {"record", ".mcap", Form::Kind::kRecord}}};
std::string form_names() {
  return "sinew, config, record, " + program::form_names(false);
}

std::expected<Form, Outcome> form_of(const std::optional<std::string>& name,
                                     const std::string& file, const char* option) {
  const auto* text = name ? program::text_form(*name) : program::form_of_file(file);
  if (text != nullptr) return Form{Form::Kind::kText, text};
  for (const Own& one : kOwn) {
    if (name ? one.name == *name : file.ends_with(one.ending)) return Form{one.kind};
  }
  if (name) {
    return std::unexpected(
        bad_input(fmt::format("{}: '{}' is not {}", option, printable(*name), form_names())));
  }
  return std::unexpected(bad_input(fmt::format(
      "{}: its ending does not say what it is; write {} {}", file, option, form_names())));
}

/// A text that was made, or why it was not.
using Made = std::expected<std::string, Outcome>;

bool is_pose(const Form& form) {
  return form.text != nullptr && form.text == program::text_form("pos");
}

program::DecimalMark mark_of(const ConvertRequest& request) {
  return request.comma ? program::DecimalMark::kComma : program::DecimalMark::kPoint;
}

Made from_program(const ConvertRequest& request, const RobotModel& model,
                  const program::TextForm& to) {
  const auto program = read_program(request.in, model);
  if (!program) return std::unexpected(program.error());
  auto text = program::text_of(to, *program, model, mark_of(request));
  if (text) return std::move(*text);
  const int file = text.error().refusal ? text.error().refusal->file : 0;
  return std::unexpected(no_form(text.error(), model, file_of(*program, file, request.in)));
}

/// The same pose with the other decimal mark.
Made pose_again(const ConvertRequest& request, const std::string& text, const RobotModel& model) {
  const auto pose = program::read_pose_file(text, request.in);
  if (!pose) return std::unexpected(complaints_outcome(pose.error()));
  const auto fit = program::platform_of(*pose, model, request.in, 1);
  if (!fit) return std::unexpected(no_form(fit.error(), model, request.in));
  return program::pose_text(*pose, mark_of(request));
}

/// The journal's next run begins with these positions.
/// @error  the journal cannot be used, or knows better
std::expected<std::string, Outcome> taken_over(const std::string& name, const RobotModel& model,
                                               const std::vector<JointPosition>& legs,
                                               bool replace) {
  const auto record = open_journal(name, model);
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
  const auto fit = program::platform_of(config->real, model, request.in, 3);
  if (!fit) return no_form(fit.error(), model, request.in);
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

Made taught(const ConvertRequest& request, const RobotModel& model) {
  const auto way = way_of_record(request.in, model);
  if (!way) return std::unexpected(way.error());
  auto made = program_of_way(*way, model);
  if (!made) return std::unexpected(made.error());
  auto out = program::format(made->text, request.in);
  if (!out) return std::unexpected(complaints_outcome(out.error()));
  return std::move(*out);
}

Made converted(const ConvertRequest& request, const RobotModel& model, Form from, Form to) {
  const bool to_rows = to.kind == Form::Kind::kProgram;
  const bool to_text = to.text != nullptr && to.text->text != nullptr;
  if (from.kind == Form::Kind::kProgram && to_text) return from_program(request, model, *to.text);
  if (from.kind == Form::Kind::kRecord && to_rows) return taught(request, model);
  const auto text = io::read_file(request.in);
  if (!text) return std::unexpected(bad_input(text.error().sentence));
  if (from.text != nullptr && to_rows) {
    auto rows = program::rows_of(*from.text, *text, request.in, model);
    if (!rows) return std::unexpected(no_form(rows.error(), model, request.in));
    return std::move(rows->text);
  }
  if (is_pose(from) && is_pose(to)) return pose_again(request, *text, model);
  return std::unexpected(
      bad_input(fmt::format("convert: from record, {} to sinew, from sinew to {}, from pos to pos; "
                            "a config is only told",
                            program::form_names(false), program::form_names(true))));
}

}  // namespace

Outcome convert(const ConvertRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  const RobotModel& model = file->model;
  const auto from = form_of(request.from, request.in, "--from");
  if (!from) return from.error();
  if (from->kind == Form::Kind::kConfig && !request.out && !request.to) {
    const auto text = io::read_file(request.in);
    return text ? tell_config(request, *text, model) : bad_input(text.error().sentence);
  }
  if (request.journal) return bad_input("--journal: only of a config that is told, without OUT");
  const bool by_name = request.to || request.out;
  const auto to = by_name ? form_of(request.to, request.out.value_or(""), "--to")
                          : std::expected<Form, Outcome>(Form{});
  if (!to) return to.error();
  if (request.comma && !is_pose(*to)) {
    return bad_input("--decimal-comma: only of a .pos file");
  }
  if (request.out && io::same_file(request.in, *request.out)) {
    return bad_input(*request.out + ": is the file that is read");
  }
  if (request.out && io::is_file(*request.out) && !request.replace) {
    return bad_input(*request.out + ": is there already; --replace writes it anew");
  }
  const auto text = converted(request, model, *from, *to);
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

void add_convert(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<ConvertRequest>();
  ConvertRequest& request = *own;
  CLI::App* verb =
      add_verb(app, call, "convert", "programs and poses from and to the forms that others read",
               "sinew convert part.gcode part.sinew --robot maxarm");
  verb->add_option("IN", request.in,
                   "NAME.sinew, .txt (BigRobotArm), .pos, .cfg (hexapod), .gcode .nc .ngc, .mcap")
      ->required();
  verb->add_option("OUT", request.out, "NAME.sinew, .txt or .pos; on stdout where left out");
  verb->add_option("--robot", request.robot, "id or .toml file")->required();
  verb->add_option("--from", request.from, form_names());
  verb->add_option("--to", request.to, "sinew, " + program::form_names(true));
  verb->add_flag("--decimal-comma", request.comma,
                 "of a .pos file, for the old program on a PC whose country writes so");
  verb->add_flag("--replace", request.replace,
                 "a file OUT that is there already; what the journal NAME knows");
  verb->add_option("--journal", request.journal,
                   "of a .cfg: the position journal NAME takes its word over, as uncertain");
  verb->callback([&call, own] { call.verb = [own] { return convert(*own); }; });
}

}  // namespace sinew::cli
