#include "scenes/load/json.hpp"

#include <stdexcept>

#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {
namespace {

class Parser {
  public:
    explicit Parser(std::string_view text) : text_(text) {}

    Json document() {
        Json result = value(0);
        skip();
        if (at_ != text_.size()) fail("more after the end of the JSON");
        return result;
    }

  private:
    [[noreturn]] void fail(const std::string& reason) const {
        throw std::runtime_error("JSON byte " + std::to_string(at_) + ": " + reason);
    }

    void skip() {
        while (at_ < text_.size() && is_space(text_[at_])) ++at_;
    }
    char peek() {
        skip();
        if (at_ == text_.size()) fail("ends too early");
        return text_[at_];
    }
    bool take(char c) {
        if (peek() != c) return false;
        ++at_;
        return true;
    }
    void expect(char c) {
        if (!take(c)) fail(std::string("no '") + c + "'");
    }

    Json value(int depth) {
        if (depth > 64) fail("nested too deeply");
        switch (peek()) {
            case '{':
                return {object(depth)};
            case '[':
                return {array(depth)};
            case '"':
                return {string()};
            default:
                return literal();
        }
    }

    Json::Object object(int depth) {
        Json::Object members;
        expect('{');
        if (take('}')) return members;
        do {
            if (peek() != '"') fail("no name");
            std::string name = string();
            expect(':');
            members.insert_or_assign(std::move(name), value(depth + 1));
        } while (take(','));
        expect('}');
        return members;
    }

    Json::Array array(int depth) {
        Json::Array items;
        expect('[');
        if (take(']')) return items;
        do {
            items.push_back(value(depth + 1));
        } while (take(','));
        expect(']');
        return items;
    }

    std::string string() {
        std::string result;
        for (++at_; at_ < text_.size(); ++at_) {
            const char c = text_[at_];
            if (c == '"') {
                ++at_;
                return result;
            }
            if (static_cast<unsigned char>(c) < ' ') fail("a control character in a string");
            result.push_back(c == '\\' ? escaped() : c);
        }
        fail("ends within a string");
    }

    /// Leaves `at_` at the last character of the escape.
    char escaped() {
        if (++at_ >= text_.size()) fail("ends within a string");
        switch (text_[at_]) {
            case '"':
                return '"';
            case '\\':
                return '\\';
            case '/':
                return '/';
            case 'b':
                return '\b';
            case 'f':
                return '\f';
            case 'n':
                return '\n';
            case 'r':
                return '\r';
            case 't':
                return '\t';
            case 'u':
                break;
            default:
                fail("an unknown escape");
        }
        if (text_.size() - at_ < 5) fail("ends within a string");
        unsigned code = 0;
        const char* const digits = text_.data() + at_ + 1;
        if (std::from_chars(digits, digits + 4, code, 16).ptr != digits + 4) fail("an escape without four digits");
        at_ += 4;
        return code < 128 ? static_cast<char>(code) : '?';
    }

    Json literal() {
        const std::size_t begin = at_;
        while (at_ < text_.size() && !is_space(text_[at_]) &&
               std::string_view(",]}:\"[{").find(text_[at_]) == std::string_view::npos) {
            ++at_;
        }
        const std::string_view word = text_.substr(begin, at_ - begin);
        if (word == "null") return {nullptr};
        if (word == "true") return {true};
        if (word == "false") return {false};
        // Neither "inf" nor "nan" is JSON.
        const bool digit = !word.empty() && (word[0] == '-' || (word[0] >= '0' && word[0] <= '9'));
        const std::optional<double> n = digit ? scenes::detail::number<double>(word) : std::nullopt;
        if (!n || !std::isfinite(*n)) {
            at_ = begin;
            fail(in_quotes(word) + " is no value");
        }
        return {*n};
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

}  // namespace

Json parse_json(std::string_view text) {
    return Parser(text).document();
}

}  // namespace farfield::scenes::detail
