#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "sinew/program/plans/bullride.h"
#include "sinew/program/runs/program_run.h"
#include "sinew/runtime/station_client.h"

namespace sinew::runtime {

/// What somebody wants to have run.
struct JobOrder {
  std::string title;  ///< as it is shown: the program's name
  program::Program program;
  /// Instead of the program: made where the machine stands, or from its home where nobody knows.
  std::optional<program::RideOrder> ride;
  std::optional<program::Statement> standing_at;
  bool take_over = false;    ///< the lease, from whoever has it
  bool single_step = false;  ///< pauses behind each order
  bool recorded = true;      ///< leaves a record where jobs do, and faults meanwhile too
  double feed = 1;           ///< share (0, 1] of all motions' pace, through the feed
  /// Motions can be paused and slowed down under way; they take up to an eighth longer.
  bool changeable = true;
  ClientLoss on_client_loss = ClientLoss::kPause;
  std::optional<RecordPlace> record{};  ///< nothing: the station's own
  /// In the job's thread: after each cycle, and once when nothing of it moves any more.
  std::function<void(const program::Run&, Instant)> look{};
  std::function<void(const program::Run&, Instant)> ended{};
};

/// A job as it was a moment ago.
struct JobView {
  std::uint32_t id = 0;          ///< 0: there was none yet
  control::ClientId client = 0;  ///< under whose lease it runs
  bool client_lost = false;      ///< and that is gone: it waits for another who resumes it
  control::ClientId guard = 0;   ///< who alone may resume it; 0: anyone
  std::string title;
  bool handles_cubes = false;  ///< a row of it looks, picks or places
  program::Run::Phase phase = program::Run::Phase::kOpening;
  bool paused = false;
  std::optional<Error> paused_by = std::nullopt;  ///< why, where it paused by itself
  bool over = true;                               ///< nothing of it moves any more
  int line = 0;  ///< of the order under way or, between two, the next one; or that failed
  std::size_t orders_done = 0;
  std::size_t orders = 0;
  double duration = 0;            ///< s, predicted; homing not counted
  double homing_max = 0;          ///< s
  bool planned = false;           ///< its duration is known, and that all of it can be carried out
  bool begun = false;             ///< its first order was sent
  planning::LimitTimes limits{};  ///< what holds its motions back
  double progress = 0;
  double elapsed = 0;  ///< s, since its first order, without the time that it was held
  std::optional<program::Refusal> failure = std::nullopt;
  std::vector<std::string> remedies{};  ///< what would work instead of what failed, as rows
  /// What in its cell a motion would have met: why it failed, or waits.
  std::optional<CellRefusal> in_the_way = std::nullopt;
  bool waits_for_room = false;
  std::optional<control::StopCause> stopped_by = std::nullopt;
  std::size_t notices = 0;
  std::optional<program::Notice> last_notice = std::nullopt;
  std::vector<program::ProgramNote> notes{};  ///< of its text
  std::size_t wishes = 0;                     ///< pause, resume, steps: so many were heard
  /// Why the last wish was not done; a step back may be impossible.
  std::optional<program::Refusal> wish_refused = std::nullopt;
};

/// Runs programs on a station, one at a time, each planned in a thread of this, under the lease of
/// the client that asked for it. A job outlives its client: where the lease is lost it is held, and
/// goes on under the lease of whoever resumes it. With ClientLoss::kContinue it keeps its lease
/// alive itself.
class JobRunner {
 public:
  /// @param station, clock  outlive this
  JobRunner(Station& station, const io::Clock& clock) : station_(station), clock_(clock) {}
  /// Stops what runs. The station has to be alive: it still looks at the motion.
  ~JobRunner();
  /// What programs look with from the next job on; outlives this. Any thread.
  void see_by(program::Eyes& eyes) { eyes_ = &eyes; }
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;

  /// @return its id. @error kBusy: there is one, or no place for another client
  Expected<std::uint32_t> start(JobOrder order, control::ClientId client);
  /// Without effect where the job is not the one under way.
  void stop(std::uint32_t id);
  /// @param guard  who alone may resume it, as far as resume() is asked; 0: anyone. Another
  ///               client's guard stays
  void pause(std::uint32_t id, control::ClientId guard = 0);
  /// @param client  under whose lease it goes on where its own client has lost it
  void resume(std::uint32_t id, control::ClientId client = 0);
  /// The next order, then a pause.
  void step(std::uint32_t id, control::ClientId client = 0);
  /// While paused between two orders: to where the last one began, and a pause there.
  void step_back(std::uint32_t id, control::ClientId client = 0);

  /// The job under way, or the last one.
  JobView view() const;

 private:
  enum class Wish : std::uint8_t { kNone, kPause, kResume, kStep, kStepBack, kStop };

  void work(const JobOrder& order, StationClient& client);
  void run(const JobOrder& order, const program::Program& program, StationClient& client);
  void obey(program::Run& run, StationClient& client, Instant now);
  bool goes_on(program::Run& run, StationClient& client, control::ClientId under);
  void publish(const program::Run& run, Instant now);
  void wish(std::uint32_t id, Wish what, control::ClientId client = 0);

  Station& station_;
  const io::Clock& clock_;
  std::atomic<program::Eyes*> eyes_ = nullptr;
  std::thread thread_;
  mutable std::mutex mutex_;
  JobView view_;                  ///< under the mutex
  Wish wish_ = Wish::kNone;       ///< under the mutex
  control::ClientId wisher_ = 0;  ///< under the mutex
  bool abandoned_ = false;        ///< under the mutex
  // Of the thread that runs.
  std::size_t wishes_ = 0;
  std::optional<program::Refusal> wish_refused_;
};

}  // namespace sinew::runtime
