#include "sinew/server/server_loop.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <vector>

#include "sinew/io/clock.h"

namespace sinew::server {
namespace {

constexpr auto kTurn = std::chrono::milliseconds(5);

}  // namespace

struct ServerLoop::Implementation {
  explicit Implementation(Api& cell) : api(cell), timer(context) {}

  void tick() {
    api.poll(clock.now());
    for (const auto& turn : turns) turn();
    if ((*stop)()) return context.stop();
    timer.expires_after(kTurn);
    timer.async_wait([this](auto error) {
      if (!error) tick();
    });
  }

  Api& api;
  io::Clock clock;
  boost::asio::io_context context{1};  // one thread
  boost::asio::steady_timer timer;
  std::vector<std::function<void()>> turns;
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
