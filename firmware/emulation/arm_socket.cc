#include "firmware/emulation/arm_socket.h"

#include "sinew/io/local_socket.h"
#include "sinew/runtime/links/byte_log.h"
#include "sinew/runtime/links/simwire_bus.h"
#include "sinew/sim/simwire_server.h"

namespace sinew::emulation {

ArmSocket::ArmSocket(EmulatedArm& arm, const RobotModel& model, const std::string& path)
    : path_(path), thread_([this, &arm, &model] { serve(arm, model); }) {
  while (!listens_ && !ends_) std::this_thread::yield();
}

void ArmSocket::end() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
}

void ArmSocket::serve(EmulatedArm& arm, const RobotModel& model) {
  constexpr Duration kSlice = std::chrono::milliseconds(50);
  auto listener = io::LocalListener::create(path_);
  if (!listener) {
    ends_ = true;
    return;
  }
  listens_ = true;
  arm.on_tick = [&] {
    Steps now{};
    for (std::size_t i = 0; i < now.size(); ++i) now[i] = arm.board(i).steps;
    steps_.push_back(now);
    first_axis_ = now[0];
    ticks_ = steps_.size();
  };
  sim::SimwireServer server(arm, boards_of(model.device), "emulated");
  runtime::ByteLog log;
  const auto stop = [&] { return ends_.load(); };
  while (!stop()) {
    auto client = listener->accept(kSlice);
    if (!client) break;
    if (!*client) continue;
    server.restart();
    // A host that goes away is no failure: the next one may come.
    static_cast<void>(runtime::serve_simwire(server, **client, log, stop));
  }
  arm.on_tick = [] {};
}

}  // namespace sinew::emulation
