// A web server for tests, on the loopback, that answers as a test wants: also as none should.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "farfield/adapters/http_answer.hpp"

namespace farfield::test {

struct HttpRequest {
    std::string head;  ///< with its first line
    std::uint64_t first = 0, last = 0;

    std::string path() const {
        const std::size_t begin = head.find(' ') + 1;
        return head.substr(begin, head.find(' ', begin) - begin);
    }
    /// Of a field; empty if it is not there.
    std::string field(std::string_view name) const {
        for (std::size_t at = head.find("\r\n"); at != head.npos; at = head.find("\r\n", at + 2)) {
            const std::string_view line = std::string_view(head).substr(at + 2, head.find("\r\n", at + 2) - at - 2);
            const std::size_t colon = line.find(':');
            if (colon != line.npos && detail::is_same_name(line.substr(0, colon), name)) {
                return std::string(detail::trimmed(line.substr(colon + 1)));
            }
        }
        return {};
    }
};

/// All that is sent: first nothing for a while, then the bytes, in pieces with pauses; then it listens again, or
/// closes, or stays silent.
struct HttpReply {
    enum class End { listen, close, silence };
    std::string bytes;
    End end = End::listen;
    std::chrono::microseconds delay{0}, pause{0};
    std::size_t piece = std::size_t(-1);
};

/// A file as a good server sends it, with every part of that open to change.
struct HttpFile {
    std::string_view bytes;
    std::string etag = "\"1\"", last_modified = "Mon, 02 Jan 2006 15:04:05 GMT";
    std::string status = "206 Partial Content";
    std::optional<std::string> content_range{}, content_length{};
    std::string more_fields{};
    std::optional<std::string> body{};

    HttpReply reply(const HttpRequest& r) const {
        const auto field = [](const std::string& name, const std::string& value) {
            return value.empty() ? "" : name + ": " + value + "\r\n";
        };
        const std::uint64_t last = std::min<std::uint64_t>(r.last, bytes.size() - 1);
        const std::string sent =
            body ? *body : std::string(bytes.substr(std::size_t(r.first), std::size_t(last - r.first + 1)));
        const std::string range =
            "bytes " + std::to_string(r.first) + "-" + std::to_string(last) + "/" + std::to_string(bytes.size());
        return {"HTTP/1.1 " + status + "\r\n" + field("Content-Range", content_range.value_or(range)) +
                field("Content-Length", content_length.value_or(std::to_string(sent.size()))) + field("ETag", etag) +
                field("Last-Modified", last_modified) + more_fields + "\r\n" + sent};
    }
};

class HttpServer {
  public:
    using Answer = std::function<HttpReply(const HttpRequest&)>;

    explicit HttpServer(Answer answer, std::uint16_t port = 0) : answer_(std::move(answer)) {
        ::setenv("no_proxy", "*", 1);
        listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
        const int yes = 1;
        ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof address;
        auto* const any = reinterpret_cast<sockaddr*>(&address);
        if (::bind(listener_, any, size) != 0 || ::listen(listener_, 64) != 0 ||
            ::getsockname(listener_, any, &size) != 0) {
            throw std::runtime_error("no server on the loopback");
        }
        port_ = ntohs(address.sin_port);
        thread_ = std::thread([this] { accept_all(); });
    }
    ~HttpServer() {
        is_stopped_ = true;
        thread_.join();
        for (std::thread& t : talks_) t.join();
        ::close(listener_);
    }
    HttpServer(const HttpServer&) = delete;
    HttpServer& operator=(const HttpServer&) = delete;

    void behave(Answer answer) {
        const std::lock_guard lock(mutex_);
        answer_ = std::move(answer);
    }
    std::uint16_t port() const { return port_; }
    std::string url(const std::string& path = "/f", const std::string& user = {}) const {
        return "http://" + user + "127.0.0.1:" + std::to_string(port_) + path;
    }
    std::uint32_t connections() const { return connections_; }
    std::vector<HttpRequest> requests() const {
        const std::lock_guard lock(mutex_);
        return requests_;
    }
    void forget_requests() {
        const std::lock_guard lock(mutex_);
        requests_.clear();
        connections_ = 0;
    }

  private:
    bool waits_for(int socket, short what) const {
        while (!is_stopped_) {
            pollfd poll{socket, what, 0};
            if (::poll(&poll, 1, 10) > 0) return true;
        }
        return false;
    }
    void accept_all() {
        while (waits_for(listener_, POLLIN)) {
            const int socket = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
            if (socket < 0) continue;
            const int yes = 1;
            ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
            ++connections_;
            talks_.emplace_back([this, socket] {
                talk(socket);
                ::close(socket);
            });
        }
    }
    void talk(int socket) {
        std::string got;
        while (true) {
            std::size_t end = 0;
            while ((end = got.find("\r\n\r\n")) == got.npos) {
                char some[4096];
                if (!waits_for(socket, POLLIN)) return;
                const auto count = ::recv(socket, some, sizeof some, 0);
                if (count <= 0) return;
                got.append(some, std::size_t(count));
            }
            HttpRequest request{got.substr(0, end + 2)};
            got.erase(0, end + 4);
            const std::string range = request.field("Range");
            const std::size_t equals = range.find('='), dash = range.find('-');
            if (equals != range.npos && dash != range.npos) {
                request.first = std::strtoull(range.c_str() + equals + 1, nullptr, 10);
                request.last = std::strtoull(range.c_str() + dash + 1, nullptr, 10);
            }
            Answer answer;
            {
                const std::lock_guard lock(mutex_);
                requests_.push_back(request);
                answer = answer_;
            }
            const HttpReply reply = answer(request);
            pause(reply.delay);
            if (!sends(socket, reply)) return;
            if (reply.end == HttpReply::End::close) return;
            while (reply.end == HttpReply::End::silence && !is_stopped_) pause(std::chrono::milliseconds(5));
        }
    }
    void pause(std::chrono::microseconds time) const {
        const auto until = std::chrono::steady_clock::now() + time;
        while (!is_stopped_) {
            const auto left = until - std::chrono::steady_clock::now();
            if (left.count() <= 0) return;
            std::this_thread::sleep_for(std::min<std::chrono::nanoseconds>(left, std::chrono::milliseconds(10)));
        }
    }
    bool sends(int socket, const HttpReply& reply) const {
        for (std::string_view left = reply.bytes; !left.empty();) {
            const std::string_view piece = left.substr(0, reply.piece);
            for (std::size_t at = 0; at < piece.size();) {
                if (!waits_for(socket, POLLOUT)) return false;
                const auto count = ::send(socket, piece.data() + at, piece.size() - at, MSG_NOSIGNAL);
                if (count <= 0) return false;
                at += std::size_t(count);
            }
            left.remove_prefix(piece.size());
            pause(reply.pause);
        }
        return true;
    }

    int listener_ = -1;
    std::uint16_t port_ = 0;
    std::atomic<bool> is_stopped_{false};
    std::atomic<std::uint32_t> connections_{0};
    mutable std::mutex mutex_;
    Answer answer_;
    std::vector<HttpRequest> requests_;
    std::list<std::thread> talks_;
    std::thread thread_;
};

}  // namespace farfield::test
