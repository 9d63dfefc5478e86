#include "sinew/cli/procedure_dialogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "sinew/cli/shown_text.h"
#include "sinew/cli/table.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

using program::Procedure;
using program::StepResult;
using State = StepResult::State;

constexpr std::size_t kWidth = 72;

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// In lines of kWidth, each behind the margin.
std::string wrapped(const std::string& text, const std::string& margin) {
  std::string out;
  std::string line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t space = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, space - at);
    if (!line.empty() && line.size() + 1 + word.size() > kWidth) {
      out += margin + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    at = space + 1;
  }
  return line.empty() ? out : out + margin + line + "\n";
}

constexpr const char* kMargin = "         ";

std::string found_text(const StepResult& result) {
  if (result.state == State::kSkipped && result.words.empty()) return {};
  return result.words.empty() ? result.answer : result.words;
}

bool only_begins(const Procedure& procedure) {
  const auto choices = procedure.choices();
  return !choices.empty() && (choices[0] == "go" || choices[0] == "yes");
}

}  // namespace

std::expected<ScriptedAnswers, std::string> ScriptedAnswers::read(const std::string& path) {
  const auto text = io::read_file(path);
  if (!text) return std::unexpected(text.error().sentence);
  ScriptedAnswers script;
  script.path_ = path;
  int number = 0;
  for (std::size_t at = 0; at < text->size();) {
    const std::size_t end = std::min(text->find('\n', at), text->size());
    const std::string line = trimmed(text->substr(at, end - at));
    at = end + 1;
    ++number;
    if (line.empty() || line[0] == '#') continue;
    const std::size_t equals = line.find('=');
    const std::string step = trimmed(line.substr(0, std::min(equals, line.size())));
    if (equals == std::string::npos || step.empty()) {
      return std::unexpected(fmt::format("{}:{}: '{}' is no answer; write STEP = ANSWER", path,
                                         number, printable(line.substr(0, 60))));
    }
    const std::string answer = trimmed(line.substr(equals + 1));
    if (step == "*" && answer != "yes") {
      return std::unexpected(fmt::format("{}:{}: * can only be answered with yes", path, number));
    }
    if (step == "*") script.yes_to_all_ = true;
    script.answers_[step].push_back(answer);
  }
  return script;
}

std::optional<std::string> ScriptedAnswers::unknown(const program::ProcedurePlan& plan) const {
  for (const auto& [step, answers] : answers_) {
    const bool known = std::ranges::any_of(
        plan.steps, [&](const program::ProcedureStep& one) { return one.id == step; });
    if (known || step == "*") continue;
    std::vector<std::string_view> names;
    for (const program::ProcedureStep& one : plan.steps) names.push_back(one.id);
    const std::string_view meant = nearest_spelling(step, names);
    return fmt::format("{}: there is no step '{}'{}", path_, printable(step),
                       meant.empty() ? "" : fmt::format(", did you mean '{}'?", meant));
  }
  return std::nullopt;
}

std::optional<std::string> ScriptedAnswers::take(const Procedure& procedure) {
  const auto choices = procedure.choices();
  auto& answers = answers_[procedure.step().id];
  // What is said of a motion's way is said behind it.
  const bool motion = std::holds_alternative<program::MotionStep>(procedure.step().what);
  const bool begins = !choices.empty() && choices[0] == "go";
  if (begins &&
      (answers.empty() || (motion && answers.front() != "go" && answers.front() != "skip"))) {
    // What did not go once would not go a hundred times.
    if (!procedure.trouble().empty()) return std::nullopt;
    if (!answers.empty() || yes_to_all_) return "go";
    return std::nullopt;
  }
  if (answers.empty()) {
    if (yes_to_all_ && only_begins(procedure)) return choices[0];
    return std::nullopt;
  }
  std::string answer = answers.front();
  answers.pop_front();
  return answer;
}

ProcedureDialogue::ProcedureDialogue(bool quiet, ScriptedAnswers* script)
    : quiet_(quiet), live_(io::stderr_is_terminal()), script_(script) {}

ProcedureDialogue::~ProcedureDialogue() {
  clear_line();
}

void ProcedureDialogue::clear_line() {
  if (dirty_) std::fputs("\r\033[K", stderr);
  dirty_ = false;
}

void ProcedureDialogue::say(const std::string& text) {
  if (quiet_) return;
  clear_line();
  std::fputs(shown(text).c_str(), stderr);
}

void ProcedureDialogue::turn(Procedure& procedure, Instant now) {
  show(procedure, now);
  if (procedure.phase() == Procedure::Phase::kAsking) ask(procedure, now);
}

/// Of the steps that have ended since the last look.
void ProcedureDialogue::show_results(const Procedure& procedure) {
  told_results_ = std::min(told_results_, procedure.place());
  for (; told_results_ < procedure.place(); ++told_results_) {
    const StepResult& result = procedure.results()[told_results_];
    const program::ProcedureStep& step = procedure.plan().steps[told_results_];
    const bool seen = shown_step_ == told_results_;
    if (!seen && result.words == "not needed") continue;
    if (!seen) {
      say(fmt::format("\n  {:>2}/{:<3} {}\n", told_results_ + 1, procedure.plan().steps.size(),
                      step.id) +
          wrapped(step.text, kMargin));
    }
    const std::string words = found_text(result);
    const std::string state =
        result.state == State::kDone ? "ok" : std::string(program::name(result.state));
    say(wrapped(state + (words.empty() ? "" : ": " + words), kMargin));
  }
}

void ProcedureDialogue::show(const Procedure& procedure, Instant now) {
  if (quiet_) return;
  show_results(procedure);
  if (procedure.place() == procedure.plan().steps.size()) return;
  const bool opened = procedure.phase() != Procedure::Phase::kOpening;
  if (opened && !procedure.finished() && shown_step_ != procedure.place()) {
    shown_step_ = procedure.place();
    shown_question_.clear();
    shown_trouble_.clear();
    say(fmt::format("\n  {:>2}/{:<3} {}\n", procedure.place() + 1, procedure.plan().steps.size(),
                    procedure.step().id) +
        wrapped(procedure.step().text, kMargin));
  }
  if (procedure.trouble() != shown_trouble_ && !procedure.finished()) {
    shown_trouble_ = procedure.trouble();
    if (!shown_trouble_.empty()) say(wrapped("! " + shown_trouble_, kMargin));
    shown_question_.clear();
  }
  const std::string question = procedure.question();
  if (!question.empty() && question != shown_question_) {
    say(std::string(kMargin) + "[" + question + "]" + (script_ != nullptr ? "\n" : " > "));
  }
  shown_question_ = question;
  const std::string progress = procedure.progress(now);
  if (live_ && !progress.empty() && progress != shown_progress_) {
    std::fputs(("\r\033[K" + std::string(kMargin) + shown(progress)).c_str(), stderr);
    dirty_ = true;
  }
  shown_progress_ = progress;
}

void ProcedureDialogue::ask(Procedure& procedure, Instant now) {
  if (script_ == nullptr) {
    if (const auto line = lines_.next()) give(procedure, trimmed(*line), now);
    return;
  }
  if (procedure.machine().state() != control::MachineState::kReady) return;
  const auto answer = script_->take(procedure);
  if (!answer) {
    const std::string trouble = procedure.trouble().empty() ? "" : " (" + procedure.trouble() + ")";
    complaint_ = fmt::format("{}: no answer for the step '{}'{}: {}", script_->path(),
                             procedure.step().id, trouble, procedure.question());
    return procedure.cancel(now);
  }
  say(std::string(kMargin) + "> " + *answer + "\n");
  give(procedure, *answer, now);
}

void ProcedureDialogue::give(Procedure& procedure, const std::string& text, Instant now) {
  shown_question_.clear();
  shown_trouble_.clear();
  if (text == "cancel" || text == "quit") return procedure.cancel(now);
  const std::string step = procedure.step().id;
  const auto taken = text == "back" ? procedure.back(now) : procedure.answer(text, now);
  if (taken) {
    if (text == "back") shown_step_.reset(), told_results_ = procedure.place();
    return;
  }
  say(wrapped("! " + taken.error(), kMargin));
  if (script_ == nullptr) return;
  complaint_ = fmt::format("{}: {}: {}", script_->path(), step, taken.error());
  procedure.cancel(now);
}

std::string results_text(const Procedure& procedure) {
  Table table({"step", "", "found"});
  table.left(1).left(2);
  for (std::size_t k = 0; k < procedure.results().size(); ++k) {
    const StepResult& result = procedure.results()[k];
    if (result.words == "not needed") continue;
    const std::string words = found_text(result);
    table.add({procedure.plan().steps[k].id, std::string(program::name(result.state)), words});
  }
  return table.text();
}

Json results_json(const Procedure& procedure) {
  Json steps = Json::array();
  for (std::size_t k = 0; k < procedure.results().size(); ++k) {
    const StepResult& result = procedure.results()[k];
    Json one{{"step", procedure.plan().steps[k].id}, {"state", program::name(result.state)}};
    if (!result.answer.empty()) one["answer"] = result.answer;
    if (!result.words.empty()) one["words"] = result.words;
    if (result.number) one["number"] = *result.number;
    steps.push_back(std::move(one));
  }
  return steps;
}

}  // namespace sinew::cli
