#pragma once

#include <cstddef>

#include "sinew/runtime/sequence_session.h"

namespace sinew::cli {

/// How a run gets on, on stderr: one line that is written over on a terminal, a line per motion
/// into a log.
class ProgressLine {
 public:
  explicit ProgressLine(bool quiet);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const runtime::SessionView& view);

 private:
  void show_live(const runtime::SessionView& view);

  bool quiet_;
  bool live_;
  bool dirty_ = false;
  std::size_t told_ = 0;
  Instant next_{};
};

}  // namespace sinew::cli
