// Words with the line they stand in, of OFF and its relatives. Not for users, as load_detail.hpp.
#pragma once

#include <algorithm>

#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {

/// Braces are words of their own; from '#' to the end of a line is a comment.
class Words {
  public:
    explicit Words(std::string_view text, std::size_t line = 1) : text_(text), line_(line) { skip(); }

    bool done() const { return at_ == text_.size(); }
    std::size_t line() const { return line_; }
    std::size_t bytes_left() const { return text_.size() - at_; }
    /// From the next word on.
    std::string_view rest() const { return text_.substr(at_); }

    /// Empty at the end.
    std::string_view peek() const {
        if (done()) return {};
        std::size_t end = at_ + 1;
        if (!is_brace(text_[at_])) {
            while (end < text_.size() && !is_space(text_[end]) && text_[end] != '#' && !is_brace(text_[end])) ++end;
        }
        return text_.substr(at_, end - at_);
    }
    std::string_view next(std::string_view wanted) {
        if (done()) throw std::runtime_error("ends where " + std::string(wanted) + " should be");
        const std::string_view word = peek();
        at_ += word.size();
        skip();
        return word;
    }
    template <class T>
    T next_number(std::string_view wanted) {
        const std::size_t line = line_;
        const std::string_view word = next(wanted);
        const std::optional<T> value = number<T>(word);
        if (!value) fail(line, in_quotes(word) + " where " + std::string(wanted) + " should be");
        return *value;
    }
    /// The words left in line `line`, up to a brace.
    std::vector<std::string_view> rest_of(std::size_t line) {
        std::vector<std::string_view> result;
        while (!done() && line_ == line && !is_brace(text_[at_])) result.push_back(next(""));
        return result;
    }
    void back_over(std::string_view word, std::size_t keep) {
        at_ = static_cast<std::size_t>(word.data() - text_.data()) + keep;
    }

    [[noreturn]] static void fail(std::size_t line, const std::string& reason) {
        throw std::runtime_error("line " + std::to_string(line) + ": " + reason);
    }

  private:
    static bool is_brace(char c) { return c == '{' || c == '}'; }

    void skip() {
        for (; at_ < text_.size(); ++at_) {
            if (text_[at_] == '#') at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
            if (at_ == text_.size()) return;
            if (!is_space(text_[at_])) return;
            line_ += text_[at_] == '\n' || (text_[at_] == '\r' && text_.substr(at_, 2) != "\r\n");
        }
    }

    std::string_view text_;
    std::size_t at_ = 0;
    std::size_t line_;
};

/// An OFF from the next word on, which is its keyword or the first count; binary ones go to the end of the text.
Mesh read_off_object(Words& words, Rgba8 color_of_others);

}  // namespace farfield::scenes::detail
