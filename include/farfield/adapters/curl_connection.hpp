// One connection to a web server, by libcurl: a request at a time, and everything checked before a byte is taken.
//
// Every request has an easy handle of its own; the connection is kept by the multi handle. curl 7.88, which Debian 12
// has, reads freed memory where a handle is used again and the first field of an answer begins with a blank: any server
// can send that. And whoever waits in a multi handle can be woken.
#pragma once

#include "farfield/settings.hpp"

#include <curl/curl.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "farfield/adapters/http_answer.hpp"
#include "farfield/adapters/http_options.hpp"
#include "farfield/fail.hpp"
#include "farfield/paging/page_source.hpp"

namespace farfield::detail {

[[noreturn]] inline void refuse_address(const std::string& name, std::string_view why) {
    fail<std::runtime_error>("farfield::HttpPageSource: " + name + ": " + std::string(why));
}

/// Frees what curl gave.
struct CurlFree {
    void operator()(CURLM* handle) const { ::curl_multi_cleanup(handle); }
    void operator()(CURLU* url) const { ::curl_url_cleanup(url); }
    void operator()(curl_slist* list) const { ::curl_slist_free_all(list); }
    void operator()(char* text) const { ::curl_free(text); }
};
struct CurlEasyFree {
    void operator()(CURL* handle) const { ::curl_easy_cleanup(handle); }
};
using CurlText = std::unique_ptr<char, CurlFree>;
using CurlLines = std::unique_ptr<curl_slist, CurlFree>;

/// curl is set up once a process, by whoever comes first, and stays so: others may use it too.
inline bool curl_is_ready() {
    static const bool is_ready = ::curl_global_init(CURL_GLOBAL_DEFAULT) == CURLE_OK;
    return is_ready;
}

inline void append_line(CurlLines& lines, const std::string& line) {
    curl_slist* const longer = ::curl_slist_append(lines.get(), line.c_str());
    if (longer == nullptr) fail<std::bad_alloc>();
    lines.release();  // is part of the longer one
    lines.reset(longer);
}

/// What all connections to a file have in common.
struct HttpTarget {
    std::string url, name;  ///< and what messages say of it, without secrets
    HttpOptions options;
    bool is_https = false;
    HttpIdentity file{};
    CurlLines fields{};  ///< sent with every request
    std::atomic<bool> is_cancelled{false};

    HttpTarget(const std::string& address, const HttpOptions& wanted) : url(address), options(wanted) {
        // A password may be in what cannot be taken apart.
        name = url.substr(url.find('@') == url.npos ? 0 : url.rfind('@') + 1);
        std::replace_if(
            name.begin(), name.end(), [](char c) { return c < ' ' || c == 127; }, '?');
        if (!curl_is_ready()) refuse_address(name, "curl cannot be set up");
        const std::unique_ptr<CURLU, CurlFree> parts(::curl_url());
        const auto get = [&](CURLUPart part) {
            char* text = nullptr;
            ::curl_url_get(parts.get(), part, &text, 0);
            const CurlText owned(text);
            return std::string(text == nullptr ? "" : text);
        };
        const bool is_url =
            url.find('\0') == url.npos && ::curl_url_set(parts.get(), CURLUPART_URL, url.c_str(), 0) == CURLUE_OK;
        const std::string scheme = is_url ? get(CURLUPART_SCHEME) : "";
        if (scheme != "http" && scheme != "https") {
            refuse_address(name, "is no whole address that begins with http:// or https://");
        }
        is_https = scheme == "https";
        for (const CURLUPart secret : {CURLUPART_USER, CURLUPART_PASSWORD, CURLUPART_QUERY, CURLUPART_FRAGMENT}) {
            ::curl_url_set(parts.get(), secret, nullptr, 0);
        }
        name = get(CURLUPART_URL);
        append_line(fields, "Accept-Encoding: identity");
    }

    /// From now on a request is for this file as it was found, and else for nothing (RFC 9110, 13.1).
    void know_file() {
        if (is_strong(file.etag)) {
            append_line(fields, "If-Match: " + file.etag);
        } else if (!file.last_modified.empty()) {
            append_line(fields, "If-Unmodified-Since: " + file.last_modified);
        }
    }
};

class CurlConnection {
  public:
    CurlConnection* next_idle = nullptr;  ///< in the list of those that nobody uses
    CurlConnection* next_made = nullptr;  ///< in the list of all

    /// Null if there is no memory. The target outlives it.
    static CurlConnection* make(const HttpTarget& target) noexcept {
        std::unique_ptr<CurlConnection> made(new (std::nothrow) CurlConnection(target));
        return made != nullptr && made->multi_ != nullptr ? made.release() : nullptr;
    }

    /// Of the first bytes of the file, as many as there are. It fills in what the server says of the file.
    ReadResult read_first(std::span<std::byte> bytes, HttpIdentity& found) {
        is_first_ = true;
        const ReadResult result = performed(0, bytes);
        if (result.status == ReadStatus::done) {
            found = {verdict_.wants_body ? *answer_.range->size : 0, answer_.etag, answer_.last_modified};
        }
        return result;
    }
    ReadResult read(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        is_first_ = false;
        return performed(offset, bytes);
    }

    /// A read that waits looks at once whether it was given up. For other threads to call.
    void wake() noexcept { ::curl_multi_wakeup(multi_.get()); }

  private:
    explicit CurlConnection(const HttpTarget& target) : target_(target), multi_(::curl_multi_init()) {}

    template <class Value>
    bool set(CURLoption option, Value value) {
        return ::curl_easy_setopt(easy_.get(), option, value) == CURLE_OK;
    }

    bool is_set_up() {
        easy_.reset(::curl_easy_init());
        if (easy_ == nullptr) return false;
        const HttpOptions& options = target_.options;
        const long seconds = std::max(1L, long((options.answer_timeout.count() + 999) / 1000));
        return set(CURLOPT_URL, target_.url.c_str()) && set(CURLOPT_NOSIGNAL, 1L) &&
               set(CURLOPT_HTTP_VERSION, long(CURL_HTTP_VERSION_1_1)) &&  // one request at a time has no use for others
               set(CURLOPT_HTTPHEADER, target_.fields.get()) && set(CURLOPT_USERAGENT, "farfield") && set_protocols() &&
               set(CURLOPT_FOLLOWLOCATION, 1L) && set(CURLOPT_MAXREDIRS, 5L) &&
               set(CURLOPT_SUPPRESS_CONNECT_HEADERS, 1L) && set(CURLOPT_BUFFERSIZE, 256L << 10) &&
               set(CURLOPT_CONNECTTIMEOUT_MS, long(options.connect_timeout.count())) &&
               set(CURLOPT_LOW_SPEED_LIMIT, long(options.least_bytes_per_second)) &&
               set(CURLOPT_LOW_SPEED_TIME, seconds) && set(CURLOPT_ERRORBUFFER, error_.data()) &&
               set(CURLOPT_HEADERFUNCTION, &on_header) && set(CURLOPT_HEADERDATA, static_cast<void*>(this)) &&
               set(CURLOPT_WRITEFUNCTION, &on_bytes) && set(CURLOPT_WRITEDATA, static_cast<void*>(this));
    }
    /// Nobody is redirected to a file of his own, nor from https to http.
    bool set_protocols() {
#if LIBCURL_VERSION_NUM >= 0x075500
        const char* const first = target_.is_https ? "https" : "http";
        return set(CURLOPT_PROTOCOLS_STR, first) &&
               set(CURLOPT_REDIR_PROTOCOLS_STR, target_.is_https ? "https" : "http,https");
#else
        const long https = CURLPROTO_HTTPS, http = CURLPROTO_HTTP;
        return set(CURLOPT_PROTOCOLS, target_.is_https ? https : http) &&
               set(CURLOPT_REDIR_PROTOCOLS, target_.is_https ? https : http | https);
#endif
    }

    ReadResult performed(std::uint64_t offset, std::span<std::byte> bytes) noexcept {
        answer_.clear();
        verdict_ = {};
        is_judged_ = is_too_long_ = false;
        offset_ = offset;
        asked_ = free_ = bytes;
        if (!is_set_up() || !set_range(offset, bytes.size()) || !set(CURLOPT_TIMEOUT_MS, time_for(bytes.size()))) {
            return not_read(ReadStatus::unavailable, {target_.name, ": there is no memory for a request"});
        }
        error_[0] = '\0';
        const ReadResult result = result_of(code_of_transfer());
        easy_.reset();
        return result;
    }
    CURLcode code_of_transfer() noexcept {
        if (::curl_multi_add_handle(multi_.get(), easy_.get()) != CURLM_OK) return CURLE_OUT_OF_MEMORY;
        CURLcode code = CURLE_ABORTED_BY_CALLBACK;
        while (!target_.is_cancelled) {
            int running = 0, messages = 0;
            if (::curl_multi_perform(multi_.get(), &running) != CURLM_OK) break;
            if (const CURLMsg* const message = ::curl_multi_info_read(multi_.get(), &messages)) {
                code = message->data.result;  // there is no other message than that it is done
                break;
            }
            if (::curl_multi_poll(multi_.get(), nullptr, 0, 1000, nullptr) != CURLM_OK) break;
        }
        ::curl_multi_remove_handle(multi_.get(), easy_.get());
        return code;
    }
    bool set_range(std::uint64_t offset, std::uint64_t count) {
        std::array<char, 48> text{};  // two numbers of 20 digits at most
        char* at = std::to_chars(text.data(), text.data() + 20, offset).ptr;
        *at = '-';
        std::to_chars(at + 1, at + 21, offset + count - 1);
        return set(CURLOPT_RANGE, static_cast<const char*>(text.data()));
    }
    long time_for(std::uint64_t count) const {
        const HttpOptions& options = target_.options;
        const double least = std::max(1.0, double(options.least_bytes_per_second));
        const double ms = double(options.connect_timeout.count()) + double(options.answer_timeout.count()) +
                          1000.0 * double(count) / least;
        return long(std::clamp(ms, 1.0, 2e9));
    }

    ReadResult result_of(CURLcode code) const noexcept {
        const auto unavailable = [&](std::string_view why, std::string_view more = {}) {
            return not_read(ReadStatus::unavailable, {target_.name, ": ", why, more});
        };
        if (is_judged_ && !verdict_.wants_body) {
            if (verdict_.status == ReadStatus::done) return {};
            std::array<char, 16> status{};
            std::to_chars(status.data(), status.data() + status.size(), answer_.status);
            return not_read(verdict_.status, {target_.name, ": answers ", status.data(), ": ", verdict_.why});
        }
        if (target_.is_cancelled && code != CURLE_OK) return unavailable("given up");
        if (is_too_long_) return unavailable("sends more bytes than it says");
        if (code == CURLE_WRITE_ERROR) return unavailable("its answer cannot be taken");
        if (code != CURLE_OK) return unavailable(error_[0] != '\0' ? error_.data() : ::curl_easy_strerror(code));
        if (!is_judged_) return unavailable("redirects to nowhere");
        if (received() != expected()) return unavailable("sends fewer bytes than it says");
        return {};
    }
    std::uint64_t received() const {
        return asked_.size() - free_.size();
    }
    /// What the answer's own head says, which was found to be what was asked for, or at first fewer.
    std::uint64_t expected() const {
        return *answer_.range->last - *answer_.range->first + 1;
    }

    static std::size_t on_header(char* text, std::size_t size, std::size_t count, void* self) {
        bool goes_on = false;
        guarded<std::exception>(
            [&] {
                goes_on = static_cast<CurlConnection*>(self)->takes_line({text, size * count});
            },
            [] {});
        return goes_on ? size * count : 0;
    }
    /// False ends the transfer, before what is not wanted comes.
    bool takes_line(std::string_view line) {
        if (is_judged_) return true;  // fields that follow the bytes
        if (!trimmed(line).empty()) {
            answer_.take(line);
            return true;
        }
        if (answer_.is_interim()) return true;
        verdict_ = is_first_ ? judged_first(answer_, asked_.size())
                             : judged(answer_, offset_, offset_ + asked_.size() - 1, target_.file);
        is_judged_ = true;
        return verdict_.wants_body;
    }
    static std::size_t on_bytes(char* bytes, std::size_t size, std::size_t count, void* self) {
        return static_cast<CurlConnection*>(self)->takes_bytes(bytes, size * count) ? size * count : 0;
    }
    bool takes_bytes(const char* bytes, std::size_t count) {
        if (!is_judged_) return false;
        is_too_long_ = count > expected() - received();
        if (is_too_long_) return false;
        if (count > 0) std::memcpy(free_.data(), bytes, count);
        free_ = free_.subspan(count);
        return true;
    }

    const HttpTarget& target_;
    std::unique_ptr<CURLM, CurlFree> multi_;
    std::unique_ptr<CURL, CurlEasyFree> easy_;  ///< goes before the one that it may be added to
    std::array<char, CURL_ERROR_SIZE> error_{};
    // The request that is being made.
    HttpAnswer answer_;
    HttpVerdict verdict_;
    bool is_first_ = false, is_judged_ = false, is_too_long_ = false;
    std::uint64_t offset_ = 0;
    std::span<std::byte> asked_, free_;
};

}  // namespace farfield::detail
