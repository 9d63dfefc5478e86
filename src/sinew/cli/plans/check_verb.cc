#include "sinew/cli/plans/check_verb.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/plan_report.h"
#include "sinew/cli/output/program_folder.h"
#include "sinew/cli/output/progress_line.h"
#include "sinew/cli/output/robot_argument.h"
#include "sinew/cli/output/table.h"
#include "sinew/cli/output/targets.h"
#include "sinew/cli/output/verb_options.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/program_format.h"
#include "sinew/program/language/program_rows.h"
#include "sinew/program/plans/program_check.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/links/robot_variant.h"

namespace sinew::cli {
namespace {

using program::RowVerdict;
using Kind = RowVerdict::Kind;

constexpr std::size_t kRowShown = 44;  // characters

struct Checked {
  const RobotModel& model;
  const program::Program& program;
  const program::CheckedProgram& result;
  std::vector<std::vector<std::string>> texts;  ///< of each file, its rows
  bool from_home = true;
};

/// The rows of all files of a program, as they were written.
std::vector<std::vector<std::string>> texts_of(const program::Program& program) {
  std::vector<std::vector<std::string>> texts;
  for (const std::string& file : program.files) {
    auto& rows = texts.emplace_back();
    const auto text = io::read_file(file);
    if (!text) continue;
    program::for_each_line(*text, [&](int, std::string_view line) {
      rows.emplace_back(line);
      return true;
    });
  }
  return texts;
}

std::string row_text(const Checked& checked, const program::Step& step) {
  const auto& rows = checked.texts[static_cast<std::size_t>(step.file)];
  const auto line = static_cast<std::size_t>(step.line) - 1;
  if (line >= rows.size()) return {};
  std::string text = rows[line].substr(0, rows[line].find('#'));
  std::ranges::replace(text, '\t', ' ');
  text.erase(text.find_last_not_of(" \r") + 1);
  if (text.size() > kRowShown) text = text.substr(0, kRowShown - 3) + "...";
  return text;
}

/// "4", of a called program "place.sinew:4".
std::string line_text(const Checked& checked, const program::Step& step) {
  if (step.file == 0) return fmt::format("{}", step.line);
  const std::string& path = checked.program.files[static_cast<std::size_t>(step.file)];
  return fmt::format("{}:{}", path.substr(path.rfind('/') + 1), step.line);
}

/// The sentence and what would work, and the same for machines.
Outcome refusal_of(const Checked& checked, const program::Refusal& refusal) {
  return plan_refusal(checked.model, file_of(checked.program, refusal.file, ""), refusal);
}

std::string time_text(double least, double most) {
  if (most - least < 0.005) return fmt::format("{:.2f} s", most);
  return fmt::format("{:.2f} to {:.2f} s", least, most);
}

std::string verdict_text(const Checked& checked, std::size_t place) {
  const RowVerdict& row = checked.result.rows[place];
  const program::Step& step = checked.program.steps[place];
  if (row.kind == Kind::kUnchecked) {
    return "not checked, because nobody knows where line " +
           line_text(checked, checked.program.steps[row.because]) + " would have left the arm";
  }
  if (row.kind == Kind::kRefused) {
    std::string sentence = refusal_of(checked, *row.refusal).complaint;
    constexpr std::string_view kNothingMoved = "; nothing was moved";
    if (const std::size_t at = sentence.find(kNothingMoved); at != std::string::npos) {
      sentence.erase(at, kNothingMoved.size());
    }
    // "file:12, at 40 mm: .." to ".., at 40 mm": the line stands beside it.
    const std::string head =
        fmt::format("{}:{}", file_of(checked.program, step.file, ""), step.line);
    if (sentence.starts_with(head)) sentence.erase(0, head.size());
    while (sentence.starts_with(',') || sentence.starts_with(':') || sentence.starts_with(' ')) {
      sentence.erase(0, 1);
    }
    return (row.round > 1 ? fmt::format("refused in round {}: ", row.round) : "refused: ") +
           sentence;
  }
  if (std::holds_alternative<program::HomeStep>(step.what)) {
    return row.time_max > 0 ? at_most_text(row.time_max) : "as long as its board takes";
  }
  if (row.motion != place) {
    return "one motion with line " + line_text(checked, checked.program.steps[row.motion]);
  }
  return time_text(row.time_min, row.time_max);
}

Json verdict_json(const Checked& checked, std::size_t place) {
  const RowVerdict& row = checked.result.rows[place];
  const program::Step& step = checked.program.steps[place];
  Json json{{"file", file_of(checked.program, step.file, "")}, {"line", step.line}};
  constexpr const char* kNames[] = {"nothing", "fine", "refused", "not_checked"};
  json["verdict"] = kNames[static_cast<int>(row.kind)];
  if (row.kind == Kind::kFine) {
    json["time_min_s"] = row.time_min;
    json["time_max_s"] = row.time_max;
    json["motion_of_line"] = checked.program.steps[row.motion].line;
  } else if (row.kind == Kind::kRefused) {
    json["round"] = row.round;
    json["refusal"] = refusal_of(checked, *row.refusal).json["refusal"];
  } else if (row.kind == Kind::kUnchecked) {
    json["because_of_line"] = checked.program.steps[row.because].line;
    json["because_of_file"] = file_of(checked.program, checked.program.steps[row.because].file, "");
  }
  return json;
}

std::string totals_text(const Checked& checked) {
  const auto& result = checked.result;
  std::size_t refused = 0, unchecked = 0;
  for (const RowVerdict& row : result.rows) {
    refused += row.kind == Kind::kRefused ? 1 : 0;
    unchecked += row.kind == Kind::kUnchecked ? 1 : 0;
  }
  std::string text = "  ";
  if (result.fine()) {
    text += "all rows are fine; it takes " + time_text(result.duration_min, result.duration_max);
    if (result.homing_max > 0) text += ", and homing: " + at_most_text(result.homing_max);
  } else {
    text += fmt::format("{} refused, {} not checked", refused, unchecked);
  }
  if (checked.from_home) text += "; checked from the home pose (--from-joints says another one)";
  return text + "; nothing was moved\n";
}

Outcome report(const Checked& checked) {
  Outcome outcome;
  outcome.json = {{"robot", checked.model.id},
                  {"fine", checked.result.fine()},
                  {"duration_min_s", checked.result.duration_min},
                  {"duration_max_s", checked.result.duration_max},
                  {"homing_at_most_s", checked.result.homing_max},
                  {"rows", Json::array()}};
  Table table({"line", "row", "verdict"});
  table.left(1).left(2);
  for (std::size_t place = 0; place < checked.program.steps.size(); ++place) {
    const program::Step& step = checked.program.steps[place];
    if (checked.result.rows[place].kind == Kind::kNothing) continue;
    outcome.json["rows"].push_back(verdict_json(checked, place));
    std::string verdict = verdict_text(checked, place);
    std::string row = row_text(checked, step);
    std::string line = line_text(checked, step);
    for (std::size_t end = 0; end != std::string::npos;) {
      end = verdict.find('\n');
      table.add({line, row, verdict.substr(0, end)});
      if (end != std::string::npos) verdict.erase(0, end + 1);
      line.clear();
      row.clear();
    }
  }
  outcome.text = "\n" + table.text() + "\n";
  if (const auto& why = checked.result.broken_off) {
    const Outcome refusal = refusal_of(checked, *why);
    outcome.json["broken_off"] = refusal.json["refusal"];
    outcome.text += "  " + refusal.complaint + "\n";
  }
  outcome.json["notes"] = Json::array();
  for (const program::ProgramNote& one : checked.program.notes) {
    const std::string sentence = fmt::format("line {}: {}", one.line, one.sentence);
    outcome.json["notes"].push_back(sentence);
    outcome.text += "  note: " + sentence + "\n";
  }
  outcome.text += totals_text(checked);
  if (!checked.result.fine()) outcome.exit = ExitCode::kBadInput;
  return outcome;
}

}  // namespace

Outcome check_program(const CheckRequest& request) {
  const auto file = find_robot(request.robot);
  if (!file) return file.error();
  RobotModel model = file->model;
  if (request.profile || request.wire || !request.without.empty()) {
    auto variant = runtime::variant_of(file->model, request.profile, request.wire, request.without);
    if (!variant) return bad_input(variant.error());
    model = std::move(*variant);
  }
  JointVector from = home_joints(model);
  if (request.from) {
    const auto q = parse_joints("--from-joints", *request.from, model);
    if (!q) return bad_input(q.error());
    from = *q;
  }
  const auto program = read_program(request.file, model);
  if (!program) return program.error();
  const auto result = program::check(*program, model, from, runtime::homing_of(model));
  return report({model, *program, result, texts_of(*program), !request.from});
}

Outcome format_programs(const FormatRequest& request) {
  Outcome outcome;
  outcome.json["files"] = Json::array();
  std::vector<Complaint> complaints;
  bool differs = false;
  for (const std::string& file : request.files) {
    const auto text = io::read_file(file);
    if (!text) return bad_input(text.error().sentence);
    const auto laid_out = program::format(*text, file);
    if (!laid_out) {
      complaints.insert(complaints.end(), laid_out.error().begin(), laid_out.error().end());
      continue;
    }
    const bool same = *laid_out == *text;
    outcome.json["files"].push_back({{"file", file}, {"changed", !same}});
    if (same) continue;
    differs = true;
    if (!request.only_look) {
      if (const auto written = io::replace_file(file, *laid_out); !written) {
        return could_not(written.error().sentence);
      }
    }
    outcome.text += file + "\n";
  }
  if (!complaints.empty()) return complaints_outcome(complaints);
  if (request.only_look && differs) outcome.exit = ExitCode::kCouldNot;
  return outcome;
}

void add_check(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<CheckRequest>();
  CheckRequest& request = *own;
  CLI::App* verb =
      add_verb(app, call, "check", "everything but the motion: a verdict for each row of a program",
               "sinew check robots/learm/square.sinew --robot learm");
  verb->add_option("FILE", request.file, "the program NAME.sinew")->required();
  verb->add_option("--robot", request.robot, "id or .toml file")->required();
  verb->add_option("--from-joints", request.from, "where it starts; home where left out");
  add_variant(*verb, request);
  verb->callback([&call, own] { call.verb = [own] { return check_program(*own); }; });
}

void add_format(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<FormatRequest>();
  FormatRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "fmt", "lays out programs in their one form, in place",
                            "sinew fmt --check robots/learm/square.sinew");
  verb->add_option("FILE", request.files, "programs NAME.sinew")->required();
  verb->add_flag("--check", request.only_look,
                 "only names those that are not laid out; exit 1 where there is one");
  verb->callback([&call, own] { call.verb = [own] { return format_programs(*own); }; });
}

}  // namespace sinew::cli
