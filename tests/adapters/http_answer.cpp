#include "farfield/adapters/http_answer.hpp"

#include <string>
#include <string_view>
#include <vector>

#include "catch.hpp"

using namespace farfield;
using namespace farfield::detail;

namespace {

HttpAnswer answer(std::string_view head) {
    HttpAnswer a;
    while (!head.empty()) {
        const std::size_t end = std::min(head.find('\n'), head.size() - 1) + 1;
        a.take(head.substr(0, end));
        head.remove_prefix(end);
    }
    return a;
}

/// "first-last/size", as it was understood.
std::string understood(std::string_view text) {
    const auto range = parsed_content_range(text);
    if (!range) return "nothing";
    const auto number = [](const std::optional<std::uint64_t>& n) { return n ? std::to_string(*n) : "?"; };
    return number(range->first) + "-" + number(range->last) + "/" + number(range->size);
}

const HttpIdentity file{1000, "\"a\"", "yesterday"};

ReadStatus status_of(const std::string& head, const HttpIdentity& known = file) {
    return judged(answer(head), 100, 199, known).status;
}

}  // namespace

TEST_CASE("a Content-Range is understood or not, never half") {
    CHECK(understood("bytes 0-99/1000") == "0-99/1000");
    CHECK(understood("BYTES  0-99/1000") == "0-99/1000");
    CHECK(understood("bytes 0-0/1") == "0-0/1");
    CHECK(understood("bytes 0-99/*") == "0-99/?");
    CHECK(understood("bytes */1000") == "?-?/1000");
    CHECK(understood("bytes */0") == "?-?/0");
    CHECK(understood("bytes 0-18446744073709551614/18446744073709551615") ==
          "0-18446744073709551614/18446744073709551615");
    for (const char* const wrong : {"",
                                    "bytes",
                                    "bytes ",
                                    "bytes */*",
                                    "bytes 0-99",
                                    "bytes 0/1000",
                                    "bytes 99-0/1000",
                                    "bytes 0-1000/1000",
                                    "bytes -1-99/1000",
                                    "bytes 0-+99/1000",
                                    "bytes 0x0-99/1000",
                                    "bytes 0 - 99/1000",
                                    "bytes 0-99/1000 more",
                                    "bytes 0-99/18446744073709551616",
                                    "bytes 18446744073709551616-18446744073709551617/*",
                                    "bytes=0-99/1000",
                                    "lines 0-99/1000",
                                    "bytes 0-99/-1",
                                    "bytes /1000",
                                    "bytes -/1000"}) {
        CAPTURE(wrong);
        CHECK(understood(wrong) == "nothing");
    }
}

TEST_CASE("the head of an answer is read whatever the case and the blanks of its lines, and afresh at each status") {
    const HttpAnswer a = answer(
        "HTTP/1.1 100 Continue\r\nETag: \"old\"\r\n\r\nhTTP/9: none\r\nHTTP/2  206 \r\n"
        "content-range:bytes 0-9/10\r\nCONTENT-LENGTH:   10  \r\nEtag:\t\"x\" \r\nlast-modified: then: now\r\n"
        "Content-Encoding: identity\r\nnonsense\r\n: \r\n");
    CHECK(a.status == 206);
    CHECK(a.range->last == 9u);
    CHECK(a.content_length == 10u);
    CHECK(a.etag == "\"x\"");
    CHECK(a.last_modified == "then: now");
    CHECK(!a.is_encoded);
    CHECK(!a.is_elsewhere);
    CHECK(answer("X: a\n ETag: \"x\"\n\tETag: \"x\"\n HTTP/1.1 206").etag.empty());  // go on with X
    CHECK(answer("Content-Encoding: gzip").is_encoded);
    CHECK(!answer("Content-Length: 1 0").content_length);
    CHECK(!answer("Content-Length: -1").content_length);
    for (const char* const line : {"HTTP/1.1", "HTTP/1.1 ", "HTTP/1.1 OK", "HTTP/"}) CHECK(answer(line).status == 0);
}

TEST_CASE("an answer that another one follows is told from the last") {
    CHECK(answer("HTTP/1.1 100 Continue").is_interim());
    CHECK(answer("HTTP/1.1 103 Early Hints").is_interim());
    CHECK(answer("HTTP/1.1 302 Found\nLocation: /g").is_interim());
    CHECK(!answer("HTTP/1.1 302 Found").is_interim());
    CHECK(!answer("HTTP/1.1 304 Not Modified\nLocation: /g").is_interim());
    CHECK(!answer("HTTP/1.1 201 Created\nLocation: /g").is_interim());
}

TEST_CASE("only a strong ETag is one to be sent back") {
    for (const char* const strong : {"\"a\"", "\"\"", "\"W/a\""}) CHECK(is_strong(strong));
    for (const char* const weak : {"", "\"", "W/\"a\"", "a", "\"a", "a\"", "\"a\" \"b\"", "\"a\"b"}) {
        CHECK(!is_strong(weak));
    }
}

TEST_CASE("the first answer tells the size, or why there is none") {
    const auto why = [](const char* head) -> std::string { return judged_first(answer(head), 100).why; };
    CHECK(judged_first(answer("HTTP/1.1 206\nContent-Range: bytes 0-99/1000"), 100).wants_body);
    CHECK(judged_first(answer("HTTP/1.1 206\nContent-Range: bytes 0-9/10\nContent-Length: 10"), 100).wants_body);
    for (const char* const empty : {"HTTP/1.1 200\nContent-Length: 0", "HTTP/1.1 416\nContent-Range: bytes */0"}) {
        CHECK(judged_first(answer(empty), 100).status == ReadStatus::done);
        CHECK(!judged_first(answer(empty), 100).wants_body);
    }
    CHECK(why("HTTP/1.1 206") == "it does not say which bytes it sends");
    CHECK(why("HTTP/1.1 206\nContent-Range: bytes */10") == "it does not say which bytes it sends");
    CHECK(why("HTTP/1.1 206\nContent-Range: bytes 0-99/*") == "it does not say how large the file is");
    CHECK(why("HTTP/1.1 206\nContent-Range: bytes 1-99/1000") == "it sends other bytes than it was asked for");
    CHECK(why("HTTP/1.1 206\nContent-Range: bytes 0-98/1000") == "it sends other bytes than it was asked for");
    CHECK(why("HTTP/1.1 206\nContent-Range: bytes 0-100/1000") == "it sends other bytes than it was asked for");
    CHECK(why("HTTP/1.1 206\nContent-Range: bytes 0-99/1000\nContent-Length: 101") ==
          "it sends another number of bytes than it says");
    CHECK(why("HTTP/1.1 206\nContent-Range: bytes 0-99/1000\nContent-Encoding: br") ==
          "it sends the file encoded: switch compression off for it");
    const std::string whole =
        "the server sends whole files only: use one that sends ranges of bytes (Accept-Ranges: bytes)";
    CHECK(why("HTTP/1.1 200") == whole);
    CHECK(why("HTTP/1.1 200\nContent-Length: 10") == whole);
    CHECK(why("HTTP/1.1 404") == "there is no such file: check the address");
    CHECK(why("HTTP/1.1 503") == "the server cannot do it now: try again later");
    for (const char* const other :
         {"HTTP/1.1 204", "HTTP/1.1 304", "HTTP/1.1 400", "HTTP/1.1 999", "", "HTTP/1.1 abc"}) {
        CHECK(judged_first(answer(other), 100).status == ReadStatus::refused);
    }
}

TEST_CASE("a later answer is taken if it is of the same file and of the bytes that were asked for") {
    const std::string good = "HTTP/1.1 206\nContent-Range: bytes 100-199/1000\nETag: \"a\"\n";
    CHECK(judged(answer(good), 100, 199, file).wants_body);
    CHECK(status_of(good) == ReadStatus::done);
    CHECK(status_of(good + "Content-Length: 100\n") == ReadStatus::done);
    CHECK(status_of(good + "Last-Modified: today\n") == ReadStatus::done);  // the ETag is the better witness
    CHECK(status_of(good + "Content-Length: 99\n") == ReadStatus::unavailable);
    CHECK(status_of(good + "Content-Encoding: gzip\n") == ReadStatus::unavailable);
    CHECK(status_of(good + "ETag: \"b\"\n") == ReadStatus::changed);
    CHECK(status_of(good + "ETag:\n") == ReadStatus::changed);
    CHECK(status_of(good + "ETag: W/\"a\"\n") == ReadStatus::changed);
    CHECK(status_of(good + "Content-Range: bytes 100-199/1001\n") == ReadStatus::changed);
    for (const char* const range : {"bytes 99-198/1000", "bytes 100-198/1000", "bytes 100-200/1000", "bytes 100-199/*",
                                    "bytes */1000", "what", ""}) {
        CAPTURE(range);
        const HttpVerdict verdict = judged(answer(good + "Content-Range: " + range), 100, 199, file);
        CHECK(verdict.status == ReadStatus::unavailable);
        CHECK(!verdict.wants_body);
    }
}

TEST_CASE("without an ETag the time of a file tells, without that its size") {
    const std::string part = "HTTP/1.1 206\nContent-Range: bytes 100-199/1000\n";
    const HttpIdentity timed{1000, "", "yesterday"}, plain{1000, "", ""};
    CHECK(status_of(part + "Last-Modified: yesterday", timed) == ReadStatus::done);
    CHECK(status_of(part, timed) == ReadStatus::done);
    CHECK(status_of(part + "Last-Modified: today", timed) == ReadStatus::changed);
    CHECK(status_of(part + "Last-Modified: today\nETag: \"b\"", plain) == ReadStatus::done);
    CHECK(status_of("HTTP/1.1 206\nContent-Range: bytes 100-199/999\n", plain) == ReadStatus::changed);
}

TEST_CASE("of what else a server answers later it is told whether it may pass") {
    const auto changed = ReadStatus::changed, unavailable = ReadStatus::unavailable, refused = ReadStatus::refused;
    CHECK(status_of("HTTP/1.1 200\nETag: \"a\"") == unavailable);
    CHECK(status_of("HTTP/1.1 200\nETag: \"a\"\nContent-Length: 1000") == unavailable);
    CHECK(status_of("HTTP/1.1 200\nETag: \"a\"\nContent-Length: 999") == changed);
    CHECK(status_of("HTTP/1.1 200\nETag: \"b\"") == changed);
    CHECK(status_of("HTTP/1.1 416\nContent-Range: bytes */50") == changed);
    CHECK(status_of("HTTP/1.1 416") == changed);
    CHECK(status_of("HTTP/1.1 416\nContent-Range: bytes */1000") == unavailable);
    CHECK(status_of("HTTP/1.1 410") == changed);
    CHECK(status_of("HTTP/1.1 412") == changed);
    for (const int status : {0, 401, 403, 404, 407, 408, 425, 429, 500, 502, 503, 504, 599}) {
        CAPTURE(status);
        CHECK(status_of("HTTP/1.1 " + std::to_string(status)) == unavailable);
    }
    for (const int status : {204, 300, 304, 400, 405, 414, 451, 600}) {
        CAPTURE(status);
        CHECK(status_of("HTTP/1.1 " + std::to_string(status)) == refused);
    }
}
