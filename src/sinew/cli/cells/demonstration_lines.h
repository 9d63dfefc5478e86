#pragma once

#include <vector>

#include "sinew/core/instant.h"
#include "sinew/server/api/demonstration.h"

namespace sinew::cli {

/// How a demonstration gets on, on stderr: one line that is written over on a terminal, a line a
/// round into a log.
class DemonstrationLines {
 public:
  /// @param shown  outlives this
  explicit DemonstrationLines(const server::Demonstration& shown);
  ~DemonstrationLines();
  DemonstrationLines(const DemonstrationLines&) = delete;
  DemonstrationLines& operator=(const DemonstrationLines&) = delete;

  /// @param now  real time
  void show(Instant now);

 private:
  void tell(const std::string& line);

  const server::Demonstration& shown_;
  std::vector<server::Demonstration::Part> told_;
  bool live_;
  bool dirty_ = false;
  bool told_end_ = false;
  Instant next_{};
};

}  // namespace sinew::cli
