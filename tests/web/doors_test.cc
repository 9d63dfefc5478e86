#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "sinew/server/web/web_tokens.h"
#include "web/web_cell.h"

/// doors.txt: routes, names of the server, pages that ask, tokens. Each row is a connection of its
/// own from an address of its own, so that none is told to wait for the wrong tokens of another.
namespace sinew::test {
namespace {

struct Row {
  int line = 0;
  std::string method, route, host, origin, token;
  int status = 0;
};

std::vector<Row> rows() {
  std::ifstream file(SINEW_WEB_TABLES "/doors.txt");
  std::vector<Row> rows;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line.starts_with('#')) continue;
    std::istringstream words(line);
    Row row;
    row.line = number;
    words >> row.method >> row.route >> row.host >> row.origin >> row.token >> row.status;
    EXPECT_TRUE(words) << "doors.txt:" << number;
    rows.push_back(row);
  }
  return rows;
}

std::string host_lines(const std::string& word, const std::string& port) {
  const std::map<std::string, std::string> lines{
      {"own", "Host: 127.0.0.1:" + port + "\r\n"},
      {"localhost", "Host: LocalHost:" + port + "\r\n"},
      {"ipv6", "Host: [::1]:" + port + "\r\n"},
      {"evil", "Host: robots.example:" + port + "\r\n"},
      {"no-port", "Host: 127.0.0.1\r\n"},
      {"other-port", "Host: 127.0.0.1:1" + port + "\r\n"},
      {"suffix", "Host: 127.0.0.1:" + port + ".robots.example\r\n"},
      {"userinfo", "Host: 127.0.0.1:" + port + "@robots.example\r\n"},
      {"dot", "Host: localhost.:" + port + "\r\n"},
      {"twice", "Host: 127.0.0.1:" + port + "\r\nHost: 127.0.0.1:" + port + "\r\n"},
      {"none", ""}};
  return lines.at(word);
}

std::string origin_lines(const std::string& word, const Row& row, const std::string& port) {
  std::string same = "http://127.0.0.1:" + port;
  if (row.host == "localhost") same = "http://localhost:" + port;
  if (row.host == "ipv6") same = "http://[::1]:" + port;
  const std::map<std::string, std::string> lines{
      {"none", ""},
      {"same", "Origin: " + same + "\r\n"},
      {"foreign", "Origin: http://robots.example\r\n"},
      {"null", "Origin: null\r\n"},
      {"other-port", "Origin: http://127.0.0.1:1\r\n"},
      {"https", "Origin: https://127.0.0.1:" + port + "\r\n"},
      {"localhost-page", "Origin: http://localhost:" + port + "\r\n"},
      {"suffix", "Origin: " + same + ".robots.example\r\n"},
      {"file", "Origin: file://\r\n"},
      {"empty", "Origin:\r\n"},
      {"twice", "Origin: " + same + "\r\nOrigin: " + same + "\r\n"}};
  return lines.at(word);
}

std::string token_lines(const std::string& word) {
  const std::string bearer = "Authorization: Bearer ";
  const std::string good = kOperatorToken;
  const std::map<std::string, std::string> lines{
      {"none", ""},
      {"wrong", bearer + kWrongToken + "\r\n"},
      {"viewer", bearer + kViewerToken + "\r\n"},
      {"operator", bearer + good + "\r\n"},
      {"basic", "Authorization: Basic " + good + "\r\n"},
      {"short", bearer + good.substr(0, 31) + "\r\n"},
      {"upper", bearer + "0123456789ABCDEF0123456789ABCDEF\r\n"},
      {"empty", bearer + "\r\n"},
      {"twice", bearer + good + "\r\n" + bearer + good + "\r\n"},
      {"query", ""}};
  return lines.at(word);
}

std::string text_of(const Row& row, const std::string& port) {
  const std::string body = R"({"jsonrpc":"2.0","id":1,"method":"cell.describe"})";
  const std::string query = row.token == "query" ? "?token=" + std::string(kOperatorToken) : "";
  std::string text = row.method + " " + row.route + query + " HTTP/1.1\r\n" +
                     host_lines(row.host, port) + origin_lines(row.origin, row, port) +
                     token_lines(row.token);
  if (row.route == "/ws") {
    return text +
           "Connection: keep-alive, Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
           "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
  }
  text += "Connection: close\r\n";
  if (row.method == "POST") {
    text += "Content-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) +
            "\r\n\r\n" + body;
    return text;
  }
  return text + "\r\n";
}

TEST(Doors, each_request_of_the_table_gets_the_answer_that_stands_there) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  const std::vector<Row> table = rows();
  EXPECT_GE(table.size(), 150U);
  int number = 0;
  for (const Row& row : table) {
    ++number;
    RawConnection raw(cell.port(), "127.1." + std::to_string(number / 200) + "." +
                                       std::to_string(number % 200 + 1));
    raw.send(text_of(row, std::to_string(cell.port())));
    const Answered answer = raw.answer(row.method == "HEAD");
    EXPECT_EQ(answer.status, row.status) << "doors.txt:" << row.line << "\n" << answer.body;
    const bool refused = answer.status >= 400;
    EXPECT_EQ(refused, answer.head.contains("Connection: close") && answer.status != 200)
        << "doors.txt:" << row.line;
    // Nothing here is for other origins, whatever they ask.
    EXPECT_FALSE(answer.head.contains("Access-Control-")) << "doors.txt:" << row.line;
    if (answer.status == 101) continue;
    EXPECT_TRUE(
        answer.head.contains("Content-Security-Policy: default-src 'none'; script-src 'self'"))
        << answer.head;
    EXPECT_EQ(answer.field("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(answer.field("Referrer-Policy"), "no-referrer");
    EXPECT_EQ(answer.field("X-Frame-Options"), "DENY");
  }
}

TEST(Doors, wrong_tokens_are_told_to_wait_and_right_ones_never_are) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  const auto ask = [&](const char* token, const std::string& from) {
    RawConnection raw(cell.port(), from);
    raw.send("GET /openrpc.json HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(cell.port()) +
             "\r\nConnection: close\r\nAuthorization: Bearer " + token + "\r\n\r\n");
    return raw.answer();
  };
  for (std::size_t k = 0; k < server::WebTokens::kWrongMax; ++k) {
    EXPECT_EQ(ask(kWrongToken, "127.0.0.9").status, 401);
  }
  const Answered late = ask(kWrongToken, "127.0.0.9");
  EXPECT_EQ(late.status, 429);
  EXPECT_FALSE(late.field("Retry-After").empty());
  EXPECT_EQ(ask(kWrongToken, "127.0.0.10").status, 401);
  EXPECT_EQ(ask(kOperatorToken, "127.0.0.9").status, 200);
}

TEST(Doors, files_of_a_panel_are_served_as_they_are_kept) {
  constexpr std::uint8_t kBytes[] = {0x1f, 0x8b, 8, 0};
  const server::Asset assets[] = {{"/index.html", "text/html; charset=utf-8", "\"one\"", kBytes},
                                  {"/assets/app-1a2b.js", "text/javascript", "\"two\"", kBytes}};
  WebCell cell({server::test::place("left", "learm", "bus")}, {.assets = assets});
  const auto ask = [&](const std::string& line, const std::string& fields) {
    RawConnection raw(cell.port());
    raw.send(line + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(cell.port()) +
             "\r\nConnection: close\r\n" + fields + "\r\n");
    return raw.answer(line.starts_with("HEAD"));
  };
  const std::string gzip = "Accept-Encoding: br, gzip\r\n";
  const Answered page = ask("GET /", gzip);
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, std::string("\x1f\x8b\x08\0", 4));
  EXPECT_EQ(page.field("Content-Encoding"), "gzip");
  EXPECT_EQ(page.field("Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(page.field("Cache-Control"), "no-cache");
  EXPECT_TRUE(page.field("Content-Security-Policy")
                  .contains("connect-src 'self' ws://127.0.0.1:" + std::to_string(cell.port())));
  const Answered script = ask("GET /assets/app-1a2b.js", gzip);
  EXPECT_TRUE(script.field("Cache-Control").contains("immutable"));
  EXPECT_EQ(ask("HEAD /assets/app-1a2b.js", gzip).field("Content-Length"), "4");
  const Answered known = ask("GET /", gzip + "If-None-Match: \"zero\", \"one\"\r\n");
  EXPECT_EQ(known.status, 304);
  EXPECT_TRUE(known.body.empty());
  EXPECT_EQ(ask("GET /", "").status, 406);
  EXPECT_EQ(ask("GET /assets/other.js", gzip).status, 404);
  EXPECT_EQ(ask("POST /assets/app-1a2b.js", gzip).status, 405);
}

}  // namespace
}  // namespace sinew::test
