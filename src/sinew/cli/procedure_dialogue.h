#pragma once

#include <deque>
#include <expected>
#include <map>
#include <optional>
#include <string>

#include "sinew/cli/outcome.h"
#include "sinew/io/request_lines.h"
#include "sinew/program/procedure.h"

namespace sinew::cli {

/// Answers from a file, `STEP = ANSWER` a line; several of one step are given one after the other,
/// and `* = yes` stands for all that is only told or only begins.
class ScriptedAnswers {
 public:
  /// @error  what is wrong with the file, with the line
  static std::expected<ScriptedAnswers, std::string> read(const std::string& path);

  /// Nothing: the file has none for this step.
  std::optional<std::string> take(const program::Procedure& procedure);
  const std::string& path() const { return path_; }
  /// A step that no procedure asked about is a mistake that somebody should hear of.
  std::optional<std::string> unknown(const program::ProcedurePlan& plan) const;

 private:
  std::string path_;
  std::map<std::string, std::deque<std::string>> answers_;
  bool yes_to_all_ = false;
};

/// A procedure on a terminal: each step's text and question, what was found, how what moves gets
/// on; and what is typed, or scripted, as its answers.
class ProcedureDialogue {
 public:
  ProcedureDialogue(bool quiet, ScriptedAnswers* script);
  ~ProcedureDialogue();
  ProcedureDialogue(const ProcedureDialogue&) = delete;
  ProcedureDialogue& operator=(const ProcedureDialogue&) = delete;

  void turn(program::Procedure& procedure, Instant now);
  /// Why a script ended it; empty where none did.
  const std::string& complaint() const { return complaint_; }

 private:
  void show(const program::Procedure& procedure, Instant now);
  void show_results(const program::Procedure& procedure);
  void ask(program::Procedure& procedure, Instant now);
  void give(program::Procedure& procedure, const std::string& text, Instant now);
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
std::string results_text(const program::Procedure& procedure);
Json results_json(const program::Procedure& procedure);

}  // namespace sinew::cli
