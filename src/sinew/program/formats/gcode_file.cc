#include "sinew/program/formats/gcode_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>

#include "sinew/core/units.h"
#include "sinew/model/hand.h"
#include "sinew/program/language/program_rows.h"
#include "sinew/program/language/row_reader.h"

namespace sinew::program {
namespace {

constexpr double kNumberMax = 1e6;
constexpr double kWaitMax = 3600;        // s
constexpr double kMotionTimeMin = 1e-4;  // s, of a motion
constexpr double kMotionTimeMax = 86400;

/// One letter with its number.
struct Code {
  char letter = 0;
  double value = 0;
  Word word;
  bool whole(int number) const { return value == number; }
};

std::string shortest(double value) {
  std::array<char, 64> buffer{};
  const int size = std::snprintf(buffer.data(), buffer.size(), "%.6f", value + 0.0);
  std::string text(buffer.data(), static_cast<std::size_t>(size));
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

class GcodeReader {
 public:
  GcodeReader(std::string_view file_name, const RobotModel& robot)
      : row_(file_name), robot_(robot) {}

  void take_line(int number, std::string_view line) {
    row_.begin(number, {});
    codes_.clear();
    remark_.clear();
    if (!split(line)) return;
    if (codes_.empty()) {
      if (!remark_.empty()) add("#" + remark_ + "\n");
      return;
    }
    if (ended_) return complain(codes_[0], "stands behind the end of the program (M2, M30)");
    take_row();
    if (!remark_.empty() && !row_text_.empty()) {
      row_text_.insert(row_text_.find('\n'), "  #" + remark_);
    } else if (!remark_.empty()) {
      row_text_ = "#" + remark_ + "\n";
    }
    add(row_text_);
  }

  bool full() const { return row_.full(); }
  std::expected<Rows, std::vector<Complaint>> finish() {
    if (!row_.complaints().empty()) return std::unexpected(std::move(row_.complaints()));
    return std::move(out_);
  }

 private:
  enum class Motion : std::uint8_t { kNone, kRapid, kLine };

  /// Whole rows.
  void add(const std::string& rows) {
    out_.text += rows;
    out_.lines.resize(out_.lines.size() + static_cast<std::size_t>(std::ranges::count(rows, '\n')),
                      row_.line());
  }

  void complain(const Code& code, std::string message) {
    row_.complain(code.word, in_quotes(code.word.text) + " " + std::move(message));
  }

  void remark(std::string_view text) {
    for (const char c : text) {
      const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
      remark_ += control ? ' ' : c;
    }
    remark_.erase(remark_.find_last_not_of(' ') + 1);
    if (!remark_.empty() && remark_[0] != ' ') remark_.insert(0, " ");
  }

  /// Comments off, letters and numbers apart. @return false: something is no word
  bool split(std::string_view line) {
    const std::size_t complaints = row_.complaints().size();
    std::size_t at = 0;
    while (at < line.size()) {
      const Word here{line.substr(at, std::min<std::size_t>(line.size() - at, 20)),
                      static_cast<int>(at) + 1};
      const char c = line[at];
      if (c == ' ' || c == '\t') {
        ++at;
      } else if (c == ';') {
        remark(line.substr(at + 1));
        break;
      } else if (c == '(') {
        const std::size_t end = line.find(')', at);
        if (end == std::string_view::npos) {
          row_.complain(here, "a remark begins with ( and has no )");
          return false;
        }
        remark(line.substr(at + 1, end - at - 1));
        at = end + 1;
      } else if (c == '%' && line.find_first_not_of(" \t\r", at + 1) == std::string_view::npos) {
        break;  // where a paper tape began and ended
      } else if (!take_code(line, at)) {
        return false;
      }
    }
    return row_.complaints().size() == complaints;
  }

  bool take_code(std::string_view line, std::size_t& at) {
    const char letter =
        line[at] >= 'a' && line[at] <= 'z' ? static_cast<char>(line[at] - 32) : line[at];
    std::size_t first = at + 1;
    while (first < line.size() && (line[first] == ' ' || line[first] == '\t')) ++first;
    const bool plus = first < line.size() && line[first] == '+';
    const char* begin = line.data() + first + (plus ? 1 : 0);
    const char* end = line.data() + line.size();
    double value = 0;
    const bool two_signs = plus && begin < end && *begin == '-';
    const auto [stop, error] = std::from_chars(begin, end, value, std::chars_format::fixed);
    const bool number = error == std::errc{} && !two_signs && std::isfinite(value);
    const auto size = static_cast<std::size_t>((number ? stop : begin) - line.data()) - at;
    const Word word{line.substr(at, std::max<std::size_t>(1, size)), static_cast<int>(at) + 1};
    if (letter < 'A' || letter > 'Z' || !number) {
      const Word shown{line.substr(at, std::min<std::size_t>(line.size() - at, 20)), word.column};
      row_.complain(shown,
                    in_quotes(shown.text) + ": a word is a letter and a number, as in X12.5");
      return false;
    }
    if (!(std::abs(value) <= kNumberMax)) {
      row_.complain(word, in_quotes(word.text) + " is beyond any machine");
      return false;
    }
    if (codes_.size() == 64) {
      row_.complain(word, "a line has at most 64 words");
      return false;
    }
    codes_.push_back({letter, value, word});
    at += size;
    return true;
  }

  const Code* find(char letter) const {
    const auto found = std::ranges::find(codes_, letter, &Code::letter);
    return found != codes_.end() ? &*found : nullptr;
  }

  /// Each letter but G once, and none that nobody reads. In the order in which machines obey.
  void take_row() {
    row_text_.clear();
    const std::size_t complaints = row_.complaints().size();
    action_ = nullptr;
    const Code* tool = nullptr;
    std::array<bool, 26> seen{};
    for (const Code& code : codes_) {
      bool& again = seen[static_cast<std::size_t>(code.letter - 'A')];
      if (again && code.letter != 'G') complain(code, "stands twice in one line");
      again = true;
      if (code.letter == 'G') take_g(code);
      if (code.letter == 'M') tool = &code;
      constexpr std::string_view kRead = "GMXYZFPSN";
      if (kRead.find(code.letter) == std::string_view::npos) {
        complain(code, "is no word that is read here: G M X Y Z F P S N are");
      }
    }
    if (const Code* feed = find('F')) take_feed(*feed);
    if (tool != nullptr) take_m(*tool);
    const bool moves = find('X') != nullptr || find('Y') != nullptr || find('Z') != nullptr;
    const Code* time = find('P');
    if (time != nullptr && (action_ == nullptr || !action_->whole(4))) {
      complain(*time, "belongs to a G4");
    }
    const Code* amount = find('S');
    if (amount != nullptr && (tool == nullptr || !tool->whole(3))) {
      complain(*amount, "belongs to an M3 in its line");
    }
    // What the line does is not asked of one that is not understood.
    if (row_.complaints().size() == complaints) take_what_it_does(moves, time);
    if (row_.complaints().size() != complaints) row_text_.clear();
  }

  void take_what_it_does(bool moves, const Code* time) {
    if (action_ != nullptr && moves) {
      complain(*action_, "takes no X, Y or Z here: write the motion in a line of its own");
    } else if (action_ != nullptr) {
      take_action(time);
    } else if (moves) {
      take_motion();
    }
  }

  void take_g(const Code& code) {
    constexpr std::array<int, 4> kDefaults{17, 40, 49, 80};
    if (code.whole(0) || code.whole(1)) {
      if (find_second('G', 0, 1, code)) complain(code, "and another motion stand in one line");
      motion_ = code.whole(0) ? Motion::kRapid : Motion::kLine;
      return;
    }
    if (code.whole(93) || code.whole(94)) {
      timed_ = code.whole(93);
      return;
    }
    if (code.whole(20) || code.whole(21)) {
      inches_ = code.whole(20);
      return;
    }
    if (code.whole(90) || code.whole(91)) {
      relative_ = code.whole(91);
      return;
    }
    if (code.whole(4) || code.whole(28)) {
      if (action_ != nullptr)
        complain(code, "and " + std::string(action_->word.text) + " cannot stand in one line");
      action_ = &code;
      return;
    }
    if (code.whole(2) || code.whole(3)) {
      return complain(code,
                      "is an arc in a plane of the machine; write it as lines, or as a row "
                      "arc via=X,Y,Z x= y= z= of a program");
    }
    const bool is_default =
        std::ranges::any_of(kDefaults, [&](int one) { return code.whole(one); });
    if (is_default) return;  // what it says holds anyway
    complain(code, code.whole(54) ? "means the zero of a workpiece; here zero is the robot's base"
                                  : "is not read here: G0 G1 G4 G20 G21 G28 G90 G91 G93 G94 are");
  }

  /// Another code of the line, before this one, with one of two numbers.
  bool find_second(char letter, int a, int b, const Code& than) const {
    return std::ranges::any_of(codes_, [&](const Code& code) {
      return &code < &than && code.letter == letter && (code.whole(a) || code.whole(b));
    });
  }

  void take_feed(const Code& code) {
    if (!(code.value > 0))
      return complain(code, "is no speed: F is above 0, mm or inches a minute");
    if (timed_) return;  // counts for its own line only
    feed_ = code.value;
    feed_in_inches_ = inches_;
  }

  void take_action(const Code* time) {
    if (action_->whole(28)) {
      row_text_ += "home\n";
      return;
    }
    if (time == nullptr) return complain(*action_, "needs P, the seconds that it waits");
    if (!(time->value >= 0 && time->value <= kWaitMax)) {
      return complain(*time, "is no wait: 0 to 3600 seconds");
    }
    row_text_ += "wait " + shortest(time->value) + "s\n";
  }

  void take_motion() {
    if (motion_ == Motion::kNone) {
      return complain(codes_[0], "moves without a G0 or G1 before it");
    }
    const std::string unit = inches_ ? "in" : "mm";
    std::string row = motion_ == Motion::kRapid ? "move" : "line";
    for (const char axis : {'X', 'Y', 'Z'}) {
      const Code* code = find(axis);
      if (code == nullptr) continue;
      row += std::string(" ") + (relative_ ? "d" : "") + static_cast<char>(axis + 32) + "=" +
             shortest(code->value) + unit;
    }
    if (const Code* inverse = find('F'); motion_ == Motion::kLine && timed_) {
      if (inverse == nullptr) return complain(codes_[0], "needs an F of its own behind G93");
      const double seconds = 60 / inverse->value;
      if (!(seconds >= kMotionTimeMin && seconds <= kMotionTimeMax)) {
        return complain(*inverse, "is no time behind G93: 60/F seconds are 0.1 ms to 24 h");
      }
      row += " time=" + shortest(seconds) + "s";
    } else if (motion_ == Motion::kLine) {
      if (!feed_) return complain(codes_[0], "has no speed: a G1 needs an F in or before its line");
      row += " speed=" + shortest(*feed_ / 60) + (feed_in_inches_ ? "in/s" : "mm/s");
    }
    row_text_ += row + "\n";
  }

  void take_m(const Code& code) {
    if (code.whole(2) || code.whole(30)) {
      ended_ = true;
      return;
    }
    if (!code.whole(3) && !code.whole(4) && !code.whole(5)) {
      return complain(code, "is not read here: M2 M3 M4 M5 M30 are");
    }
    const auto row = tool_row(code);
    if (!row) {
      return complain(code, "has no meaning for the tool of " + robot_.id);
    }
    row_text_ += *row;
  }

  /// M3 takes hold, M4 lets go of what sticks, M5 is off.
  std::optional<std::string> tool_row(const Code& code) {
    const HandDrive hand = robot_.device.capability.hand;
    const Code* amount = find('S');
    const auto needs_amount = [&](const char* what) {
      complain(code, std::string("needs S, ") + what);
      return std::string();
    };
    if (hand == HandDrive::kSuction) {
      if (amount != nullptr) complain(*amount, "says nothing to a pump that is on or off");
      return code.whole(3) ? "suction on\n" : code.whole(4) ? "suction release\n" : "suction off\n";
    }
    if (code.whole(4)) return std::nullopt;
    if (hand == HandDrive::kServo) {
      if (code.whole(5)) return "gripper off\n";
      if (amount == nullptr) return needs_amount("the degrees of the gripper");
      return "gripper " + shortest(amount->value) + "deg\n";
    }
    const JawGripper* jaws = jaws_of(robot_);
    if (jaws == nullptr) return std::nullopt;
    if (code.whole(5)) return "jaws " + shortest(to_mm(jaws->width_max)) + "mm\n";
    if (amount == nullptr) return needs_amount("the width between the jaws, mm");
    return "jaws " + shortest(amount->value) + "mm\n";
  }

  RowReader row_;
  const RobotModel& robot_;
  std::vector<Code> codes_;
  std::string remark_;
  const Code* action_ = nullptr;  ///< G4 or G28 of the line
  Motion motion_ = Motion::kNone;
  bool inches_ = false;
  bool relative_ = false;
  bool timed_ = false;          ///< F is how often a minute its line could be made
  std::optional<double> feed_;  ///< mm or in a minute
  bool feed_in_inches_ = false;
  bool ended_ = false;
  std::string row_text_;
  Rows out_;
};

}  // namespace

std::expected<Rows, std::vector<Complaint>> rows_of_gcode(std::string_view text,
                                                          std::string_view file_name,
                                                          const RobotModel& robot) {
  GcodeReader reader(file_name, robot);
  for_each_line(text, [&](int number, std::string_view line) {
    reader.take_line(number, line);
    return !reader.full();
  });
  return reader.finish();
}

}  // namespace sinew::program
