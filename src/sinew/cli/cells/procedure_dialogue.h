#pragma once

#include <deque>
#include <expected>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sinew/cli/output/outcome.h"
#include "sinew/io/request_lines.h"
#include "sinew/program/procedures/procedure_view.h"

namespace sinew::cli {

/// Answers from a file, `STEP = ANSWER` a line; several of one step are given one after the other,
/// and `* = yes` stands for all that is only told or only begins.
class ScriptedAnswers {
 public:
  /// @error  what is wrong with the file, with the line
  static std::expected<ScriptedAnswers, std::string> read(const std::string& path);
  /// From a text. @param name  what complaints call it
  static std::expected<ScriptedAnswers, std::string> parse(const std::string& text,
                                                           const std::string& name);

  /// Nothing: the file has none for this step.
  std::optional<std::string> take(const program::ProcedureView& procedure);
  const std::string& path() const { return path_; }
  /// A step that no procedure asked about is a mistake that somebody should hear of.
  std::optional<std::string> unknown(const std::vector<std::string>& steps) const;

 private:
  std::string path_;
  std::map<std::string, std::deque<std::string>> answers_;
  bool yes_to_all_ = false;
};

/// How the procedure that is shown is given answers, in this process or over a cell's API.
struct ProcedureHands {
  std::function<std::expected<void, std::string>(const std::string&)> answer;
  std::function<std::expected<void, std::string>()> back;
  std::function<void()> cancel;
};

/// A procedure on a terminal: each step's text and question, what was found, how what moves gets
/// on; and what is typed, or scripted, as its answers.
class ProcedureDialogue {
 public:
  ProcedureDialogue(bool quiet, ScriptedAnswers* script);
  ~ProcedureDialogue();
  ProcedureDialogue(const ProcedureDialogue&) = delete;
  ProcedureDialogue& operator=(const ProcedureDialogue&) = delete;

  void turn(const program::ProcedureView& procedure, const ProcedureHands& hands);
  /// Why it was ended from here: by a script, or by the end of the input; empty where it was not.
  const std::string& complaint() const { return complaint_; }

 private:
  void show(const program::ProcedureView& procedure);
  void show_results(const program::ProcedureView& procedure);
  void ask(const program::ProcedureView& procedure, const ProcedureHands& hands);
  void give(const program::ProcedureView& procedure, const ProcedureHands& hands,
            const std::string& text);
  void say(const std::string& text);
  void clear_line();

  bool quiet_;
  bool live_;
  ScriptedAnswers* script_;
  io::RequestLines lines_;
  std::string complaint_;
  std::optional<std::size_t> shown_step_;
  std::size_t told_results_ = 0;
  std::string shown_question_;
  std::string shown_trouble_;
  std::string shown_progress_;
  bool dirty_ = false;
};

/// Each step with what came of it, for people and for machines.
std::string results_text(const program::ProcedureView& procedure);
Json results_json(const program::ProcedureView& procedure);
/// The ids of its steps.
std::vector<std::string> step_ids(const program::ProcedureView& procedure);

}  // namespace sinew::cli
