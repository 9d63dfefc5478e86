#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sinew/planning/paths/tool_space.h"
#include "sinew/runtime/links/wire_monitor.h"
#include "sinew/runtime/running_cell.h"
#include "sinew/server/api/calibrations.h"
#include "sinew/server/files/event_file.h"
#include "sinew/server/files/event_log.h"
#include "sinew/server/files/keeper.h"
#include "sinew/server/json/camera_json.h"
#include "sinew/server/json/cube_reach.h"
#include "sinew/server/json/methods.h"
#include "sinew/server/json/preview.h"

namespace sinew::server {

/// A client for as long as it is connected; also who it is to the controllers. Never 0.
using SessionId = control::ClientId;

enum class Role : std::uint8_t { kViewer, kOperator };

/// When the message behind this one is due. A turn that came late does not slow the rate down, and
/// several that were missed are not made up for.
inline Instant next_due(Instant due, Duration interval, Instant now) {
  return std::max(due + interval, now);
}

/// What a connection can carry to its client.
enum class Delivery : std::uint8_t { kMessages, kAnswersOnly };

/// The running cell as clients see it: JSON-RPC texts in, texts out. It has no socket and no
/// thread: whoever owns it brings what clients say to receive(), calls poll() each few
/// milliseconds, and carries away what take_output() has. Everything waits for nobody; docs/api.md
/// has the methods.
class Api {
 public:
  static constexpr std::size_t kSessionsMax = 62;
  /// Each of them may stop each robot, beside the Api itself and a robot's job.
  static_assert(kSessionsMax + 2 <= runtime::Station::kSlots);
  /// Requests of a session that wait for an answer.
  static constexpr std::size_t kPendingMax = 32;
  /// Texts that wait for a session that does not read: answers beyond that end it.
  static constexpr std::size_t kOutputMax = 256;
  /// The same in bytes: an answer of records.read has a third of a megabyte.
  static constexpr std::size_t kOutputBytesMax = std::size_t{8} << 20;
  /// Of all sessions together: beyond it the one with the most is ended.
  static constexpr std::size_t kOutputAllMax = std::size_t{64} << 20;
  /// Messages that wait for work(), and their bytes; then a client is not read any more.
  static constexpr std::size_t kInboxMax = 256;
  static constexpr std::size_t kInboxBytesMax = std::size_t{256} << 10;
  /// Status and job messages are not made for a session that has so many to read.
  static constexpr std::size_t kOutputSlow = 8;

  /// @param cell, settings  outlive this. @param version  of the program
  /// @param event_file  keeps events beyond this process; empty: none
  Api(runtime::RunningCell& cell, std::string version, runtime::CellSettings* settings = nullptr,
      const std::string& event_file = {});
  ~Api();

  /// @return  nothing where as many as are served are there
  std::optional<SessionId> open(Role role, Delivery delivery = Delivery::kMessages);
  /// Its leases end, and with them what they moved.
  void close(SessionId session);
  bool knows(SessionId session) const { return sessions_.contains(session); }
  /// It has the lease of a robot, or a program of its own runs.
  bool holds(SessionId session) const;
  /// A session that gives way: it is closed before anything else that moves a robot, or a stop, of
  /// another one is done. One at a time.
  void yield(SessionId session);
  /// One message, whatever its bytes are. Stop and hold are done at once, all else by work(); what
  /// came before a stop of its robot and would begin to move it then ends as stopped.
  void receive(SessionId session, std::string_view text, Instant now);
  /// A session that has too many messages waiting is not read until this is true again.
  bool has_room(SessionId session) const;
  /// Nothing of it waits for work().
  bool settled(SessionId session) const;
  /// Does the next message that waits: of a session with a lease, then of each in turn.
  /// @return  whether more wait
  bool work(Instant now);
  /// Somebody waits for an answer, or has to hear of something soon: poll() each few milliseconds.
  bool hurries() const;
  void poll(Instant now);
  std::optional<std::string> take_output(SessionId session);
  /// It has not read what it asked for; whoever owns the connection ends it.
  bool too_slow(SessionId session) const;
  std::size_t sessions() const { return sessions_.size(); }
  const std::string& version() const { return version_; }

 private:
  /// A command under way, and who waits to hear of it.
  struct Pending {
    Json id;
    bool answered = true;
    std::size_t robot = 0;
    std::uint32_t command = 0;
    std::uint64_t group = 0;  ///< requests that wait for several robots
    bool at_start = false;    ///< that it has begun is answer enough
    bool epoch = false;       ///< the answer is the lease
    Json statement{};         ///< a statement of a position: its event, once it has an end
  };
  struct Watch {
    bool on = false;
    Duration interval{};  ///< zero: no status
    std::optional<std::size_t> robot;
    Instant next{};
    std::uint64_t event = 0;
    std::vector<runtime::JobView> jobs;  ///< as last told
    Instant job_next{};
    std::vector<runtime::ProcedureStatus> procedures;  ///< as last told
    Instant procedure_next{};
  };
  struct Subscription {
    Duration interval{};  ///< zero: no messages
    Instant next{};
    Json known = Json::object();  ///< of each object, as the client knows it
    std::uint64_t baskets = 0;    ///< revision that it knows
  };
  struct Message {
    std::string text;
    std::uint64_t number = 0;  ///< of all, in the order in which they came
  };
  struct Session {
    SessionId id = 0;
    Role role = Role::kViewer;
    Delivery delivery = Delivery::kMessages;
    std::map<std::size_t, std::unique_ptr<runtime::StationClient>> machines;
    std::vector<Pending> pending;
    std::deque<Message> inbox;
    std::size_t inbox_bytes = 0;  ///< in them
    std::deque<std::string> out;
    std::size_t out_bytes = 0;  ///< in them
    Watch watch;
    Subscription subscription;
    std::optional<Instant> renewed;
    bool too_slow = false;
  };
  struct Call {
    Session& session;
    const RpcRequest& request;
    Instant now;
    std::optional<std::size_t> robot;
  };
  /// Commands whose end is the answer.
  struct Later {
    std::vector<Pending> commands;
  };
  /// A preview under way: PreviewDesk has it, with its id.
  struct Elsewhere {
    PreviewWish wish;
  };
  /// Work of a desk, whose end is the answer.
  struct Errand {
    TaskDesk& desk;
    TaskDesk::Task task;
  };
  /// A result that is written already.
  struct Text {
    std::string json;
  };
  using Answer = std::variant<Json, Text, Later, Elsewhere, Errand, RpcError>;

  // api.cc
  void put(Session& session, std::string text);
  void answer(Session& session, const Json& id, bool answered, const Answer& what);
  Answer call(const Method& method, const Call& call);
  void handle(Session& session, const std::expected<RpcRequest, BadRequest>& request,
              std::uint64_t number, Instant now);
  bool overtaken(const Method& method, const Call& call, std::uint64_t number) const;
  Session* next_session();
  void finish_inbox(Session& session);
  void cut_off_largest();
  void give_way(const Method& method, SessionId session);
  std::expected<runtime::StationClient*, RpcError> machine(Session& session, std::size_t robot);
  void renew(Session& session, Instant now);
  void take_events(Session& session);
  void settle(Session& session, const Pending& pending, const control::ControlEvent& event);
  void log_statement(const Pending& pending, const control::ControlEvent& event);
  std::expected<bool, RpcError> moved(const Call& call) const;
  void take_answered();
  void take_answered(const Answered& done);
  void log_demonstration();
  void begin_events(const std::string& file);
  void keep_events();
  void log_events();
  void log_jobs();
  void log_job(std::size_t robot, const runtime::JobView& job);
  void tell(Session& session, Instant now);
  void tell_jobs(Session& session, Instant now);
  RpcError refusal(RpcCode code, const Error& error, std::size_t robot) const;
  Json status(std::size_t robot);
  /// Of one robot, or of all.
  Json cell_status(std::optional<std::size_t> robot = std::nullopt);
  Json job_status(std::size_t robot) const;
  Text events(std::uint64_t after) const;
  const std::string& status_text(std::optional<std::size_t> robot);
  static bool same(const runtime::JobView& a, const runtime::JobView& b);

  // api_objects.cc
  std::vector<std::string> object_names() const;
  std::optional<Json> object(std::string_view name);
  std::expected<Json, RpcError> objects(const Json& names);
  Answer query(const Call& call);
  Answer subscribe(const Call& call);
  void tell_objects(Session& session, Instant now);

  // api_methods.cc
  Answer look(const Method& method, const Call& call);
  Answer describe() const;
  Answer truth(const Call& call) const;
  Answer enable(const Call& call);
  Answer watch(const Call& call);
  std::expected<Duration, RpcError> message_interval(const Call& call) const;
  Answer stop(const Call& call);
  Answer jog(const Call& call);
  Answer declare(const Call& call);
  Answer free_drive(const Call& call);
  Answer nudge(const Call& call);
  Answer run_program(const Call& call);
  Answer ride(const Call& call);
  Answer start(const Call& call, runtime::JobOrder order);
  std::optional<RpcError> no_port(std::size_t robot) const;
  std::optional<RpcError> held_by_another(const Call& call, bool take_over) const;
  std::optional<RpcError> job_under_way(std::size_t robot) const;
  ClientLoss on_client_loss(std::size_t robot) const;
  Answer preview(const Call& call) const;
  std::optional<RpcError> may_not_resume(const Call& call, const runtime::JobView& job);
  Answer steer_job(const Method& method, const Call& call);
  Answer steer_motion(const Method& method, const Call& call);
  Answer give(const Call& call, const control::CommandWhat& what, bool at_start = false);
  std::expected<JointVector, RpcError> joints(const Json& numbers, std::size_t robot) const;

  // api_files.cc
  Errand at_files(std::function<Keeper::Result()> work);
  Answer keep(const Method& method, const Call& call);
  Answer keep_texts(const Method& method, const Call& call);
  Answer check_program(const Call& call);
  Answer import_program(const Call& call);
  Answer export_program(const Call& call);
  Answer keep_settings(const Method& method, const Call& call);
  // api_device.cc
  Json device_status(std::size_t robot) const;
  Answer read_wire(const Call& call);
  std::string wire_text(std::size_t robot, std::uint64_t since, std::uint64_t limit);
  void forget_wires(Instant now);

  // api_camera.cc
  std::expected<std::size_t, RpcError> camera_of(const Call& call) const;
  Answer look_through(const Call& call);
  static Answer print_sheet(const Call& call);
  Answer calibrate(const Method& method, const Call& call);
  std::optional<RpcError> job_under_way_anywhere() const;

  // api_cubes.cc
  Answer judge_cubes(const Call& call);
  Answer cube_reach(const Call& call);
  Answer move_basket(const Call& call);
  Answer trouble_camera(const Call& call);

  // api_procedures.cc
  Json procedure(std::size_t robot) const;
  Answer start_procedure(const Call& call);
  Answer steer_procedure(const Method& method, const Call& call);
  void poll_procedures();
  void tell_procedures(Session& session, Instant now);

  runtime::RunningCell& cell_;
  std::unique_ptr<PreviewDesk> previews_;
  Keeper keeper_;
  TaskDesk files_;        ///< the keeper's
  TaskDesk checks_;       ///< of programs
  ShownTags shown_tags_;  ///< of pictures_' thread
  TaskDesk pictures_;     ///< of cameras
  TaskDesk verdicts_;     ///< of cubes
  /// Of baskets that are moved: a person waits for it, and not for all verdicts before it.
  TaskDesk moves_{TaskDesk::kWaitingMax, io::Share::kServing};
  CubeReachDesk reach_{cell_};
  Calibrations calibrations_;  ///< of calibrating_'s thread
  TaskDesk calibrating_;
  std::size_t asked_ = 0;               ///< previews and tasks under way
  std::uint64_t messages_ = 0;          ///< that came, ever
  std::size_t inbox_ = 0;               ///< messages that wait
  std::size_t out_bytes_ = 0;           ///< texts that wait, of all sessions
  std::vector<std::uint64_t> stopped_;  ///< of each robot: the number of its last stop or hold
  SessionId served_ = 0;                ///< whose message was done last
  bool holder_first_ = true;            ///< a session with a lease is next
  std::string version_;
  std::string open_rpc_;             ///< written when it is asked for first; never changes
  std::vector<std::string> models_;  ///< of each robot, as open_rpc_
  SessionId last_session_ = 0;
  std::uint64_t last_group_ = 0;
  std::map<SessionId, Session> sessions_;
  std::optional<SessionId> yielding_;
  EventLog log_;
  std::shared_ptr<EventFile> event_file_;             ///< of files_' thread; null: none
  std::uint64_t event_kept_ = 0;                      ///< the last one that was given to it
  std::vector<std::optional<std::uint8_t>> ears_;     ///< a slot of each station: what concerns all
  std::vector<runtime::JobView> jobs_;                ///< as last logged
  std::vector<runtime::ProcedureStatus> procedures_;  ///< the same
  std::vector<std::unique_ptr<planning::ToolSpace>> tools_;
  std::vector<planning::PoseBT> X_near_;
  std::vector<std::optional<double>> jaws_;  ///< m, that tools_ are for
  /// Status messages of this turn, made once for all who watch: of each robot, and of all.
  std::vector<std::string> status_texts_;
  /// Of the thread that reads wires: of those that are looked at.
  std::vector<std::unique_ptr<runtime::WireMonitor>> monitors_;
  std::optional<Instant> wires_read_;  ///< last
  TaskDesk wires_{kSessionsMax * TaskDesk::kOfOneMax};
};

}  // namespace sinew::server
