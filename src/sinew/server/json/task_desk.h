#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <expected>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "sinew/io/thread_share.h"
#include "sinew/server/json/json_rpc.h"

namespace sinew::server {

/// Who waits for an answer that is not there at once.
struct Ticket {
  std::uint32_t client = 0;
  Json id;
  bool answered = true;
};

struct Answered {
  Ticket ticket;
  std::expected<std::string, RpcError> result;  ///< JSON
};

/// What waits for a disk or thinks for seconds, in a thread of its own, one after the other in the
/// order in which it was asked for: the server's thread waits for nobody. What was asked for is
/// done, also where its client has gone meanwhile.
class TaskDesk {
 public:
  /// Its result is JSON: whoever writes a large one does so in this thread.
  using Task = std::function<std::expected<std::string, RpcError>()>;
  /// So many may wait, of all clients together and of one.
  static constexpr std::size_t kWaitingMax = 64;
  static constexpr std::size_t kOfOneMax = 16;

  explicit TaskDesk(std::size_t waiting_max = kWaitingMax, io::Share share = io::Share::kThinking);
  ~TaskDesk();
  TaskDesk(const TaskDesk&) = delete;
  TaskDesk& operator=(const TaskDesk&) = delete;

  /// @return false where too many wait; of client 0, the server itself, no share is kept
  bool ask(Ticket ticket, Task task);
  /// Each once.
  std::optional<Answered> take();

 private:
  void work(io::Share share);

  const std::size_t waiting_max_;
  std::mutex mutex_;
  std::condition_variable more_;
  std::deque<std::pair<Ticket, Task>> waiting_;  ///< under the mutex, as all below
  std::deque<Answered> done_;
  bool ends_ = false;
  std::thread thread_;
};

/// What ends with a value, as a task.
template <class Work>
TaskDesk::Task as_task(Work work) {
  return [work = std::move(work)]() mutable -> std::expected<std::string, RpcError> {
    const std::expected<Json, RpcError> result = work();
    if (!result) return std::unexpected(result.error());
    return text_of(*result);
  };
}

}  // namespace sinew::server
