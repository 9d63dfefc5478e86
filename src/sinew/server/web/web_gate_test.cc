#include "sinew/server/web/web_gate.h"

#include <gtest/gtest.h>

#include "sinew/server/web/web_answer.h"

namespace sinew::server {
namespace {

constexpr const char* kOperator = "0123456789abcdef0123456789abcdef";

struct Case {
  const char* host;
  const char* origin;
  int status;  ///< 0: let in
};

/// The door behind TLS; over plain HTTP tests/web/doors.txt has the table.
TEST(WebGate, behind_tls_only_pages_that_came_by_tls_are_its_own) {
  WebGate gate({.tls = true,
                .hosts = {"cell.example", "cell.example:8700"},
                .operator_token = kOperator,
                .viewer_token = "fedcba9876543210fedcba9876543210"});
  const Case cases[] = {
      {"cell.example", "https://cell.example", 0},
      {"CELL.example", "https://cell.example", 0},
      {"cell.example:8700", "https://cell.example:8700", 0},
      {"cell.example", "http://cell.example", 403},
      {"cell.example", "https://cell.example:443", 403},
      {"cell.example", "https://cell.example.evil.example", 403},
      {"cell.example", "https://cell.example:8700", 403},
      {"cell.example:443", "https://cell.example", 421},
      {"evil.example", "https://evil.example", 421},
  };
  for (const Case& one : cases) {
    const std::string text = std::string("GET /ws HTTP/1.1\r\nHost: ") + one.host +
                             "\r\nOrigin: " + one.origin +
                             "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                             "Sec-WebSocket-Version: 13\r\n"
                             "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                             "Sec-WebSocket-Protocol: sinew.v1, bearer." +
                             kOperator + "\r\n\r\n";
    const auto decided = gate.decide(text, {"192.0.2.7", "192.0.2.1:8700"}, Instant{});
    EXPECT_EQ(decided ? 0 : decided.error().status, one.status)
        << one.host << " from " << one.origin;
  }
}

TEST(WebGate, a_page_that_came_by_tls_may_only_open_secured_sockets) {
  const std::string head = answer_head({.status = 200}, "https://cell.example");
  EXPECT_NE(head.find(" wss://cell.example"), std::string::npos) << head;
  EXPECT_EQ(head.find(" ws://"), std::string::npos) << head;
}

}  // namespace
}  // namespace sinew::server
