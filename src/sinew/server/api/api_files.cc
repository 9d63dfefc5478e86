#include <algorithm>
#include <utility>

#include "sinew/config/points_file.h"
#include "sinew/program/formats/program_format.h"
#include "sinew/program/formats/text_forms.h"
#include "sinew/program/language/program_rows.h"
#include "sinew/program/plans/program_check.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/server/api/api.h"
#include "sinew/server/json/preview.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

using program::RowVerdict;

std::map<std::string, std::string> texts_of(const RpcRequest& request, const char* name) {
  std::map<std::string, std::string> texts;
  if (!request.params.contains(name)) return texts;
  for (const auto& [key, text] : request.params[name].items()) {
    texts.emplace(key, text.get<std::string>());
  }
  return texts;
}

/// What a check looks at, in a thread of its own.
struct CheckWish {
  std::size_t robot = 0;
  std::string text;
  const program::TextForm* form = nullptr;
  std::optional<std::string> points;
  std::optional<std::map<std::string, std::string>> called;
};

CheckWish wish_of(std::size_t robot, const RpcRequest& request) {
  CheckWish wish{
      .robot = robot, .text = request.text("text"), .form = {}, .points = {}, .called = {}};
  if (request.params.contains("points")) wish.points = request.text("points");
  if (request.params.contains("called")) wish.called = texts_of(request, "called");
  return wish;
}

constexpr const char* kOwnName = "program";

Json complaint_rows(const std::vector<Complaint>& complaints) {
  Json rows = Json::array();
  for (const Complaint& one : complaints) {
    Json row{{"line", one.line}, {"column", one.column}};
    if (one.file != kOwnName) row["file"] = one.file;
    row["verdict"] = "refused";
    row["sentence"] = one.message;
    if (!one.key.empty()) row["key"] = one.key;
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Where the words of each line begin, counted from 1.
std::vector<int> columns_of(std::string_view text) {
  std::vector<int> columns;
  program::for_each_line(text, [&](int, std::string_view line) {
    const std::size_t first = line.find_first_not_of(" \t");
    columns.push_back(first == std::string_view::npos ? 1 : static_cast<int>(first) + 1);
    return true;
  });
  return columns;
}

/// Rows of a program that can be read, each with what a run would say to it.
class Verdicts {
 public:
  Verdicts(const runtime::RunningCell& cell, const CheckWish& wish, const program::Program& program)
      : cell_(cell), wish_(wish), program_(program), columns_(columns_of(wish.text)) {}

  Json json() {
    const RobotModel& model = cell_.station(wish_.robot).robot();
    const auto look = [this](const planning::CellWay& way) { return meets(way); };
    const auto checked = program::check(program_, model, standing(cell_.station(wish_.robot)),
                                        runtime::homing_of(model), look);
    Json rows = Json::array();
    for (std::size_t i = 0; i < checked.rows.size(); ++i) {
      if (checked.rows[i].kind != RowVerdict::Kind::kNothing) rows.push_back(row(checked.rows, i));
    }
    Json json{{"fine", checked.fine()},
              {"duration_min_s", checked.duration_min},
              {"duration_max_s", checked.duration_max},
              {"homing_at_most_s", checked.homing_max},
              {"rows", std::move(rows)}};
    for (const program::ProgramNote& note : program_.notes) {
      json["notes"].push_back({{"line", note.line}, {"sentence", note.sentence}});
    }
    if (checked.broken_off) json["broken_off"] = refusal(*checked.broken_off);
    return json;
  }

 private:
  std::optional<Error> meets(const planning::CellWay& way) {
    auto meeting = cell_.space().meets(wish_.robot, way);
    if (!meeting) return std::nullopt;
    met_.emplace_back(meeting->error, std::move(meeting->refusal));
    return met_.back().first;
  }
  Json refusal(const program::Refusal& why) const {
    const auto met = std::ranges::find(met_, why.error, &Met::first);
    const RpcError error =
        refused_plan(why, cell_.station(wish_.robot).robot(),
                     met != met_.end() ? std::optional(met->second) : std::nullopt);
    Json json{{"sentence", error.message}, {"refusal", error.data}};
    if (why.file != 0) json["file"] = program_.files[static_cast<std::size_t>(why.file)];
    return json;
  }
  /// Where a step stands.
  Json place(std::size_t i) const {
    const program::Step& step = program_.steps[i];
    const auto line = static_cast<std::size_t>(step.line);
    const bool own = step.file == 0 && line >= 1 && line <= columns_.size();
    Json json{{"line", step.line}, {"column", own ? columns_[line - 1] : 1}};
    if (step.file != 0) json["file"] = program_.files[static_cast<std::size_t>(step.file)];
    return json;
  }
  Json row(const std::vector<RowVerdict>& rows, std::size_t i) const {
    const RowVerdict& one = rows[i];
    Json json = place(i);
    if (one.kind == RowVerdict::Kind::kFine) {
      json["verdict"] = "fine";
      json["time_min_s"] = one.time_min;
      json["time_max_s"] = one.time_max;
      if (one.motion != i) json["motion_of_line"] = program_.steps[one.motion].line;
    } else if (one.kind == RowVerdict::Kind::kRefused) {
      json["verdict"] = "refused";
      json.update(refusal(*one.refusal));
      if (one.round > 1) json["round"] = one.round;
    } else {
      json["verdict"] = "not_checked";
      json["because"] = place(one.because);
    }
    return json;
  }

  using Met = std::pair<Error, runtime::CellRefusal>;
  const runtime::RunningCell& cell_;
  const CheckWish& wish_;
  const program::Program& program_;
  std::vector<int> columns_;
  std::vector<Met> met_;
};

/// A program with the points and programs around it.
std::expected<program::Program, program::NoForm> read_program(const runtime::RunningCell& cell,
                                                              const Keeper& keeper,
                                                              const CheckWish& wish) {
  const auto kept = wish.points ? std::expected<std::string, std::string>(*wish.points)
                                : keeper.kept_points(wish.robot);
  if (!kept) return std::unexpected(program::NoForm{kept.error(), {}, {}});
  const TaughtPoints points = usable_points(*kept, "points.toml");
  program::Surroundings around;
  around.points = &points;
  around.table = cell.table_top(wish.robot);
  around.load = [&](std::string_view name) -> std::expected<program::CalledFile, std::string> {
    const std::string key(name);
    if (!wish.called) {
      auto text = keeper.kept_program(wish.robot, name);
      if (!text) return std::unexpected(text.error());
      return program::CalledFile{key, std::move(*text)};
    }
    const auto found = wish.called->find(key);
    if (found != wish.called->end()) return program::CalledFile{key, found->second};
    return std::unexpected("the request does not bring the program '" + key + "'");
  };
  return program::read_text(wish.form, wish.text, kOwnName, cell.station(wish.robot).robot(),
                            around);
}

Keeper::Result check_text(const runtime::RunningCell& cell, const Keeper& keeper,
                          const CheckWish& wish) {
  const auto program = read_program(cell, keeper, wish);
  if (program) return Verdicts(cell, wish, *program).json();
  const std::vector<Complaint>& complaints = program.error().complaints;
  if (complaints.empty()) {
    return std::unexpected(no_form(program.error(), cell.station(wish.robot).robot()));
  }
  return Json{{"fine", false}, {"rows", complaint_rows(complaints)}};
}

Keeper::Result export_text(const runtime::RunningCell& cell, const Keeper& keeper,
                           const CheckWish& wish, const program::TextForm& form,
                           program::DecimalMark mark) {
  const auto program = read_program(cell, keeper, wish);
  const RobotModel& model = cell.station(wish.robot).robot();
  if (!program) return std::unexpected(no_form(program.error(), model));
  auto text = program::text_of(form, *program, model, mark);
  if (!text) return std::unexpected(no_form(text.error(), model));
  return Json{{"text", std::move(*text)}};
}

}  // namespace

Api::Errand Api::at_files(std::function<Keeper::Result()> work) {
  return {files_, as_task(std::move(work))};
}

Api::Answer Api::check_program(const Call& call) {
  const auto form = asked_form(call.request, cell_.station(*call.robot).robot());
  if (!form) return form.error();
  CheckWish wish = wish_of(*call.robot, call.request);
  wish.form = *form;
  return Errand{checks_, as_task([this, wish] { return check_text(cell_, keeper_, wish); })};
}

Api::Answer Api::import_program(const Call& call) {
  const auto* form = program::text_form(call.request.text("form"));
  if (form == nullptr) return invalid("form is " + program::form_names(false));
  const RobotModel& model = cell_.station(*call.robot).robot();
  return Errand{checks_, as_task([=, &model, text = call.request.text("text")]() -> Keeper::Result {
                  auto rows = program::rows_of(*form, text, "the file", model);
                  if (!rows) return std::unexpected(no_form(rows.error(), model));
                  return Json{{"text", std::move(rows->text)}};
                })};
}

Api::Answer Api::export_program(const Call& call) {
  const auto* form = program::text_form(call.request.text("form"));
  if (form == nullptr || form->text == nullptr) {
    return invalid("form is " + program::form_names(true));
  }
  const auto mark = call.request.flag("decimal_comma") ? program::DecimalMark::kComma
                                                       : program::DecimalMark::kPoint;
  return Errand{checks_, as_task([=, this, wish = wish_of(*call.robot, call.request)] {
                  return export_text(cell_, keeper_, wish, *form, mark);
                })};
}

Api::Answer Api::keep_texts(const Method& method, const Call& call) {
  Keeper& keeper = keeper_;
  const std::size_t robot = *call.robot;
  const std::string name = call.request.text("name");
  const std::uint64_t revision = call.request.whole("revision", 0);
  switch (method.id) {
    case MethodId::kProgramsList:
      return at_files([&keeper, robot] { return keeper.list_programs(robot); });
    case MethodId::kProgramsLoad:
      return at_files([=, &keeper] { return keeper.load_program(robot, name); });
    case MethodId::kProgramsSave:
      return at_files([=, &keeper, text = call.request.text("text")] {
        return keeper.save_program(robot, name, text, revision);
      });
    case MethodId::kProgramsRemove:
      return at_files([=, &keeper] { return keeper.remove_program(robot, name, revision); });
    case MethodId::kPointsList:
      return at_files([&keeper, robot] { return keeper.list_points(robot); });
    case MethodId::kPointsSave:
      return at_files([=, &keeper, points = call.request.text("points")] {
        return keeper.save_points(robot, points, revision);
      });
    case MethodId::kPointsRemove:
      return at_files([=, &keeper] { return keeper.remove_point(robot, name, revision); });
    default:
      return at_files([=, &keeper, to = call.request.text("to")] {
        return keeper.rename_point(robot, name, to, revision);
      });
  }
}

Api::Answer Api::keep_settings(const Method& method, const Call& call) {
  Keeper& keeper = keeper_;
  const std::size_t robot = *call.robot;
  const auto settings = texts_of(call.request, "settings");
  const std::uint64_t revision = call.request.whole("revision", 0);
  if (method.id == MethodId::kSettingsGet) {
    return at_files([&keeper, robot] { return keeper.get_settings(robot); });
  }
  if (method.id == MethodId::kSettingsCheck) {
    return at_files([=, &keeper] { return keeper.check_settings(robot, settings); });
  }
  return at_files([=, &keeper] { return keeper.set_settings(robot, settings, revision); });
}

Api::Answer Api::keep(const Method& method, const Call& call) {
  Keeper& keeper = keeper_;
  const std::string record = call.request.text("record");
  const std::uint64_t offset = call.request.whole("offset", 0);
  switch (method.id) {
    case MethodId::kProgramCheck:
      return check_program(call);
    case MethodId::kProgramFormat: {
      auto text = program::format(call.request.text("text"), kOwnName);
      if (!text) return complained(text.error());
      return Json{{"text", std::move(*text)}};
    }
    case MethodId::kProgramImport:
      return import_program(call);
    case MethodId::kProgramExport:
      return export_program(call);
    case MethodId::kSettingsGet:
    case MethodId::kSettingsCheck:
    case MethodId::kSettingsSet:
      return keep_settings(method, call);
    case MethodId::kRecordStart:
      return at_files([&keeper, robot = *call.robot, title = call.request.text("title")] {
        return keeper.start_record(robot, title);
      });
    case MethodId::kRecordStop:
      return at_files([&keeper, robot = *call.robot] { return keeper.stop_record(robot); });
    case MethodId::kRecordsList:
      return at_files([&keeper] { return keeper.list_records(); });
    case MethodId::kRecordsRead:
      return at_files([=, &keeper] { return keeper.read_record(record, offset); });
    case MethodId::kRecordsCsv:
      return at_files([=, &keeper] { return keeper.read_csv(record, offset); });
    case MethodId::kRecordsRemove:
      return at_files([=, &keeper] { return keeper.remove_record(record); });
    default:
      return keep_texts(method, call);
  }
}

}  // namespace sinew::server
