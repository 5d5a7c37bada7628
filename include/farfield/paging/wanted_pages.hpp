// What frames have not found, and in what order it is to be read.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace farfield::detail {

/// A page that a frame has missed, or will.
struct WantedPage {
    float weight = 0;
    std::uint32_t page = 0;
    friend bool operator==(const WantedPage&, const WantedPage&) = default;
};

/// What weighs less is not needed by a frame, but expected by those to come.
inline constexpr float least_weight_needed = 0.5f;

/// Those of one user, frame after frame.
class WantedPages {
  public:
    explicit WantedPages(std::uint32_t page_count) : asked_(page_count) {}

    void begin(std::uint32_t frame) {
        pages_.clear();
        frame_ = frame;
    }
    /// Of several weights the largest holds.
    void ask(std::uint32_t page, float weight) {
        Asked& asked = asked_[page];
        if (asked.frame == frame_) {
            WantedPage& w = pages_[asked.index];
            w.weight = std::max(w.weight, weight);
            return;
        }
        asked = {frame_, std::uint32_t(pages_.size())};
        pages_.push_back({weight, page});
    }
    /// What was asked for since begin(), the most wanted first. More will not be there before the next frame, which
    /// asks anew; and of what is expected some each frame: it is not needed at once, and reading it all would keep what
    /// is.
    std::vector<WantedPage>& in_order() {
        const std::size_t kept = std::min(pages_.size(), most_pages);
        std::partial_sort(pages_.begin(), pages_.begin() + std::ptrdiff_t(kept), pages_.end(),
                          [](const WantedPage& a, const WantedPage& b) {
                              return a.weight != b.weight ? a.weight > b.weight : a.page < b.page;
                          });
        pages_.resize(kept);
        const auto first_expected = std::find_if(pages_.begin(), pages_.end(),
                                                 [](const WantedPage& w) { return w.weight < least_weight_needed; });
        if (std::size_t(pages_.end() - first_expected) > most_expected) {
            pages_.erase(first_expected + most_expected, pages_.end());
        }
        return pages_;
    }

  private:
    static constexpr std::size_t most_pages = 512;
    static constexpr std::size_t most_expected = 8;
    struct Asked {
        std::uint32_t frame = 0, index = 0;
    };

    std::vector<Asked> asked_;  ///< by page: the frame that it was asked for in, and where it is in `pages_`
    std::vector<WantedPage> pages_;
    std::uint32_t frame_ = 0;
};

/// What one read is made of: `first`, and those of `others`, any order, that lie near it in a file, so that all of them
/// span at most `most_pages` and are no more than `gap` pages apart. may_merge(page) says whether one may be read now.
template <class MayMerge>
std::vector<WantedPage> pages_of_one_read(const WantedPage& first_wanted, std::vector<WantedPage> others,
                                          std::uint32_t most_pages, std::uint32_t gap, MayMerge&& may_merge) {
    const auto is_before = [](const WantedPage& a, const WantedPage& b) { return a.page < b.page; };
    std::vector<WantedPage> read{first_wanted};
    std::sort(others.begin(), others.end(), is_before);
    std::uint32_t first = first_wanted.page, last = first;
    const auto above = std::upper_bound(others.begin(), others.end(), first_wanted, is_before);
    for (auto i = above; i != others.end() && i->page - last <= gap && i->page - first < most_pages; ++i) {
        if (!may_merge(i->page)) continue;
        read.push_back(*i);
        last = i->page;
    }
    for (auto i = above; i != others.begin();) {
        --i;
        if (i->page == first) continue;
        if (first - i->page > gap || last - i->page >= most_pages) break;
        if (!may_merge(i->page)) continue;
        read.push_back(*i);
        first = i->page;
    }
    return read;
}

}  // namespace farfield::detail
