#include "system/system_run.h"

#include <gtest/gtest-spi.h>

#include <algorithm>
#include <sstream>

#include "sinew/core/dispatch.h"
#include "sinew/runtime/links/robot_variant.h"
#include "support/robots.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;

struct Kind {
  const char* robot;
  const char* profile;  ///< null: its default
  const char* wire;     ///< the same
};
constexpr Kind kKinds[] = {{"hexapod", nullptr, nullptr},
                           {"bigrobotarm", "document", nullptr},
                           {"learm", "bus", nullptr},
                           {"bigrobotarm", "sinew", "framed"}};

std::optional<std::string> name_of(const char* name) {
  return name == nullptr ? std::nullopt : std::optional<std::string>(name);
}

/// A generator's own step is added to its state: seeds that differ by it are one stream, shifted.
std::uint64_t stream_of(std::uint64_t seed, std::size_t robot) {
  Random random(seed * std::size(kKinds) + robot);
  return random.bits();
}

/// The run itself; what breaks a promise says so by GoogleTest's means.
class Run {
 public:
  Run(const SystemPlan& plan, SystemCounts& counts, const testing::TestPartResultArray& failures)
      : plan_(plan), failures_(failures) {
    robots_.reserve(std::size(kKinds));
    for (std::size_t k = 0; k < std::size(kKinds); ++k) {
      robots_.push_back(runtime::variant_of(robot(kKinds[k].robot), name_of(kKinds[k].profile),
                                            name_of(kKinds[k].wire))
                            .value());
      if ((plan.robots >> k & 1) == 0) continue;
      stations_.push_back(std::make_unique<Station>(robots_[k], name_of(kKinds[k].profile),
                                                    stream_of(plan.seed, k), counts, hash_));
      if (plan.supplies) stations_.back()->let_supplies_sink();
      stations_.back()->spare(plan.spared, k * kMisfortunesMax);
    }
  }

  void go(SystemCounts& counts) {
    for (Duration t{}; t < plan_.time && fine(); t += kSlice) {
      for (const auto& station : stations_) station->slice(kSlice);
      look_for_planted();
    }
    for (const auto& station : stations_) station->heal();
    for (const auto& station : stations_) {
      for (Duration t{}; t < 120s && !station->ready() && fine(); t += kSlice) {
        station->slice(kSlice);
      }
      if (!fine()) return;  // it was not waited for
      EXPECT_TRUE(station->ready()) << station->where() << " never came back";
      counts.back += station->ready() ? 1 : 0;
    }
  }

  std::uint64_t hash() const { return hash_.value(); }
  std::vector<Misfortune> misfortunes() const {
    std::vector<Misfortune> all;
    for (const auto& station : stations_) {
      all.insert(all.end(), station->misfortunes().begin(), station->misfortunes().end());
    }
    return all;
  }

 private:
  static constexpr Duration kSlice = 20ms;
  static constexpr std::uint64_t kMisfortunesMax = 1'000'000;  ///< of one robot

  bool fine() const { return failures_.size() == 0; }
  void look_for_planted() const {
    if (plan_.planted.empty()) return;
    for (const Misfortune& one : misfortunes()) {
      if (one.text.contains(plan_.planted)) ADD_FAILURE() << "planted: " << one.text;
    }
  }

  const SystemPlan& plan_;
  const testing::TestPartResultArray& failures_;
  TraceHash hash_;
  std::vector<RobotModel> robots_;
  std::vector<std::unique_ptr<Station>> stations_;
};

}  // namespace

SystemRun run_system(const SystemPlan& plan, SystemCounts& counts) {
  take_vectors(Vectors::kPortable);
  testing::TestPartResultArray told;
  SystemRun result;
  {
    const testing::ScopedFakeTestPartResultReporter listener(
        testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &told);
    Run run(plan, counts, told);
    run.go(counts);
    result.hash = run.hash();
    result.misfortunes = run.misfortunes();
  }
  for (int k = 0; k < told.size(); ++k) {
    if (told.GetTestPartResult(k).failed()) {
      result.failures.emplace_back(told.GetTestPartResult(k).message());
    }
  }
  return result;
}

SystemPlan shrunk(SystemPlan plan, int tries) {
  const auto fails = [&](const SystemPlan& candidate) {
    SystemCounts counts;
    return tries-- > 0 && !run_system(candidate, counts).failures.empty();
  };
  for (std::size_t k = 0; k < std::size(kKinds); ++k) {
    const unsigned robot = 1U << k;
    SystemPlan fewer = plan;
    fewer.robots &= ~robot;
    if (fewer.robots != 0 && fails(fewer)) plan = fewer;
  }
  for (Duration less = plan.time / 2; less >= 100ms; less /= 2) {
    SystemPlan shorter = plan;
    shorter.time -= less;
    if (shorter.time > 0s && fails(shorter)) plan = shorter;
  }
  // Half of them at once, then a quarter, ... and one by one.
  SystemCounts counts;
  std::vector<std::uint64_t> left;
  for (const Misfortune& one : run_system(plan, counts).misfortunes) left.push_back(one.number);
  for (std::size_t part = (left.size() + 1) / 2; part > 0 && tries > 0; part /= 2) {
    for (std::size_t begin = 0; begin < left.size();) {
      SystemPlan fewer = plan;
      const std::size_t end = std::min(begin + part, left.size());
      fewer.spared.insert(left.begin() + static_cast<std::ptrdiff_t>(begin),
                          left.begin() + static_cast<std::ptrdiff_t>(end));
      if (fails(fewer)) {
        plan = fewer;
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(begin),
                   left.begin() + static_cast<std::ptrdiff_t>(end));
      } else {
        begin = end;
      }
    }
  }
  return plan;
}

std::string describe(const SystemPlan& plan, const SystemRun& run) {
  std::ostringstream text;
  text << "robots";
  for (std::size_t k = 0; k < std::size(kKinds); ++k) {
    if ((plan.robots >> k & 1) != 0) text << ' ' << kKinds[k].robot;
  }
  text << ", " << to_seconds(plan.time) << " s, " << run.misfortunes.size() << " misfortunes ("
       << plan.spared.size() << " spared)";
  for (const Misfortune& one : run.misfortunes) text << "\n    " << one.text;
  return text.str();
}

}  // namespace sinew::test
