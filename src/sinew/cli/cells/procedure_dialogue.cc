#include "sinew/cli/cells/procedure_dialogue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <utility>

#include "sinew/cli/output/shown_text.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/spelling.h"
#include "sinew/io/file.h"
#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

using program::Procedure;
using program::ProcedureView;
using program::StepResult;
using Asks = ProcedureView::Asks;
using State = StepResult::State;

constexpr std::size_t kTextWidth = 72;

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

/// In lines of kTextWidth, each behind the margin.
std::string wrapped(const std::string& text, const std::string& margin) {
  std::string out;
  std::string line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t space = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, space - at);
    if (!line.empty() && line.size() + 1 + word.size() > kTextWidth) {
      out += margin + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
    at = space + 1;
  }
  return line.empty() ? out : out + margin + line + "\n";
}

constexpr const char* kIndent = "         ";

std::string found_text(const StepResult& result) {
  if (result.state == State::kSkipped && result.words.empty()) return {};
  return result.words.empty() ? result.answer : result.words;
}

bool only_begins(const ProcedureView& procedure) {
  return procedure.asks == Asks::kGo || procedure.asks == Asks::kYes;
}

/// "leg1 goes +0.2 mm, 1.2 s, 40 %"
std::string progress_text(const ProcedureView& procedure) {
  if (!procedure.share || procedure.progress.empty()) return procedure.progress;
  return fmt::format("{}, {:.0f} %", procedure.progress, 100 * *procedure.share);
}

}  // namespace

std::expected<ScriptedAnswers, std::string> ScriptedAnswers::read(const std::string& path) {
  const auto text = io::read_file(path);
  if (!text) return std::unexpected(text.error().sentence);
  return parse(*text, path);
}

std::expected<ScriptedAnswers, std::string> ScriptedAnswers::parse(const std::string& text,
                                                                   const std::string& path) {
  ScriptedAnswers script;
  script.path_ = path;
  int number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = trimmed(text.substr(at, end - at));
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

std::optional<std::string> ScriptedAnswers::unknown(const std::vector<std::string>& steps) const {
  for (const auto& [step, answers] : answers_) {
    if (step == "*" || std::ranges::find(steps, step) != steps.end()) continue;
    const std::vector<std::string_view> names(steps.begin(), steps.end());
    const std::string_view meant = nearest_spelling(step, names);
    return fmt::format("{}: there is no step '{}'{}", path_, printable(step),
                       meant.empty() ? "" : fmt::format(", did you mean '{}'?", meant));
  }
  return std::nullopt;
}

std::optional<std::string> ScriptedAnswers::take(const ProcedureView& procedure) {
  auto& answers = answers_[procedure.steps[procedure.place].step];
  // What is said of a motion's way is said behind it.
  const bool motion = procedure.joint.has_value();
  const bool begins = procedure.asks == Asks::kGo;
  if (begins &&
      (answers.empty() || (motion && answers.front() != "go" && answers.front() != "skip"))) {
    // What did not go once would not go a hundred times.
    if (!procedure.trouble.empty()) return std::nullopt;
    if (!answers.empty() || yes_to_all_) return "go";
    return std::nullopt;
  }
  if (answers.empty()) {
    if (yes_to_all_ && only_begins(procedure)) return procedure.choices[0];
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

void ProcedureDialogue::turn(const ProcedureView& procedure, const ProcedureHands& hands) {
  show(procedure);
  if (procedure.phase == Procedure::Phase::kAsking) ask(procedure, hands);
}

/// Of the steps that have ended since the last look.
void ProcedureDialogue::show_results(const ProcedureView& procedure) {
  told_results_ = std::min(told_results_, procedure.place);
  for (; told_results_ < procedure.place; ++told_results_) {
    const auto& [id, text, result] = procedure.steps[told_results_];
    const bool seen = shown_step_ == told_results_;
    if (!seen && result.words == "not needed") continue;
    if (!seen) {
      say(fmt::format("\n  {:>2}/{:<3} {}\n", told_results_ + 1, procedure.steps.size(), id) +
          wrapped(text, kIndent));
    }
    const std::string words = found_text(result);
    const std::string state =
        result.state == State::kDone ? "ok" : std::string(program::name(result.state));
    say(wrapped(state + (words.empty() ? "" : ": " + words), kIndent));
  }
}

void ProcedureDialogue::show(const ProcedureView& procedure) {
  if (quiet_) return;
  show_results(procedure);
  if (procedure.place == procedure.steps.size()) return;
  const bool opened = procedure.phase != Procedure::Phase::kOpening;
  if (opened && !procedure.finished() && shown_step_ != procedure.place) {
    shown_step_ = procedure.place;
    shown_question_.clear();
    shown_trouble_.clear();
    const auto& step = procedure.steps[procedure.place];
    say(fmt::format("\n  {:>2}/{:<3} {}\n", procedure.place + 1, procedure.steps.size(),
                    step.step) +
        wrapped(step.text, kIndent));
  }
  if (procedure.trouble != shown_trouble_ && !procedure.finished()) {
    shown_trouble_ = procedure.trouble;
    if (!shown_trouble_.empty()) say(wrapped("! " + shown_trouble_, kIndent));
    shown_question_.clear();
  }
  if (!procedure.question.empty() && procedure.question != shown_question_) {
    say(std::string(kIndent) + "[" + procedure.question + "]" +
        (script_ != nullptr ? "\n" : " > "));
  }
  shown_question_ = procedure.question;
  const std::string progress = progress_text(procedure);
  if (live_ && !progress.empty() && progress != shown_progress_) {
    std::fputs(("\r\033[K" + std::string(kIndent) + shown(progress)).c_str(), stderr);
    dirty_ = true;
  }
  shown_progress_ = progress;
}

void ProcedureDialogue::ask(const ProcedureView& procedure, const ProcedureHands& hands) {
  if (script_ == nullptr) {
    // What is piped in waits until it can be taken.
    if (!procedure.ready && !io::stdin_is_terminal()) return;
    if (const auto line = lines_.next()) return give(procedure, hands, trimmed(*line));
    if (!lines_.ended() || !complaint_.empty()) return;
    complaint_ =
        "the standard input ended before the last answer; give the answers with --answers FILE";
    return hands.cancel();
  }
  if (!procedure.ready || !complaint_.empty()) return;
  const auto answer = script_->take(procedure);
  if (!answer) {
    const std::string trouble = procedure.trouble.empty() ? "" : " (" + procedure.trouble + ")";
    complaint_ = fmt::format("{}: no answer for the step '{}'{}: {}", script_->path(),
                             procedure.steps[procedure.place].step, trouble, procedure.question);
    return hands.cancel();
  }
  say(std::string(kIndent) + "> " + *answer + "\n");
  give(procedure, hands, *answer);
}

void ProcedureDialogue::give(const ProcedureView& procedure, const ProcedureHands& hands,
                             const std::string& text) {
  shown_question_.clear();
  shown_trouble_.clear();
  if (text == "cancel" || text == "quit") return hands.cancel();
  const auto taken = text == "back" ? hands.back() : hands.answer(text);
  if (taken) {
    if (text == "back") shown_step_.reset();
    return;
  }
  say(wrapped("! " + taken.error(), kIndent));
  if (script_ == nullptr) return;
  complaint_ = fmt::format("{}: {}: {}", script_->path(), procedure.steps[procedure.place].step,
                           taken.error());
  hands.cancel();
}

std::string results_text(const ProcedureView& procedure) {
  Table table({"step", "", "found"});
  table.left(1).left(2);
  for (const auto& [id, text, result] : procedure.steps) {
    if (result.words == "not needed") continue;
    table.add({id, std::string(program::name(result.state)), found_text(result)});
  }
  return table.text();
}

Json results_json(const ProcedureView& procedure) {
  Json steps = Json::array();
  for (const auto& [id, text, result] : procedure.steps) {
    Json one{{"step", id}, {"state", program::name(result.state)}};
    if (!result.answer.empty()) one["answer"] = result.answer;
    if (!result.words.empty()) one["words"] = result.words;
    if (result.number) one["number"] = *result.number;
    steps.push_back(std::move(one));
  }
  return steps;
}

std::vector<std::string> step_ids(const ProcedureView& procedure) {
  std::vector<std::string> ids;
  for (const auto& found : procedure.steps) ids.push_back(found.step);
  return ids;
}

}  // namespace sinew::cli
