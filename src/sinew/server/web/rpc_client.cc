#include "sinew/server/web/rpc_client.h"

#include <array>

#include "sinew/io/clock.h"
#include "sinew/io/local_socket.h"

namespace sinew::server {
namespace {

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

io::IoResult<RpcClient> RpcClient::connect(const std::string& path) {
  auto port = io::connect_local(path);
  if (!port) return std::unexpected(port.error());
  return RpcClient(std::move(*port));
}

bool RpcClient::send(std::string_view method, const Json& params) {
  const std::string text = request_text(++last_id_, method, params) + "\n";
  if (!port_.write(bytes_of(text))) broken_ = true;
  return !broken_;
}

std::expected<Json, RpcError> RpcClient::call(std::string_view method, const Json& params,
                                              Duration patience) {
  const io::Clock clock;
  const Instant end = clock.now() + patience;
  const auto lost = [](const char* why) {
    return std::unexpected(RpcError{RpcCode::kFailed, why, nullptr});
  };
  if (!send(method, params)) return lost("the server has gone away");
  const std::uint64_t id = last_id_;
  while (clock.now() < end) {
    auto message = read(clock.until(end));
    if (broken_) return lost("the server has gone away");
    if (!message) break;
    if (message->contains("method")) {
      kept_.push_back(std::move(*message));
      continue;
    }
    if (!message->contains("id") || (*message)["id"] != id) continue;
    if (message->contains("result")) return (*message)["result"];
    const Json& error = (*message)["error"];
    return std::unexpected(RpcError{static_cast<RpcCode>(error.value("code", 0)),
                                    error.value("message", std::string()),
                                    error.value("data", Json(nullptr))});
  }
  return lost("the server did not answer in time");
}

std::optional<Json> RpcClient::next(Duration patience) {
  if (!kept_.empty()) {
    Json message = std::move(kept_.front());
    kept_.pop_front();
    return message;
  }
  const io::Clock clock;
  const Instant end = clock.now() + patience;
  do {
    auto message = read(clock.until(end));
    if (message && message->contains("method")) return message;
  } while (!broken_ && clock.now() < end);
  return std::nullopt;
}

std::optional<Json> RpcClient::read(Duration patience) {
  const io::Clock clock;
  const Instant end = clock.now() + patience;
  while (true) {
    if (const auto line_end = received_.find('\n'); line_end != std::string::npos) {
      Json message = Json::parse(received_.substr(0, line_end), nullptr, false);
      received_.erase(0, line_end + 1);
      if (message.is_object()) return message;
      continue;
    }
    std::array<std::uint8_t, 65536> buffer;
    const auto count = port_.read(buffer, clock.until(end));
    if (!count) {
      broken_ = true;
      return std::nullopt;
    }
    if (*count == 0 && clock.now() >= end) return std::nullopt;
    received_.append(reinterpret_cast<const char*>(buffer.data()), *count);
  }
}

}  // namespace sinew::server
