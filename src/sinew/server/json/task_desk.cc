#include "sinew/server/json/task_desk.h"

#include <algorithm>
#include <utility>

namespace sinew::server {

TaskDesk::TaskDesk(std::size_t waiting_max, io::Share share)
    : waiting_max_(waiting_max), thread_([this, share] { work(share); }) {}

TaskDesk::~TaskDesk() {
  {
    const std::scoped_lock lock(mutex_);
    ends_ = true;
  }
  more_.notify_all();
  thread_.join();
}

bool TaskDesk::ask(Ticket ticket, Task task) {
  {
    const std::scoped_lock lock(mutex_);
    const auto of_one = std::ranges::count_if(
        waiting_, [&](const auto& one) { return one.first.client == ticket.client; });
    const bool greedy = ticket.client != 0 && of_one >= static_cast<std::ptrdiff_t>(kOfOneMax);
    if (greedy || waiting_.size() >= waiting_max_) return false;
    waiting_.emplace_back(std::move(ticket), std::move(task));
  }
  more_.notify_all();
  return true;
}

std::optional<Answered> TaskDesk::take() {
  const std::scoped_lock lock(mutex_);
  if (done_.empty()) return std::nullopt;
  Answered first = std::move(done_.front());
  done_.pop_front();
  return first;
}

void TaskDesk::work(io::Share share) {
  io::let_others_go_first(share);
  std::unique_lock lock(mutex_);
  while (true) {
    more_.wait(lock, [this] { return ends_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    auto [ticket, task] = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    auto result = task();
    lock.lock();
    done_.push_back({std::move(ticket), std::move(result)});
  }
}

}  // namespace sinew::server
