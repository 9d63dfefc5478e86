#include "sinew/server/json/procedure_json.h"

#include <array>
#include <utility>

namespace sinew::server {
namespace {

using program::Procedure;
using program::ProcedureView;
using program::StepResult;

/// What stands behind the names of a number's bounds.
std::string unit_of(Measure measure) {
  if (measure == Measure::kLength) return "_m";
  return measure == Measure::kAngle ? "_rad" : "";
}

Json step_json(const ProcedureView::Found& found) {
  Json json{
      {"step", found.step}, {"text", found.text}, {"state", program::name(found.result.state)}};
  if (!found.result.answer.empty()) json["answer"] = found.result.answer;
  if (!found.result.words.empty()) json["words"] = found.result.words;
  if (found.result.number) json["number"] = *found.result.number;
  return json;
}

Json asks_json(const ProcedureView& view) {
  Json json{{"kind", program::name(view.asks)},
            {"words", view.question},
            {"choices", view.choices},
            {"ready", view.ready}};
  if (view.range) {
    json["lower" + unit_of(view.range->measure)] = view.range->lower;
    json["upper" + unit_of(view.range->measure)] = view.range->upper;
  }
  return json;
}

template <class Enum>
bool read_name(const Json& json, Enum last, Enum& out) {
  for (int k = 0; k <= static_cast<int>(last); ++k) {
    if (json.get<std::string>() != program::name(static_cast<Enum>(k))) continue;
    out = static_cast<Enum>(k);
    return true;
  }
  return false;
}

ProcedureView::Found read_step(const Json& json) {
  ProcedureView::Found found{json.at("step"), json.at("text"), {}};
  read_name(json.at("state"), StepResult::State::kFailed, found.result.state);
  found.result.answer = json.value("answer", "");
  found.result.words = json.value("words", "");
  if (json.contains("number")) found.result.number = json["number"].get<double>();
  return found;
}

void read_asks(const Json& json, ProcedureView& view) {
  read_name(json.at("kind"), ProcedureView::Asks::kPlace, view.asks);
  view.question = json.at("words");
  view.choices = json.at("choices").get<std::vector<std::string>>();
  view.ready = json.at("ready");
  for (const Measure measure : {Measure::kLength, Measure::kAngle, Measure::kShare}) {
    const std::string lower = "lower" + unit_of(measure);
    if (!json.contains(lower)) continue;
    view.range = ProcedureView::Range{measure, json[lower].get<double>(),
                                      json.at("upper" + unit_of(measure)).get<double>()};
  }
}

}  // namespace

Json procedure_json(const std::string& robot, const runtime::ProcedureStatus& status) {
  const ProcedureView& view = status.view;
  Json json{
      {"robot", robot},      {"number", status.number},   {"client", status.client},
      {"kind", view.id},     {"title", view.title},       {"phase", program::name(view.phase)},
      {"over", status.over}, {"answers", status.answers}, {"place", view.place}};
  if (view.place < view.steps.size()) {
    const ProcedureView::Found& step = view.steps[view.place];
    json["step"] = {{"id", step.step},
                    {"number", view.place + 1},
                    {"of", view.steps.size()},
                    {"text", step.text}};
  }
  if (view.asks != ProcedureView::Asks::kNothing) json["asks"] = asks_json(view);
  if (view.left) json["client_lost"] = true;
  if (view.joint) json["joint"] = *view.joint;
  if (!view.progress.empty()) {
    json["progress"] = {{"words", view.progress}, {"elapsed_s", view.elapsed}};
    if (view.at_most) json["progress"]["at_most_s"] = *view.at_most;
    if (view.share) json["progress"]["share"] = *view.share;
  }
  if (!view.trouble.empty()) json["trouble"] = view.trouble;
  json["steps"] = Json::array();
  for (const ProcedureView::Found& found : view.steps) json["steps"].push_back(step_json(found));
  if (!status.file.empty()) {
    json["file"] = status.file;
    json["settings"] = Json::object();
    for (const auto& [key, value] : status.settings) json["settings"][key] = value;
  }
  if (!status.note.empty()) json["note"] = status.note;
  return json;
}

std::optional<runtime::ProcedureStatus> read_procedure(const Json& json) {
  try {
    runtime::ProcedureStatus status;
    status.number = json.at("number");
    status.client = json.at("client");
    status.over = json.at("over");
    status.answers = json.at("answers");
    status.file = json.value("file", "");
    status.note = json.value("note", "");
    const Json settings = json.value("settings", Json::object());
    for (const auto& [key, value] : settings.items()) status.settings[key] = value;
    ProcedureView& view = status.view;
    view.id = json.at("kind");
    view.title = json.at("title");
    if (!read_name(json.at("phase"), Procedure::Phase::kFailed, view.phase)) return std::nullopt;
    view.place = json.at("place");
    view.trouble = json.value("trouble", "");
    view.left = json.value("client_lost", false);
    for (const Json& step : json.at("steps")) view.steps.push_back(read_step(step));
    if (json.contains("asks")) read_asks(json["asks"], view);
    if (json.contains("joint")) view.joint = json["joint"].get<std::string>();
    if (json.contains("progress")) {
      const Json& progress = json["progress"];
      view.progress = progress.at("words");
      view.elapsed = progress.at("elapsed_s");
      if (progress.contains("at_most_s")) view.at_most = progress["at_most_s"].get<double>();
      if (progress.contains("share")) view.share = progress["share"].get<double>();
    }
    if (view.place > view.steps.size()) return std::nullopt;
    return status;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace sinew::server
