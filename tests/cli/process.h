#pragma once

#include <sys/types.h>

#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace sinew::test {

using Json = nlohmann::json;
using Arguments = std::vector<std::string>;

/// How a process ended. `exit` is minus the signal where one killed it.
struct Ended {
  int exit = 0;
  std::string out;
  std::string err;

  /// stdout as one JSON document; a failure and null where it is none.
  Json json() const;
  /// It gave up because something came too late: what a computer that others keep busy does to two
  /// processes that talk in real time. Then it may be tried again.
  bool was_late() const;
};

/// So often, in all, is something tried that was late.
inline constexpr int kTriesWhereLate = 4;

/// Where the three streams of a process go; a path, "" for this object's own keeping, or "closed".
struct Streams {
  std::string out{};
  std::string err{};
  int in = -1;  ///< an open file; -1: the standard input of the test itself
};

/// What is typed into a process, as its Streams::in.
class Typed {
 public:
  Typed();
  ~Typed();
  Typed(const Typed&) = delete;
  Typed& operator=(const Typed&) = delete;

  int in() const { return ends_[0]; }
  void say(const std::string& text) const;
  /// Nothing more will come.
  void end();

 private:
  std::array<int, 2> ends_{-1, -1};
};

/// The built `sinew` under way. Whoever forgets to end it kills it.
class Process {
 public:
  explicit Process(const Arguments& arguments, const Streams& streams = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const;
  /// What was on stdout when it was last waited for.
  const std::string& out() const { return out_.text; }
  /// Waits until stdout (stderr) holds `text`; a failure after 10 s.
  void wait_for_out(const std::string& text) { wait_for(out_, text); }
  void wait_for_err(const std::string& text) { wait_for(err_, text); }
  /// The first whole line of stdout behind so many characters of it; a failure after 10 s.
  std::string line_after(std::size_t position);
  /// Lets it run for so long, and takes what it says meanwhile.
  void let_run(std::chrono::milliseconds time);
  /// The end of the process; a failure and its death after 300 s.
  Ended end();

 private:
  struct Output {
    int file = -1;  ///< of the pipe from it; -1 where it has been closed
    std::string text;
  };
  /// Reads what comes first, on either stream; false where nothing did until `limit`.
  bool pump(std::chrono::steady_clock::time_point limit);
  void wait_for(const Output& output, const std::string& text);

  pid_t pid_ = -1;
  Output out_;
  Output err_;
};

/// One call of `sinew` from its start to its end.
Ended sinew(const Arguments& arguments, const Streams& streams = {});

/// A call that must succeed with one JSON document on stdout and nothing on stderr.
Json answer(Arguments arguments);

}  // namespace sinew::test
