#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "web/web_cell.h"

/// requests.txt: requests byte by byte, the answers that have to come, and frames behind upgrades.
namespace sinew::test {
namespace {

struct Case {
  std::string name;
  std::string request;             ///< as it stands in the file
  std::string expected;            ///< status and words
  std::vector<std::string> steps;  ///< behind an upgrade
};

std::vector<Case> cases() {
  std::ifstream file(SINEW_WEB_TABLES "/requests.txt");
  std::vector<Case> cases;
  std::string line;
  bool in_request = false;
  while (std::getline(file, line)) {
    if (line.starts_with("case ")) {
      cases.push_back({.name = line.substr(5), .request = {}, .expected = {}, .steps = {}});
      in_request = true;
    } else if (line.starts_with("expect ")) {
      cases.back().expected = line.substr(7);
      in_request = false;
    } else if (in_request) {
      cases.back().request += line + "\n";
    } else if (!cases.empty() && !line.empty()) {
      cases.back().steps.push_back(line);
    }
  }
  return cases;
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
    text.replace(at, from.size(), to);
    at += to.size();
  }
}

/// `\r`, `\x1b`, ...
std::string with_bytes(const std::string& text) {
  std::string bytes;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] != '\\' || k + 1 == text.size()) {
      bytes += text[k];
      continue;
    }
    const char kind = text[++k];
    if (kind == 'x') {
      bytes += static_cast<char>(std::stoi(text.substr(k + 1, 2), nullptr, 16));
      k += 2;
    } else {
      bytes += kind == 'r' ? '\r' : kind == 'n' ? '\n' : kind == 't' ? '\t' : '\0';
    }
  }
  return bytes;
}

/// `{a*30}`: what stands between a bracket and `*N}`.
std::string with_repeats(const std::string& text) {
  std::string all;
  std::size_t done = 0;
  for (std::size_t star = text.find('*'); star != std::string::npos;
       star = text.find('*', star + 1)) {
    const std::size_t end = text.find_first_not_of("0123456789", star + 1);
    const std::size_t begin = text.rfind('{', star);
    const bool repeats = end != std::string::npos && end > star + 1 && text[end] == '}' &&
                         begin != std::string::npos && begin >= done;
    if (!repeats) continue;
    all += text.substr(done, begin - done);
    const int count = std::stoi(text.substr(star + 1));
    for (int k = 0; k < count; ++k) all += text.substr(begin + 1, star - begin - 1);
    done = end + 1;
  }
  return all + text.substr(done);
}

std::string filled(std::string text, std::uint16_t port) {
  replace_all(text, "{host}", "127.0.0.1:" + std::to_string(port));
  replace_all(text, "{operator}", kOperatorToken);
  replace_all(text, "{viewer}", kViewerToken);
  replace_all(text, "{wrong}", kWrongToken);
  return with_bytes(with_repeats(text));
}

std::string request_text(const Case& one, std::uint16_t port) {
  // A body's last line has no end.
  const std::size_t split = one.request.find("\n\n");
  std::string head = one.request.substr(0, split);
  std::string body = split != std::string::npos ? one.request.substr(split + 2) : "";
  if (!body.empty()) body.pop_back();
  body = filled(body, port);
  replace_all(head, "\n", "\r\n");
  replace_all(head, "{length}", std::to_string(body.size()));
  head = filled(head, port);
  return split != std::string::npos ? head + "\r\n\r\n" + body : head;
}

void take_step(RawConnection& raw, const std::string& step, std::uint16_t port) {
  const std::size_t blank = step.find(' ');
  const std::string kind = step.substr(0, blank);
  const std::string rest = filled(step.substr(blank + 1), port);
  if (kind == "text") {
    raw.send_frame(rest);
  } else if (kind == "bytes") {
    raw.send(rest);
  } else if (kind == "frame") {
    raw.send_frame(rest.substr(3),
                   static_cast<unsigned char>(std::stoi(rest.substr(0, 2), nullptr, 16)));
  } else if (kind == "message" || kind == "pong") {
    const RawConnection::Frame frame = raw.frame();
    EXPECT_EQ(frame.opcode, kind == "pong" ? 10 : 1);
    EXPECT_TRUE(frame.payload.contains(rest)) << frame.payload;
  } else if (kind == "close") {
    const RawConnection::Frame frame = raw.frame();
    EXPECT_EQ(frame.opcode, 8) << frame.payload;
    EXPECT_TRUE(("," + rest + ",").contains("," + std::to_string(frame.close_code()) + ","))
        << frame.close_code();
    raw.send_frame(frame.payload, 0x88);
    EXPECT_TRUE(raw.ends());
  } else {
    ADD_FAILURE() << "no step is called " << kind;
  }
}

TEST(Requests, each_gets_the_answer_that_stands_beside_it) {
  WebCell cell({server::test::place("left", "learm", "bus")});
  const std::vector<Case> all = cases();
  EXPECT_GE(all.size(), 140U);
  int number = 0;
  for (const Case& one : all) {
    SCOPED_TRACE(one.name);
    ++number;
    RawConnection raw(cell.port(), "127.2." + std::to_string(number / 200) + "." +
                                       std::to_string(number % 200 + 1));
    raw.send(request_text(one, cell.port()));
    const Answered answer = raw.answer(one.request.starts_with("HEAD"));
    const std::size_t blank = one.expected.find(' ');
    EXPECT_EQ(std::to_string(answer.status), one.expected.substr(0, blank)) << answer.body;
    const std::string whole = answer.head + answer.body;
    if (blank != std::string::npos) {
      EXPECT_TRUE(whole.contains(one.expected.substr(blank + 1))) << whole;
    }
    EXPECT_TRUE(answer.status < 400 || raw.ends());
    if (answer.status == 101) {
      for (const std::string& step : one.steps) {
        SCOPED_TRACE(step.substr(0, 80));
        take_step(raw, step, cell.port());
      }
    }
  }
  // All of that has left the server as it was.
  WebClient client(cell.port(), kOperatorToken);
  EXPECT_EQ(client.call("cell.describe")["result"]["title"], "test");
}

}  // namespace
}  // namespace sinew::test
