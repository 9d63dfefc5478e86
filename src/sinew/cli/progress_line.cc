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

}  // namespace

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), live_(io::stderr_is_terminal()) {}

ProgressLine::~ProgressLine() {
  if (dirty_) std::fputs("\r\033[K", stderr);
}

void ProgressLine::show(const runtime::SessionView& view) {
  if (quiet_) return;
  if (live_) {
    show_live(view);
    return;
  }
  const auto records = view.run.records();
  for (; told_ < records.size(); ++told_) {
    const auto& record = records[told_];
    std::fputs(fmt::format("  {:>3}/{} line {} round {}/{} done after {:.2f} s\n", told_ + 1,
                           view.run.plan().orders.size(), record.order->line, record.order->round,
                           record.order->rounds, to_seconds(record.done - record.asked))
                   .c_str(),
               stderr);
  }
}

void ProgressLine::show_live(const runtime::SessionView& view) {
  using Phase = sequence::Run::Phase;
  if (view.now < next_) return;
  next_ = view.now + std::chrono::milliseconds(100);
  dirty_ = true;
  if (view.run.phase() == Phase::kOpening) {
    std::fputs("\r  waiting for the device ...\033[K", stderr);
    return;
  }
  const auto& plan = view.run.plan();
  const double done = view.run.progress(view.now);
  std::string line =
      fmt::format("\r  [{}] {:5.1f} of {:.1f} s", bar(plan.duration > 0 ? done / plan.duration : 1),
                  done, plan.duration);
  if (const auto record = view.run.under_way()) {
    line += fmt::format("   order {} of {}, line {}, round {}/{}", view.run.records().size() + 1,
                        plan.orders.size(), record->order->line, record->order->round,
                        record->order->rounds);
  }
  if (view.run.phase() == Phase::kStopping) line += "   stopping after this motion";
  std::fputs((line + "\033[K").c_str(), stderr);
}

}  // namespace sinew::cli
