#include "sinew/devices/bigrobotarm/bigrobotarm_sequence.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "sinew/core/spelling.h"

namespace sinew::sequence {
namespace {

constexpr std::array<std::string_view, kBigRobotArmJoints> kLetters{"B", "S", "E", "WR", "W"};
constexpr std::string_view kLetterList = "B S E WR W";
constexpr std::array<std::string_view, 10> kCommands{"G0", "G28", "G92", "M203",  "M201",
                                                     "G1", "S0",  "S1",  "BEGIN", "END"};
/// Above this the firmware reports positions wrongly.
constexpr std::int32_t kStepMax = (1 << 24) - 1;

struct Word {
  std::string_view text;
  int column = 0;
};

struct Range {
  std::int32_t lower = 0;
  std::int32_t upper = 0;
};

std::string in_quotes(std::string_view text) {
  return "'" + printable(text) + "'";
}

std::string upper_case(std::string_view text) {
  std::string result(text);
  for (char& character : result) {
    if (character >= 'a' && character <= 'z') character = static_cast<char>(character - 'a' + 'A');
  }
  return result;
}

/// "did you mean G0?", or the list of all commands.
std::string suggestion(std::string_view word) {
  const std::string_view nearest = nearest_spelling(upper_case(word.substr(0, 8)), kCommands);
  if (!nearest.empty()) return "did you mean " + std::string(nearest) + "?";
  return "commands are G0 G28 G92 M203 M201 G1 S0 S1 BEGIN END";
}

std::vector<Word> words_of(std::string_view line) {
  std::vector<Word> words;
  std::size_t place = 0;
  while (true) {
    place = line.find_first_not_of(" \t", place);
    if (place == std::string_view::npos) return words;
    const std::size_t end = std::min(line.find_first_of(" \t", place), line.size());
    words.push_back({line.substr(place, end - place), static_cast<int>(place) + 1});
    place = end;
  }
}

class Parser {
 public:
  Parser(std::string_view file_name, const BigRobotArmDevice& device)
      : file_name_(file_name),
        multipliers_{1, device.multiplier_max},
        gripper_{0, device.gripper_max} {}

  void take_line(int number, std::string_view line) {
    line_ = number;
    line = line.substr(0, line.find('#'));
    const std::vector<Word> words = words_of(line);
    if (words.empty()) return;
    end_column_ = words.back().column + static_cast<int>(words.back().text.size());
    if (words[0].text == "BEGIN") return begin(words);
    if (words[0].text == "END") return end(words);
    if (auto command = take_command(words)) add(*command, words[0].column);
  }

  void finish() {
    if (!open_) return;
    line_ = block_.line;
    complain(1, "BEGIN without END: write END behind the last command of the block");
  }

  std::vector<Complaint>& complaints() { return complaints_; }
  Program& program() { return program_; }
  bool full() const { return complaints_.size() >= kComplaintMax; }

 private:
  void complain(int column, std::string text) {
    if (!full()) complaints_.push_back({file_name_, line_, column, "", std::move(text)});
  }

  std::optional<std::int32_t> take_number(const Word& word, std::size_t letters, Range range,
                                          std::string_view what) {
    const std::string_view digits = word.text.substr(std::min(letters, word.text.size()));
    const int column = word.column + static_cast<int>(letters);
    std::int32_t value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc::invalid_argument ||
        (error == std::errc{} && end != digits.data() + digits.size())) {
      complain(column, in_quotes(word.text) + ": " + std::string(what) +
                           " is a whole number, as in " +
                           std::string(word.text.substr(0, letters)) + "100");
      return std::nullopt;
    }
    if (error != std::errc{} || value < range.lower || value > range.upper) {
      complain(column, in_quotes(word.text) + ": " + std::string(what) + " must be " +
                           std::to_string(range.lower) + ".." + std::to_string(range.upper));
      return std::nullopt;
    }
    return value;
  }

  std::optional<GivenWords> take_words(const std::vector<Word>& words, Range range,
                                       std::string_view what, bool allows_speed_word) {
    std::size_t count = words.size() - 1;
    // Recorded programs carry a seventh word G.. here, which the firmware never looks at.
    if (allows_speed_word && count == kBigRobotArmJoints + 1 && words[6].text.starts_with('G')) {
      if (!take_number(words[6], 1, gripper_, "a gripper position")) return std::nullopt;
      --count;
    }
    if (count == 0 || count > kBigRobotArmJoints) {
      const int column = count == 0 ? end_column_ : words[kBigRobotArmJoints + 1].column;
      complain(column, std::string(words[0].text) + " takes one to five words, " +
                           std::string(kLetterList) + " in this order");
      return std::nullopt;
    }
    GivenWords given{.count = count};
    bool good = true;
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = take_joint(words[i + 1], i, range, what);
      good = good && value.has_value();
      given.words[i] = value.value_or(0);
    }
    return good ? std::optional(given) : std::nullopt;
  }

  std::optional<std::int32_t> take_joint(const Word& word, std::size_t joint, Range range,
                                         std::string_view what) {
    const std::string_view letters = kLetters[joint];
    const std::size_t own = std::min(word.text.find_first_of("+-0123456789"), word.text.size());
    if (word.text.substr(0, own) == letters) {
      return take_number(word, letters.size(), range, what);
    }
    complain(word.column, in_quotes(word.text) + " stands where " + std::string(letters) +
                              " is due: the arm reads by place, " + std::string(kLetterList));
    return std::nullopt;
  }

  std::optional<Command> take_command(const std::vector<Word>& words) {
    const std::string_view name = words[0].text;
    if (name == "G0") {
      const auto given = take_words(words, {-kStepMax, kStepMax}, "a position in steps", true);
      return given ? std::optional<Command>(Move{*given}) : std::nullopt;
    }
    if (name == "M203") {
      const auto given = take_words(words, multipliers_, "a speed", false);
      return given ? std::optional<Command>(Speeds{*given}) : std::nullopt;
    }
    if (name == "M201") {
      const auto given = take_words(words, multipliers_, "an acceleration", false);
      return given ? std::optional<Command>(Accelerations{*given}) : std::nullopt;
    }
    if (name == "G1") return take_gripper(words);
    if (name == "G28" || name == "G92" || name == "S0" || name == "S1") {
      if (words.size() > 1) {
        complain(words[1].column,
                 std::string(name) + " stands alone; remove " + in_quotes(words[1].text));
        return std::nullopt;
      }
      if (name == "G28") return Home{};
      if (name == "G92") return Reset{};
      return Synchronise{name == "S1"};
    }
    if (name == "M503") {
      complain(words[0].column,
               "M503 asks for the status, which a program has no use for; remove "
               "the line");
    } else {
      complain(words[0].column, "unknown command " + in_quotes(name) + ": " + suggestion(name));
    }
    return std::nullopt;
  }

  std::optional<Command> take_gripper(const std::vector<Word>& words) {
    if (words.size() != 3 || !words[1].text.starts_with('E') || !words[2].text.starts_with('P')) {
      complain(words[0].column, "G1 takes E0 or E1 and a position, as in G1 E1 P90");
      return std::nullopt;
    }
    const auto enabled = take_number(words[1], 1, {0, 1}, "the gripper's switch");
    const auto position = take_number(words[2], 1, gripper_, "a gripper position");
    if (!enabled || !position) return std::nullopt;
    return Gripper{*enabled == 1, *position};
  }

  void begin(const std::vector<Word>& words) {
    if (open_) {
      complain(words[0].column, "BEGIN inside the block of line " + std::to_string(block_.line) +
                                    ": blocks do not nest; write END first");
      return;
    }
    open_ = true;
    too_long_ = false;
    block_ = {.block = true, .line = line_, .repeats = 1, .steps = {}};
    if (words.size() != 2 || !words[1].text.starts_with('I')) {
      complain(words.size() > 1 ? words[1].column : end_column_,
               "BEGIN takes the number of rounds, as in BEGIN I5");
      return;
    }
    const auto repeats = take_number(words[1], 1, {1, kRepeatsMax}, "the number of rounds");
    block_.repeats = repeats.value_or(1);
  }

  void end(const std::vector<Word>& words) {
    if (words.size() > 1) {
      complain(words[1].column, "END stands alone; remove " + in_quotes(words[1].text));
    }
    if (!open_) {
      complain(words[0].column, "END without BEGIN: remove it, or write BEGIN I1 above");
      return;
    }
    open_ = false;
    program_.sections.push_back(std::move(block_));
  }

  void add(const Command& command, int column) {
    if (!open_) {
      program_.sections.push_back(
          {.block = false, .line = line_, .repeats = 1, .steps = {{line_, command}}});
      return;
    }
    if (block_.steps.size() < kBlockMax) {
      block_.steps.push_back({line_, command});
    } else if (!too_long_) {
      too_long_ = true;
      complain(column, "a block holds at most " + std::to_string(kBlockMax) +
                           " commands: end it above and begin another");
    }
  }

  std::string file_name_;
  Range multipliers_;
  Range gripper_;
  int line_ = 0;
  int end_column_ = 1;
  bool open_ = false;
  bool too_long_ = false;
  Section block_;
  Program program_;
  std::vector<Complaint> complaints_;
};

void put_words(std::string& out, std::string_view name, const GivenWords& given) {
  out += name;
  for (std::size_t i = 0; i < given.count; ++i) {
    out += ' ';
    out += kLetters[i];
    out += std::to_string(given.words[i]);
  }
}

void put_command(std::string& out, const Command& command) {
  if (const auto* move = std::get_if<Move>(&command)) {
    put_words(out, "G0", move->steps);
  } else if (const auto* speeds = std::get_if<Speeds>(&command)) {
    put_words(out, "M203", speeds->multipliers);
  } else if (const auto* accelerations = std::get_if<Accelerations>(&command)) {
    put_words(out, "M201", accelerations->multipliers);
  } else if (const auto* gripper = std::get_if<Gripper>(&command)) {
    out += gripper->enabled ? "G1 E1 P" : "G1 E0 P";
    out += std::to_string(gripper->position);
  } else if (const auto* sync = std::get_if<Synchronise>(&command)) {
    out += sync->on ? "S1" : "S0";
  } else {
    out += std::holds_alternative<Home>(command) ? "G28" : "G92";
  }
  out += '\n';
}

}  // namespace

std::expected<Program, std::vector<Complaint>> parse(std::string_view text,
                                                     std::string_view file_name,
                                                     const BigRobotArmDevice& device) {
  Parser parser(file_name, device);
  for (int number = 1; !text.empty() && !parser.full(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    parser.take_line(number, line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  parser.finish();
  if (!parser.complaints().empty()) {
    std::ranges::sort(parser.complaints(), {}, [](const Complaint& complaint) {
      return std::pair(complaint.line, complaint.column);
    });
    return std::unexpected(std::move(parser.complaints()));
  }
  return std::move(parser.program());
}

std::string to_text(const Program& program) {
  std::string out;
  for (const Section& section : program.sections) {
    if (section.block) out += "BEGIN I" + std::to_string(section.repeats) + "\n";
    for (const Step& step : section.steps) put_command(out, step.command);
    if (section.block) out += "END\n";
  }
  return out;
}

bool same(const Program& a, const Program& b) {
  const auto same_step = [](const Step& x, const Step& y) { return x.command == y.command; };
  const auto same_section = [&](const Section& x, const Section& y) {
    return x.block == y.block && x.repeats == y.repeats &&
           std::equal(x.steps.begin(), x.steps.end(), y.steps.begin(), y.steps.end(), same_step);
  };
  return std::equal(a.sections.begin(), a.sections.end(), b.sections.begin(), b.sections.end(),
                    same_section);
}

}  // namespace sinew::sequence
