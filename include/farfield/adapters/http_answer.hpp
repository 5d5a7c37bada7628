// What a server's answer to a request for a range of bytes says, before the first byte of it is taken (RFC 9110,
// sections 8.8, 13, 14 and 15). Nothing here needs a library.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "farfield/paging/page_source.hpp"

namespace farfield::detail {

/// By what a file on a server is known again.
struct HttpIdentity {
    std::uint64_t size = 0;
    std::string etag{};           ///< empty if the server sends none
    std::string last_modified{};  ///< as it came
};

/// Part of a file and its size, or its size alone.
struct ContentRange {
    std::optional<std::uint64_t> first, last, size;
};

inline std::string_view trimmed(std::string_view text) {
    const auto is_blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

/// Names in HTTP are of any case.
inline bool is_same_name(std::string_view a, std::string_view b) {
    const auto lower = [](char c) { return 'A' <= c && c <= 'Z' ? char(c - 'A' + 'a') : c; };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return lower(x) == lower(y); });
}

/// A number and nothing else.
inline std::optional<std::uint64_t> parsed_number(std::string_view text) {
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) return {};
    return number;
}

/// "bytes 0-99/1000", "bytes 0-99/*" or "bytes */1000".
inline std::optional<ContentRange> parsed_content_range(std::string_view text) {
    const std::size_t blank = text.find(' ');
    if (blank == text.npos || !is_same_name(text.substr(0, blank), "bytes")) return {};
    text = trimmed(text.substr(blank));
    const std::size_t slash = text.find('/');
    if (slash == text.npos) return {};
    const std::string_view part = text.substr(0, slash), whole = text.substr(slash + 1);
    ContentRange range;
    if (whole != "*") {
        range.size = parsed_number(whole);
        if (!range.size) return {};
    }
    if (part == "*") return range.size ? std::optional(range) : std::nullopt;
    const std::size_t dash = part.find('-');
    if (dash == part.npos) return {};
    range.first = parsed_number(part.substr(0, dash));
    range.last = parsed_number(part.substr(dash + 1));
    if (!range.first || !range.last || *range.first > *range.last) return {};
    if (range.size && *range.last >= *range.size) return {};
    return range;
}

/// An ETag that promises the same bytes, and may be sent back in If-Match.
inline bool is_strong(std::string_view etag) {
    return etag.size() >= 2 && etag.front() == '"' && etag.find('"', 1) == etag.size() - 1;
}

/// The head of an answer, taken line by line.
struct HttpAnswer {
    int status = 0;
    std::optional<ContentRange> range{};
    std::optional<std::uint64_t> content_length{};
    std::string etag{}, last_modified{};
    bool is_encoded = false;    ///< compressed, say
    bool is_elsewhere = false;  ///< names a location

    void clear() {
        status = 0;
        range.reset();
        content_length.reset();
        etag.clear();
        last_modified.clear();
        is_encoded = is_elsewhere = false;
    }

    void take(std::string_view line) {
        if (line.starts_with(' ') || line.starts_with('\t')) return;  // goes on with a field that nobody asked for
        line = trimmed(line);
        if (line.starts_with("HTTP/")) {
            clear();
            const std::size_t blank = std::min(line.find(' '), line.size());
            status = int(parsed_number(trimmed(line.substr(blank)).substr(0, 3)).value_or(0));
            return;
        }
        const std::size_t colon = line.find(':');
        if (colon == line.npos) return;
        const std::string_view name = line.substr(0, colon), value = trimmed(line.substr(colon + 1));
        if (is_same_name(name, "Content-Range")) range = parsed_content_range(value);
        if (is_same_name(name, "Content-Length")) content_length = parsed_number(value);
        if (is_same_name(name, "ETag")) etag = value;
        if (is_same_name(name, "Last-Modified")) last_modified = value;
        if (is_same_name(name, "Content-Encoding")) is_encoded = !is_same_name(value, "identity");
        if (is_same_name(name, "Location")) is_elsewhere = !value.empty();
    }

    /// Another answer follows: after 100 Continue, or from the location that this one names.
    bool is_interim() const {
        const bool redirects = status == 301 || status == 302 || status == 303 || status == 307 || status == 308;
        return status / 100 == 1 || (redirects && is_elsewhere);
    }
};

/// What is to be done with an answer whose head has come. Bytes are taken only where it `wants_body`.
struct HttpVerdict {
    ReadStatus status = ReadStatus::done;
    const char* why = "";  ///< what follows "answers 503: "
    bool wants_body = false;
};

/// The answer to the first request, of bytes 0 to `count` - 1, fewer if there are no more. Where it is done without a
/// body the file is empty.
inline HttpVerdict judged_first(const HttpAnswer& a, std::uint64_t count) {
    switch (a.status) {
        case 206:
            if (!a.range || !a.range->first) return {ReadStatus::refused, "it does not say which bytes it sends"};
            if (!a.range->size) return {ReadStatus::refused, "it does not say how large the file is"};
            if (*a.range->first != 0 || *a.range->last != std::min(count, *a.range->size) - 1) {
                return {ReadStatus::refused, "it sends other bytes than it was asked for"};
            }
            if (a.content_length && *a.content_length != *a.range->last + 1) {
                return {ReadStatus::refused, "it sends another number of bytes than it says"};
            }
            if (a.is_encoded) return {ReadStatus::refused, "it sends the file encoded: switch compression off for it"};
            return {ReadStatus::done, "", true};
        case 200:
            if (a.content_length == 0u) return {};
            return {ReadStatus::refused,
                    "the server sends whole files only: use one that sends ranges of bytes (Accept-Ranges: bytes)"};
        case 416:
            if (a.range && a.range->size == 0u) return {};
            return {ReadStatus::refused, "the server does not send the beginning of the file"};
        case 404:
        case 410:
            return {ReadStatus::refused, "there is no such file: check the address"};
        case 401:
        case 403:
        case 407:
            return {ReadStatus::refused, "it may not be read: check the permissions, or give user and password"};
        default:
            break;
    }
    if (a.status == 408 || a.status == 425 || a.status == 429 || a.status / 100 == 5) {
        return {ReadStatus::unavailable, "the server cannot do it now: try again later"};
    }
    return {ReadStatus::refused, "that is no answer to a request for a range of bytes"};
}

/// Whether what the answer says of the file is true of another one only. What it does not say it cannot deny, but for
/// the ETag: a server that sent one sends it with every part (RFC 9110, 15.3.7).
inline bool is_of_another_file(const HttpAnswer& a, const HttpIdentity& file) {
    if (!file.etag.empty()) return a.etag != file.etag;
    return !file.last_modified.empty() && !a.last_modified.empty() && a.last_modified != file.last_modified;
}

/// The answer to a later request, of bytes `first` to `last`, which lie within the file. The server could do it when
/// the file was opened: what else it says now than that the file is another one may pass.
inline HttpVerdict judged(const HttpAnswer& a, std::uint64_t first, std::uint64_t last, const HttpIdentity& file) {
    const HttpVerdict changed{ReadStatus::changed, "the file has changed since it was opened: open it again"};
    switch (a.status) {
        case 206:
            if (!a.range || !a.range->first || !a.range->size) {
                return {ReadStatus::unavailable, "it does not say which bytes it sends"};
            }
            if (*a.range->size != file.size || is_of_another_file(a, file)) return changed;
            if (*a.range->first != first || *a.range->last != last) {
                return {ReadStatus::unavailable, "it sends other bytes than it was asked for"};
            }
            if (a.content_length && *a.content_length != last - first + 1) {
                return {ReadStatus::unavailable, "it sends another number of bytes than it says"};
            }
            if (a.is_encoded) return {ReadStatus::unavailable, "it sends the file encoded"};
            return {ReadStatus::done, "", true};
        case 200:
            if (is_of_another_file(a, file) || (a.content_length && *a.content_length != file.size)) return changed;
            return {ReadStatus::unavailable, "the server sends the whole file instead of a range of bytes"};
        case 416:
            if (a.range && a.range->size == file.size) {
                return {ReadStatus::unavailable, "the server does not send bytes that it has"};
            }
            return changed;
        case 410:
            return {ReadStatus::changed, "the file is gone for good"};
        case 412:
            return changed;
        case 404:
            return {ReadStatus::unavailable, "the file is not there any more"};
        case 401:
        case 403:
        case 407:
            return {ReadStatus::unavailable, "it may not be read any more"};
        default:
            break;
    }
    if (a.status == 0) return {ReadStatus::unavailable, "that is no status"};
    if (a.status == 408 || a.status == 425 || a.status == 429 || a.status / 100 == 5) {
        return {ReadStatus::unavailable, "the server cannot do it now"};
    }
    return {ReadStatus::refused, "that is no answer to a request for a range of bytes"};
}

}  // namespace farfield::detail
