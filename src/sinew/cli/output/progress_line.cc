#include "sinew/cli/output/progress_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "sinew/cli/output/program_report.h"
#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

constexpr int kBarWidth = 28;
constexpr double kMinutesFrom = 100;  // s

std::string bar(double share) {
  const auto full = static_cast<int>(std::clamp(share, 0.0, 1.0) * kBarWidth);
  return std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(kBarWidth - full), '.');
}

/// @param line  of the order; of a called program with its name
std::string order_text(std::size_t done, std::size_t planned, const program::Order& order,
                       const std::string& line) {
  return fmt::format("order {} of {}, line {}, round {}/{}", done + 1, planned, line, order.round,
                     order.rounds);
}

void tell_done(std::size_t place, std::size_t planned, const program::Record& record,
               const std::string& line) {
  std::fputs(
      fmt::format("  {:>3}/{} line {} round {}/{} done after {:.2f} s\n", place + 1, planned, line,
                  record.order->round, record.order->rounds, to_seconds(record.done - record.asked))
          .c_str(),
      stderr);
}

}  // namespace

std::string elapsed_text(double seconds) {
  return seconds < kMinutesFrom ? fmt::format("{:.0f} s", std::floor(seconds))
                                : fmt::format("{:.0f} min", std::floor(seconds / 60));
}

std::string at_most_text(double seconds) {
  return seconds < kMinutesFrom ? fmt::format("at most {:.0f} s", std::ceil(seconds))
                                : fmt::format("at most {:.0f} min", std::ceil(seconds / 60));
}

std::string homing_text(const std::string& joint, double elapsed_s, double at_most_s) {
  std::string text = "homing" + (joint.empty() ? "" : " " + joint) + " (" + elapsed_text(elapsed_s);
  if (at_most_s > 0) text += " of " + at_most_text(at_most_s);
  return text + ")";
}

ProgressLine::ProgressLine(bool quiet, std::string waits_for)
    : quiet_(quiet), waits_for_(std::move(waits_for)), live_(io::stderr_is_terminal()) {}

ProgressLine::~ProgressLine() {
  end();
}

void ProgressLine::end() {
  if (dirty_) std::fputs("\r\033[K", stderr);
  dirty_ = false;
}

void ProgressLine::show(const program::Run& run, const RobotModel& model, Instant now) {
  using Phase = program::Run::Phase;
  if (quiet_) return;
  tell_wait(run, now);
  tell_notices(run, model);
  const auto& plan = run.plan();
  for (; !live_ && told_ < run.records().size(); ++told_) {
    const auto& record = run.records()[told_];
    tell_done(told_, plan.orders.size(), record, first_line(*record.order, run));
  }
  if (!due(now)) return;
  const double share = run.progress(now);
  const double total = plan.duration + plan.homing_max;
  View shown{.opening = run.phase() == Phase::kOpening,
             .stopping = run.phase() == Phase::kStopping,
             .share = share,
             .amount = fmt::format("{:5.1f} of {}{:.1f} s", share * total,
                                   plan.homing_max > 0 ? "at most " : "", total),
             .under_way = {},
             .orders_done = run.records().size()};
  if (run.under_way()) {
    const auto& record = *run.under_way();
    shown.under_way = order_text(run.records().size(), plan.orders.size(), *record.order,
                                 first_line(*record.order, run));
    if (const auto* home = std::get_if<program::HomeOrder>(&record.order->what)) {
      const auto joint = run.machine().homing_joint();
      shown.under_way += ", " + homing_text(joint ? model.joints[*joint].name : "",
                                            to_seconds(now - record.asked), home->duration_max);
    }
  }
  show_live(shown, now);
}

/// A device that finishes a move of the run before, and may report nothing meanwhile.
void ProgressLine::tell_wait(const program::Run& run, Instant now) {
  constexpr Duration kWorthSaying = std::chrono::seconds(2);
  const auto until = run.machine().goes_on_until();
  const bool waits = run.phase() == program::Run::Phase::kOpening && until;
  if (wait_told_ || !waits || *until - now < kWorthSaying) return;
  wait_told_ = true;
  const std::string text =
      fmt::format("{}  note: the device may still be finishing a move of the run before, {}\n",
                  dirty_ ? "\r\033[K" : "", at_most_text(to_seconds(*until - now)));
  std::fputs(text.c_str(), stderr);
}

/// Each on a line of its own, above the one that is written over.
void ProgressLine::tell_notices(const program::Run& run, const RobotModel& model) {
  for (; notices_told_ < run.notices().size(); ++notices_told_) {
    const std::string text = notice_text(run.notices()[notices_told_], run, model);
    std::fputs(((dirty_ ? "\r\033[K  note: " : "  note: ") + text + "\n").c_str(), stderr);
  }
}

void ProgressLine::show_live(const View& view, Instant now) {
  next_ = now + std::chrono::milliseconds(100);
  dirty_ = true;
  if (view.opening) {
    std::fputs(("\r  waiting for " + waits_for_ + " ...\033[K").c_str(), stderr);
    return;
  }
  std::string line = fmt::format("\r  [{}] {}   {}", bar(view.share), view.amount, view.under_way);
  if (view.stopping) line += "   stopping";
  std::fputs((line + "\033[K").c_str(), stderr);
}

}  // namespace sinew::cli
