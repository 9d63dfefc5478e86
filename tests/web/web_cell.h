#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "sinew/server/api/api_test_cell.h"
#include "sinew/server/web/web_server.h"

namespace sinew::test {

inline constexpr const char* kOperatorToken = "0123456789abcdef0123456789abcdef";
inline constexpr const char* kViewerToken = "fedcba9876543210fedcba9876543210";
inline constexpr const char* kWrongToken = "00000000000000000000000000000000";

/// A cell of simulated robots behind a network door, served in a thread of its own.
class WebCell {
 public:
  explicit WebCell(const std::vector<CellRobot>& robots, server::WebOptions options = {});
  ~WebCell();
  WebCell(const WebCell&) = delete;
  WebCell& operator=(const WebCell&) = delete;

  std::uint16_t port() const { return web_->port(); }
  std::string url() const { return web_->url(); }
  runtime::RunningCell& cell() { return cell_.cell(); }

 private:
  server::test::ApiCell cell_;
  server::ServerLoop loop_;
  std::unique_ptr<server::WebServer> web_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

/// An HTTP answer as it came.
struct Answered {
  int status = 0;  ///< 0: none came before the end
  std::string head;
  std::string body;
  /// The value of a field; empty where there is none.
  std::string field(std::string_view name) const;
};

/// A TCP connection, byte by byte. Each of its waits ends after 20 s.
class RawConnection {
 public:
  /// @param from  this side's address: wrong tokens are counted by it
  RawConnection(std::uint16_t port, const std::string& from = "127.0.0.1");
  ~RawConnection();
  RawConnection(RawConnection&& other) noexcept;
  RawConnection& operator=(RawConnection&&) = delete;

  /// @return  false where the other side is gone
  bool send(std::string_view bytes);
  /// Reads until so many bytes are there, or the end.
  std::string receive(std::size_t count);
  Answered answer(bool head_only = false);
  /// Whether the other side ends it within that time.
  bool ends();

  struct Frame {
    int opcode = -1;  ///< -1: the connection ended
    std::string payload;
    /// Of a close frame; 0 where it has none.
    int close_code() const;
  };
  /// The next frame of a WebSocket.
  Frame frame();
  /// A frame of a client, masked. @param first  FIN and opcode
  bool send_frame(std::string_view payload, unsigned char first = 0x81);

 private:
  bool more();
  int socket_ = -1;
  std::string received_;
};

/// A WebSocket that has been let in.
class WebClient {
 public:
  WebClient(std::uint16_t port, const char* token);
  bool open() const { return open_; }
  server::Json call(std::string_view method, const server::Json& params = server::Json::object());
  void send(std::string_view method, const server::Json& params = server::Json::object());
  /// The next message, whatever it is; null where the connection ended.
  server::Json next();
  RawConnection& raw() { return raw_; }

 private:
  RawConnection raw_;
  bool open_ = false;
  std::uint64_t last_ = 0;
};

/// The head of an upgrade with a token as subprotocol.
std::string upgrade_text(std::uint16_t port, std::string_view token);

}  // namespace sinew::test
