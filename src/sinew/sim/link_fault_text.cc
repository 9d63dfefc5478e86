#include <algorithm>
#include <charconv>
#include <cmath>

#include "sinew/core/quantity.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/sim/fault_switches.h"
#include "sinew/sim/link_fault.h"

// The text of a fault plan, both ways.

namespace sinew::sim {
namespace {

using Checked = std::expected<void, std::string>;

constexpr double kTimeMax = 1e6;  // s, some eleven days
// Far beyond these the physics has no numbers any more, and no robot here comes near them.
constexpr double kSupplyMax = 60;    // V
constexpr double kPayloadMax = 100;  // kg
constexpr double kLoadMax = 1000;    // Nm, N
constexpr double kAngleMax = 100;    // rad
constexpr double kLengthMax = 10;    // m
constexpr std::array<std::string_view, 16> kItems{
    "drop",    "duplicate", "flip",    "delay",  "cut",  "half-open", "seed", "supply",
    "payload", "block",     "unblock", "magnet", "load", "coupling",  "lead", "probe"};

std::string in_quotes(std::string_view text) {
  return "\"" + printable(text) + "\"";
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

/// Up to `separator`, which is taken away too; the rest stays in `text`.
std::string_view take_until(std::string_view& text, char separator) {
  const std::size_t end = std::min(text.find(separator), text.size());
  const std::string_view head = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return trimmed(head);
}

/// One item of the plan: reads its own text and complains with it.
class ItemReader {
 public:
  ItemReader(std::string_view item, std::size_t joints, FaultPlan& plan,
             std::vector<std::string>& seen)
      : item_(item), joints_(joints), plan_(plan), seen_(seen) {}

  Checked read() {
    const std::size_t end = std::min(item_.find_first_of("=@"), item_.size());
    name_ = trimmed(item_.substr(0, end));
    rest_ = item_.substr(std::min(end + 1, item_.size()));
    if (std::ranges::find(kItems, name_) == kItems.end()) return unknown();
    const char separator = end < item_.size() ? item_[end] : ' ';
    const bool chance =
        name_ == "drop" || name_ == "duplicate" || name_ == "flip" || name_ == "delay";
    if (chance && separator == '@') return read_once();
    const char due = name_ == "cut" || name_ == "half-open" ? '@' : '=';
    if (separator != due) return wrong("needs " + std::string(1, due) + " behind its name");
    if (name_ == "cut") return read_cut();
    if (name_ == "half-open") return read_half_open();
    if (name_ == "seed") return read_seed();
    if (chance && rest_.find('@') != std::string_view::npos) return read_span();
    if (name_ == "delay") return read_delay();
    if (name_ == "drop") return read_chance(&ByteFaults::drop);
    if (name_ == "duplicate") return read_chance(&ByteFaults::duplicate);
    if (name_ == "flip") return read_chance(&ByteFaults::flip);
    return read_disturbance();
  }

 private:
  std::unexpected<std::string> wrong(const std::string& what) const {
    return std::unexpected("fault " + in_quotes(item_) + ": " + what);
  }

  Checked unknown() const {
    const std::string_view near = nearest_spelling(name_, kItems);
    if (!near.empty()) return wrong("did you mean " + in_quotes(near) + "?");
    std::string all;
    for (const std::string_view name : kItems) all += (all.empty() ? "" : ", ") + std::string(name);
    return wrong("there are " + all);
  }

  Checked once(const std::string& key) {
    if (std::ranges::find(seen_, key) != seen_.end()) return wrong("is said twice");
    seen_.push_back(key);
    return {};
  }

  Checked read_time(std::string_view text, Duration& out) const {
    const auto seconds = parse_quantity(text, Measure::kTime, UnitRule::kRequired);
    if (!seconds) return wrong(seconds.error());
    if (!(*seconds >= 0 && *seconds <= kTimeMax)) return wrong("a time is 0..1000000 s");
    out = from_seconds(*seconds);
    return {};
  }

  Checked read_quantity(std::string_view text, Measure measure, double& out) const {
    const auto value = parse_quantity(text, measure, UnitRule::kRequired);
    if (!value) return wrong(value.error());
    out = *value;
    return {};
  }

  Checked read_probability(std::string_view text, double& out) const {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
    const bool whole = error == std::errc{} && end == text.data() + text.size();
    if (!whole || !(out >= 0 && out <= 1)) {
      return wrong(in_quotes(text) + " is no chance; it is a number 0..1 for each byte, as 0.001");
    }
    if (out == 0) return wrong("a chance of 0 says nothing; leave it out");
    return {};
  }

  Checked read_direction(std::string_view text, LinkDirection& out) const {
    if (text != "to-host" && text != "to-device") {
      return wrong(in_quotes(text) + " is no direction; there are to-host and to-device");
    }
    out = text == "to-host" ? LinkDirection::kToHost : LinkDirection::kToDevice;
    return {};
  }

  /// Sets the item in both directions, or in the one that `rest_` names.
  template <class Set>
  Checked for_directions(Set&& set) {
    std::array<bool, 2> meant{true, true};
    if (!rest_.empty()) {
      LinkDirection only{};
      if (auto read = read_direction(trimmed(rest_), only); !read) return read;
      meant[only == LinkDirection::kToHost ? 0 : 1] = false;
    }
    for (std::size_t i = 0; i < meant.size(); ++i) {
      if (!meant[i]) continue;
      if (auto first = once(std::string(name_) + (i == 0 ? ">" : "<")); !first) return first;
      set(plan_.link.bytes[i]);
    }
    return {};
  }

  Checked read_chance(double ByteFaults::* member) {
    double chance = 0;
    if (auto read = read_probability(take_until(rest_, ':'), chance); !read) return read;
    return for_directions([&](ByteFaults& faults) { faults.*member = chance; });
  }

  Checked read_delay() {
    double chance = 0;
    Duration time{};
    if (auto read = read_probability(take_until(rest_, ':'), chance); !read) return read;
    if (rest_.empty()) return wrong("needs how long, as delay=0.01:200ms");
    if (auto read = read_delay_time(take_until(rest_, ':'), time); !read) return read;
    return for_directions([&](ByteFaults& faults) {
      faults.delay = chance;
      faults.delay_time = time;
    });
  }

  TimedByteFault::Kind kind_of_chance() const {
    using Kind = TimedByteFault::Kind;
    if (name_ == "drop") return Kind::kDrop;
    if (name_ == "duplicate") return Kind::kDuplicate;
    return name_ == "flip" ? Kind::kFlip : Kind::kDelay;
  }

  Checked read_delay_time(std::string_view text, Duration& out) const {
    if (auto read = read_time(text, out); !read) return read;
    if (out == Duration::zero()) return wrong("a delay of 0 s says nothing; leave it out");
    return {};
  }

  /// Behind the moment of a timed fault stands its direction, if anything; then it is complete.
  Checked take_timed(TimedByteFault& fault) {
    fault.kind = kind_of_chance();
    if (!rest_.empty()) {
      LinkDirection only{};
      if (auto read = read_direction(trimmed(rest_), only); !read) return read;
      fault.only = only;
    }
    const std::string key = std::string(name_) + (fault.once ? "!" : "");
    for (const auto way : {LinkDirection::kToDevice, LinkDirection::kToHost}) {
      if (fault.only && *fault.only != way) continue;
      const bool to_host = way == LinkDirection::kToHost;
      if (auto first = once_at(key + (to_host ? "<" : ">"), fault.at); !first) return first;
    }
    plan_.link.timed.push_back(fault);
    return {};
  }

  Checked read_once() {
    TimedByteFault fault;
    fault.once = true;
    if (auto read = read_time(take_until(rest_, ':'), fault.at); !read) return read;
    if (name_ == "delay") {
      if (rest_.empty()) return wrong("needs how long, as delay@3s:200ms");
      if (auto read = read_delay_time(take_until(rest_, ':'), fault.delay_time); !read) return read;
    }
    return take_timed(fault);
  }

  Checked read_span() {
    TimedByteFault fault;
    std::string_view what = take_until(rest_, '@');
    if (auto read = read_probability(take_until(what, ':'), fault.chance); !read) return read;
    if (name_ == "delay") {
      if (what.empty()) return wrong("needs how long, as delay=0.01:200ms@3s..5s");
      if (auto read = read_delay_time(trimmed(what), fault.delay_time); !read) return read;
    } else if (!what.empty()) {
      return wrong("a direction stands behind the moment, as " + std::string(name_) +
                   "=0.1@3s..5s:to-host");
    }
    const std::string_view span = take_until(rest_, ':');
    const std::size_t dots = span.find("..");
    if (auto read = read_time(trimmed(span.substr(0, dots)), fault.at); !read) return read;
    if (dots != std::string_view::npos) {
      Duration until{};
      if (auto read = read_time(trimmed(span.substr(dots + 2)), until); !read) return read;
      if (until <= fault.at) return wrong("a span ends after it begins, as 3s..5s");
      fault.until = until;
    }
    return take_timed(fault);
  }

  /// Two cuts that begin at once, or two blows to the same thing at once: the later one would take
  /// the place of the earlier one.
  Checked once_at(const std::string& what, Duration at) {
    return once(what + "@" + std::to_string(at.count()));
  }

  Checked read_lasts(LinkCut& cut) {
    if (rest_.empty()) return {};
    Duration lasts{};
    if (auto read = read_time(trimmed(rest_), lasts); !read) return read;
    if (lasts == Duration::zero()) return wrong("a cut of 0 s says nothing; leave it out");
    cut.lasts = lasts;
    return {};
  }

  Checked read_cut() {
    LinkCut cut;
    if (auto read = read_time(take_until(rest_, ':'), cut.at); !read) return read;
    if (auto read = read_lasts(cut); !read) return read;
    plan_.link.cuts.push_back(cut);
    return once_at("cut", cut.at);
  }

  Checked read_half_open() {
    LinkCut cut;
    LinkDirection only{};
    if (auto read = read_time(take_until(rest_, ':'), cut.at); !read) return read;
    if (auto read = read_direction(take_until(rest_, ':'), only); !read) return read;
    if (auto read = read_lasts(cut); !read) return read;
    cut.only = only;
    plan_.link.cuts.push_back(cut);
    return once_at(only == LinkDirection::kToHost ? "half-open<" : "half-open>", cut.at);
  }

  Checked read_seed() {
    const std::string_view text = trimmed(rest_);
    const auto [end, error] =
        std::from_chars(text.data(), text.data() + text.size(), plan_.link.seed);
    if (error != std::errc{} || end != text.data() + text.size()) {
      return wrong("a seed is a whole number, 0 or more");
    }
    return once("seed");
  }

  Checked read_joint(std::string_view text, std::int8_t& joint) const {
    const bool named = text.starts_with('J') || text.starts_with('j');
    const std::string_view digits = named ? text.substr(1) : std::string_view{};
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    const bool whole = error == std::errc{} && end == digits.data() + digits.size();
    if (!whole || number < 1 || number > joints_) {
      return wrong(in_quotes(text) + " is no joint; they are J1 to J" + std::to_string(joints_));
    }
    joint = static_cast<std::int8_t>(number - 1);
    return {};
  }

  Checked read_place(std::string_view text, TimedDisturbance& timed) const {
    const auto angle = parse_quantity(text, Measure::kAngle, UnitRule::kRequired);
    const auto length = parse_quantity(text, Measure::kLength, UnitRule::kRequired);
    if (!angle && !length) {
      return wrong(in_quotes(text) + " is no place of a joint; write 20deg or 12mm");
    }
    timed.what.value = angle ? *angle : *length;
    timed.unit = angle ? JointKind::kRevolute : JointKind::kPrismatic;
    if (!(std::abs(timed.what.value) <= (angle ? kAngleMax : kLengthMax))) {
      return wrong("a place is -100..100 rad or -10..10 m");
    }
    return {};
  }

  /// A force of a leg is written in N and a torque in Nm; the number is the same.
  Checked read_load(std::string_view text, TimedDisturbance& timed) const {
    std::string torque(text);
    const bool force = torque.ends_with('N');
    if (force) torque += 'm';
    timed.unit = force ? JointKind::kPrismatic : JointKind::kRevolute;
    double& load = timed.what.value;
    if (auto read = read_quantity(torque, Measure::kTorque, load); !read) return read;
    if (!(std::abs(load) <= kLoadMax)) return wrong("a load is -1000..1000 Nm or N");
    return {};
  }

  Checked read_disturbance() {
    const std::size_t at = rest_.rfind('@');
    if (at == std::string_view::npos) return wrong("needs its moment, as @3s");
    TimedDisturbance timed;
    if (auto read = read_time(trimmed(rest_.substr(at + 1)), timed.at); !read) return read;
    if (auto read = read_what(rest_.substr(0, at), timed); !read) return read;
    plan_.disturbances.push_back(timed);
    const std::string_view thing = name_ == "unblock" ? "block" : name_;
    return once_at(std::string(thing) + std::to_string(timed.what.joint), timed.at);
  }

  Checked read_what(std::string_view what, TimedDisturbance& timed) const {
    using Kind = Disturbance::Kind;
    Disturbance& out = timed.what;
    if (name_ == "supply") {
      out.kind = Kind::kSupply;
      if (auto read = read_quantity(trimmed(what), Measure::kVoltage, out.value); !read)
        return read;
      if (!(out.value >= 0 && out.value <= kSupplyMax)) return wrong("a supply is 0..60 V");
      return {};
    }
    if (name_ == "payload") {
      out.kind = Kind::kPayload;
      if (auto read = read_quantity(trimmed(what), Measure::kMass, out.value); !read) return read;
      if (!(out.value >= 0 && out.value <= kPayloadMax)) return wrong("a payload is 0..100 kg");
      return {};
    }
    const bool has_place = name_ == "block" || name_ == "probe";
    const char separator = has_place ? '@' : ':';
    if (auto read = read_joint(take_until(what, separator), out.joint); !read) return read;
    const std::string_view value = trimmed(what);
    if (has_place) {
      out.kind = name_ == "block" ? Kind::kBlock : Kind::kProbe;
      return read_place(value, timed);
    }
    if (name_ == "load") {
      out.kind = Kind::kLoad;
      return read_load(value, timed);
    }
    const auto* part = std::ranges::find(kFaultSwitches, name_, &FaultSwitch::name);
    if (part != kFaultSwitches.end()) {
      out.kind = part->kind;
      out.value = value == part->good ? 1 : 0;
      if (value != part->good && value != part->bad) return wrong(std::string(part->either));
      return {};
    }
    out.kind = Kind::kUnblock;
    if (!value.empty()) return wrong("needs a joint and its moment only, as unblock=J2@5s");
    return {};
  }

  std::string_view item_;
  std::size_t joints_;
  FaultPlan& plan_;
  std::vector<std::string>& seen_;
  std::string_view name_;
  std::string_view rest_;
};

/// Shortest text that reads back as the same number.
std::string exact(double value) {
  std::array<char, 32> text{};
  const auto result = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), result.ptr};
}

/// Whole where they are whole, so that nothing is rounded.
std::string text_of(Duration time) {
  using std::chrono::milliseconds;
  if (time % std::chrono::seconds(1) == Duration::zero()) {
    return std::to_string(time / std::chrono::seconds(1)) + "s";
  }
  if (time % milliseconds(1) == Duration::zero()) {
    return std::to_string(time / milliseconds(1)) + "ms";
  }
  return exact(to_seconds(time)) + "s";
}

std::string_view text_of(LinkDirection direction) {
  return direction == LinkDirection::kToHost ? "to-host" : "to-device";
}

void print_bytes(const LinkFaultSpec& link, std::vector<std::string>& items) {
  const ByteFaults& to_device = link.bytes[0];
  const ByteFaults& to_host = link.bytes[1];
  const auto print = [&](std::string_view name, auto&& value_of) {
    const std::string both[2]{value_of(to_device), value_of(to_host)};
    if (both[0] == both[1]) {
      if (!both[0].empty()) items.push_back(std::string(name) + "=" + both[0]);
      return;
    }
    for (const auto direction : {LinkDirection::kToDevice, LinkDirection::kToHost}) {
      const std::string& value = both[static_cast<std::size_t>(direction)];
      if (value.empty()) continue;
      items.push_back(std::string(name) + "=" + value + ":" + std::string(text_of(direction)));
    }
  };
  const auto chance = [](double p) { return p > 0 ? exact(p) : std::string{}; };
  print("drop", [&](const ByteFaults& f) { return chance(f.drop); });
  print("duplicate", [&](const ByteFaults& f) { return chance(f.duplicate); });
  print("flip", [&](const ByteFaults& f) { return chance(f.flip); });
  print("delay", [&](const ByteFaults& f) {
    return f.delay > 0 ? exact(f.delay) + ":" + text_of(f.delay_time) : std::string{};
  });
}

std::string text_of(const TimedByteFault& fault) {
  constexpr std::string_view kNames[] = {"drop", "duplicate", "flip", "delay"};
  std::string text(kNames[static_cast<std::size_t>(fault.kind)]);
  const bool delay = fault.kind == TimedByteFault::Kind::kDelay;
  const std::string late = delay ? ":" + text_of(fault.delay_time) : std::string{};
  if (fault.once) {
    text += "@" + text_of(fault.at) + late;
  } else {
    text += "=" + exact(fault.chance) + late + "@" + text_of(fault.at);
    if (fault.until) text += ".." + text_of(*fault.until);
  }
  if (fault.only) text += ":" + std::string(text_of(*fault.only));
  return text;
}

std::string text_of(const LinkCut& cut) {
  std::string text = (cut.only ? "half-open@" : "cut@") + text_of(cut.at);
  if (cut.only) text += ":" + std::string(text_of(*cut.only));
  if (cut.lasts) text += ":" + text_of(*cut.lasts);
  return text;
}

std::string text_of(const TimedDisturbance& timed) {
  using Kind = Disturbance::Kind;
  const std::string joint = "J" + std::to_string(timed.what.joint + 1);
  const std::string value = exact(timed.what.value);
  const std::string at = "@" + text_of(timed.at);
  const bool leg = timed.unit == JointKind::kPrismatic;
  switch (timed.what.kind) {
    case Kind::kSupply:
      return "supply=" + value + "V" + at;
    case Kind::kPayload:
      return "payload=" + value + "kg" + at;
    case Kind::kBlock:
    case Kind::kProbe:
      return std::string(place_item(timed.what.kind)) + "=" + joint + "@" + value +
             (leg ? "m" : "rad") + at;
    case Kind::kUnblock:
      return "unblock=" + joint + at;
    case Kind::kMagnet:
    case Kind::kCoupling:
    case Kind::kLead: {
      const FaultSwitch& part = *switch_of(timed.what.kind);
      const std::string_view state = timed.what.value != 0 ? part.good : part.bad;
      return std::string(part.name) + "=" + joint + ":" + std::string(state) + at;
    }
    case Kind::kLoad:
      break;
  }
  return "load=" + joint + ":" + value + (leg ? "N" : "Nm") + at;
}

bool has_chances(const LinkFaultSpec& link) {
  // Which bit is flipped is a matter of chance too.
  const bool timed = std::ranges::any_of(link.timed, [](const TimedByteFault& fault) {
    return !fault.once || fault.kind == TimedByteFault::Kind::kFlip;
  });
  return timed || std::ranges::any_of(link.bytes, [](const ByteFaults& faults) {
           return faults.drop > 0 || faults.duplicate > 0 || faults.flip > 0 || faults.delay > 0;
         });
}

}  // namespace

std::expected<FaultPlan, std::string> parse_faults(std::string_view text, std::size_t joints) {
  FaultPlan plan;
  std::vector<std::string> seen;
  if (trimmed(text).empty()) {
    return std::unexpected("an empty fault: it says nothing; write one, as drop=0.001");
  }
  while (true) {
    const bool last = text.find(',') == std::string_view::npos;
    const std::string_view item = take_until(text, ',');
    if (item.empty()) return std::unexpected("an empty fault: one comma too many");
    if (auto read = ItemReader(item, joints, plan, seen).read(); !read) {
      return std::unexpected(read.error());
    }
    if (last) break;
  }
  const bool seeded = std::ranges::find(seen, "seed") != seen.end();
  if (!seeded || has_chances(plan.link)) return plan;
  return std::unexpected(
      "fault \"seed\": says nothing without a chance; it goes with drop, duplicate, flip or delay");
}

std::string to_text(const FaultPlan& plan) {
  std::vector<std::string> items;
  print_bytes(plan.link, items);
  for (const TimedByteFault& fault : plan.link.timed) items.push_back(text_of(fault));
  for (const LinkCut& cut : plan.link.cuts) items.push_back(text_of(cut));
  for (const TimedDisturbance& timed : plan.disturbances) items.push_back(text_of(timed));
  if (plan.link.seed != LinkFaultSpec{}.seed) {
    items.push_back("seed=" + std::to_string(plan.link.seed));
  }
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ",") + item;
  return text;
}

}  // namespace sinew::sim
