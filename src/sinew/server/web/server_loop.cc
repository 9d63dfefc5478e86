#include "sinew/server/web/server_loop.h"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <vector>

#include "sinew/io/clock.h"
#include "sinew/io/thread_share.h"

namespace sinew::server {
namespace {

/// While somebody waits, and otherwise.
constexpr auto kTurn = std::chrono::milliseconds(4);
constexpr auto kIdleTurn = std::chrono::milliseconds(20);
/// So long messages are done before sockets are looked at again, where a stop may have come.
constexpr Duration kSlice = std::chrono::milliseconds(1);
/// Memory of clients that have gone is given back to the system, at most so often.
constexpr Duration kTrim = std::chrono::seconds(3);
/// Memory of jobs and previews that have ended.
constexpr Duration kTrimAlways = std::chrono::minutes(1);

}  // namespace

struct ServerLoop::Implementation {
  explicit Implementation(Api& cell) : api(cell), timer(context) {}

  void tick() {
    api.poll(clock.now());
    for (const auto& turn : turns) turn();
    if ((*stop)()) return context.stop();
    trim();
    hurried = api.hurries();
    if (hurried) work_soon();
    wait();
  }
  void wait() {
    timer.expires_after(hurried ? kTurn : kIdleTurn);
    timer.async_wait([this](auto error) {
      if (!error) tick();
    });
  }

  void receive(SessionId session, std::string_view text) {
    api.receive(session, text, clock.now());
    work_soon();
    if (hurried) return;
    hurried = true;
    wait();
  }
  void work_soon() {
    if (working) return;
    working = true;
    boost::asio::post(context, [this] { work(); });
  }
  void work() {
    working = false;
    const Instant end = clock.now() + kSlice;
    bool more = true;
    while (more && clock.now() < end) more = api.work(clock.now());
    for (const auto& turn : turns) turn();
    if (more) work_soon();
  }

  void trim() {
    const bool left = api.sessions() < sessions;
    const Instant now = clock.now();
    if (now < trim_next || (!left && now < trim_next + kTrimAlways)) {
      sessions = std::max(sessions, api.sessions());
      return;
    }
    sessions = api.sessions();
    trim_next = now + kTrim;
    io::give_memory_back();
  }

  Api& api;
  io::Clock clock;
  boost::asio::io_context context{1};  // one thread
  boost::asio::steady_timer timer;
  std::vector<std::function<void()>> turns;
  bool hurried = false;      ///< the next turn comes soon
  bool working = false;      ///< work() will come
  std::size_t sessions = 0;  ///< that were there, since memory was given back
  Instant trim_next{};
  const std::function<bool()>* stop = nullptr;
};

ServerLoop::ServerLoop(Api& api) : implementation_(std::make_unique<Implementation>(api)) {}
ServerLoop::~ServerLoop() = default;

void ServerLoop::run(const std::function<bool()>& stop) {
  implementation_->stop = &stop;
  implementation_->context.restart();
  implementation_->tick();
  implementation_->context.run();
  implementation_->timer.cancel();
}

Api& ServerLoop::api() {
  return implementation_->api;
}

void ServerLoop::receive(SessionId session, std::string_view text) {
  implementation_->receive(session, text);
}

Instant ServerLoop::now() const {
  return implementation_->clock.now();
}

boost::asio::io_context& ServerLoop::context() {
  return implementation_->context;
}

void ServerLoop::each_turn(std::function<void()> turn) {
  implementation_->turns.push_back(std::move(turn));
}

void ServerLoop::drain() {
  implementation_->timer.cancel();
  implementation_->context.restart();
  implementation_->context.poll();
}

}  // namespace sinew::server
