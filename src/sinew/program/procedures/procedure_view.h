#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sinew/core/quantity.h"
#include "sinew/program/procedures/procedure.h"

namespace sinew::program {

/// A procedure as somebody sees it who is not in its thread, or not in its process.
struct ProcedureView {
  /// What kind of answer is waited for.
  enum class Asks : std::uint8_t {
    kNothing,
    kYes,     ///< it was read, or done by hand
    kGo,      ///< something begins to move
    kWords,   ///< one of the choices
    kNumber,  ///< a number with its unit, within its range
    kAmount,  ///< by how much a joint moves; or done
    kPlace,   ///< one of the choices, or a value a joint
  };
  struct Found {
    std::string step;
    std::string text;
    StepResult result;
  };
  /// Of a number, SI.
  struct Range {
    Measure measure = Measure::kLength;
    double lower = 0;
    double upper = 0;
  };

  std::string id;
  std::string title;
  Procedure::Phase phase = Procedure::Phase::kOpening;
  std::size_t place = 0;     ///< of the step under way, from 0; their number behind the last
  std::vector<Found> steps;  ///< all of them, with what has come of each
  std::string trouble;       ///< why the question stands still, or why it has failed

  Asks asks = Asks::kNothing;
  bool ready = false;  ///< an answer would be taken now
  bool left = false;   ///< control is lost: it waits for a client that goes on with it
  std::string question;
  std::vector<std::string> choices;
  std::optional<Range> range;
  std::optional<std::string> joint;  ///< that it is about

  std::string progress;  ///< in words, while something goes on
  double elapsed = 0;    ///< s, of what goes on
  std::optional<double> at_most;
  std::optional<double> share;  ///< of the motion that goes on, 0..1

  bool finished() const { return phase >= Procedure::Phase::kDone; }
};

ProcedureView view_of(const Procedure& procedure, Instant now);

/// "yes", "go", "words", "number", "amount", "place"; empty for nothing.
std::string_view name(ProcedureView::Asks asks);

}  // namespace sinew::program
