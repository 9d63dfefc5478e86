#include "sinew/devices/grbl/grbl_wire.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <concepts>
#include <span>

#include "sinew/core/assert.h"

namespace sinew::grbl {
namespace {

constexpr std::array<std::string_view, 10> kStates{"Idle", "Run",   "Hold", "Jog",   "Alarm",
                                                   "Door", "Check", "Home", "Sleep", "Tool"};
constexpr std::string_view kMoveWords = "G53G93G1";
constexpr std::string_view kModeWords = "G21G90G94";
constexpr std::string_view kJogWords = "$J=G21G91";
constexpr std::string_view kProbeWords = "G21G91G94G38.3";
constexpr std::string_view kToolWords = "G43.1Z";
constexpr int kDecimals = 3;
/// No board's number is larger: settings in steps, or per minute.
constexpr double kReadMost = 1e7;

/// One line under way.
class Writer {
 public:
  Writer& text(std::string_view text) {
    for (const char c : text) line_.push_back(c);
    return *this;
  }
  Writer& value(double value, int decimals = kDecimals) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                   std::chars_format::fixed, decimals)
                         .ptr;
    return text({digits.data(), end});
  }
  Writer& number(std::integral auto value) {
    std::array<char, 16> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    return text({digits.data(), end});
  }
  Writer& word(char letter, double value) { return text({&letter, 1}).value(value); }
  Writer& list(const Values& values) {
    for (std::size_t i = 0; i < values.size(); ++i) text(i == 0 ? "" : ",").value(values[i]);
    return *this;
  }
  Line end() { return text("\n").line_; }

 private:
  Line line_;
};

/// Takes a line apart from its beginning on.
class Reader {
 public:
  explicit Reader(std::string_view text) : rest_(text) {}

  bool next_is(std::string_view text) {
    const bool is = rest_.starts_with(text);
    if (is) rest_.remove_prefix(text.size());
    return is;
  }
  /// A plain decimal number, without an exponent.
  std::optional<double> value() {
    double value = 0;
    const auto [end, error] =
        std::from_chars(rest_.data(), rest_.data() + rest_.size(), value, std::chars_format::fixed);
    // Written so that NaN is refused too.
    if (error != std::errc{} || !(std::abs(value) <= kReadMost)) return std::nullopt;
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }
  std::optional<std::uint16_t> number() {
    std::uint16_t value = 0;
    const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (error != std::errc{}) return std::nullopt;
    rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
    return value;
  }
  /// "1.000,2.000"
  std::optional<Values> list() {
    Values values;
    do {
      const auto one = value();
      if (!one || values.full()) return std::nullopt;
      values.push_back(*one);
    } while (next_is(","));
    return values;
  }
  /// Up to `end`, which is taken too; all that is left where there is none.
  std::string_view until(char end) {
    const std::size_t length = std::min(rest_.find(end), rest_.size());
    const std::string_view own = rest_.substr(0, length);
    rest_.remove_prefix(std::min(length + 1, rest_.size()));
    return own;
  }
  std::string_view rest() const { return rest_; }
  bool empty() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

std::optional<std::size_t> axis_of(char letter) {
  const auto* const found = std::ranges::find(kAxisLetters, letter);
  if (found == kAxisLetters.end()) return std::nullopt;
  return static_cast<std::size_t>(found - kAxisLetters.begin());
}

/// Nine characters of one over minutes, whatever the duration.
Writer& put_inverse_time(Writer& line, double duration) {
  const double rate = 60 / duration;
  return line.text("F").value(rate, rate >= 1000 ? 3 : rate >= 1 ? 5 : 7);
}

bool fits(double value) {
  return std::abs(value) <= kValueMax;
}

struct RequestWriter {
  Line operator()(const Move& move) const {
    SINEW_ASSERT(!move.to.empty() && std::ranges::all_of(move.to, fits));
    SINEW_ASSERT(move.duration >= kDurationMin && move.duration <= kDurationMax);
    Writer line;
    line.text(kMoveWords);
    for (std::size_t i = 0; i < move.to.size(); ++i) line.word(kAxisLetters[i], move.to[i]);
    return put_inverse_time(line, move.duration).end();
  }
  Line operator()(const Jog& jog) const {
    SINEW_ASSERT(jog.axis < kAxesMax && fits(jog.by) && jog.rate > 0);
    return Writer().text(kJogWords).word(kAxisLetters[jog.axis], jog.by).word('F', jog.rate).end();
  }
  Line operator()(const Probe& probe) const {
    SINEW_ASSERT(probe.axis < kAxesMax && fits(probe.by) && probe.rate > 0);
    Writer line;
    line.text(kProbeWords).word(kAxisLetters[probe.axis], probe.by);
    return line.word('F', probe.rate).end();
  }
  Line operator()(const Home& home) const {
    Writer line;
    line.text("$H");
    for (std::size_t i = 0; i < kAxesMax; ++i) {
      if ((home.axes >> i & 1) != 0) line.text({&kAxisLetters[i], 1});
    }
    return line.end();
  }
  Line operator()(const Unlock& /*unlock*/) const { return Writer().text("$X").end(); }
  Line operator()(const AskSettings& /*ask*/) const { return Writer().text("$$").end(); }
  Line operator()(const AskBuild& /*ask*/) const { return Writer().text("$I").end(); }
  Line operator()(const Modes& /*modes*/) const { return Writer().text(kModeWords).end(); }
  Line operator()(const ToolOffset& offset) const {
    SINEW_ASSERT(fits(offset.z));
    return Writer().text(kToolWords).value(offset.z).end();
  }
};

std::optional<Request> read_move(Reader line) {
  Move move;
  while (!line.empty() && line.rest()[0] != 'F') {
    const auto axis = axis_of(line.rest()[0]);
    if (!axis || *axis != move.to.size()) return std::nullopt;
    line.next_is(line.rest().substr(0, 1));
    const auto value = line.value();
    if (!value) return std::nullopt;
    move.to.push_back(*value);
  }
  if (move.to.empty() || !line.next_is("F")) return std::nullopt;
  const auto rate = line.value();
  if (!rate || !(*rate > 0) || !line.empty()) return std::nullopt;
  move.duration = 60 / *rate;
  return move;
}

/// "X0.100F60.000" @tparam Way  Jog or Probe
template <class Way>
std::optional<Request> read_way(Reader line) {
  if (line.empty()) return std::nullopt;
  const auto axis = axis_of(line.rest()[0]);
  line.next_is(line.rest().substr(0, 1));
  const auto by = line.value();
  if (!axis || !by || !line.next_is("F")) return std::nullopt;
  const auto rate = line.value();
  if (!rate || !(*rate > 0) || !line.empty()) return std::nullopt;
  return Way{*axis, *by, *rate};
}

std::optional<Request> read_tool(Reader line) {
  const auto z = line.value();
  if (!z || !fits(*z) || !line.empty()) return std::nullopt;
  return ToolOffset{*z};
}

std::optional<Request> read_home(std::string_view letters) {
  Home home;
  for (const char letter : letters) {
    const auto axis = axis_of(letter);
    if (!axis) return std::nullopt;
    home.axes = static_cast<AxisMask>(home.axes | 1U << *axis);
  }
  return home;
}

struct PinLetter {
  char letter;
  bool Pins::* pin;
};
constexpr PinLetter kPinLetters[] = {{'P', &Pins::probe}, {'D', &Pins::door},
                                     {'H', &Pins::hold},  {'R', &Pins::reset},
                                     {'S', &Pins::start}, {'E', &Pins::emergency_stop}};

/// Letters of switches that an arm has not are passed over.
Pins read_pins(std::string_view letters) {
  Pins pins;
  for (const char letter : letters) {
    if (const auto axis = axis_of(letter)) {
      pins.limits = static_cast<AxisMask>(pins.limits | 1U << *axis);
    }
    for (const PinLetter& one : kPinLetters) pins.*one.pin |= one.letter == letter;
  }
  return pins;
}

void put_pins(Writer& line, const Pins& pins) {
  for (const PinLetter& one : kPinLetters) {
    if (pins.*one.pin) line.text({&one.letter, 1});
  }
  for (std::size_t i = 0; i < kAxesMax; ++i) {
    if ((pins.limits >> i & 1) != 0) line.text({&kAxisLetters[i], 1});
  }
}

struct ReplyWriter {
  Line operator()(const Ok& /*ok*/) const { return Writer().text("ok").end(); }
  Line operator()(const Refused& one) const {
    return Writer().text("error:").number(one.code).end();
  }
  Line operator()(const Alarm& one) const { return Writer().text("ALARM:").number(one.code).end(); }
  Line operator()(const Welcome& one) const {
    Writer line;
    line.text(one.firmware == Firmware::kGrblHal ? "GrblHAL " : "Grbl ");
    line.number(one.major).text(".").number(one.minor);
    if (one.firmware == Firmware::kFluidNc) {
      return line.text(" [FluidNC '$' for help]").end();
    }
    return line.text("f ['$' for help]").end();
  }
  Line operator()(const Status& one) const {
    Writer line;
    line.text("<").text(word_of(one.state));
    if (one.detail != 0 || one.state == State::kHold || one.state == State::kDoor) {
      line.text(":").number(one.detail);
    }
    line.text(one.work ? "|WPos:" : "|MPos:").list(one.position);
    if (one.room) line.text("|Bf:").number(one.room->blocks).text(",").number(one.room->bytes);
    if (one.pins) put_pins(line.text("|Pn:"), *one.pins);
    if (one.offset) line.text("|WCO:").list(*one.offset);
    return line.text(">").end();
  }
  Line operator()(const Setting& one) const {
    return Writer().text("$").number(one.number).text("=").value(one.value).end();
  }
  Line operator()(const Build& one) const {
    Writer line;
    line.text("[OPT:V,").number(one.blocks).text(",").number(one.bytes);
    if (one.axes != 0) line.text(",").number(one.axes);
    return line.text("]").end();
  }
  Line operator()(const Probed& one) const {
    return Writer().text("[PRB:").list(one.at).text(one.touched ? ":1]" : ":0]").end();
  }
  Line operator()(const Note& /*note*/) const { return Writer().text("[MSG:]").end(); }
};

template <class Coded>
std::optional<Reply> read_code(Reader line) {
  const auto code = line.number();
  if (!code || !line.empty()) return std::nullopt;
  return Coded{*code};
}

std::optional<Reply> read_welcome(Reader line, Firmware firmware) {
  const auto major = line.number();
  if (!major || !line.next_is(".")) return std::nullopt;
  const auto minor = line.number();
  if (!minor) return std::nullopt;
  if (line.rest().contains("[FluidNC")) firmware = Firmware::kFluidNc;
  return Welcome{firmware, *major, *minor};
}

/// One field of a status report; false where it is damaged. Fields of another meaning pass.
bool read_field(Reader field, Status& status) {
  if (field.next_is("MPos:") || field.next_is("WPos:")) {
    status.work = false;
    const auto position = field.list();
    if (position) status.position = *position;
    return position && field.empty();
  }
  if (field.next_is("WCO:")) {
    status.offset = field.list();
    return status.offset && field.empty();
  }
  if (field.next_is("Bf:")) {
    const auto blocks = field.number();
    if (!blocks || !field.next_is(",")) return false;
    const auto bytes = field.number();
    if (!bytes || !field.empty()) return false;
    status.room = {*blocks, *bytes};
    return true;
  }
  if (field.next_is("Pn:")) status.pins = read_pins(field.rest());
  return true;
}

std::optional<Reply> read_status(std::string_view line) {
  if (!line.ends_with('>')) return std::nullopt;
  Reader fields(line.substr(0, line.size() - 1));
  Reader state(fields.until('|'));
  Status status;
  const auto* const found = std::ranges::find(kStates, state.until(':'));
  if (found == kStates.end()) return std::nullopt;
  status.state = static_cast<State>(found - kStates.begin());
  if (!state.empty()) {
    const auto detail = state.number();
    if (!detail || !state.empty()) return std::nullopt;
    status.detail = *detail;
  }
  while (!fields.empty()) {
    const std::string_view field = fields.until('|');
    if (!read_field(Reader(field), status)) return std::nullopt;
    status.work |= field.starts_with("WPos:");
  }
  if (status.position.empty()) return std::nullopt;
  const bool other = status.offset && status.offset->size() != status.position.size();
  return other ? std::nullopt : std::optional<Reply>(status);
}

/// Named settings, and those whose value is a text, are notes.
Reply read_setting(Reader line) {
  const auto number = line.number();
  if (!number || !line.next_is("=")) return Note{};
  const auto value = line.value();
  if (!value || !line.empty()) return Note{};
  return Setting{*number, *value};
}

/// Behind the letters of the options; more may follow.
std::optional<Reply> read_build(Reader line) {
  line.until(',');
  const auto blocks = line.number();
  if (!blocks || !line.next_is(",")) return std::nullopt;
  const auto bytes = line.number();
  if (!bytes) return std::nullopt;
  Build build{*blocks, *bytes};
  if (line.next_is(",")) {
    const auto axes = line.number();
    if (!axes || *axes > 255) return std::nullopt;
    build.axes = static_cast<std::uint8_t>(*axes);
  }
  return build;
}

std::optional<Reply> read_probed(Reader line) {
  const auto at = line.list();
  if (!at || !line.next_is(":")) return std::nullopt;
  const auto touched = line.number();
  if (!touched || *touched > 1 || line.rest() != "]") return std::nullopt;
  return Probed{*at, *touched == 1};
}

}  // namespace

std::string_view word_of(State state) {
  return kStates[static_cast<std::size_t>(state) % kStates.size()];
}

Line encode(const Request& request) {
  return std::visit(RequestWriter{}, request);
}

std::optional<Request> decode_request(std::string_view line) {
  if (line == "$X") return Unlock{};
  if (line == "$$") return AskSettings{};
  if (line == "$I") return AskBuild{};
  if (line == kModeWords) return Modes{};
  if (line.starts_with(kToolWords)) return read_tool(Reader(line.substr(kToolWords.size())));
  if (line.size() > kLineMax) return std::nullopt;
  if (line.starts_with(kMoveWords)) return read_move(Reader(line.substr(kMoveWords.size())));
  if (line.starts_with(kJogWords)) return read_way<Jog>(Reader(line.substr(kJogWords.size())));
  if (line.starts_with(kProbeWords)) {
    return read_way<Probe>(Reader(line.substr(kProbeWords.size())));
  }
  if (line.starts_with("$H")) return read_home(line.substr(2));
  return std::nullopt;
}

Line encode(const Reply& reply) {
  return std::visit(ReplyWriter{}, reply);
}

std::optional<Reply> decode_reply(std::string_view line) {
  Reader reader(line);
  if (line == "ok") return Ok{};
  if (reader.next_is("error:")) return read_code<Refused>(reader);
  if (reader.next_is("ALARM:")) return read_code<Alarm>(reader);
  if (reader.next_is("<")) return read_status(reader.rest());
  if (reader.next_is("$")) return read_setting(reader);
  if (reader.next_is("GrblHAL ")) return read_welcome(reader, Firmware::kGrblHal);
  if (reader.next_is("Grbl ")) return read_welcome(reader, Firmware::kGrbl);
  if (reader.next_is("[OPT:")) return read_build(Reader(reader.until(']')));
  if (reader.next_is("[PRB:")) return read_probed(reader);
  return Note{};
}

LineDecoder::Result LineDecoder::push(std::uint8_t byte) {
  if (complete_) reset();
  const bool end = byte == '\n' || byte == '\r';
  if (end) {
    const bool damaged = damaged_;
    if (damaged) {
      reset();
      return Result::kDamaged;
    }
    complete_ = !text_.empty();
    return complete_ ? Result::kLine : Result::kMore;
  }
  // Characters of other alphabets stand in messages only.
  const bool control = byte < 0x20 || byte == 0x7F;
  damaged_ = damaged_ || control || text_.full();
  if (!damaged_) text_.push_back(static_cast<char>(byte));
  return Result::kMore;
}

}  // namespace sinew::grbl
