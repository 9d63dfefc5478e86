#include "sinew/sim/link_fault.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <map>

#include "sinew/core/units.h"
#include "support/allocation_guard.h"
#include "support/property.h"

namespace sinew::sim {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;
constexpr auto kToDevice = LinkDirection::kToDevice;
constexpr auto kToHost = LinkDirection::kToHost;

FaultPlan plan_of(const std::string& text) {
  const auto plan = parse_faults(text);
  if (!plan) ADD_FAILURE() << plan.error();
  return plan.value_or(FaultPlan{});
}

Bytes all_of(LinkFaults& link, LinkDirection direction, Instant now) {
  Bytes bytes;
  std::array<std::uint8_t, 7> piece{};
  while (const std::size_t n = link.take(direction, now, piece)) {
    bytes.insert(bytes.end(), piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(n));
  }
  return bytes;
}

Bytes counting(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(i % 251);
  return bytes;
}

TEST(LinkFaults, without_faults_it_is_a_wire) {
  LinkFaults link({}, Instant{});
  const Bytes sent = counting(1000);
  link.push(kToHost, sent, Instant{1s});
  EXPECT_TRUE(all_of(link, kToDevice, Instant{1s}).empty());
  EXPECT_EQ(link.next_event(), Instant{1s});
  EXPECT_EQ(all_of(link, kToHost, Instant{1s}), sent);
  EXPECT_FALSE(link.next_event());
  EXPECT_EQ(link.counts(kToHost), (LinkCounts{.in = 1000, .out = 1000}));
}

TEST(LinkFaults, each_fault_comes_as_often_as_its_chance_says) {
  LinkFaults link(plan_of("drop=0.1,duplicate=0.05,flip=0.02:to-device,seed=5").link, Instant{});
  const Bytes sent = counting(50'000);
  for (const auto direction : {kToDevice, kToHost}) {
    link.push(direction, sent, Instant{});
    (void)all_of(link, direction, Instant{});
    const LinkCounts& counts = link.counts(direction);
    EXPECT_NEAR(static_cast<double>(counts.dropped), 5000, 350);
    EXPECT_NEAR(static_cast<double>(counts.duplicated), 2250, 250);
    EXPECT_NEAR(static_cast<double>(counts.flipped), direction == kToDevice ? 900 : 0, 150);
  }
}

TEST(LinkFaults, a_flip_turns_exactly_one_bit_and_any_of_the_eight) {
  LinkFaults link(plan_of("flip=1").link, Instant{});
  const Bytes sent(2000, 0x5A);
  link.push(kToDevice, sent, Instant{});
  std::map<int, int> bits;
  for (const std::uint8_t byte : all_of(link, kToDevice, Instant{})) {
    const auto changed = static_cast<std::uint8_t>(byte ^ 0x5A);
    ASSERT_EQ(std::popcount(changed), 1);
    ++bits[std::countr_zero(changed)];
  }
  for (int bit = 0; bit < 8; ++bit) EXPECT_GT(bits[bit], 180) << bit;
}

TEST(LinkFaults, a_late_byte_holds_up_all_behind_it) {
  LinkFaults link(plan_of("delay=0.02:200ms,seed=2").link, Instant{});
  const Bytes sent = counting(500);
  Bytes got;
  Instant now{};
  for (const std::uint8_t byte : sent) {
    now += 1ms;
    link.push(kToHost, std::span(&byte, 1), now);
    for (const std::uint8_t b : all_of(link, kToHost, now)) got.push_back(b);
  }
  EXPECT_LT(got.size(), sent.size()) << "some are still under way";
  EXPECT_GT(link.counts(kToHost).delayed, 2U);
  while (const auto next = link.next_event()) {
    for (const std::uint8_t b : all_of(link, kToHost, *next)) got.push_back(b);
  }
  EXPECT_EQ(got, sent);
}

TEST(LinkFaults, cut_is_dead_both_ways_for_its_time_and_half_open_one_way) {
  LinkFaults link(plan_of("cut@3s:500ms,half-open@10s:to-host").link, Instant{100s});
  const auto passes = [&](LinkDirection direction, Duration since_start) {
    link.push(direction, Bytes{1}, Instant{100s} + since_start);
    return all_of(link, direction, Instant{100s} + since_start).size() == 1;
  };
  EXPECT_TRUE(passes(kToHost, 2999ms));
  EXPECT_FALSE(passes(kToHost, 3s));
  EXPECT_FALSE(passes(kToDevice, 3499ms));
  EXPECT_TRUE(passes(kToDevice, 3500ms));
  EXPECT_TRUE(passes(kToHost, 9999ms));
  EXPECT_FALSE(passes(kToHost, 10s));
  EXPECT_TRUE(passes(kToDevice, 10s));
  EXPECT_FALSE(passes(kToHost, 1000s)) << "no end: for ever";
  EXPECT_EQ(link.counts(kToHost).cut, 3U);
}

TEST(LinkFaults, a_fault_at_a_moment_befalls_the_first_byte_from_then_on_and_no_other) {
  const Bytes ten = counting(10);
  struct Row {
    const char* text;
    Bytes at_once;
  };
  for (const Row& row :
       {Row{"drop@3s", {1, 2, 3, 4, 5, 6, 7, 8, 9}},
        Row{"duplicate@3s", {0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9}}, Row{"delay@3s:20ms", {}}}) {
    LinkFaults link(plan_of(row.text).link, Instant{});
    link.push(kToHost, ten, Instant{} + 2999ms);
    EXPECT_EQ(all_of(link, kToHost, Instant{} + 2999ms), ten) << row.text;
    link.push(kToHost, ten, Instant{} + 3500ms);
    EXPECT_EQ(all_of(link, kToHost, Instant{} + 3500ms), row.at_once) << row.text;
    (void)all_of(link, kToHost, Instant{} + 4s);
    for (const auto direction : {kToDevice, kToHost}) {
      link.push(direction, ten, Instant{} + 5s);
      EXPECT_EQ(all_of(link, direction, Instant{} + 5s), ten) << row.text << ": once";
    }
  }
  LinkFaults link(plan_of("flip@3s:to-host").link, Instant{});
  link.push(kToDevice, ten, Instant{} + 4s);
  EXPECT_EQ(all_of(link, kToDevice, Instant{} + 4s), ten);
  link.push(kToHost, ten, Instant{} + 4s);
  const Bytes spoiled = all_of(link, kToHost, Instant{} + 4s);
  EXPECT_EQ(std::popcount(static_cast<unsigned>(spoiled[0] ^ ten[0])), 1);
  EXPECT_TRUE(std::equal(spoiled.begin() + 1, spoiled.end(), ten.begin() + 1));
}

TEST(LinkFaults, a_chance_with_a_span_holds_in_it_alone) {
  LinkFaults link(plan_of("flip=0.1@3s..5s,drop=0.2@4s:to-host,seed=5").link, Instant{});
  const Bytes sent = counting(20'000);
  struct Row {
    Duration at;
    double flipped, dropped;  // per byte, to the host
  };
  std::array<LinkCounts, 2> before{};
  for (const Row& row : {Row{2999ms, 0, 0}, Row{3s, 0.1, 0}, Row{4s, 0.08, 0.2}, Row{5s, 0, 0.2}}) {
    for (const auto direction : {kToDevice, kToHost}) {
      const bool to_host = direction == kToHost;
      link.push(direction, sent, Instant{} + row.at);
      (void)all_of(link, direction, Instant{} + row.at);
      const LinkCounts& counts = link.counts(direction);
      LinkCounts& last = before[to_host ? 1 : 0];
      const double flipped = static_cast<double>(counts.flipped - last.flipped) / 20'000;
      const double dropped = static_cast<double>(counts.dropped - last.dropped) / 20'000;
      EXPECT_NEAR(flipped, to_host || row.flipped == 0 ? row.flipped : 0.1, 0.01);
      EXPECT_NEAR(dropped, to_host ? row.dropped : 0, 0.01);
      last = counts;
    }
  }
}

TEST(LinkFaults, faults_with_a_moment_leave_the_others_where_they_fall) {
  const Bytes sent = counting(5000);
  LinkFaults plain(plan_of("flip=0.01,seed=3").link, Instant{});
  LinkFaults timed(plan_of("flip=0.01,flip=1@3s..4s,delay@9s:1s,seed=3").link, Instant{});
  for (LinkFaults* link : {&plain, &timed}) link->push(kToHost, sent, Instant{});
  EXPECT_EQ(all_of(plain, kToHost, Instant{}), all_of(timed, kToHost, Instant{}));
}

TEST(LinkFaults, a_full_link_loses_and_says_so) {
  LinkFaults link(plan_of("delay=1:10s").link, Instant{});
  link.push(kToDevice, Bytes(LinkFaults::kCapacity + 5), Instant{});
  EXPECT_EQ(link.counts(kToDevice).cut, 5U);
  EXPECT_EQ(all_of(link, kToDevice, Instant{10s}).size(), LinkFaults::kCapacity);
}

TEST(LinkFaults, same_seed_same_faults_however_bytes_are_grouped_and_none_is_made_up) {
  test::for_random_cases(300, [](test::Random& random) {
    LinkFaultSpec spec;
    for (ByteFaults& faults : spec.bytes) {
      faults = {random.uniform(0, 0.2), random.uniform(0, 0.2), random.uniform(0, 0.2),
                random.uniform(0, 0.1), std::chrono::milliseconds(random.integer(0, 50))};
    }
    spec.seed = random.bits();
    LinkFaults whole(spec, Instant{});
    LinkFaults pieces(spec, Instant{});
    const Bytes sent = counting(static_cast<std::size_t>(random.integer(0, 400)));
    const Bytes other = counting(50);
    const test::AllocationCounter allocations;
    pieces.push(kToHost, other, Instant{});  // the other direction changes nothing
    whole.push(kToDevice, sent, Instant{});
    for (std::size_t at = 0; at < sent.size();) {
      const auto n = std::min(sent.size() - at, static_cast<std::size_t>(random.integer(1, 9)));
      pieces.push(kToDevice, std::span(sent).subspan(at, n), Instant{});
      at += n;
    }
    EXPECT_EQ(allocations.count(), 0U);
    const Bytes early = all_of(whole, kToDevice, Instant{10ms});
    EXPECT_EQ(early, all_of(pieces, kToDevice, Instant{10ms}));
    EXPECT_EQ(all_of(whole, kToDevice, Instant{1s}), all_of(pieces, kToDevice, Instant{1s}));
    const LinkCounts& counts = whole.counts(kToDevice);
    EXPECT_EQ(counts, pieces.counts(kToDevice));
    EXPECT_EQ(counts.out, counts.in - counts.dropped - counts.cut + counts.duplicated);
  });
}

TEST(FaultText, all_items_are_read) {
  const FaultPlan plan = plan_of(
      " drop=0.001 , flip=1e-4:to-host,delay=0.01:200ms,cut@3s:500ms,half-open@10s:to-host:1s,"
      "cut@1min,seed=7,supply=9V@3s,block=J2@20deg@4s,unblock=J2@5s,payload=0.5kg@1s,"
      "magnet=J3:off@2s,magnet=J3:on@2500ms,load=J1:-0.5Nm@0s,block=J6@12mm@1s,load=J4:2N@1s,"
      "lead=J5:loose@3s,lead=J5:fast@4s");
  EXPECT_EQ(plan.link.bytes[0].drop, 0.001);
  EXPECT_EQ(plan.link.bytes[1].drop, 0.001);
  EXPECT_EQ(plan.link.bytes[0].flip, 0);
  EXPECT_EQ(plan.link.bytes[1].flip, 1e-4);
  EXPECT_EQ(plan.link.bytes[1].delay_time, 200ms);
  EXPECT_EQ(plan.link.cuts,
            (std::vector<LinkCut>{
                {3s, 500ms, std::nullopt}, {10s, 1s, kToHost}, {60s, std::nullopt, std::nullopt}}));
  EXPECT_EQ(plan.link.seed, 7U);
  using Kind = Disturbance::Kind;
  struct Row {
    Kind kind;
    int joint;
    double value;
    Duration at;
  };
  const std::vector<Row> rows{{Kind::kSupply, -1, 9, 3s}, {Kind::kBlock, 1, from_deg(20), 4s},
                              {Kind::kUnblock, 1, 0, 5s}, {Kind::kPayload, -1, 0.5, 1s},
                              {Kind::kMagnet, 2, 0, 2s},  {Kind::kMagnet, 2, 1, 2500ms},
                              {Kind::kLoad, 0, -0.5, 0s}, {Kind::kBlock, 5, 0.012, 1s},
                              {Kind::kLoad, 3, 2, 1s},    {Kind::kLead, 4, 0, 3s},
                              {Kind::kLead, 4, 1, 4s}};
  ASSERT_EQ(plan.disturbances.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(plan.disturbances[i].what.kind, rows[i].kind) << i;
    EXPECT_EQ(plan.disturbances[i].what.joint, rows[i].joint) << i;
    EXPECT_NEAR(plan.disturbances[i].what.value, rows[i].value, 1e-15) << i;
    EXPECT_EQ(plan.disturbances[i].at, rows[i].at) << i;
  }
}

TEST(FaultText, chances_take_moments_and_spans) {
  const FaultPlan plan = plan_of(
      "flip@3s,drop@1500ms:to-host,delay@4s:200ms:to-device,flip=0.1@3s,duplicate=0.2@3s..5s:to-"
      "host"
      ",delay=0.01:50ms@1min..2min,flip=1e-4");
  using Fault = TimedByteFault;
  using Kind = Fault::Kind;
  const std::vector<Fault> expected{
      {.kind = Kind::kFlip, .at = 3s, .once = true},
      {.kind = Kind::kDrop, .at = 1500ms, .once = true, .only = kToHost},
      {.kind = Kind::kDelay, .at = 4s, .once = true, .only = kToDevice, .delay_time = 200ms},
      {.kind = Kind::kFlip, .chance = 0.1, .at = 3s},
      {.kind = Kind::kDuplicate, .chance = 0.2, .at = 3s, .until = 5s, .only = kToHost},
      {.kind = Kind::kDelay, .chance = 0.01, .at = 60s, .until = 120s, .delay_time = 50ms}};
  EXPECT_EQ(plan.link.timed, expected);
  EXPECT_EQ(plan.link.bytes[0].flip, 1e-4) << "of every moment, besides";
}

TEST(FaultText, every_mistake_earns_a_sentence_that_names_it) {
  const std::vector<std::array<std::string, 2>> mistakes{
      {"dorp=0.1", "did you mean \"drop\"?"},
      {"nonsense", "there are drop, duplicate"},
      {"drop", "needs = behind its name"},
      {"flip@x", "fault \"flip@x\":"},
      {"flip@3s:sideways", "\"sideways\" is no direction"},
      {"flip@3s,flip@3000ms:to-host", "is said twice"},
      {"flip=0.1@3s..3s", "a span ends after it begins, as 3s..5s"},
      {"flip=0.1@3s..", "fault \"flip=0.1@3s..\":"},
      {"flip=0@3s", "a chance of 0 says nothing"},
      {"flip=0.1:to-host@3s", "a direction stands behind the moment, as flip=0.1@3s..5s:to-host"},
      {"drop=0.1@1s..2s,drop=0.3@1s", "is said twice"},
      {"delay@3s", "needs how long, as delay@3s:200ms"},
      {"delay@3s:0s", "a delay of 0 s says nothing"},
      {"delay=0.1@3s", "needs how long, as delay=0.01:200ms@3s..5s"},
      {"drop@3s,seed=4", "says nothing without a chance"},
      {"cut=3s", "needs @ behind its name"},
      {"drop=2", "\"2\" is no chance; it is a number 0..1"},
      {"drop=nan", "is no chance"},
      {"drop=1%", "is no chance"},
      {"drop=0.1:sideways", "\"sideways\" is no direction; there are to-host and to-device"},
      {"drop=0.1,drop=0.2:to-host", "is said twice"},
      {"drop=0.1,seed=1,seed=2", "is said twice"},
      {"seed=-1", "a seed is a whole number"},
      {"delay=0.1", "needs how long, as delay=0.01:200ms"},
      {"delay=0.1:5", "needs a unit"},
      {"cut@-1s", "a time is 0..1000000 s"},
      {"cut@1e9s", "a time is 0..1000000 s"},
      {"half-open@3s", "is no direction"},
      {"supply=9V", "needs its moment, as @3s"},
      {"supply=9kg@1s", "fault \"supply=9kg@1s\":"},
      {"payload=-1kg@1s", "a payload is 0..100 kg"},
      {"payload=100.1kg@1s", "a payload is 0..100 kg"},
      {"payload=1e300kg@1s", "a payload is 0..100 kg"},
      {"supply=-1V@1s", "a supply is 0..60 V"},
      {"supply=1e9V@1s", "a supply is 0..60 V"},
      {"load=J1:1e308Nm@1s", "a load is -1000..1000 Nm or N"},
      {"load=J1:-1001N@1s", "a load is -1000..1000 Nm or N"},
      {"block=J2@101rad@1s", "a place is -100..100 rad or -10..10 m"},
      {"block=J2@-6000deg@1s", "a place is -100..100 rad or -10..10 m"},
      {"block=J2@11m@1s", "a place is -100..100 rad or -10..10 m"},
      {"block=J9@1deg@1s", "\"J9\" is no joint; they are J1 to J8"},
      {"drop=0", "a chance of 0 says nothing"},
      {"flip=0:to-host", "a chance of 0 says nothing"},
      {"delay=0:1s", "a chance of 0 says nothing"},
      {"delay=0.1:0s", "a delay of 0 s says nothing"},
      {"cut@1s:0s", "a cut of 0 s says nothing"},
      {"half-open@1s:to-host:0ms", "a cut of 0 s says nothing"},
      {"seed=7", "says nothing without a chance"},
      {"cut@1s,seed=7", "says nothing without a chance"},
      {"block=2@1deg@1s", "\"2\" is no joint"},
      {"block=J2@1kg@1s", "is no place of a joint; write 20deg or 12mm"},
      {"block=J2@1s", "is no place of a joint"},
      {"magnet=J1@1s", "a magnet is on or off"},
      {"coupling=J1:off@1s", "a coupling slips or holds"},
      {"lead=J1:off@1s", "a lead is loose or fast"},
      {"unblock=J1:x@1s", "needs a joint and its moment only"},
      {"load=J1:5kg@1s", "fault \"load=J1:5kg@1s\":"},
      {"drop=0.1,,flip=0.1", "one comma too many"},
      {"drop=0.1,", "one comma too many"},
      {"", "an empty fault: it says nothing; write one, as drop=0.001"},
      {"  ", "an empty fault: it says nothing"}};
  for (const auto& [text, words] : mistakes) {
    const auto plan = parse_faults(text);
    ASSERT_FALSE(plan) << text;
    EXPECT_NE(plan.error().find(words), std::string::npos) << text << " -> " << plan.error();
  }
}

TEST(FaultText, an_item_that_says_again_what_holds_from_that_moment_is_a_mistake) {
  for (const std::string text :
       {"cut@1s,cut@1s", "cut@1s:2s,cut@1000ms:3s", "half-open@1s:to-host,half-open@1s:to-host:1s",
        "supply=9V@8s,supply=9V@8s", "supply=9V@8s,drop=0.1,supply=10V@8000ms",
        "payload=1kg@1s,payload=2kg@1s", "block=J2@1deg@1s,block=J2@2deg@1s",
        "block=J2@1deg@1s,unblock=J2@1s", "magnet=J3:off@2s,magnet=J3:on@2s",
        "load=J1:1Nm@0s,load=J1:1N@0s"}) {
    const auto plan = parse_faults(text);
    ASSERT_FALSE(plan) << text;
    const std::string last = text.substr(text.rfind(',') + 1);
    EXPECT_EQ(plan.error(), "fault \"" + last + "\": is said twice");
  }
  for (const std::string text :
       {"cut@1s:1s,cut@3s", "half-open@1s:to-host:1s,half-open@1s:to-device:1s",
        "supply=9V@8s,supply=9V@9s", "supply=9V@8s,payload=1kg@8s",
        "block=J2@1deg@1s,block=J1@1deg@1s", "block=J2@1deg@1s,load=J2:1Nm@1s"}) {
    EXPECT_TRUE(parse_faults(text)) << text;
  }
}

TEST(FaultText, the_bounds_themselves_are_read) {
  const FaultPlan plan = plan_of(
      "supply=0V@1s,supply=60V@2s,payload=0kg@1s,payload=100kg@2s,load=J1:-1000Nm@1s,"
      "load=J1:1000N@2s,block=J1@-100rad@1s,block=J2@10m@1s");
  const std::vector<double> values{0, 60, 0, 100, -1000, 1000, -100, 10};
  ASSERT_EQ(plan.disturbances.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(plan.disturbances[i].what.value, values[i]) << i;
  }
}

TEST(FaultText, what_is_printed_reads_back_as_the_same_plan) {
  test::for_random_cases(2000, [](test::Random& random) {
    FaultPlan plan;
    for (ByteFaults& faults : plan.link.bytes) {
      if (random.chance(0.5)) faults.drop = random.uniform(0, 1);
      if (random.chance(0.5)) faults.duplicate = 0.25;
      if (random.chance(0.5)) faults.flip = random.uniform(0, 1e-6);
      if (random.chance(0.5)) {
        faults.delay = 0.5;
        faults.delay_time = std::chrono::microseconds(random.integer(1, 10'000'000));
      }
    }
    for (std::int64_t i = random.integer(0, 3); i > 0; --i) {
      TimedByteFault fault;
      fault.kind = static_cast<TimedByteFault::Kind>(random.integer(0, 3));
      fault.at = std::chrono::milliseconds(4 * random.integer(0, 25'000) + i);
      fault.once = random.chance(0.5);
      if (!fault.once) fault.chance = random.uniform(0.001, 1);
      if (!fault.once && random.chance(0.5)) fault.until = fault.at + 7ms;
      if (random.chance(0.5)) fault.only = random.chance(0.5) ? kToHost : kToDevice;
      if (fault.kind == TimedByteFault::Kind::kDelay) fault.delay_time = 3ms;
      plan.link.timed.push_back(fault);
    }
    for (std::int64_t i = random.integer(0, 3); i > 0; --i) {
      // No two at one moment, which would be a mistake.
      LinkCut cut{std::chrono::milliseconds(4 * random.integer(0, 25'000) + i), std::nullopt,
                  std::nullopt};
      if (random.chance(0.5)) cut.lasts = std::chrono::nanoseconds(random.integer(1, 1LL << 40));
      if (random.chance(0.5)) cut.only = random.chance(0.5) ? kToHost : kToDevice;
      plan.link.cuts.push_back(cut);
    }
    for (std::int64_t i = random.integer(0, 4); i > 0; --i) {
      Disturbance what{.kind = static_cast<Disturbance::Kind>(random.integer(0, 7))};
      using Kind = Disturbance::Kind;
      const bool global = what.kind == Kind::kSupply || what.kind == Kind::kPayload;
      if (!global) what.joint = static_cast<std::int8_t>(random.integer(0, 7));
      if (what.kind == Kind::kMagnet || what.kind == Kind::kCoupling || what.kind == Kind::kLead) {
        what.value = random.chance(0.5) ? 1 : 0;
      } else if (what.kind != Kind::kUnblock) {
        what.value = random.uniform(global ? 0 : -3, 12);
      }
      plan.disturbances.push_back(
          {std::chrono::microseconds(5 * random.integer(0, 1LL << 30) + i), what});
    }
    const ByteFaults none;
    const bool chances = plan.link.bytes != std::array{none, none};
    if (chances && random.chance(0.5)) plan.link.seed = random.bits();
    const std::string text = to_text(plan);
    if (text.empty()) return random.discard();  // no faults at all
    const FaultPlan again = plan_of(text);
    EXPECT_EQ(again.link, plan.link) << text;
    ASSERT_EQ(again.disturbances.size(), plan.disturbances.size()) << text;
    for (std::size_t i = 0; i < plan.disturbances.size(); ++i) {
      EXPECT_EQ(again.disturbances[i].at, plan.disturbances[i].at) << text;
      EXPECT_EQ(again.disturbances[i].what.kind, plan.disturbances[i].what.kind) << text;
      EXPECT_EQ(again.disturbances[i].what.joint, plan.disturbances[i].what.joint) << text;
      EXPECT_EQ(again.disturbances[i].what.value, plan.disturbances[i].what.value) << text;
    }
    EXPECT_EQ(to_text(again), text);
  });
}

TEST(FaultText, any_text_is_read_or_refused_with_a_sentence) {
  static constexpr std::string_view kPieces[] = {
      "drop", "cut", "half-open", "=",  "@",   ":",     ",",  "J2",  "J", "0.1", "1e999", "..",
      "3s",   "ms",  "to-host",   "-1", "off", "block", "kg", "nan", " ", "\n",  "magnet"};
  static constexpr std::string_view kItems[] = {
      "drop=0.1", "cut@3s",         "block=J2@20deg@4s", "delay=0.01:3ms", "half-open@1s:to-host",
      "flip@3s",  "drop=0.1@1s..2s"};
  int accepted = 0;
  test::for_random_cases(20'000, [&](test::Random& random) {
    std::string text;
    for (std::int64_t i = random.integer(0, 4); i > 0; --i) {
      if (!text.empty()) text += ',';
      text += kItems[static_cast<std::size_t>(random.integer(0, std::ssize(kItems) - 1))];
    }
    for (std::int64_t i = random.integer(0, 4); i > 0; --i) {
      const auto piece = static_cast<std::size_t>(random.integer(0, std::ssize(kPieces) - 1));
      const auto place = static_cast<std::size_t>(random.integer(0, std::ssize(text)));
      text.insert(place, kPieces[piece]);
    }
    const auto plan = parse_faults(text);
    if (plan) {
      ++accepted;
      const std::string again = to_text(*plan);
      if (again.empty()) return random.discard();  // a chance of 0
      EXPECT_EQ(parse_faults(again)->link, plan->link) << text;
    } else {
      EXPECT_FALSE(plan.error().empty());
    }
  });
  EXPECT_GT(accepted, 1000) << "some are read";
  EXPECT_LT(accepted, 15'000) << "some are refused";
}

}  // namespace
}  // namespace sinew::sim
