#include "sinew/wire/simwire.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace sinew::simwire {
namespace {

constexpr std::string_view kHexDigits = "0123456789abcdef";
constexpr std::array<std::string_view, 3> kPulls = {"UP", "DOWN", "OFF"};  // by Pull

/// Words of a line, one at a time.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}

  /// The next word; empty at the end. One space between words, none at the ends.
  std::string_view next() {
    const std::size_t end = rest_.find(' ');
    const std::string_view word = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
    return word;
  }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

template <class Integer>
bool number(std::string_view word, Integer& out) {
  // No leading zeros: a number has one spelling.
  if (word.size() > 1 && word[0] == '0') return false;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), out);
  return error == std::errc() && end == word.data() + word.size() && !word.empty();
}

bool flag(std::string_view word, bool& out) {
  out = word == "1";
  return word == "0" || word == "1";
}

int hex_digit(char c) {
  const std::size_t place = kHexDigits.find(c);
  return place == std::string_view::npos ? -1 : static_cast<int>(place);
}

bool hex(std::string_view word, Bytes& out) {
  if (word.size() % 2 != 0 || word.size() / 2 > out.capacity()) return false;
  out.clear();
  for (std::size_t i = 0; i < word.size(); i += 2) {
    const int high = hex_digit(word[i]);
    const int low = hex_digit(word[i + 1]);
    if (high < 0 || low < 0) return false;
    out.push_back(static_cast<std::uint8_t>(high * 16 + low));
  }
  return true;
}

bool settings_of(Words& words, BusSettings& out) {
  return number(words.next(), out.bus) && number(words.next(), out.device) &&
         number(words.next(), out.clock_hz) && number(words.next(), out.mode);
}

void put(Line& line, std::string_view text) {
  for (const char c : text) line.push_back(c);
}

template <class Integer>
void put_digits(Line& line, Integer value) {
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  put(line, {digits, static_cast<std::size_t>(end - digits)});
}

template <class Integer>
void put_number(Line& line, Integer value) {
  line.push_back(' ');
  put_digits(line, value);
}

void put_hex(Line& line, const Bytes& bytes) {
  line.push_back(' ');
  for (const std::uint8_t byte : bytes) {
    line.push_back(kHexDigits[byte >> 4]);
    line.push_back(kHexDigits[byte & 15]);
  }
}

void put_settings(Line& line, const BusSettings& settings) {
  for (const std::uint32_t value :
       {settings.bus, settings.device, settings.clock_hz, settings.mode}) {
    put_number(line, value);
  }
}

void put_text(Line& line, std::string_view text) {
  if (text.empty()) return;
  line.push_back(' ');
  put(line, text);
}

struct ActionWriter {
  Line& line;

  void operator()(const Hello& hello) const {
    put(line, "HELLO");
    put_number(line, hello.version);
  }
  void operator()(const Direction& direction) const {
    put(line, "DIR");
    put_number(line, direction.pin);
    put(line, direction.output ? " OUT" : " IN");
    put_text(line, kPulls.at(static_cast<std::size_t>(direction.pull)));
  }
  void operator()(const SetPin& set) const {
    put(line, "SET");
    put_number(line, set.pin);
    put(line, set.high ? " 1" : " 0");
  }
  void operator()(const GetPin& get) const {
    put(line, "GET");
    put_number(line, get.pin);
  }
  void operator()(const Open& open) const {
    put(line, "OPEN");
    put_settings(line, open.settings);
  }
  void operator()(const Exchange& exchange) const {
    put(line, "XFER");
    put_settings(line, exchange.settings);
    put_hex(line, exchange.mosi);
  }
  void operator()(const Close& close) const {
    put(line, "CLOSE");
    put_number(line, close.bus);
    put_number(line, close.device);
  }
  void operator()(const Statistics& /*none*/) const { put(line, "STAT"); }
  void operator()(const Dump& /*none*/) const { put(line, "DUMP"); }
  void operator()(const Poke& poke) const {
    put(line, "POKE");
    put_number(line, poke.reg);
    put_hex(line, poke.value);
  }
  void operator()(const Fault& fault) const {
    put(line, "FAULT");
    put_text(line, view(fault.text));
  }
  void operator()(const Bye& /*none*/) const { put(line, "BYE"); }
};

using Decoded = std::expected<Action, std::string_view>;

Decoded decode_direction(Words& words) {
  Direction direction;
  const bool pin = number(words.next(), direction.pin);
  const std::string_view way = words.next();
  const std::string_view pull = words.next();
  direction.output = way == "OUT";
  const auto found = std::find(kPulls.begin(), kPulls.end(), pull);
  if (found != kPulls.end()) direction.pull = static_cast<Pull>(found - kPulls.begin());
  const bool known = (way == "IN" || way == "OUT") && found != kPulls.end();
  if (!pin || !known) return std::unexpected("write DIR <pin> IN|OUT UP|DOWN|OFF");
  return direction;
}

Decoded decode_exchange(Words& words) {
  Exchange exchange;
  if (!settings_of(words, exchange.settings) || !hex(words.next(), exchange.mosi)) {
    return std::unexpected("write XFER <bus> <dev> <hz> <mode> <mosi as lower-case hex>");
  }
  return exchange;
}

Decoded decode_pin(std::string_view name, Words& words) {
  if (name == "GET") {
    GetPin get;
    if (!number(words.next(), get.pin)) return std::unexpected("write GET <pin>");
    return get;
  }
  SetPin set;
  if (!number(words.next(), set.pin) || !flag(words.next(), set.high)) {
    return std::unexpected("write SET <pin> 0|1");
  }
  return set;
}

Decoded decode_bus(std::string_view name, Words& words) {
  if (name == "OPEN") {
    Open open;
    if (!settings_of(words, open.settings)) {
      return std::unexpected("write OPEN <bus> <dev> <hz> <mode>");
    }
    return open;
  }
  Close close;
  if (!number(words.next(), close.bus) || !number(words.next(), close.device)) {
    return std::unexpected("write CLOSE <bus> <dev>");
  }
  return close;
}

Decoded decode_action(std::string_view name, Words& words) {
  if (name == "XFER") return decode_exchange(words);
  if (name == "SET" || name == "GET") return decode_pin(name, words);
  if (name == "DIR") return decode_direction(words);
  if (name == "OPEN" || name == "CLOSE") return decode_bus(name, words);
  if (name == "STAT") return Statistics{};
  if (name == "DUMP") return Dump{};
  if (name == "BYE") return Bye{};
  if (name == "HELLO") {
    Hello hello;
    if (!number(words.next(), hello.version)) return std::unexpected("write HELLO <version>");
    return hello;
  }
  if (name == "POKE") {
    Poke poke;
    if (!number(words.next(), poke.reg) || !hex(words.next(), poke.value)) {
      return std::unexpected("write POKE <reg> <hex>");
    }
    return poke;
  }
  if (name == "FAULT") {
    if (words.rest().size() > kTextMax) return std::unexpected("FAULT: at most 256 characters");
    const Fault fault{text_of(words.rest())};
    words = Words("");
    return fault;
  }
  return std::unexpected(
      "unknown request; known are HELLO DIR SET GET OPEN XFER CLOSE STAT DUMP POKE FAULT BYE");
}

}  // namespace

Line encode_request(const Request& request) {
  Line line;
  put_digits(line, request.time_us);
  line.push_back(' ');
  std::visit(ActionWriter{line}, request.action);
  return line;
}

std::expected<Request, std::string_view> decode_request(std::string_view line) {
  Words words(line);
  Request request;
  if (!number(words.next(), request.time_us)) {
    return std::unexpected("a request begins with its time in microseconds");
  }
  const std::string_view name = words.next();
  auto action = decode_action(name, words);
  if (!action) return std::unexpected(action.error());
  if (!words.rest().empty()) return std::unexpected("more words than this request has");
  request.action = *action;
  // One spelling for each request: a space too many is a line that was damaged.
  if (view(encode_request(request)) != line) return std::unexpected("one space between words");
  return request;
}

Line encode_reply(const Reply& reply) {
  Line line;
  if (const auto* ok = std::get_if<Ok>(&reply)) {
    put(line, "OK");
    put_text(line, view(ok->text));
  } else if (const auto* level = std::get_if<Level>(&reply)) {
    put(line, level->high ? "LVL 1" : "LVL 0");
  } else if (const auto* miso = std::get_if<Miso>(&reply)) {
    put(line, "MISO");
    put_hex(line, miso->bytes);
  } else if (const auto* report = std::get_if<Report>(&reply)) {
    put(line, report->dump ? "DUMP" : "STAT");
    const std::size_t room = line.capacity() - line.size() - 1;
    put_text(line, view(report->text).substr(0, room));
  } else {
    put(line, "ERR");
    put_text(line, view(std::get<Refused>(reply).text));
  }
  return line;
}

std::optional<Reply> decode_reply(std::string_view line) {
  Words words(line);
  const std::string_view name = words.next();
  const std::string_view rest = words.rest();
  std::optional<Reply> reply;
  if (name == "OK" && rest.size() <= kTextMax) reply = Ok{text_of(rest)};
  if (name == "ERR" && rest.size() <= kTextMax) reply = Refused{text_of(rest)};
  if (name == "LVL" && (rest == "0" || rest == "1")) reply = Level{rest == "1"};
  if (name == "MISO") {
    Miso miso;
    if (hex(rest, miso.bytes)) reply = miso;
  }
  if ((name == "STAT" || name == "DUMP") && line.size() <= kLineMax) {
    reply = Report{name == "DUMP", text_of<kLineMax>(rest)};
  }
  if (reply && view(encode_reply(*reply)) != line) return std::nullopt;
  return reply;
}

LineReader::Result LineReader::push(char character) {
  if (complete_) {
    line_.clear();
    complete_ = false;
    too_long_ = false;
  }
  if (character == '\n') {
    complete_ = true;
    return too_long_ ? Result::kTooLong : Result::kLine;
  }
  if (line_.full()) {
    too_long_ = true;
  } else {
    line_.push_back(character);
  }
  return Result::kMore;
}

}  // namespace sinew::simwire
