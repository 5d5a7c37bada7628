#include "farfield/adapters/http_page_source.hpp"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/paging/write_pages.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "http_server.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"
#include "support/temporary_directory.hpp"
#include "support/views.hpp"

extern char** environ;

using namespace farfield;
using namespace std::chrono_literals;
using test::HttpFile;
using test::HttpReply;
using test::HttpRequest;
using test::HttpServer;
using End = test::HttpReply::End;

namespace {

std::string random_text(std::size_t count, std::uint64_t seed = 1) {
    test::Random random(seed);
    std::string text(count, ' ');
    for (char& c : text) c = char(random.bits());
    return text;
}
const std::string content = random_text(300'000), other_content = random_text(300'000, 2);

HttpServer::Answer file(HttpFile f = {content}) {
    return [f](const HttpRequest& r) { return f.reply(r); };
}
HttpServer::Answer fixed(std::string bytes, End end = End::listen) {
    return [=](const HttpRequest&) { return HttpReply{bytes, end}; };
}
/// A good answer of which no more than `count` bytes are sent.
HttpServer::Answer cut(std::size_t count, End end) {
    return [=](const HttpRequest& r) {
        HttpReply reply = HttpFile{content}.reply(r);
        reply.bytes.resize(reply.bytes.find("\r\n\r\n") + 4 + count);
        reply.end = end;
        return reply;
    };
}
/// A few bytes, chunked.
HttpServer::Answer chunked(std::string_view bytes) {
    HttpFile f{content};
    char size[32];
    *std::to_chars(size, size + 31, bytes.size(), 16).ptr = '\0';
    f.content_length = "";
    f.more_fields = "Transfer-Encoding: chunked\r\nTrailer: ETag\r\n";
    f.body =
        std::string(size) + "\r\n" + std::string(bytes) + "\r\n0\r\nHTTP/1.1 200: OK\r\nETag: \"trailing\"\r\n\r\n";
    return file(f);
}

const HttpOptions patient{.head_bytes = 1000};
/// For servers that are silent. A good one may be too slow for it on a busy machine.
const HttpOptions hasty{.connect_timeout = 150ms, .answer_timeout = 150ms, .head_bytes = 1000};

/// The bytes if they came, else the message; the bytes around the buffer must be as they were.
struct Outcome {
    ReadStatus status;
    std::string message, bytes;
};
Outcome read(HttpPageSource& source, std::uint64_t at, std::size_t count) {
    std::string around(count + 64, '#');
    const ReadResult result = source.read(at, std::as_writable_bytes(std::span(around)).subspan(32, count));
    CHECK(around.substr(0, 32) == std::string(32, '#'));
    CHECK(around.substr(32 + count) == std::string(32, '#'));
    CHECK(result.message.find('\n') == std::string::npos);
    CHECK(result.message.empty() == (result.status == ReadStatus::done));
    return {result.status, result.message, around.substr(32, count)};
}
bool is_right(const Outcome& outcome, std::size_t at, const std::string& all = content) {
    UNSCOPED_INFO(outcome.message);
    return outcome.status == ReadStatus::done && outcome.bytes == all.substr(at, outcome.bytes.size());
}

/// What the opening of it says behind the address.
std::string refusal(const std::string& url, const std::string& name, const HttpOptions& options = patient) {
    try {
        const HttpPageSource source(url, options);
        return "it opens";
    } catch (const std::runtime_error& e) {
        const std::string start = "farfield::HttpPageSource: " + name + ": ", what = e.what();
        CHECK(what.find('\n') == std::string::npos);
        return what.starts_with(start) ? what.substr(start.size()) : "MISSING: " + what;
    }
}

HttpPageSource opened_in_haste(const std::string& url) {
    for (int i = 0; i < 50; ++i) {
        try {
            return HttpPageSource(url, hasty);
        } catch (const std::runtime_error&) {
        }
    }
    return HttpPageSource(url, hasty);
}

}  // namespace

TEST_CASE("one request opens a file, and reads of its beginning ask nobody") {
    HttpServer server(file());
    HttpPageSource source(server.url(), patient);
    CHECK(source.size() == content.size());
    CHECK(is_right(read(source, 0, 1000), 0));
    CHECK(is_right(read(source, 990, 10), 990));
    CHECK(read(source, 300'000, 0).status == ReadStatus::done);
    CHECK(server.requests().size() == 1);
    CHECK(server.requests()[0].field("Range") == "bytes=0-999");
    CHECK(server.requests()[0].field("Accept-Encoding") == "identity");
    CHECK(server.requests()[0].field("If-Match").empty());

    CHECK(is_right(read(source, 500, 1000), 500));
    CHECK(is_right(read(source, 1000, 1), 1000));
    CHECK(is_right(read(source, 299'999, 1), 299'999));
    CHECK(is_right(read(source, 0, content.size()), 0));
    const auto requests = server.requests();
    REQUIRE(requests.size() == 5);
    CHECK(requests[1].field("Range") == "bytes=1000-1499");
    CHECK(requests[2].field("Range") == "bytes=1000-1000");
    CHECK(requests[4].field("Range") == "bytes=1000-299999");
    for (std::size_t i = 1; i < requests.size(); ++i) CHECK(requests[i].field("If-Match") == "\"1\"");
    CHECK(server.connections() == 1);
    CHECK(source.merging().most_reads_at_once >= 4);
}

TEST_CASE("a read beyond the end of a file on a server is refused without asking it") {
    HttpServer server(file());
    HttpPageSource source(server.url(), patient);
    CHECK(read(source, 299'999, 2).status == ReadStatus::refused);
    CHECK(read(source, 300'001, 0).status == ReadStatus::refused);
    CHECK(read(source, std::numeric_limits<std::uint64_t>::max(), 100).status == ReadStatus::refused);
    CHECK(server.requests().size() == 1);
}

TEST_CASE("small and empty files on a server") {
    HttpServer server(file({std::string_view(content).substr(0, 10)}));
    {
        HttpPageSource source(server.url(), patient);
        CHECK(source.size() == 10);
        CHECK(is_right(read(source, 0, 10), 0));
        CHECK(read(source, 0, 11).status == ReadStatus::refused);
        CHECK(server.requests().size() == 1);
    }
    for (const char* const empty : {"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n",
                                    "HTTP/1.1 416 No\r\nContent-Range: bytes */0\r\nContent-Length: 4\r\n\r\nnope"}) {
        server.behave(fixed(empty));
        HttpPageSource source(server.url(), patient);
        CHECK(source.size() == 0);
        CHECK(read(source, 0, 0).status == ReadStatus::done);
        CHECK(read(source, 0, 1).status == ReadStatus::refused);
    }
}

TEST_CASE("threads read at once, each over a connection that stays open") {
    HttpServer server(file());
    HttpPageSource source(server.url(), patient);
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        threads.emplace_back([&, seed] {
            test::Random random(seed);
            for (int i = 0; i < 50; ++i) {
                const std::size_t at = random.below(std::uint32_t(content.size()));
                std::string bytes(1 + random.below(std::uint32_t(content.size() - at)), ' ');
                const ReadResult result = source.read(at, std::as_writable_bytes(std::span(bytes)));
                wrong += result.status != ReadStatus::done || bytes != content.substr(at, bytes.size());
            }
        });
    }
    for (std::thread& t : threads) t.join();
    CHECK(wrong == 0);
    CHECK(server.connections() <= 6);
    CHECK(server.requests().size() > 250);
}

TEST_CASE("what cannot be opened says why, and what to do") {
    HttpServer server(file());
    const auto why = [&](HttpServer::Answer answer) {
        server.behave(std::move(answer));
        return refusal(server.url(), server.url());
    };
    const auto is_timed_out = [&](HttpServer::Answer answer) {
        server.behave(std::move(answer));
        const std::string what = refusal(server.url(), server.url(), hasty);
        UNSCOPED_INFO(what);
        return what.find("timed out after") != std::string::npos;
    };
    const std::string whole =
        "answers 200: the server sends whole files only: use one that sends ranges of bytes (Accept-Ranges: bytes)";
    CHECK(why(file({.bytes = content, .status = "200 OK", .content_range = "", .body = content})) == whole);
    CHECK(why(fixed("HTTP/1.0 200 OK\r\n\r\n" + content, End::silence)) == whole);
    CHECK(why(fixed("HTTP/1.1 404 Not Found\r\nContent-Length: 5\r\n\r\nnope\n")) ==
          "answers 404: there is no such file: check the address");
    CHECK(why(fixed("HTTP/1.1 403 No\r\nContent-Length: 0\r\n\r\n")) ==
          "answers 403: it may not be read: check the permissions, or give user and password");
    CHECK(why(fixed("HTTP/1.1 503 No\r\nContent-Length: 100000\r\n\r\n", End::silence)) ==
          "answers 503: the server cannot do it now: try again later");
    CHECK(why(fixed("HTTP/1.1 416 No\r\nContent-Range: bytes */10\r\nContent-Length: 0\r\n\r\n")) ==
          "answers 416: the server does not send the beginning of the file");
    CHECK(why(file({.bytes = content, .content_range = "bytes 0-999/*"})) ==
          "answers 206: it does not say how large the file is");
    CHECK(why(file({.bytes = content, .content_range = "bytes 1-1000/300000"})) ==
          "answers 206: it sends other bytes than it was asked for");
    CHECK(why(fixed("HTTP/1.1 302 Found\r\nLocation: /g\r\nContent-Length: 0\r\n\r\n")) ==
          "Maximum (5) redirects followed");
    CHECK(
        why(fixed("HTTP/1.1 302 Found\r\nLocation: file:///etc/hosts\r\nContent-Length: 0\r\n\r\n")).find("\"file\"") !=
        std::string::npos);
    CHECK(why(fixed("HTTP/1.1 302 Found\r\nContent-Length: 0\r\n\r\n")) ==
          "answers 302: that is no answer to a request for a range of bytes");
    CHECK(why(fixed("", End::close)) == "Empty reply from server");
    CHECK(why(fixed("I speak no HTTP\r\n\r\n", End::close)) == "Received HTTP/0.9 when not allowed");
    CHECK(is_timed_out(fixed("", End::silence)));
    CHECK(why(cut(500, End::close)).find("closed with 500 bytes remaining") != std::string::npos);
    CHECK(is_timed_out(cut(500, End::silence)));
    CHECK(why(chunked(std::string_view(content).substr(0, 999))) == "sends fewer bytes than it says");
    CHECK(why(chunked(std::string_view(content).substr(0, 1001))) == "sends more bytes than it says");
}

TEST_CASE("what is no address of a file on a web server is refused, and passwords stay secret") {
    const std::string what = "is no whole address that begins with http:// or https://";
    for (const char* const url : {"", "f", "/f", "127.0.0.1/f", "file:///etc/hosts", "ftp://127.0.0.1/f", "http://",
                                  "gopher://a", "http:/", "what://a/b"}) {
        CAPTURE(url);
        CHECK(refusal(url, url) == what);
    }
    CHECK(refusal("http://me:secret@a b/f", "a b/f") == what);
    CHECK(refusal("http://a/\n", "http://a/?") == what);
    CHECK(refusal(std::string("http://a\0b/", 11), "http://a?b/") == what);

    HttpServer server(fixed("HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n"));
    CHECK(refusal(server.url("/f?secret#part", "me:secret@"), server.url()) ==
          "answers 404: there is no such file: check the address");
    CHECK(server.requests()[0].path() == "/f?secret");
    CHECK(server.requests()[0].field("Authorization") == "Basic bWU6c2VjcmV0");
    server.behave(file());
    HttpPageSource source(server.url("/f?secret", "me:secret@"), patient);
    server.behave(fixed("HTTP/1.1 503 No\r\nContent-Length: 0\r\n\r\n"));
    CHECK(read(source, 2000, 10).message == server.url() + ": answers 503: the server cannot do it now");
}

TEST_CASE("a server that is not there") {
    std::uint16_t port = 0;
    {
        const HttpServer server(file());
        port = server.port();
    }
    const std::string url = "http://127.0.0.1:" + std::to_string(port) + "/f";
    CHECK(refusal(url, url).find("Failed to connect to 127.0.0.1") == 0);
    CHECK(!refusal("http://no-such-host.invalid/f", "http://no-such-host.invalid/f").empty());
}

TEST_CASE("whatever a server does later, a read says what, and the next one is right when the server is") {
    HttpServer server(file());
    HttpPageSource source(server.url(), patient), hasty_source(opened_in_haste(server.url()));
    struct Case {
        const char* name;
        HttpServer::Answer answer;
        ReadStatus status;
        const char* message;  ///< part of it
    };
    const auto status_line = [](const char* status, const char* more = "") {
        return fixed(std::string("HTTP/1.1 ") + status + "\r\nContent-Length: 4\r\n" + more + "\r\nnope");
    };
    HttpFile other{other_content};
    other.etag = "\"2\"";
    const auto unavailable = ReadStatus::unavailable, changed = ReadStatus::changed;
    const std::string_view asked = std::string_view(content).substr(5000, 2000);
    const Case cases[] = {
        {"200, the same", file({.bytes = content, .status = "200 OK", .content_range = "", .body = content}),
         unavailable, "answers 200: the server sends the whole file instead of a range of bytes"},
        {"200, another file",
         file({.bytes = content, .etag = "\"2\"", .status = "200 OK", .content_range = "", .body = content}), changed,
         "answers 200: the file has changed since it was opened: open it again"},
        {"404", status_line("404 Not Found"), unavailable, "answers 404: the file is not there any more"},
        {"403", status_line("403 Forbidden"), unavailable, "answers 403: it may not be read any more"},
        {"410", status_line("410 Gone"), changed, "answers 410: the file is gone for good"},
        {"412", status_line("412 Precondition Failed"), changed, "answers 412: the file has changed"},
        {"416, shorter", status_line("416 No", "Content-Range: bytes */100\r\n"), changed, "answers 416: the file has"},
        {"416, as long", status_line("416 No", "Content-Range: bytes */300000\r\n"), unavailable,
         "does not send bytes"},
        {"429", status_line("429 Too Many Requests"), unavailable, "answers 429: the server cannot do it now"},
        {"503", status_line("503 No"), unavailable, "answers 503: the server cannot do it now"},
        {"503 and silence", fixed("HTTP/1.1 503 No\r\nContent-Length: 9999\r\n\r\n", End::silence), unavailable, "503"},
        {"400", status_line("400 Bad"), ReadStatus::refused, "answers 400: that is no answer"},
        {"another ETag", file(other), changed, "answers 206: the file has changed"},
        {"no ETag", file({.bytes = content, .etag = ""}), changed, "answers 206: the file has changed"},
        {"another size", file({.bytes = content, .content_range = "bytes 5000-6999/300001"}), changed, "has changed"},
        {"other bytes", file({.bytes = content, .content_range = "bytes 5001-7000/300000"}), unavailable,
         "answers 206: it sends other bytes than it was asked for"},
        {"fewer bytes", file({.bytes = content, .content_range = "bytes 5000-6998/300000"}), unavailable,
         "other bytes"},
        {"no Content-Range", file({.bytes = content, .content_range = ""}), unavailable, "does not say which bytes"},
        {"a wrong length", file({.bytes = content, .content_length = "2001"}), unavailable, "another number of bytes"},
        {"encoded", file({.bytes = content, .more_fields = "Content-Encoding: gzip\r\n"}), unavailable, "encoded"},
        {"chunked, too many", chunked(std::string_view(content).substr(0, 2001)), unavailable, "more bytes"},
        {"chunked, too few", chunked(asked.substr(0, 1999)), unavailable, "fewer bytes"},
        {"chunked, endless",
         file({.bytes = content, .content_length = "", .more_fields = "Transfer-Encoding: chunked\r\n", .body = "fff"}),
         unavailable, "timed out"},
        {"a short body", cut(1999, End::close), unavailable, "closed with 1 bytes remaining"},
        {"a body that stalls", cut(1999, End::silence), unavailable, "timed out"},
        {"only a head", cut(0, End::close), unavailable, "closed with 2000 bytes remaining"},
        {"half a head", fixed("HTTP/1.1 206 Partial Content\r\nContent-Ra", End::close), unavailable, ""},
        {"nothing", fixed("", End::close), unavailable, ""},
        {"silence", fixed("", End::silence), unavailable, "timed out"},
        {"noise", fixed(random_text(5000, 3), End::close), unavailable, ""},
        {"drops a byte at a time",
         [](const HttpRequest& r) {
             HttpReply reply = HttpFile{content}.reply(r);
             reply.piece = 1;
             reply.pause = 1ms;
             return reply;
         },
         unavailable, "timed out"},
        {"elsewhere for ever", fixed("HTTP/1.1 307 No\r\nLocation: /g\r\nContent-Length: 0\r\n\r\n"), unavailable,
         "redirects"},
        {"to another protocol", fixed("HTTP/1.1 307 No\r\nLocation: file:///etc/hosts\r\nContent-Length: 0\r\n\r\n"),
         unavailable, ""},
    };
    for (const Case& c : cases) {
        CAPTURE(c.name);
        const bool is_silent = std::string_view(c.message) == "timed out";
        HttpPageSource& reader = is_silent ? hasty_source : source;
        server.behave(c.answer);
        const auto begin = std::chrono::steady_clock::now();
        const Outcome outcome = read(reader, 5000, 2000);
        CHECK(outcome.status == c.status);
        CHECK(outcome.message.find(server.url() + ": ") == 0);
        CHECK(outcome.message.find(c.message) != std::string::npos);
        if (is_silent) CHECK(std::chrono::steady_clock::now() - begin < 5s);
        CHECK(is_right(read(reader, 10, 100), 10));  // what is kept asks nobody
        server.behave(file());
        Outcome after = read(reader, 5000, 2000);
        for (int i = 0; is_silent && after.status == ReadStatus::unavailable && i < 50; ++i) {
            after = read(reader, 5000, 2000);
        }
        CHECK(is_right(after, 5000));
    }
    server.behave(chunked(asked));
    CHECK(is_right(read(source, 5000, 2000), 5000));
    server.behave([](const HttpRequest& r) {
        HttpReply reply = HttpFile{content}.reply(r);
        reply.bytes = "HTTP/1.1 103 Early Hints\r\nETag: \"2\"\r\n\r\n" + reply.bytes;
        reply.delay = 50ms;
        reply.piece = 300;
        reply.pause = 1ms;
        return reply;
    });
    CHECK(is_right(read(source, 5000, 2000), 5000));
}

TEST_CASE("a file that is replaced while threads read it is found changed, and never half of each") {
    HttpServer server(file());
    HttpPageSource source(server.url(), patient);
    HttpFile other{other_content};
    other.etag = "\"2\"";
    std::atomic<int> done{0}, changed{0}, wrong{0};
    std::vector<std::thread> threads;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        threads.emplace_back([&, seed] {
            test::Random random(seed);
            while (changed < 20 && wrong == 0) {
                const std::size_t at = 1000 + random.below(200'000);
                std::string bytes(1 + random.below(50'000), ' ');
                const ReadResult result = source.read(at, std::as_writable_bytes(std::span(bytes)));
                changed += result.status == ReadStatus::changed;
                const bool is_done = result.status == ReadStatus::done;
                wrong += is_done ? bytes != content.substr(at, bytes.size()) : result.status != ReadStatus::changed;
                if (is_done && ++done == 40) server.behave(file(other));
            }
        });
    }
    for (std::thread& t : threads) t.join();
    CHECK(wrong == 0);
    CHECK(done >= 40);
    HttpPageSource again(server.url(), patient);
    CHECK(is_right(read(again, 7000, 5000), 7000, other_content));
}

TEST_CASE("a server that goes and comes back") {
    auto server = std::make_unique<HttpServer>(file());
    const std::uint16_t port = server->port();
    HttpPageSource source(server->url(), patient);
    CHECK(is_right(read(source, 5000, 2000), 5000));
    server.reset();
    for (int i = 0; i < 2; ++i) {
        const Outcome outcome = read(source, 5000, 2000);
        CHECK(outcome.status == ReadStatus::unavailable);
        CHECK(outcome.message.find("Failed to connect to 127.0.0.1") != std::string::npos);
    }
    server = std::make_unique<HttpServer>(file(), port);
    CHECK(is_right(read(source, 5000, 2000), 5000));
}

TEST_CASE("pages on a server are drawn as those in memory, coarser while it is away, and whole when it is back") {
    using Tensors = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    const test::Triangles scene = test::mixed_triangles(20000, 7);
    const auto h = build<Tensors>(scene);
    const auto bytes = paged<Tensors, Triangle>(h, scene, {.page_bytes = 4096});
    const HttpServer::Answer pages_file =
        file({std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size())});
    auto server = std::make_unique<HttpServer>(pages_file);
    const std::uint16_t port = server->port();
    const auto pages = open_pages_of<Tensors, Triangle>(std::make_shared<HttpPageSource>(server->url(), patient),
                                                        server->url(), {.first_retry = 2ms, .longest_retry = 20ms});
    const View view = test::looking(glm::dvec3(0.3, 0.4, 1.0), glm::dvec3(0), 96, 1);
    ZBufferRenderer expected, renderer;
    make_viewer(h, scene, expected).frame(view);
    auto viewer = make_viewer(pages, renderer);
    server.reset();
    for (int i = 0; i < 20; ++i) {
        CHECK(viewer.frame(view).cells_missing != 0);
        CHECK(test::coverage(renderer.image()) > 0);
        std::this_thread::sleep_for(1ms);
    }
    while (pages.cache_stats().failures == 0) std::this_thread::sleep_for(1ms);
    CHECK(pages.cache_stats().last_failure.find("127.0.0.1") != std::string::npos);
    server = std::make_unique<HttpServer>(pages_file, port);
    int frames = 0;
    while (viewer.frame(view).cells_missing != 0 && ++frames < 10000) std::this_thread::sleep_for(2ms);
    CHECK(test::different_pixels(renderer.image(), expected.image()) <= 3);
    CHECK(pages.cache_stats().reads < pages.cache_stats().loads);  // neighbors together
    auto waiting = pages;
    waiting.wait_for_pages(true);
    ZBufferRenderer waiting_renderer;
    auto waiting_viewer = make_viewer(waiting, waiting_renderer);
    CHECK(waiting_viewer.frame(view).cells_missing == 0);
    CHECK(waiting_renderer.image() == renderer.image());
}

TEST_CASE("a first image, coarse and without a hole, takes one request, and what is finer comes level by level") {
    using H = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    // From within, so that all of the picture is covered.
    const auto triangles = test::sphere(glm::vec3(0), 1, 90, {90, 160, 220, 255});
    const H h = build<H>(triangles);
    const auto bytes = paged<H, Triangle>(h, triangles);
    HttpServer server(file({std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size())}));
    auto pages = open_pages_of<H, Triangle>(std::make_shared<HttpPageSource>(server.url()), server.url(),
                                            {.loads_in_background = false});
    CHECK(pages.page_bytes() > 60'000);
    REQUIRE(pages.page_count() > 8);
    const View view = test::looking(glm::dvec3(0.3, 0.2, 0.1), glm::dvec3(-1, 0.2, 0.3), 96, 1);
    ZBufferRenderer renderer;
    auto viewer = make_viewer(pages, renderer);
    std::size_t rounds = 0;
    do {
        const FrameStats stats = viewer.frame(view);
        CHECK((stats.cells_missing != 0) == (rounds == 0 || pages.cache_stats().missing != 0));
        CHECK(test::coverage(renderer.image()) > 0.5 * 96 * 96);
        for (const Rgba8 p : renderer.image().pixels()) REQUIRE(p.a != 0);
        if (rounds == 0) CHECK(server.requests().size() == 1);
    } while (pages.load_wanted() != 0 && ++rounds < 100);
    CHECK(viewer.frame(view).cells_missing == 0);
    CHECK(rounds >= 1);
    CHECK(rounds <= h.report().levels);
}

TEST_CASE("caches smaller than a walk needs, over a server: never a hole, no frame that waits, errors that fall") {
    using H = SpatialHierarchy<Octree, OpacityTensor, TriangleCount>;
    const auto triangles = test::mixed_triangles(20'000, 7);
    const auto bytes = paged<H, Triangle>(build<H>(triangles), triangles, {.page_bytes = 4096});
    const HttpServer server(file({std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size())}));
    const auto open = [&](std::size_t most_bytes) {
        return open_pages_of<H, Triangle>(std::make_shared<HttpPageSource>(server.url(), patient), "server",
                                          {.most_bytes = most_bytes, .loads_in_background = false});
    };
    constexpr int frames = 600;
    const auto view = [](int i) {
        const double t = 0.002 * i;
        return test::looking(glm::dvec3(1.5 - t, 0.3, 1.2 - 0.3 * t), glm::dvec3(0.2 - t, 0, 0), 48, 2);
    };
    auto all = open(std::size_t(64) << 20);
    all.wait_for_pages(true);
    ZBufferRenderer renderer, limited_renderer;
    auto whole = make_viewer(all, renderer);
    std::vector<Image> truth;
    for (int i = 0; i < frames; ++i) {
        whole.frame(view(i));
        truth.push_back(renderer.image());
    }
    const std::size_t working_set = all.cache_stats().resident * all.page_bytes();
    double last = std::numeric_limits<double>::infinity();
    for (const double part : {0.05, 0.1, 0.25, 0.5, 1.0}) {
        // The tables of a cache and the first two pages are not part of it.
        const auto pages = open(std::size_t(part * double(working_set)) + 3 * all.page_bytes() + 24 * all.page_count());
        auto paged_copy = pages;
        auto viewer = make_viewer(pages, limited_renderer);
        double squares = 0;
        int holes = 0;
        for (int i = 0; i < frames; ++i) {
            const std::uint64_t loads = pages.cache_stats().loads;
            viewer.frame(view(i));
            CHECK(pages.cache_stats().loads == loads);  // it did not wait for any
            const auto seen = limited_renderer.image().pixels();
            const std::span<const Rgba8> wanted = truth[std::size_t(i)].pixels();
            for (std::size_t p = 0; p < seen.size(); ++p) {
                const double d = (double(seen[p].g) - double(wanted[p].g)) / 255;
                squares += d * d;
                holes += seen[p].a == 0 && wanted[p].a == 255;
            }
            paged_copy.load_wanted();
        }
        INFO(part << ": " << squares << " after " << last << ", holes " << holes);
        CHECK(holes == 0);
        CHECK(squares <= 1.02 * last);
        last = squares;
    }
}

TEST_CASE("a first field that begins with a blank hurts no later answer") {
    HttpServer server(file());
    HttpPageSource source(server.url(), patient);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(is_right(read(source, 5000 + i, 2000), 5000 + i));
        server.behave([](const HttpRequest& r) {
            HttpReply reply = HttpFile{content}.reply(r);
            reply.bytes.insert(reply.bytes.find("\r\n") + 2, "\tfolded: \"x\"\r\n");
            return reply;
        });
        const Outcome outcome = read(source, 5000 + i, 2000);
        CHECK((outcome.status == ReadStatus::unavailable || is_right(outcome, 5000 + i)));
        server.behave(file());
    }
}

TEST_CASE("a connection that the server closed between reads is opened again unseen") {
    HttpServer server([](const HttpRequest& r) {
        HttpReply reply = HttpFile{content}.reply(r);
        reply.end = End::close;
        return reply;
    });
    HttpPageSource source(server.url(), patient);
    for (std::size_t i = 0; i < 5; ++i) CHECK(is_right(read(source, 5000 + i, 2000), 5000 + i));
    CHECK(server.connections() == 6);
}

TEST_CASE("a file without a strong ETag is asked for by its time") {
    HttpFile f{content};
    SECTION("no ETag") {
        f.etag = "";
    }
    SECTION("a weak ETag") {
        f.etag = "W/\"1\"";
    }
    HttpServer server(file(f));
    HttpPageSource source(server.url(), patient);
    CHECK(is_right(read(source, 5000, 2000), 5000));
    CHECK(server.requests()[1].field("If-Match").empty());
    CHECK(server.requests()[1].field("If-Unmodified-Since") == f.last_modified);
    f.etag = f.etag.empty() ? "" : "W/\"2\"";
    f.last_modified = "Tue, 03 Jan 2006 15:04:05 GMT";
    server.behave(file(f));
    CHECK(read(source, 5000, 2000).status == ReadStatus::changed);
}

TEST_CASE("a redirection is followed") {
    HttpServer server([](const HttpRequest& r) {
        if (r.path() == "/g") return HttpFile{content}.reply(r);
        return HttpReply{"HTTP/1.1 302 Found\r\nLocation: /g\r\nETag: \"9\"\r\nContent-Length: 4\r\n\r\nnope"};
    });
    HttpPageSource source(server.url(), patient);
    CHECK(source.size() == content.size());
    CHECK(is_right(read(source, 5000, 2000), 5000));
    CHECK(server.connections() == 1);
}

TEST_CASE("reads of a server that is silent can be given up") {
    HttpServer server(file());
    HttpPageSource source(server.url(), {.head_bytes = 1000});
    server.behave(fixed("", End::silence));
    std::atomic<int> given_up{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 3; ++i) {
        threads.emplace_back([&] {
            std::array<std::byte, 100> bytes{};
            const ReadResult result = source.read(5000, bytes);
            given_up += result.status == ReadStatus::unavailable && result.message == server.url() + ": given up";
        });
    }
    while (server.requests().size() < 4) std::this_thread::sleep_for(1ms);
    const auto begin = std::chrono::steady_clock::now();
    source.cancel();
    for (std::thread& t : threads) t.join();
    CHECK(given_up == 3);
    CHECK(std::chrono::steady_clock::now() - begin < 5s);  // a moment, were the machine not busy
    server.behave(file());
    CHECK(read(source, 5000, 100).status == ReadStatus::unavailable);
    CHECK(is_right(read(source, 0, 100), 0));
}

TEST_CASE("a source on a server is moved with its connections") {
    HttpServer server(file());
    HttpPageSource source(server.url(), patient);
    HttpPageSource other(std::move(source));
    CHECK(is_right(read(other, 5000, 2000), 5000));
    source = std::move(other);
    CHECK(is_right(read(source, 6000, 2000), 6000));
    CHECK(server.connections() == 1);
}

namespace {

/// nginx with a configuration of its own, as whoever runs the tests.
class Nginx {
  public:
    explicit Nginx(const test::TemporaryDirectory& directory) : directory_(directory) {
        for (int i = 0; i < 5 && !is_running(); ++i) start();
    }
    ~Nginx() { stop(); }
    Nginx(const Nginx&) = delete;
    Nginx& operator=(const Nginx&) = delete;

    static std::string program() {
        for (const char* const at : {"/usr/sbin/nginx", "/usr/bin/nginx", "/usr/local/sbin/nginx",
                                     "/usr/local/bin/nginx", "/opt/homebrew/bin/nginx"}) {
            if (::access(at, X_OK) == 0) return at;
        }
        return {};
    }
    bool is_running() const { return process_ > 0; }
    std::string url(const std::string& path) const { return "http://127.0.0.1:" + std::to_string(port_) + path; }

  private:
    void start() {
        port_ = HttpServer(fixed("")).port();  // free a moment ago
        const std::string place = directory_.path().string(), config = place + "/nginx.conf";
        std::string text = "daemon off;\nmaster_process off;\npid " + place + "/pid;\nerror_log " + place +
                           "/errors;\nevents {}\nhttp {\n  access_log off;\n";
        for (const char* const kind : {"client_body", "proxy", "fastcgi", "uwsgi", "scgi"}) {
            text += std::string("  ") + kind + "_temp_path " + place + "/" + kind + ";\n";
        }
        directory_.write("nginx.conf", text + "  server {\n    listen 127.0.0.1:" + std::to_string(port_) +
                                           ";\n    root " + place + ";\n    location /whole { max_ranges 0; }\n" +
                                           "    location /busy { return 503; }\n  }\n}\n");
        std::string words[] = {program(), "-c", config, "-e", place + "/errors"};
        char* const arguments[] = {words[0].data(), words[1].data(), words[2].data(),
                                   words[3].data(), words[4].data(), nullptr};
        if (::posix_spawn(&process_, words[0].c_str(), nullptr, nullptr, arguments, environ) != 0) process_ = -1;
        for (int i = 0; is_running() && i < 500; ++i) {
            if (::waitpid(process_, nullptr, WNOHANG) != 0) {
                process_ = -1;
            } else if (answers()) {
                return;
            } else {
                std::this_thread::sleep_for(10ms);
            }
        }
        stop();
    }
    bool answers() const {
        const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port_);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        const bool does = ::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
        ::close(socket);
        return does;
    }
    void stop() {
        if (!is_running()) return;
        ::kill(process_, SIGTERM);
        ::waitpid(process_, nullptr, 0);
        process_ = -1;
    }

    const test::TemporaryDirectory& directory_;
    pid_t process_ = -1;
    std::uint16_t port_ = 0;
};

}  // namespace

TEST_CASE("nginx serves pages as it is, and what it says of other files is understood") {
    if (Nginx::program().empty()) {
        WARN("skipped: there is no nginx on this machine (Debian and Ubuntu: nginx-light)");
        return;
    }
    const test::TemporaryDirectory directory;
    directory.write("f", content);
    directory.write("small", "0123456789");
    directory.write("empty", "");
    directory.write("whole", content);
    const Nginx nginx(directory);
    REQUIRE(nginx.is_running());
    const auto why = [&](const std::string& path) { return refusal(nginx.url(path), nginx.url(path)); };
    CHECK(why("/none") == "answers 404: there is no such file: check the address");
    CHECK(why("/whole").find("answers 200: the server sends whole files only") == 0);
    CHECK(why("/busy").find("answers 503: the server cannot do it now") == 0);
    CHECK(HttpPageSource(nginx.url("/empty"), patient).size() == 0);
    HttpPageSource small(nginx.url("/small"), patient);
    CHECK(small.size() == 10);
    CHECK(read(small, 3, 4).bytes == "3456");

    HttpPageSource source(nginx.url("/f"), patient);
    REQUIRE(source.size() == content.size());
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        threads.emplace_back([&, seed] {
            test::Random random(seed);
            for (int i = 0; i < 50; ++i) {
                const std::size_t at = random.below(std::uint32_t(content.size()));
                std::string bytes(1 + random.below(std::uint32_t(content.size() - at)), ' ');
                const ReadResult result = source.read(at, std::as_writable_bytes(std::span(bytes)));
                wrong += result.status != ReadStatus::done || bytes != content.substr(at, bytes.size());
            }
        });
    }
    for (std::thread& t : threads) t.join();
    CHECK(wrong == 0);

    // Longer by a byte: nginx's ETag is made of time and size, and the time may be the same second.
    const auto replace = [&](const std::string& by) {
        directory.write("g", by);
        std::filesystem::rename(directory / "g", directory / "f");
    };
    replace(other_content + "!");
    CHECK(read(source, 5000, 2000).status == ReadStatus::changed);
    CHECK(read(source, 5000, 2000).message ==
          nginx.url("/f") + ": answers 412: the file has changed since it was opened: open it again");
    HttpPageSource again(nginx.url("/f"), patient);
    CHECK(is_right(read(again, 5000, 2000), 5000, other_content));
    std::filesystem::rename(directory / "f", directory / "away");
    CHECK(read(again, 5000, 2000).message == nginx.url("/f") + ": answers 404: the file is not there any more");
    std::filesystem::rename(directory / "away", directory / "f");
    CHECK(is_right(read(again, 5000, 2000), 5000, other_content));
}
