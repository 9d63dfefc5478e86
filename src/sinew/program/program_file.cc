#include "sinew/program/program_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <string>

#include "sinew/core/quantity.h"
#include "sinew/core/spelling.h"
#include "sinew/core/stable_sort.h"
#include "sinew/core/units.h"

namespace sinew::program {
namespace {

constexpr std::size_t kComplaintMax = 100;
constexpr std::size_t kNestingMax = 8;
constexpr int kRoundsMax = 10'000;
constexpr double kWaitMax = 3600;  // s
constexpr std::array<std::string_view, 9> kRows{"joint",  "home", "jaws", "gripper", "suction",
                                                "nozzle", "wait", "loop", "end"};

struct Word {
  std::string_view text;
  int column = 0;
};

std::vector<Word> words_of(std::string_view line) {
  std::vector<Word> words;
  std::size_t place = 0;
  while ((place = line.find_first_not_of(" \t", place)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t", place), line.size());
    words.push_back({line.substr(place, end - place), static_cast<int>(place) + 1});
    place = end;
  }
  return words;
}

std::string quoted(std::string_view text) {
  return "'" + printable(text) + "'";
}

class Parser {
 public:
  Parser(std::string_view file_name, const RobotModel& robot)
      : file_name_(file_name), robot_(robot) {
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      names_.push_back(robot.joints[i].name);
      aliases_.push_back("J" + std::to_string(i + 1));
    }
  }

  void take_line(int number, std::string_view line) {
    line_ = number;
    words_ = words_of(line.substr(0, line.find('#')));
    if (words_.empty()) return;
    const std::string_view row = words_[0].text;
    if (row == "joint") return take_joint();
    if (row == "home") return take_home();
    if (row == "wait") return take_wait();
    if (row == "loop") return take_loop();
    if (row == "end") return take_end();
    if (row == "jaws" || row == "gripper" || row == "suction" || row == "nozzle") {
      return take_tool(row);
    }
    const std::string_view meant = nearest_spelling(row, kRows);
    std::string all;
    for (const std::string_view known : kRows) all += (all.empty() ? "" : " ") + std::string(known);
    complain(words_[0], "unknown step " + quoted(row) +
                            (meant.empty() ? "; steps are " + all
                                           : "; did you mean " + std::string(meant) + "?"));
  }

  void finish() {
    for (const std::size_t loop : open_loops_) {
      line_ = program_.steps[loop].line;
      complain(Word{"loop", 1}, "loop without end: write end behind its last step");
    }
  }

  bool full() const { return complaints_.size() >= kComplaintMax; }
  std::vector<Complaint>& complaints() { return complaints_; }
  Program& program() { return program_; }

 private:
  void complain(const Word& word, std::string message) {
    if (!full()) complaints_.push_back({file_name_, line_, word.column, "", std::move(message)});
  }
  template <class What>
  void add(What what) {
    program_.steps.push_back({line_, std::move(what)});
  }

  bool takes_words(std::size_t count, std::string_view example) {
    if (words_.size() == count + 1) return true;
    const bool more = words_.size() > count + 1;
    complain(
        more ? words_[count + 1] : words_.back(),
        (more ? "too many words; write " : "something is missing; write ") + std::string(example));
    return false;
  }

  std::optional<double> quantity(const Word& word, std::string_view text, Measure measure) {
    const auto value = parse_quantity(text, measure, UnitRule::kRequired);
    if (!value) complain(word, value.error());
    return value ? std::optional(*value) : std::nullopt;
  }

  std::optional<std::size_t> joint_called(std::string_view name) const {
    auto found = std::ranges::find(names_, name);
    if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
    const auto alias = std::ranges::find(aliases_, name);
    if (alias != aliases_.end()) return static_cast<std::size_t>(alias - aliases_.begin());
    return std::nullopt;
  }

  void unknown_argument(const Word& word, std::string_view name) {
    std::vector<std::string_view> known(names_.begin(), names_.end());
    known.emplace_back("speed");
    const std::string_view meant = nearest_spelling(name, known);
    std::string all;
    for (const std::string_view one : known) all += (all.empty() ? "" : " ") + std::string(one);
    complain(word, quoted(name) + " is no joint of this robot" +
                       (meant.empty() ? "; it has " + all
                                      : "; did you mean " + std::string(meant) + "?"));
  }

  void take_joint() {
    JointStep step;
    step.q.resize(robot_.joints.size());
    bool good = words_.size() > 1;
    if (!good) {
      complain(words_[0], "a joint is missing; write joint " + names_[0] + "=" +
                              (robot_.joints[0].kind == JointKind::kRevolute ? "10deg" : "200mm"));
    }
    bool has_speed = false;
    for (std::size_t w = 1; w < words_.size(); ++w) {
      good = take_argument(words_[w], step, has_speed) && good;
    }
    if (good && step.given == 0) {
      complain(words_[0], "a joint is missing: speed alone moves nothing");
    } else if (good) {
      add(step);
    }
  }

  bool take_argument(const Word& word, JointStep& step, bool& has_speed) {
    const std::size_t equals = word.text.find('=');
    if (equals == std::string_view::npos) {
      complain(word, quoted(word.text) + ": write NAME=VALUE, as in " + names_[0] + "=10deg");
      return false;
    }
    const std::string_view name = word.text.substr(0, equals);
    const std::string_view text = word.text.substr(equals + 1);
    if (name == "speed") {
      const auto share = quantity(word, text, Measure::kShare);
      if (share && (*share < 0.01 || *share > 1 || has_speed)) {
        complain(word, "speed is 1% to 100%, once");
        return false;
      }
      has_speed = true;
      step.speed = share.value_or(1);
      return share.has_value();
    }
    const auto joint = joint_called(name);
    if (!joint) {
      unknown_argument(word, name);
      return false;
    }
    if ((step.given >> *joint & 1) != 0) {
      complain(word, quoted(name) + " is named twice");
      return false;
    }
    const bool revolute = robot_.joints[*joint].kind == JointKind::kRevolute;
    const auto value = quantity(word, text, revolute ? Measure::kAngle : Measure::kLength);
    if (!value) return false;
    step.q[*joint] = *value;
    step.given = static_cast<std::uint8_t>(step.given | 1U << *joint);
    return true;
  }

  void take_home() {
    if (takes_words(0, "home, which homes all joints")) add(HomeStep{});
  }

  void take_wait() {
    if (!takes_words(1, "wait 0.5s")) return;
    const auto time = quantity(words_[1], words_[1].text, Measure::kTime);
    if (!time) return;
    if (*time < 0 || *time > kWaitMax) {
      return complain(words_[1], "a wait is 0 s to one hour");
    }
    add(WaitStep{from_seconds(*time)});
  }

  void take_loop() {
    if (!takes_words(1, "loop 3")) return;
    int rounds = 0;
    const std::string_view text = words_[1].text;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), rounds);
    if (error != std::errc{} || end != text.data() + text.size() || rounds < 1 ||
        rounds > kRoundsMax) {
      complain(words_[1], quoted(text) + ": a loop has 1 to 10000 rounds");
    }
    if (open_loops_.size() == kNestingMax) {
      return complain(words_[0], "loops are nested at most 8 deep");
    }
    open_loops_.push_back(program_.steps.size());
    add(LoopStep{rounds, 0});
  }

  void take_end() {
    if (!takes_words(0, "end")) return;
    if (open_loops_.empty()) return complain(words_[0], "end without loop");
    const std::size_t loop = open_loops_.back();
    open_loops_.pop_back();
    std::get<LoopStep>(program_.steps[loop].what).end = program_.steps.size();
    add(EndStep{loop});
  }

  void take_tool(std::string_view row) {
    if (row == "nozzle") return take_nozzle();
    if (row == "jaws") {
      if (!takes_words(1, "jaws 20mm")) return;
      if (const auto width = quantity(words_[1], words_[1].text, Measure::kLength)) {
        add(ToolStep{JawsTo{*width}});
      }
      return;
    }
    if (row == "suction") return take_suction();
    if (!takes_words(1, "gripper 40deg or gripper off")) return;
    const std::string_view text = words_[1].text;
    if (text == "off") return add(ToolStep{GripperTo{false, 0}});
    if (const auto angle = quantity(words_[1], text, Measure::kAngle)) {
      add(ToolStep{GripperTo{true, *angle}});
    }
  }

  void take_suction() {
    if (!takes_words(1, "suction on, suction release or suction off")) return;
    const std::string_view text = words_[1].text;
    if (text == "on") return add(ToolStep{Suction{Suction::State::kOn}});
    if (text == "release") return add(ToolStep{Suction{Suction::State::kRelease}});
    if (text == "off") return add(ToolStep{Suction{Suction::State::kOff}});
    complain(words_[1], quoted(text) + ": suction is on, release or off");
  }

  void take_nozzle() {
    if (!takes_words(2, "nozzle 45deg time=1s")) return;
    const auto angle = quantity(words_[1], words_[1].text, Measure::kAngle);
    constexpr std::string_view kTime = "time=";
    if (!words_[2].text.starts_with(kTime)) {
      return complain(words_[2], "write how long it takes, as in time=1s");
    }
    const auto time = quantity(words_[2], words_[2].text.substr(kTime.size()), Measure::kTime);
    if (!angle || !time) return;
    if (*time <= 0 || *time > 60) return complain(words_[2], "time is above 0 and at most 60 s");
    add(ToolStep{NozzleTo{*angle, from_seconds(*time)}});
  }

  std::string file_name_;
  const RobotModel& robot_;
  std::vector<std::string> names_;
  std::vector<std::string> aliases_;
  std::vector<std::size_t> open_loops_;
  std::vector<Word> words_;
  int line_ = 0;
  Program program_;
  std::vector<Complaint> complaints_;
};

}  // namespace

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
