#include "sinew/cli/progress_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "sinew/io/standard_streams.h"

namespace sinew::cli {
namespace {

constexpr int kBarWidth = 28;

std::string bar(double share) {
  const auto full = static_cast<int>(std::clamp(share, 0.0, 1.0) * kBarWidth);
  return std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(kBarWidth - full), '.');
}

template <class Order>
std::string order_text(std::size_t done, std::size_t planned, const Order& order) {
  return fmt::format("order {} of {}, line {}, round {}/{}", done + 1, planned, order.line,
                     order.round, order.rounds);
}

template <class Record>
void tell_done(std::size_t place, std::size_t planned, const Record& record) {
  std::fputs(fmt::format("  {:>3}/{} line {} round {}/{} done after {:.2f} s\n", place + 1, planned,
                         record.order->line, record.order->round, record.order->rounds,
                         to_seconds(record.done - record.asked))
                 .c_str(),
             stderr);
}

}  // namespace

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), live_(io::stderr_is_terminal()) {}

ProgressLine::~ProgressLine() {
  if (dirty_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::show(const runtime::SessionView& view) {
  using Phase = sequence::Run::Phase;
  const auto& [run, now] = view;
  const auto& plan = run.plan();
  if (quiet_) return;
  for (; !live_ && told_ < run.records().size(); ++told_) {
    tell_done(told_, plan.orders.size(), run.records()[told_]);
  }
  if (!due(now)) return;
  const double done = run.progress(now);
  View shown{.opening = run.phase() == Phase::kOpening,
             .stopping = run.phase() == Phase::kStopping,
             .share = plan.duration > 0 ? done / plan.duration : 1,
             .amount = fmt::format("{:5.1f} of {:.1f} s", done, plan.duration),
             .under_way = {},
             .orders_done = run.records().size()};
  if (const auto record = run.under_way()) {
    shown.under_way = order_text(run.records().size(), plan.orders.size(), *record->order);
  }
  show_live(shown, now);
}

void ProgressLine::show(const program::Run& run, Instant now) {
  using Phase = program::Run::Phase;
  if (quiet_) return;
  const auto& plan = run.plan();
  for (; !live_ && told_ < run.records().size(); ++told_) {
    tell_done(told_, plan.orders.size(), run.records()[told_]);
  }
  if (!due(now)) return;
  const double share = run.progress(now);
  View shown{.opening = run.phase() == Phase::kOpening,
             .stopping = run.phase() == Phase::kStopping,
             .share = share,
             .amount = fmt::format("{:5.1f} of {:.1f} s", share * plan.duration, plan.duration),
             .under_way = {},
             .orders_done = run.records().size()};
  if (run.under_way()) {
    shown.under_way = order_text(run.records().size(), plan.orders.size(), *run.under_way()->order);
  }
  show_live(shown, now);
}

void ProgressLine::show_live(const View& view, Instant now) {
  next_ = now + std::chrono::milliseconds(100);
  dirty_ = true;
  if (view.opening) {
    std::fputs("\r  waiting for the device ...\033[K", stderr);
    return;
  }
  std::string line = fmt::format("\r  [{}] {}   {}", bar(view.share), view.amount, view.under_way);
  if (view.stopping) line += "   stopping";
  std::fputs((line + "\033[K").c_str(), stderr);
}

}  // namespace sinew::cli
