#pragma once

#include <expected>
#include <memory>
#include <string>
#include <string_view>

#include "sinew/program/procedures/procedure_view.h"
#include "sinew/runtime/commissioning_file.h"
#include "sinew/runtime/station_client.h"

namespace sinew::runtime {

struct ProcedureOrder {
  std::string kind;        ///< home, recover, commission
  bool take_over = false;  ///< the lease, from whoever has it
  bool anew = false;       ///< without what was answered of a list that was broken off
};

/// Where commissioning leaves what it finds, and with what of it the robot runs.
struct ResultsPlace {
  std::string file;      ///< empty: nothing is kept
  std::string settings;  ///< the file whose settings are in the robot's model; empty: none
};

/// A procedure as it is now.
struct ProcedureStatus {
  std::uint32_t number = 0;  ///< 0: there was none yet
  control::ClientId client = 0;
  bool over = true;  ///< nothing of it moves any more
  /// Answers, steps back and other clients that were taken: what has fewer was told before.
  std::size_t answers = 0;
  program::ProcedureView view;
  std::string file;  ///< that its results went to; empty where none did
  program::FoundSettings settings;
  std::string note;  ///< why its results were not kept; empty where they were
};

/// Goes through procedures on a station, one at a time, under the lease of the client that asked
/// for it, which it does not keep alive. A procedure outlives its client: it waits at its step for
/// the next one. All from one thread, and nothing waits but the destructor.
class ProcedureRunner {
 public:
  /// @param station, clock  outlive this
  ProcedureRunner(Station& station, const io::Clock& clock, ResultsPlace place);
  /// Ends what runs. The station has to be alive: it still looks at the motion.
  ~ProcedureRunner();
  ProcedureRunner(const ProcedureRunner&) = delete;
  ProcedureRunner& operator=(const ProcedureRunner&) = delete;

  /// @error  a sentence: one is under way, this robot has no such procedure, its results could not
  ///         be kept, too many clients
  std::expected<void, std::string> start(const ProcedureOrder& order, control::ClientId client);
  /// Goes on where it is, under the lease that it asks for in the name of this client. Without
  /// effect where nothing is under way.
  void go_on(control::ClientId client, bool take_over);
  /// @error  a sentence; nothing moves then, and the question stands
  std::expected<void, std::string> answer(std::string_view text);
  std::expected<void, std::string> back();
  /// Without effect where nothing is under way.
  void cancel();
  void poll();

  bool over() const { return status_.over; }
  /// The one under way, or the last one.
  const ProcedureStatus& status() const { return status_; }

 private:
  std::expected<program::ProcedurePlan, std::string> plan_for(const std::string& kind) const;
  std::expected<CommissioningFile, std::string> read_before() const;
  std::expected<void, std::string> taken(std::expected<void, std::string> what);
  void publish();
  void keep_results();

  Station& station_;
  const io::Clock& clock_;
  ResultsPlace place_;
  ProcedureStatus status_;
  bool kept_ = false;  ///< results, of the procedure as it stands
  CommissioningFile before_;
  std::unique_ptr<StationClient> client_;
  std::unique_ptr<program::Procedure> procedure_;
};

}  // namespace sinew::runtime
