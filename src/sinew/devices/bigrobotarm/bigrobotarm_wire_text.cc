#include "sinew/devices/bigrobotarm/bigrobotarm_wire_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew::bigrobotarm::text {
namespace {

constexpr std::array<std::string_view, kJoints> kLetters{"B", "S", "E", "WR", "W"};

template <class... Cases>
struct Overload : Cases... {
  using Cases::operator()...;
};

void put(Characters& out, std::string_view text) {
  for (const char character : text) out.push_back(character);
}

void put(Characters& out, std::int64_t number) {
  char digits[24];
  auto* const end = std::to_chars(digits, digits + sizeof digits, number).ptr;
  put(out, std::string_view(digits, end));
}

/// " B1 S2 E3 WR4 W5", or the first `count` of them.
void put_words(Characters& out, const Words& words, std::size_t count = kJoints) {
  for (std::size_t i = 0; i < count; ++i) {
    put(out, " ");
    put(out, kLetters[i]);
    put(out, std::int64_t{words[i]});
  }
}

/// The next word, by runs of spaces; empty at the end.
std::string_view next_word(std::string_view& rest) {
  const std::size_t begin = std::min(rest.find_first_not_of(' '), rest.size());
  const std::size_t end = std::min(rest.find(' ', begin), rest.size());
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

/// The number behind `letters` characters, the way C's atol reads it, but saturating.
std::int32_t number_of(std::string_view word, std::size_t letters) {
  word.remove_prefix(std::min(letters, word.size()));
  const bool negative = word.starts_with('-');
  if (negative || word.starts_with('+')) word.remove_prefix(1);
  std::int64_t value = 0;
  for (const char character : word) {
    if (character < '0' || character > '9') break;
    value = std::min<std::int64_t>(value * 10 + (character - '0'), std::int64_t{1} << 31);
  }
  if (negative) value = -value;
  return static_cast<std::int32_t>(
      std::min<std::int64_t>(value, std::numeric_limits<std::int32_t>::max()));
}

struct GivenWords {
  Words words{};
  std::uint8_t count = 0;
};

GivenWords take_words(std::string_view rest) {
  GivenWords given;
  while (given.count < kJoints) {
    const std::string_view word = next_word(rest);
    if (word.empty()) break;
    given.words[given.count] = number_of(word, kLetters[given.count].size());
    ++given.count;
  }
  return given;
}

/// The firmware reads a letter and the number behind it: G00 is G0, M0503 is M503.
bool is_command(std::string_view name, std::string_view command) {
  if (name.empty() || name[0] != command[0]) return false;
  std::string_view number = name.substr(1);
  while (number.size() > 1 && number[0] == '0') number.remove_prefix(1);
  return number == command.substr(1);
}

SetGripper take_gripper(std::string_view rest) {
  const bool enabled = number_of(next_word(rest), 1) == 1;
  const std::int32_t position = number_of(next_word(rest), 1);
  return {enabled, static_cast<std::uint8_t>(std::clamp(position, 0, 255))};
}

/// Strict counterparts, for the host: the device's lines have one spelling each.
template <class Number>
bool take_number(std::string_view& rest, Number& number) {
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  if (error != std::errc{}) return false;
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return true;
}

bool take_prefix(std::string_view& rest, std::string_view prefix) {
  if (!rest.starts_with(prefix)) return false;
  rest.remove_prefix(prefix.size());
  return true;
}

bool take_exact_words(std::string_view rest, Words& words) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!take_prefix(rest, " ") || !take_prefix(rest, kLetters[i])) return false;
    if (!take_number(rest, words[i])) return false;
  }
  return rest.empty();
}

bool take_flag(std::string_view& rest, bool& flag) {
  flag = rest.starts_with('1');
  return take_prefix(rest, flag ? "1" : "0");
}

std::optional<ReplyLine> decode_body_line(std::string_view rest) {
  if (rest == "MOVING-TO") return MovingTo{};
  if (rest == "READY") return Ready{};
  if (rest == "INVALID-COMMAND") return Invalid{};
  if (rest == "QUEUED-TO") return QueuedTo{};
  if (rest == "QUEUE-FULL") return QueueFull{};
  if (rest == "QUEUE-DRAINED") return QueueDrained{};
  if (rest == "QUEUE-CLEARED") return QueueCleared{};
  Words words{};
  if (take_prefix(rest, "POSITION:")) {
    if (take_exact_words(rest, words)) return PositionLine{words};
  } else if (take_prefix(rest, "SPEED:")) {
    if (take_exact_words(rest, words)) return Speeds{words};
  } else if (take_prefix(rest, "ACCELERATION:")) {
    if (take_exact_words(rest, words)) return Accelerations{words};
  } else if (take_prefix(rest, "GRIPPER: E")) {
    Gripper gripper;
    if (take_flag(rest, gripper.enabled) && take_prefix(rest, " P") &&
        take_number(rest, gripper.position) && rest.empty()) {
      return gripper;
    }
  } else if (take_prefix(rest, "SYNC-MOTORS: ")) {
    Sync sync;
    if (take_flag(rest, sync.on) && rest.empty()) return sync;
  }
  return std::nullopt;
}

/// A spelling that the other side would not write (a leading zero, a tab) is not the line it
/// looks like.
bool is_canonical(const std::optional<ReplyLine>& line, std::string_view text) {
  return line && view(encode_reply_line(*line)) == text;
}

template <class Kind, std::size_t Place = 0>
constexpr std::uint16_t bit() {
  if constexpr (std::is_same_v<Kind, std::variant_alternative_t<Place, ReplyLine>>) {
    return std::uint16_t{1} << Place;
  } else {
    return bit<Kind, Place + 1>();
  }
}

constexpr int kPreamble = bit<FreeMemory>() | bit<Echo>();

}  // namespace

Characters encode_line(const Line& line) {
  SINEW_ASSERT(line.words_given <= kJoints);
  Characters out;
  const auto words = [&](std::string_view name, const Words& values) {
    put(out, name);
    put_words(out, values, line.words_given);
  };
  const Overload request_case{[&](const Goto& m) { words("G0", m.positions); },
                              [&](const Home&) { put(out, "G28"); },
                              [&](const Reset&) { put(out, "G92"); },
                              [&](const SetSpeeds& m) { words("M203", m.speeds); },
                              [&](const SetAccelerations& m) { words("M201", m.accelerations); },
                              [&](const SetGripper& m) {
                                put(out, m.enabled ? "G1 E1 P" : "G1 E0 P");
                                put(out, std::int64_t{m.position});
                              },
                              [&](const SetSync& m) { put(out, m.on ? "S1" : "S0"); },
                              [&](const ReadStatus&) { put(out, "M503"); }};
  std::visit(Overload{[&](const Request& request) { std::visit(request_case, request); },
                      [&](const Begin& begin) {
                        put(out, "BEGIN I");
                        put(out, std::int64_t{begin.repeats});
                      },
                      [&](const End&) { put(out, "END"); },
                      [&](const QueueGoto& m) { words("Q0", m.positions); },
                      [&](const QueueFlush&) { put(out, "QFLUSH"); },
                      [&](const QueueClear&) { put(out, "QCLEAR"); }},
             line.command);
  return out;
}

bool sendable(const Line& line) {
  return encode_line(line).size() <= kLineBuffer;
}

std::optional<Line> decode_line(std::string_view line) {
  std::string_view rest = line;
  const std::string_view name = next_word(rest);
  const auto is = [&](std::string_view command) { return is_command(name, command); };
  const GivenWords given = take_words(rest);
  if (is("Q0")) return Line{QueueGoto{given.words}, given.count};
  if (is("G0")) return Line{Request{Goto{given.words}}, given.count};
  if (is("M203")) return Line{Request{SetSpeeds{given.words}}, given.count};
  if (is("M201")) return Line{Request{SetAccelerations{given.words}}, given.count};
  if (is("G28")) return Line{Request{Home{}}};
  if (is("G92")) return Line{Request{Reset{}}};
  if (is("G1")) return Line{Request{take_gripper(rest)}};
  if (is("M503")) return Line{Request{ReadStatus{}}};
  if (name == "END") return Line{End{}};
  if (name == "QFLUSH") return Line{QueueFlush{}};
  if (name == "QCLEAR") return Line{QueueClear{}};
  if (name == "BEGIN") {
    const auto repeats = static_cast<std::uint32_t>(number_of(next_word(rest), 1));
    return Line{Begin{static_cast<std::int8_t>(repeats & 0xFF)}};
  }
  if (name.starts_with('S')) return Line{Request{SetSync{number_of(name, 1) != 0}}};
  return std::nullopt;
}

Characters encode_reply_line(const ReplyLine& line) {
  Characters out;
  const auto words = [&](std::string_view name, const Words& values) {
    put(out, name);
    put_words(out, values);
  };
  std::visit(
      Overload{
          [&](const FreeMemory& m) {
            put(out, "Free mem: ");
            put(out, std::int64_t{m.bytes});
          },
          [&](const Echo& m) {
            put(out, "Process command: ");
            put(out, std::string_view(m.line.data(), m.line.size()));
          },
          [&](const MovingTo&) { put(out, "BigRobotArm::MOVING-TO"); },
          [&](const PositionLine& m) { words("BigRobotArm::POSITION:", m.positions); },
          [&](const Speeds& m) { words("BigRobotArm::SPEED:", m.speeds); },
          [&](const Accelerations& m) { words("BigRobotArm::ACCELERATION:", m.accelerations); },
          [&](const Gripper& m) {
            put(out, m.enabled ? "BigRobotArm::GRIPPER: E1 P" : "BigRobotArm::GRIPPER: E0 P");
            put(out, std::int64_t{m.position});
          },
          [&](const Sync& m) {
            put(out, m.on ? "BigRobotArm::SYNC-MOTORS: 1" : "BigRobotArm::SYNC-MOTORS: 0");
          },
          [&](const Invalid&) { put(out, "BigRobotArm::INVALID-COMMAND"); },
          [&](const Ready&) { put(out, "BigRobotArm::READY"); },
          [&](const QueuedTo&) { put(out, "BigRobotArm::QUEUED-TO"); },
          [&](const QueueFull&) { put(out, "BigRobotArm::QUEUE-FULL"); },
          [&](const QueueDrained&) { put(out, "BigRobotArm::QUEUE-DRAINED"); },
          [&](const QueueCleared&) { put(out, "BigRobotArm::QUEUE-CLEARED"); }},
      line);
  return out;
}

std::optional<ReplyLine> decode_reply_line(std::string_view line) {
  std::optional<ReplyLine> decoded;
  std::string_view rest = line;
  if (take_prefix(rest, "Free mem: ")) {
    FreeMemory memory;
    if (take_number(rest, memory.bytes) && rest.empty()) decoded = memory;
  } else if (take_prefix(rest, "Process command: ")) {
    if (rest.size() > kLineBuffer) return std::nullopt;
    Echo echo;
    for (const char character : rest) echo.line.push_back(character);
    decoded = echo;
  } else if (take_prefix(rest, "BigRobotArm::")) {
    decoded = decode_body_line(rest);
  }
  return is_canonical(decoded, line) ? decoded : std::nullopt;
}

bool LineReader::push(char character) {
  if (complete_) characters_.clear();
  complete_ = character == kLineEnd;
  if (!complete_ && !characters_.full()) characters_.push_back(character);
  return complete_;
}

std::optional<std::expected<Reply, Garbage>> ReplyDecoder::push(char character) {
  if (character != '\n') {
    if (characters_.full()) return lose();
    characters_.push_back(character);
    return std::nullopt;
  }
  std::string_view line = view(characters_);
  const bool ended = line.ends_with(kLineEnd);
  if (ended) line.remove_suffix(1);
  const std::optional<ReplyLine> decoded = ended ? decode_reply_line(line) : std::nullopt;
  if (hunting_) {
    if (decoded && std::holds_alternative<Ready>(*decoded)) reset();
    characters_.clear();
    return std::nullopt;
  }
  if (!decoded) return lose();
  characters_.clear();
  return take(*decoded);
}

void ReplyDecoder::reset() {
  *this = ReplyDecoder{};
}

std::optional<std::expected<Reply, Garbage>> ReplyDecoder::take(const ReplyLine& line) {
  const auto kind = static_cast<std::uint16_t>(1U << line.index());
  if ((seen_ & kind) != 0) return lose();  // no reply says a thing twice
  seen_ |= kind;
  if (std::holds_alternative<Ready>(line)) return finish();
  if (const auto* position = std::get_if<PositionLine>(&line)) {
    status_.positions = position->positions;
  } else if (const auto* speeds = std::get_if<Speeds>(&line)) {
    status_.speeds = speeds->speeds;
  } else if (const auto* accelerations = std::get_if<Accelerations>(&line)) {
    status_.accelerations = accelerations->accelerations;
  } else if (const auto* gripper = std::get_if<Gripper>(&line)) {
    status_.gripper = *gripper;
  } else if (const auto* sync = std::get_if<Sync>(&line)) {
    status_.sync = sync->on;
  } else if (const auto* echo = std::get_if<Echo>(&line)) {
    const auto command = decode_line({echo->line.data(), echo->line.size()});
    const auto* request = command ? std::get_if<Request>(&command->command) : nullptr;
    if (request == nullptr) return std::nullopt;
    const RequestId id = id_of(*request);
    if (id == RequestId::kGoto || id == RequestId::kHome) return MotionStarted{id};
  }
  return std::nullopt;
}

std::optional<std::expected<Reply, Garbage>> ReplyDecoder::finish() {
  const Status status = status_;
  const int body = seen_ & ~kPreamble & ~bit<Ready>();
  const bool preamble = (seen_ & kPreamble) == kPreamble;
  reset();
  if (body == bit<Invalid>()) return Invalid{};
  constexpr std::uint8_t kLetter = 'B';
  if (!preamble) return std::unexpected(Garbage{0, kLetter});
  switch (body) {
    case 0:
      return Accepted{};
    case bit<PositionLine>():
      return ResetDone{status.positions};
    case bit<MovingTo>() | bit<PositionLine>():
      return GotoDone{status.positions};
    case bit<Speeds>():
      return Speeds{status.speeds};
    case bit<Accelerations>():
      return Accelerations{status.accelerations};
    case bit<Gripper>():
      return *status.gripper;
    case bit<Sync>():
      return Sync{status.sync};
    case bit<MovingTo>() | bit<PositionLine>() | bit<Speeds>() | bit<Accelerations>() | bit<Sync>():
      return status;
    case bit<QueuedTo>() | bit<PositionLine>():
      return Queued{status.positions};
    case bit<QueueFull>():
      return QueueFull{};
    case bit<QueueDrained>():
      return QueueDrained{};
    case bit<QueueCleared>():
      return QueueCleared{};
    default:
      return std::unexpected(Garbage{0, kLetter});
  }
}

std::optional<std::expected<Reply, Garbage>> ReplyDecoder::lose() {
  const std::uint8_t seen =
      characters_.empty() ? std::uint8_t{'\n'} : static_cast<std::uint8_t>(characters_[0]);
  reset();
  hunting_ = true;
  return std::unexpected(Garbage{seen, std::uint8_t{'B'}});
}

}  // namespace sinew::bigrobotarm::text
