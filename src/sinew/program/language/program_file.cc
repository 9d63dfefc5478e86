#include "sinew/program/language/program_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <string>

#include "sinew/core/stable_sort.h"
#include "sinew/program/language/conditions.h"
#include "sinew/program/language/motion_rows.h"
#include "sinew/program/language/program_rows.h"

namespace sinew::program {
namespace {

constexpr std::size_t kNestingMax = 8;
constexpr std::size_t kCallsMax = 8;  // deep
constexpr std::size_t kFilesMax = 64;
constexpr int kRoundsMax = 10'000;
constexpr double kWaitMax = 3600;  // s
constexpr double kSettledIn = 5;   // s, where a row does not say it

/// What the files of one program share.
class Reading {
 public:
  Reading(const RobotModel& robot, const Surroundings& around, std::string name)
      : robot_(robot), around_(around), open_{std::move(name)} {}

  /// The rows of one file with all that it calls; places count from its own first row.
  std::vector<Step> read(std::string_view text, const std::string& file_name);
  /// Of a program that is called: read once, however often. Null where a sentence says why not.
  std::expected<const std::vector<Step>*, std::string> called(std::string_view name);

  /// For `more` rows behind `first` ones; also of all that was ever copied, since calls multiply.
  bool has_room(std::size_t first, std::size_t more) {
    copied_ += more;
    return first + more <= kStepsMax && copied_ <= 2 * kStepsMax;
  }

  const RobotModel& robot() const { return robot_; }
  const Surroundings& around() const { return around_; }
  std::vector<Complaint>& complaints() { return complaints_; }
  std::vector<std::string>& files() { return files_; }
  std::vector<CallRow>& calls() { return calls_; }

 private:
  const RobotModel& robot_;
  const Surroundings& around_;
  std::vector<std::string> files_;
  std::vector<CallRow> calls_;
  std::size_t copied_ = 0;
  std::vector<std::string> open_;  ///< names of those that are being read, outermost first
  std::map<std::string, std::vector<Step>, std::less<>> known_;
  std::vector<Complaint> complaints_;
};

/// One file.
class Parser {
 public:
  Parser(std::string_view file_name, int file, Reading& reading)
      : file_(file),
        reading_(reading),
        robot_(reading.robot()),
        row_(file_name),
        motions_(robot_, row_, reading.around()) {}

  void take_line(int number, std::string_view line) {
    row_.begin(number, line);
    if (row_.words().empty()) return;
    const std::string_view name = word(0).text;
    if (MotionRows::known(name)) {
      if (auto step = motions_.read()) {
        step->file = file_;
        steps_.push_back(std::move(*step));
      }
      return;
    }
    if (name == "home") return take_home();
    if (name == "wait") return take_wait();
    if (name == "loop") return take_loop();
    if (name == "if") return take_if();
    if (name == "else") return take_else();
    if (name == "end") return take_end();
    if (name == "call") return take_call();
    if (name == "velocity" || name == "acceleration") return motions_.take_limits();
    if (name == "look") return take_look();
    if (name == "pick") return take_pick();
    if (name == "place") return take_place();
    if (name == "repeat") return take_repeat();
    if (name == "jaws" || name == "gripper" || name == "suction" || name == "nozzle") {
      return take_tool(name);
    }
    row_.complain(word(0), unknown_row(name).value_or("unknown step"));
  }

  void finish() {
    for (const std::size_t place : open_) {
      const auto* loop = std::get_if<LoopStep>(&steps_[place].what);
      const std::string name = loop == nullptr ? "if" : loop->goes_on ? "repeat" : "loop";
      row_.complain_in(steps_[place].line, Word{name, 1},
                       name + " without end: write end behind its last step");
    }
  }

  bool full() const { return row_.full(); }
  std::vector<Complaint>& complaints() { return row_.complaints(); }
  std::vector<Step>& steps() { return steps_; }

 private:
  template <class What>
  void add(What what) {
    steps_.push_back({row_.line(), std::move(what), file_});
  }
  const Word& word(std::size_t place) const { return row_.words()[place]; }

  void take_home() {
    if (row_.words().size() == 1) return add(HomeStep{});
    if (!row_.takes_words(1, "home, or home time=5s")) return;
    if (robot_.device.settings->searches_zeros()) {
      return row_.complain(word(1),
                           "this robot's home looks for its end stops, as long as it takes");
    }
    if (const auto time = motions_.motion_time(word(1))) add(HomeStep{*time});
  }

  std::optional<double> waiting_time(const Word& at) {
    const auto time = row_.quantity(at, at.text, Measure::kTime);
    if (!time || (*time >= 0 && *time <= kWaitMax)) return time;
    row_.complain(at, "a wait is 0 s to one hour");
    return std::nullopt;
  }

  void take_wait() {
    const std::size_t count = row_.words().size();
    const std::string_view what = count > 1 ? word(1).text : "";
    if (what != "settled" && what != "until") {
      if (!row_.takes_words(1, "wait 0.5s")) return;
      if (const auto time = waiting_time(word(1))) add(WaitStep{from_seconds(*time)});
      return;
    }
    const bool bounded = count >= 4 && word(count - 2).text == "for";
    const auto time = bounded ? waiting_time(word(count - 1)) : std::optional(kSettledIn);
    if (what == "settled") {
      if (count != (bounded ? 4U : 2U)) {
        return row_.complain(word(2), "write wait settled, or wait settled for 5s");
      }
      if (time) add(WaitStep{from_seconds(*time), WaitStep::For::kSettled, {}});
      return;
    }
    if (!bounded || count < 5) {
      return row_.complain(word(1),
                           "say what for and how long at most, as in wait until z<100mm for 5s");
    }
    const auto condition = read_condition(row_, robot_, 2, count - 2);
    if (condition && condition->subject == Condition::Subject::kSeen) {
      return row_.complain(word(2), "a wait does not look; write if seen, or repeat while seen");
    }
    if (time && condition) {
      add(WaitStep{from_seconds(*time), WaitStep::For::kCondition, *condition});
    }
  }

  void take_loop() {
    if (!row_.takes_words(1, "loop 3")) return;
    int rounds = 0;
    const std::string_view text = word(1).text;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rounds);
    if (error != std::errc{} || end != text.data() + text.size() || rounds < 1 ||
        rounds > kRoundsMax) {
      row_.complain(word(1), in_quotes(text) + ": a loop has 1 to 10000 rounds");
    }
    open_block(LoopStep{rounds, 0});
  }

  /// Its `end` is awaited also where something was wrong with it.
  template <class What>
  void open_block(What what) {
    if (open_.size() == kNestingMax) {
      return row_.complain(word(0), "loops and ifs are nested at most 8 deep");
    }
    open_.push_back(steps_.size());
    add(std::move(what));
  }

  void take_if() {
    const auto condition = read_condition(row_, robot_, 1, row_.words().size());
    open_block(IfStep{condition.value_or(Condition{}), 0, 0});
  }

  void take_look() {
    if (row_.words().size() == 1) return add(LookStep{});
    if (!row_.takes_words(1, "look, or look CAMERA")) return;
    const auto& table = reading_.around().table;
    const std::string_view camera = word(1).text;
    if (table && table->cameras.empty()) {
      return row_.complain(word(1),
                           in_quotes(camera) +
                               ": this cell has no calibrated camera; name one in the cell's "
                               "file ([[camera]] with calibration, docs/vision.md)");
    }
    if (table && std::ranges::find(table->cameras, camera) == table->cameras.end()) {
      return row_.complain(word(1), in_quotes(camera) +
                                        " is no calibrated camera of this cell; there are " +
                                        listed(table->cameras));
    }
    add(LookStep{std::string(camera)});
  }

  void take_pick() {
    if (row_.words().size() == 1) return add(PickCubeStep{});
    constexpr std::string_view kAtKey = "at=";
    if (!row_.takes_words(1, "pick color=red")) return;
    const std::string_view text = word(1).text;
    if (text == "any") return add(PickCubeStep{});
    if (text.starts_with(kAtKey)) {
      const auto there = row_.point(word(1), text.substr(kAtKey.size()));
      if (there) add(PickCubeStep{.color = {}, .p_BT = *there});
    } else if (text.starts_with(kColorKey)) {
      if (const auto color = read_color(row_, word(1))) add(PickCubeStep{*color});
    } else {
      row_.complain(word(1),
                    in_quotes(text) + ": write pick, pick color=red, or pick at=180mm,0mm,25mm");
    }
  }

  void take_place() {
    if (row_.words().size() == 1) {
      return row_.complain(word(0),
                           "say where: place basket, place NAME (a basket or a taught point), or "
                           "place x=200mm y=0mm z=30mm");
    }
    if (auto there = motions_.read_place()) add(PlaceCubeStep{std::move(*there)});
  }

  void take_repeat() {
    std::optional<Condition> condition;
    if (row_.words().size() < 3 || word(1).text != "while" || word(2).text != "seen") {
      row_.complain(word(0), "write repeat while seen, or repeat while seen color=red");
    } else {
      condition = read_condition(row_, robot_, 2, row_.words().size());
    }
    open_block(LoopStep{kSeenRoundsMax, 0, condition.value_or(Condition{})});
  }

  void take_else() {
    if (!row_.takes_words(0, "else")) return;
    auto* branch = open_.empty() ? nullptr : std::get_if<IfStep>(&steps_[open_.back()].what);
    if (branch == nullptr) return row_.complain(word(0), "else without if");
    if (branch->otherwise != 0) return row_.complain(word(0), "this if has an else already");
    branch->otherwise = steps_.size();
    add(ElseStep{open_.back()});
  }

  void take_end() {
    if (!row_.takes_words(0, "end")) return;
    if (open_.empty()) return row_.complain(word(0), "end without loop or if");
    const std::size_t begin = open_.back();
    open_.pop_back();
    if (auto* loop = std::get_if<LoopStep>(&steps_[begin].what)) {
      loop->end = steps_.size();
    } else {
      auto& branch = std::get<IfStep>(steps_[begin].what);
      branch.end = steps_.size();
      if (branch.otherwise == 0) branch.otherwise = branch.end;
    }
    add(EndStep{begin});
  }

  void take_call() {
    if (!row_.takes_words(1, "call NAME")) return;
    const auto body = reading_.called(word(1).text);
    if (!body) return row_.complain(word(1), body.error());
    const std::size_t first = steps_.size();
    if (file_ == 0 && !(*body)->empty()) reading_.calls().push_back({row_.line(), first});
    if (!reading_.has_room(first, (*body)->size())) {
      return row_.complain(word(0), "with what it calls the program has more than 100000 rows");
    }
    for (Step step : **body) {
      if (auto* loop = std::get_if<LoopStep>(&step.what)) loop->end += first;
      if (auto* end = std::get_if<EndStep>(&step.what)) end->loop += first;
      if (auto* other = std::get_if<ElseStep>(&step.what)) other->begin += first;
      if (auto* branch = std::get_if<IfStep>(&step.what)) {
        branch->otherwise += first;
        branch->end += first;
      }
      steps_.push_back(std::move(step));
    }
  }

  void take_tool(std::string_view row) {
    if (row == "nozzle") return take_nozzle();
    if (row == "jaws") return take_jaws();
    if (row == "suction") return take_suction();
    if (!row_.takes_words(1, "gripper 40deg, gripper on or gripper off")) return;
    const std::string_view text = word(1).text;
    if (text == "off" || text == "on") return add(ToolStep{GripperTo{text == "on", {}}});
    if (const auto angle = row_.quantity(word(1), text, Measure::kAngle)) {
      add(ToolStep{GripperTo{true, *angle}});
    }
  }

  void take_jaws() {
    constexpr std::string_view kHolds = "holds=";
    constexpr double kHeldMax = 0.5;  // m
    const bool holds = row_.words().size() == 3 && word(2).text.starts_with(kHolds);
    if (!row_.takes_words(holds ? 2 : 1, holds ? "jaws 20mm holds=25mm" : "jaws 20mm")) return;
    const auto width = row_.quantity(word(1), word(1).text, Measure::kLength);
    if (!width) return;
    if (!holds) return add(ToolStep{JawsTo{*width}});
    const auto held = row_.quantity(word(2), word(2).text.substr(kHolds.size()), Measure::kLength);
    if (!held) return;
    if (*held <= 0 || *held > kHeldMax) {
      return row_.complain(word(2), "the width of what is held is above 0 and at most 500 mm");
    }
    add(ToolStep{JawsTo{*width, *held}});
  }

  void take_suction() {
    if (!row_.takes_words(1, "suction on, suction release or suction off")) return;
    const std::string_view text = word(1).text;
    if (text == "on") return add(ToolStep{Suction{Suction::State::kOn}});
    if (text == "release") return add(ToolStep{Suction{Suction::State::kRelease}});
    if (text == "off") return add(ToolStep{Suction{Suction::State::kOff}});
    row_.complain(word(1), in_quotes(text) + ": suction is on, release or off");
  }

  void take_nozzle() {
    constexpr Duration kUsual = std::chrono::seconds(1);
    const bool timed = row_.words().size() > 2;
    if (!row_.takes_words(timed ? 2 : 1, "nozzle 45deg time=1s")) return;
    const auto angle = row_.quantity(word(1), word(1).text, Measure::kAngle);
    if (!timed) {
      if (angle) add(ToolStep{NozzleTo{*angle, kUsual}});
      return;
    }
    constexpr std::string_view kTime = "time=";
    if (!word(2).text.starts_with(kTime)) {
      return row_.complain(word(2), "write how long it takes, as in time=1s");
    }
    const auto time = row_.quantity(word(2), word(2).text.substr(kTime.size()), Measure::kTime);
    if (!angle || !time) return;
    if (*time <= 0 || *time > 60) return row_.complain(word(2), "time is above 0 and at most 60 s");
    add(ToolStep{NozzleTo{*angle, from_seconds(*time)}});
  }

  int file_;
  Reading& reading_;
  const RobotModel& robot_;
  RowReader row_;
  MotionRows motions_;
  std::vector<std::size_t> open_;  ///< places of loops and ifs
  std::vector<Step> steps_;
};

std::vector<Step> Reading::read(std::string_view text, const std::string& file_name) {
  files_.push_back(file_name);
  Parser parser(file_name, static_cast<int>(files_.size()) - 1, *this);
  for_each_line(text, [&](int number, std::string_view line) {
    parser.take_line(number, line);
    return !parser.full();
  });
  parser.finish();
  stable_sort_by(parser.complaints(), [](const Complaint& complaint) {
    return Place{complaint.line, complaint.column};
  });
  for (Complaint& complaint : parser.complaints()) {
    if (complaints_.size() < RowReader::kComplaintMax) complaints_.push_back(std::move(complaint));
  }
  return std::move(parser.steps());
}

std::expected<const std::vector<Step>*, std::string> Reading::called(std::string_view name) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  if (!std::ranges::all_of(name, plain) || name.size() > 64) {
    return std::unexpected(in_quotes(name) +
                           ": a program is called by its name alone, letters, digits, - and _; it "
                           "lies in the same folder");
  }
  if (const auto known = known_.find(name); known != known_.end()) return &known->second;
  if (const auto again = std::ranges::find(open_, name); again != open_.end()) {
    std::string chain;
    for (auto one = again; one != open_.end(); ++one) chain += *one + " calls ";
    return std::unexpected("a program cannot call itself: " + chain + std::string(name));
  }
  if (open_.size() > kCallsMax) return std::unexpected("calls are nested at most 8 deep");
  if (files_.size() == kFilesMax) {
    return std::unexpected("a program calls at most 63 others");
  }
  if (!around_.load) return std::unexpected(in_quotes(name) + ": nothing can be called from here");
  const auto file = around_.load(name);
  if (!file) return std::unexpected(file.error());
  open_.emplace_back(name);
  auto steps = read(file->text, file->name);
  open_.pop_back();
  return &known_.emplace(name, std::move(steps)).first->second;
}

/// "NAME" of "folder/NAME.sinew": what a call of the file itself would say.
std::string called_name(std::string_view file_name) {
  file_name.remove_prefix(std::min(file_name.find_last_of('/') + 1, file_name.size()));
  return std::string(file_name.substr(0, file_name.rfind(".sinew")));
}

}  // namespace

bool handles_cubes(const Program& program) {
  return std::ranges::any_of(program.steps, [](const Step& step) {
    const auto* branch = std::get_if<IfStep>(&step.what);
    const auto* loop = std::get_if<LoopStep>(&step.what);
    return std::holds_alternative<LookStep>(step.what) ||
           std::holds_alternative<PickCubeStep>(step.what) ||
           std::holds_alternative<PlaceCubeStep>(step.what) || (loop != nullptr && loop->goes_on) ||
           (branch != nullptr && branch->condition.subject == Condition::Subject::kSeen);
  });
}

bool uses_baskets(const Program& program) {
  return std::ranges::any_of(program.steps, [](const Step& step) {
    const auto* place = std::get_if<PlaceCubeStep>(&step.what);
    return place != nullptr && std::holds_alternative<BasketGoal>(place->there);
  });
}

const MotionOptions* motion_of(const Step& step) {
  if (const auto* joint = std::get_if<JointStep>(&step.what)) return &joint->how;
  if (const auto* tool = std::get_if<ToolMoveStep>(&step.what)) return &tool->how;
  const auto* spline = std::get_if<SplineStep>(&step.what);
  return spline != nullptr ? &spline->how : nullptr;
}

std::expected<Program, std::vector<Complaint>> parse(std::string_view text,
                                                     std::string_view file_name,
                                                     const RobotModel& robot,
                                                     const Surroundings& around) {
  Reading reading(robot, around, called_name(file_name));
  Program program;
  program.steps = reading.read(text, std::string(file_name));
  program.files = std::move(reading.files());
  program.calls = std::move(reading.calls());
  program.table = around.table;
  if (!reading.complaints().empty()) return std::unexpected(std::move(reading.complaints()));
  return program;
}

}  // namespace sinew::program
