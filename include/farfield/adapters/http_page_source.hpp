// A page file on any web server as a source of pages, by requests for ranges of bytes. No server of farfield's own is
// needed: nginx, Apache, or a store in the cloud will do.
//
// It needs libcurl: in CMake link farfield::http, which is there where curl is (of an installed farfield a component).
// No other header includes this one.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/adapters/curl_connection.hpp"
#include "farfield/adapters/http_options.hpp"
#include "farfield/fail.hpp"
#include "farfield/paging/page_source.hpp"

namespace farfield {

/// Models CancellablePageSource. Opening it takes one request, for the first bytes, which are kept: a read of them asks
/// nobody. Connections are kept open, one for each read that is made at once; redirections are followed every time, so
/// the final address is better. Proxies are those that curl takes from the environment.
///
/// A file that was replaced is found changed by its ETag, or else by its time and its size. The server could send
/// ranges when it was opened, so nearly all that goes wrong later is unavailable: it may pass, as when a server
/// restarts, even where a file is not there (404) or may not be read (403). What is gone for good (410) is changed;
/// what is no answer to the request at all, such as 400, is refused.
///
/// Exceptions are thrown at opening only. It can be moved, as long as nobody reads. Programs that read by https ignore
/// SIGPIPE, as most do: curl cannot everywhere keep its TLS library from it (CURLOPT_NOSIGNAL).
class HttpPageSource {
  public:
    /// An address that begins with http:// or https://. User and password in it, and what follows a question mark, are
    /// left out of messages. Throws std::runtime_error, which names the address, why not, and what to do: the server
    /// may be absent, be busy, lack the file, or send whole files only; nothing is tried twice.
    explicit HttpPageSource(const std::string& url, const HttpOptions& options = {})
        : state_(std::make_unique<State>(url, options)) {
        State& s = *state_;
        const std::uint64_t count = std::max<std::uint64_t>(options.head_bytes, 1);
        s.head.resize(std::size_t(count));
        const auto connection = s.taken();
        if (connection == nullptr) detail::refuse_address(s.target.name, "curl has no memory for a connection");
        const ReadResult result = connection->read_first(s.head, s.target.file);
        if (result.status != ReadStatus::done) {
            detail::fail<std::runtime_error>("farfield::HttpPageSource: " + result.message);
        }
        s.head.resize(std::size_t(std::min(count, s.target.file.size)));
        s.head.shrink_to_fit();
        s.target.know_file();
    }

    std::uint64_t size() const noexcept { return state_->target.file.size; }
    ReadMerging merging() const noexcept { return state_->target.options.merging; }

    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        State& s = *state_;
        if (!detail::lies_within(size(), offset, bytes.size())) {
            return detail::beyond_the_end(s.target.name, size(), offset, bytes.size());
        }
        if (offset < s.head.size()) {
            const std::size_t count = std::min(bytes.size(), s.head.size() - std::size_t(offset));
            if (count > 0) std::memcpy(bytes.data(), s.head.data() + offset, count);
            offset += count;
            bytes = bytes.subspan(count);
        }
        if (bytes.empty()) return {};
        const auto connection = s.taken();
        if (connection == nullptr) {
            return not_read(ReadStatus::unavailable, {s.target.name, ": there is no memory for a connection"});
        }
        return connection->read(offset, bytes);
    }

    /// Reads end at once, and they and all later ones are unavailable, but for those of the first bytes.
    void cancel() noexcept {
        state_->target.is_cancelled = true;
        const std::lock_guard lock(state_->mutex);
        for (auto* connection = state_->made; connection != nullptr; connection = connection->next_made) {
            connection->wake();
        }
    }

  private:
    /// Connections go back to where they were taken from.
    struct State {
        State(const std::string& url, const HttpOptions& options) : target(url, options) {}
        ~State() {
            while (made != nullptr) delete std::exchange(made, made->next_made);
        }
        State(const State&) = delete;
        State& operator=(const State&) = delete;

        struct GiveBack {
            State* state;
            void operator()(detail::CurlConnection* connection) const {
                const std::lock_guard lock(state->mutex);
                connection->next_idle = std::exchange(state->idle, connection);
            }
        };
        /// The connection that was used last, which is open most probably, or a new one; null if there is no memory.
        std::unique_ptr<detail::CurlConnection, GiveBack> taken() noexcept {
            const std::lock_guard lock(mutex);
            auto* connection = idle;
            if (connection != nullptr) {
                idle = connection->next_idle;
            } else if ((connection = detail::CurlConnection::make(target)) != nullptr) {
                connection->next_made = std::exchange(made, connection);
            }
            return {connection, GiveBack{this}};
        }

        detail::HttpTarget target;
        std::vector<std::byte> head;
        std::mutex mutex;
        detail::CurlConnection *made = nullptr, *idle = nullptr;
    };
    std::unique_ptr<State> state_;
};

static_assert(CancellablePageSource<HttpPageSource>);

}  // namespace farfield
