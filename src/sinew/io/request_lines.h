#pragma once

#include <optional>
#include <string>

namespace sinew::io {

/// Lines that somebody types (or pipes) into stdin while a loop runs; never waits. A stdin that is
/// closed, empty or not there just has no lines.
class RequestLines {
 public:
  std::optional<std::string> next();
  /// There will never be another one.
  bool ended() const { return ended_; }

 private:
  std::string pending_;
  bool ended_ = false;
};

}  // namespace sinew::io
