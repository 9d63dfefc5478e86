#include "sinew/program/program_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>

#include "sinew/core/spelling.h"
#include "sinew/core/stable_sort.h"
#include "sinew/program/motion_rows.h"

namespace sinew::program {
namespace {

constexpr std::size_t kNestingMax = 8;
constexpr int kRoundsMax = 10'000;
constexpr double kWaitMax = 3600;  // s
constexpr std::array<std::string_view, 13> kRows{"joint", "move", "line",    "arc",     "spline",
                                                 "home",  "jaws", "gripper", "suction", "nozzle",
                                                 "wait",  "loop", "end"};

class Parser {
 public:
  Parser(std::string_view file_name, const RobotModel& robot)
      : row_(file_name), motions_(robot, row_) {}

  void take_line(int number, std::string_view line) {
    row_.begin(number, line);
    if (row_.words().empty()) return;
    const std::string_view name = word(0).text;
    if (MotionRows::known(name)) {
      if (auto step = motions_.read()) program_.steps.push_back(std::move(*step));
      return;
    }
    if (name == "home") return take_home();
    if (name == "wait") return take_wait();
    if (name == "loop") return take_loop();
    if (name == "end") return take_end();
    if (name == "jaws" || name == "gripper" || name == "suction" || name == "nozzle") {
      return take_tool(name);
    }
    const std::string_view meant = nearest_spelling(name, kRows);
    std::string all;
    for (const std::string_view known : kRows) all += (all.empty() ? "" : " ") + std::string(known);
    row_.complain(word(0), "unknown step " + quoted(name) +
                               (meant.empty() ? "; steps are " + all
                                              : "; did you mean " + std::string(meant) + "?"));
  }

  void finish() {
    for (const std::size_t loop : open_loops_) {
      row_.complain_in(program_.steps[loop].line, Word{"loop", 1},
                       "loop without end: write end behind its last step");
    }
  }

  bool full() const { return row_.full(); }
  std::vector<Complaint>& complaints() { return row_.complaints(); }
  Program& program() { return program_; }

 private:
  template <class What>
  void add(What what) {
    program_.steps.push_back({row_.line(), std::move(what)});
  }
  const Word& word(std::size_t place) const { return row_.words()[place]; }

  void take_home() {
    if (row_.takes_words(0, "home, which homes all joints")) add(HomeStep{});
  }

  void take_wait() {
    if (!row_.takes_words(1, "wait 0.5s")) return;
    const auto time = row_.quantity(word(1), word(1).text, Measure::kTime);
    if (!time) return;
    if (*time < 0 || *time > kWaitMax) {
      return row_.complain(word(1), "a wait is 0 s to one hour");
    }
    add(WaitStep{from_seconds(*time)});
  }

  void take_loop() {
    if (!row_.takes_words(1, "loop 3")) return;
    int rounds = 0;
    const std::string_view text = word(1).text;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rounds);
    if (error != std::errc{} || end != text.data() + text.size() || rounds < 1 ||
        rounds > kRoundsMax) {
      row_.complain(word(1), quoted(text) + ": a loop has 1 to 10000 rounds");
    }
    if (open_loops_.size() == kNestingMax) {
      return row_.complain(word(0), "loops are nested at most 8 deep");
    }
    open_loops_.push_back(program_.steps.size());
    add(LoopStep{rounds, 0});
  }

  void take_end() {
    if (!row_.takes_words(0, "end")) return;
    if (open_loops_.empty()) return row_.complain(word(0), "end without loop");
    const std::size_t loop = open_loops_.back();
    open_loops_.pop_back();
    std::get<LoopStep>(program_.steps[loop].what).end = program_.steps.size();
    add(EndStep{loop});
  }

  void take_tool(std::string_view row) {
    if (row == "nozzle") return take_nozzle();
    if (row == "jaws") {
      if (!row_.takes_words(1, "jaws 20mm")) return;
      if (const auto width = row_.quantity(word(1), word(1).text, Measure::kLength)) {
        add(ToolStep{JawsTo{*width}});
      }
      return;
    }
    if (row == "suction") return take_suction();
    if (!row_.takes_words(1, "gripper 40deg or gripper off")) return;
    const std::string_view text = word(1).text;
    if (text == "off") return add(ToolStep{GripperTo{false, 0}});
    if (const auto angle = row_.quantity(word(1), text, Measure::kAngle)) {
      add(ToolStep{GripperTo{true, *angle}});
    }
  }

  void take_suction() {
    if (!row_.takes_words(1, "suction on, suction release or suction off")) return;
    const std::string_view text = word(1).text;
    if (text == "on") return add(ToolStep{Suction{Suction::State::kOn}});
    if (text == "release") return add(ToolStep{Suction{Suction::State::kRelease}});
    if (text == "off") return add(ToolStep{Suction{Suction::State::kOff}});
    row_.complain(word(1), quoted(text) + ": suction is on, release or off");
  }

  void take_nozzle() {
    if (!row_.takes_words(2, "nozzle 45deg time=1s")) return;
    const auto angle = row_.quantity(word(1), word(1).text, Measure::kAngle);
    constexpr std::string_view kTime = "time=";
    if (!word(2).text.starts_with(kTime)) {
      return row_.complain(word(2), "write how long it takes, as in time=1s");
    }
    const auto time = row_.quantity(word(2), word(2).text.substr(kTime.size()), Measure::kTime);
    if (!angle || !time) return;
    if (*time <= 0 || *time > 60) return row_.complain(word(2), "time is above 0 and at most 60 s");
    add(ToolStep{NozzleTo{*angle, from_seconds(*time)}});
  }

  RowReader row_;
  MotionRows motions_;
  std::vector<std::size_t> open_loops_;
  Program program_;
};

}  // namespace

const MotionOptions* motion_of(const Step& step) {
  if (const auto* joint = std::get_if<JointStep>(&step.what)) return &joint->how;
  if (const auto* tool = std::get_if<ToolMoveStep>(&step.what)) return &tool->how;
  const auto* spline = std::get_if<SplineStep>(&step.what);
  return spline != nullptr ? &spline->how : nullptr;
}

std::expected<Program, std::vector<Complaint>> parse(std::string_view text,
                                                     std::string_view file_name,
                                                     const RobotModel& robot) {
  Parser parser(file_name, robot);
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  for (int number = 1; !text.empty() && !parser.full(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    parser.take_line(number, line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  parser.finish();
  if (!parser.complaints().empty()) {
    stable_sort_by(parser.complaints(), [](const Complaint& complaint) {
      return Place{complaint.line, complaint.column};
    });
    return std::unexpected(std::move(parser.complaints()));
  }
  return std::move(parser.program());
}

}  // namespace sinew::program
