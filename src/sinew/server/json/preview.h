#pragma once

#include <condition_variable>
#include <cstdint>
#include <expected>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sinew/program/formats/text_forms.h"
#include "sinew/program/language/program_file.h"
#include "sinew/program/plans/program_plan.h"
#include "sinew/runtime/running_cell.h"
#include "sinew/server/json/json_rpc.h"
#include "sinew/server/json/task_desk.h"

/// What a program would do if it ran now: planned, looked at in its cell, timed and sampled, and
/// nothing moves.
namespace sinew::server {

struct PreviewWish {
  std::size_t robot = 0;  ///< of the cell
  program::Program program;
  std::string text;           ///< what it was read from
  program::Standing from;     ///< where the robot stands; nothing: nobody knows
  std::size_t samples = 121;  ///< at most, 2 at least
};

/// A preview or its refusal, in this thread; takes milliseconds, a long program seconds.
/// @error  kRefused with what `sinew plan` would refuse, kInvalidParams: no row that moves
std::expected<Json, RpcError> preview(const runtime::RunningCell& cell, const PreviewWish& wish);

/// A plan's refusal with its place and joints that would work instead.
Json refusal_json(const program::Refusal& refusal, const RobotModel& model);
/// The same with rows that would work, as `data` has it.
/// @param met  what it meets in its cell
RpcError refused_plan(const program::Refusal& refusal, const RobotModel& model,
                      const std::optional<runtime::CellRefusal>& met);

/// The form that a request says of its text, or else the text's first word.
std::expected<const program::TextForm*, RpcError> asked_form(const RpcRequest& request,
                                                             const RobotModel& model);
/// Why a text is no program.
RpcError no_form(const program::NoForm& why, const RobotModel& model);

/// Where the next motion of a robot begins: what it was told last, else what is known of it.
program::Standing standing(const runtime::Station& station);

/// Previews in a thread of their own, one after the other. Of those that one client asked for of
/// one robot only the last one is made; the others are told so.
class PreviewDesk {
 public:
  /// So many may wait, of all clients and robots together.
  static constexpr std::size_t kWaitingMax = 64;

  /// @param cell  outlives this
  explicit PreviewDesk(const runtime::RunningCell& cell);
  ~PreviewDesk();
  PreviewDesk(const PreviewDesk&) = delete;
  PreviewDesk& operator=(const PreviewDesk&) = delete;

  /// @return false where too many wait
  bool ask(Ticket ticket, PreviewWish wish);
  /// Nobody waits for what this client asked for. @return  so many that had not begun
  std::size_t forget(std::uint32_t client);
  /// Each once.
  std::optional<Answered> take();

 private:
  struct Waiting {
    Ticket ticket;
    PreviewWish wish;
  };
  void work();

  const runtime::RunningCell& cell_;
  std::mutex mutex_;
  std::condition_variable more_;
  std::vector<Waiting> waiting_;  ///< under the mutex, as all below
  std::vector<Answered> done_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace sinew::server
