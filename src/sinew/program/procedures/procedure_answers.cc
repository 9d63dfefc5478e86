#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "sinew/control/position_evidence.h"
#include "sinew/core/quantity.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_value.h"
#include "sinew/model/left_out.h"
#include "sinew/program/procedures/procedure.h"
#include "sinew/program/procedures/procedure_words.h"

/// What a procedure asks people, and what their answers make it do.
namespace sinew::program {

using control::MachineState;

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", seconds);
  return text;
}

std::string way_text(double way, const Joint& joint) {
  char text[32];
  std::snprintf(text, sizeof text, "%+.3g %s", shown_value(way, joint), shown_unit(joint));
  return text;
}

namespace {

/// A place that is confirmed as its intervals show it.
constexpr std::string_view kShown = "shown";

std::string list_of(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ", ") + word;
  return list;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\n") - begin + 1);
}

}  // namespace

std::string Procedure::question() const {
  if (phase_ != Phase::kAsking) return {};
  std::string words = list_of(choices());
  if (const auto* number = std::get_if<NumberStep>(&step().what)) {
    words = number->measure == Measure::kLength ? "a length, as in 2.5mm" : "an angle, as in 3deg";
    if (number->measure == Measure::kShare) words = "a whole number";
    if (step().optional) words += "; or skip";
  }
  if (std::holds_alternative<AdjustStep>(step().what)) {
    words = "by how much, as in ";
    words += robot_.joints[moving_joint()].slides() ? "-0.3mm" : "-2deg";
    words += ", of all of them with all before it; or done";
  }
  if (std::holds_alternative<PlaceStep>(step().what)) {
    words += ", or a value for each joint with its unit";
  }
  return words;
}

std::vector<std::string> Procedure::choices() const {
  std::vector<std::string> words;
  if (phase_ != Phase::kAsking) return words;
  if (std::holds_alternative<TellStep>(step().what)) words = {"yes"};
  if (const auto* choice = std::get_if<ChoiceStep>(&step().what)) words = choice->words;
  if (const auto* motion = std::get_if<MotionStep>(&step().what)) {
    words = {"go"};
    if (went_) words = {motion->plus, motion->minus, "nothing", "other", "again"};
  }
  if (std::holds_alternative<CheckStep>(step().what)) words = {"again", "skip"};
  const bool starts = std::holds_alternative<SearchStep>(step().what) ||
                      std::holds_alternative<FirstMoveStep>(step().what) ||
                      std::holds_alternative<HomeMoveStep>(step().what) ||
                      std::holds_alternative<GiveStep>(step().what);
  if (starts) words = {"go"};
  if (const auto* where = std::get_if<PlaceStep>(&step().what)) {
    for (const PlaceStep::Place& place : where->places) words.push_back(place.name);
    if (shows_all()) words.emplace_back(kShown);
  }
  if (step().optional && std::ranges::find(words, "skip") == words.end()) words.push_back("skip");
  return words;
}

std::optional<std::size_t> Procedure::joint() const {
  if (place_ == plan_.steps.size()) return std::nullopt;
  if (const auto* motion = std::get_if<MotionStep>(&step().what)) return motion->joint;
  if (const auto* adjust = std::get_if<AdjustStep>(&step().what)) return adjust->joint;
  return phase_ == Phase::kWorking ? searching_ : std::nullopt;
}

double Procedure::working_for(Instant now) const {
  if (phase_ != Phase::kWorking && phase_ != Phase::kCancelling) return 0;
  return to_seconds(now - (searching_ ? searching_since_ : since_));
}

std::optional<double> Procedure::working_at_most() const {
  if (phase_ != Phase::kWorking || !searching_) return std::nullopt;
  const auto* search = std::get_if<SearchStep>(&step().what);
  if (search == nullptr || *searching_ >= search->times.size()) return std::nullopt;
  return search->times[*searching_];
}

std::string Procedure::progress(Instant now) const {
  if (phase_ == Phase::kOpening) return "finding the device";
  if (phase_ == Phase::kCancelling) return "coming to rest";
  if (phase_ != Phase::kWorking) return {};
  const std::string time = seconds_text(to_seconds(now - since_));
  if (const auto* search = std::get_if<SearchStep>(&step().what)) {
    if (!searching_) return "searching, " + time;
    const std::size_t j = *searching_;
    const std::string most =
        j < search->times.size() ? " of at most " + seconds_text(search->times[j]) : "";
    return "searching the zero of " + robot_.joints[j].name + " (" + std::to_string(j + 1) +
           " of " + std::to_string(robot_.joints.size()) + "), " +
           seconds_text(to_seconds(now - searching_since_)) + most;
  }
  if (std::holds_alternative<MotionStep>(step().what) ||
      std::holds_alternative<AdjustStep>(step().what)) {
    const Joint& joint = robot_.joints[moving_joint()];
    return joint.name + (comes_back_ ? " goes back" : " goes " + way_text(way_, joint)) + ", " +
           time;
  }
  return time;
}

std::expected<void, std::string> Procedure::answer(std::string_view text, Instant now) {
  if (phase_ != Phase::kAsking) {
    return std::unexpected(finished() ? "the procedure is over" : "nothing is asked at the moment");
  }
  text = trimmed(text);
  if (waits_for_control()) return std::unexpected("control was lost; take it, then answer");
  if (machine_.state() != MachineState::kReady) {
    return std::unexpected(std::string("the machine is ") +
                           std::string(control::name(machine_.state())) +
                           "; wait until it is ready");
  }
  given_ = printable(std::string(text.substr(0, 200)));
  if (text == "skip" && (step().optional || std::holds_alternative<CheckStep>(step().what))) {
    const bool check = std::holds_alternative<CheckStep>(step().what);
    std::string words = results_[place_].words;
    end_step(check ? StepResult::State::kFailed : StepResult::State::kSkipped, std::move(words));
    next(now);
    return {};
  }
  if (const auto* motion = std::get_if<MotionStep>(&step().what)) {
    return answer_motion(*motion, text, now);
  }
  if (std::holds_alternative<AdjustStep>(step().what)) return answer_adjust(text, now);
  if (const auto* place = std::get_if<PlaceStep>(&step().what)) return answer_place(*place, text);
  return answer_rest(text, now);
}

std::expected<void, std::string> Procedure::answer_motion(const MotionStep& step,
                                                          std::string_view text, Instant now) {
  if (!went_) {
    if (text != "go" && !text.empty()) {
      return std::unexpected("'" + given_ + "': answer go when nobody is in its way");
    }
    begin_work(now);
    return {};
  }
  if (text == "again") {
    went_ = false;
    // From where it went, so that it moves the other way now.
    if (const auto why = go(-way_)) {
      ask_again(*why);
    } else {
      way_ = -way_;
    }
    return {};
  }
  const std::array<std::pair<std::string_view, std::string_view>, 6> words{{{step.plus, "plus"},
                                                                            {step.minus, "minus"},
                                                                            {"plus", "plus"},
                                                                            {"minus", "minus"},
                                                                            {"nothing", "nothing"},
                                                                            {"other", "other"}}};
  const auto said =
      std::ranges::find(words, text, &std::pair<std::string_view, std::string_view>::first);
  if (said == words.end()) {
    return std::unexpected("'" + given_ + "' is none of " + list_of(choices()));
  }
  said_ = said->second;
  comes_back_ = true;
  if (const auto why = go(-way_)) ask_again(*why);
  return {};
}

std::expected<void, std::string> Procedure::answer_adjust(std::string_view text, Instant now) {
  const Joint& joint = robot_.joints[std::get<AdjustStep>(step().what).joint];
  if (text == "done") {
    end_step(StepResult::State::kDone, "went " + way_text(adjusted_, joint) + " in all", adjusted_);
    next(now);
    return {};
  }
  constexpr std::string_view kAll = "all ";
  const bool all = text.starts_with(kAll);
  if (all) text = trimmed(text.substr(kAll.size()));
  const auto way = parse_quantity(text, measure_of(joint), UnitRule::kRequired);
  if (!way) return std::unexpected(way.error() + "; or done");
  // Nobody looks at a long way that carefully.
  const double most = joint.slides() ? from_mm(10) : from_deg(20);
  if (!(std::abs(*way) <= most) || *way == 0) {
    return std::unexpected("'" + given_ + "': at most " + way_text(most, joint) +
                           " at a time either way, and not nothing; or done");
  }
  trouble_.clear();
  since_ = now;
  way_ = *way;
  all_ = all;
  if (const auto why = go(way_)) ask_again(*why);
  return {};
}

/// Each joint is known, if only within an interval.
bool Procedure::shows_all() const {
  const auto positions = machine_.positions();
  for (std::size_t j = 0; j < positions.size(); ++j) {
    if (positions[j].quality == PositionQuality::kLost && !is_left_out(robot_, j)) return false;
  }
  return true;
}

std::expected<void, std::string> Procedure::answer_place(const PlaceStep& step,
                                                         std::string_view text) {
  control::Declare declare;
  constexpr std::string_view kMoved = " moved:";
  if (const std::size_t moved = text.find(kMoved); moved != std::string_view::npos) {
    if (trimmed(text.substr(moved + kMoved.size())).empty()) {
      return std::unexpected("moved: needs a reason in words: who moved it, and how");
    }
    declare.moved = true;
    text = trimmed(text.substr(0, moved));
  }
  const auto declares = [&] {
    trouble_.clear();
    command_ = machine_.give(declare);
    phase_ = Phase::kWorking;
    return std::expected<void, std::string>{};
  };
  if (text == kShown && shows_all()) {
    const auto shown = control::as_shown(robot_, machine_.positions());
    if (!shown) return std::unexpected(sentence(shown.error()));
    declare.positions = *shown;
    return declares();
  }
  JointVector q;
  const auto named = std::ranges::find(step.places, text, &PlaceStep::Place::name);
  if (named != step.places.end()) q = named->q;
  std::string_view rest = text;
  while (named == step.places.end() && q.size() < robot_.joints.size()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const auto value = parse_quantity(trimmed(rest.substr(0, comma)),
                                      measure_of(robot_.joints[q.size()]), UnitRule::kRequired);
    if (!value) return std::unexpected(value.error() + "; the answers are " + question());
    q.push_back(*value);
    if (comma == rest.size()) break;
    rest.remove_prefix(comma + 1);
    if (q.size() == robot_.joints.size()) {
      return std::unexpected("more values than the robot has joints");
    }
  }
  if (q.size() != robot_.joints.size()) {
    return std::unexpected("a value for each of its " + std::to_string(robot_.joints.size()) +
                           " joints is needed, or one of " + list_of(choices()));
  }
  for (const double one : q) {
    declare.positions.push_back({PositionQuality::kCommanded, one, one, one});
  }
  return declares();
}

std::expected<void, std::string> Procedure::answer_rest(std::string_view text, Instant now) {
  const auto refuse = [&](const std::string& what) {
    return std::unexpected("'" + given_ + "': " + what);
  };
  if (std::holds_alternative<TellStep>(step().what)) {
    if (text != "yes") return refuse("answer yes when it is so, or cancel");
    end_step(StepResult::State::kDone, "");
  } else if (const auto* choice = std::get_if<ChoiceStep>(&step().what)) {
    const auto word = std::ranges::find(choice->words, text);
    if (word == choice->words.end()) return refuse("is none of " + list_of(choices()));
    end_step(StepResult::State::kDone, *word,
             static_cast<double>(std::distance(choice->words.begin(), word)));
  } else if (const auto* number = std::get_if<NumberStep>(&step().what)) {
    const bool count = number->measure == Measure::kShare;
    constexpr std::string_view kDigits = "0123456789";
    if (count && (text.empty() || text.find_first_not_of(kDigits) != std::string_view::npos)) {
      return refuse("is no whole number");
    }
    const auto value = parse_quantity(count ? std::string(text) + "00%" : std::string(text),
                                      number->measure, UnitRule::kRequired);
    if (!value)
      return std::unexpected(count ? "'" + given_ + "' is no whole number" : value.error());
    if (!(*value >= number->lower && *value <= number->upper)) {
      const bool length = number->measure == Measure::kLength;
      const auto shown = [&](double v) {
        char out[48];
        const double in_unit = count ? v : length ? to_mm(v) : to_deg(v);
        std::snprintf(out, sizeof out, count ? "%.0f" : length ? "%g mm" : "%g deg", in_unit);
        return std::string(out);
      };
      return refuse("has to be " + shown(number->lower) + " to " + shown(number->upper));
    }
    if (number->refuses) {
      if (const auto why = number->refuses(*this, *value)) return refuse(*why);
    }
    end_step(StepResult::State::kDone, given_, *value);
  } else if (std::holds_alternative<CheckStep>(step().what)) {
    if (text != "again" && !text.empty()) return refuse("is none of again, skip");
    trouble_.clear();
    since_ = now;
    phase_ = Phase::kWorking;
    return {};
  } else {
    if (text != "go" && !text.empty()) return refuse("answer go when nobody is in its way");
    begin_work(now);
    return {};
  }
  next(now);
  return {};
}

std::expected<void, std::string> Procedure::back(Instant now) {
  if (phase_ != Phase::kAsking) {
    return std::unexpected(finished() ? "the procedure is over"
                                      : "something is under way; cancel ends it");
  }
  // What looks by itself would lead here again.
  std::size_t passed = asked_.size();
  while (passed > 0 && std::holds_alternative<CheckStep>(plan_.steps[asked_[passed - 1]].what)) {
    --passed;
  }
  if (passed == 0) return std::unexpected("this is the first step");
  place_ = asked_[passed - 1];
  asked_.resize(passed - 1);
  for (std::size_t k = place_; k < results_.size(); ++k) results_[k] = {};
  enter(now);
  return {};
}

}  // namespace sinew::program
