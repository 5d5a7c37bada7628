// The best gap between things along a line: the scan of two sorted lists of Shade et al. 1996, section 4.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "farfield/partition/extent.hpp"

namespace farfield::detail {

/// A place for a plane. What ends at `at` or before lies behind it, what begins there or after lies in front.
struct Gap {
    float at = 0;
    float price = std::numeric_limits<float>::infinity();  ///< infinite: there is none
    std::size_t active = 0;                                ///< things that cross it
    float length = 0;                                      ///< of all things together

    bool is_found() const { return price < std::numeric_limits<float>::infinity(); }
};

/// Gaps are where something ends and something else begins next: there the number of things that a plane crosses is a
/// local minimum. The price of one is (1 + price_of_split * things crossed) / balance, where the balance is 4 a (1 - a)
/// and `a` the share of the weight behind it, half of what is crossed included. (The paper leaves the function open. A
/// quotient needs no other weight where there are more things: a plane of twice the use may cross twice as many.)
///
/// Sorting everything for every plane would take n log^2 n for a tree. So things are counted in bins first, each of
/// which tells what a gap in it could cost at the least, and only the most promising ones are sorted, up to an eighth
/// of the whole.
class GapSearch {
  public:
    /// `most_active`: planes that cross a larger share of the things are none.
    GapSearch(float price_of_split, float most_active) : price_of_split_(price_of_split), most_active_(most_active) {}

    Gap best(std::span<const Extent> things) {
        things_ = things;
        best_ = {};
        if (things.size() < 2) return best_;
        float first = things[0].lower, last = things[0].upper;
        double weight = 0;
        for (const Extent& e : things) {
            first = std::min(first, e.lower);
            last = std::max(last, e.upper);
            weight += double(e.weight);
        }
        best_.length = last - first;
        counts_as_one_ = !(weight > 0);
        per_weight_ = 1 / (counts_as_one_ ? double(things.size()) : weight);
        most_crossed_ = std::size_t(double(most_active_) * double(things.size()));
        // Enough that few things begin or end in one, and not so many that clearing them costs more than things do.
        bins_ = std::min(std::max(std::min<std::size_t>(things.size(), 256), things.size() / 32), most_bins);
        const float bins_per_unit = float(bins_) / (last - first);
        if (things.size() <= few) {
            take_all();
        } else {
            take_bins(first, std::isfinite(bins_per_unit) ? bins_per_unit : 0);
        }
        return best_;
    }

  private:
    static constexpr std::size_t few = 64, most_bins = 1024, most_lists = 128, few_bounds = 256;
    static constexpr float infinity = std::numeric_limits<float>::infinity();

    using Bound = EndOfExtent;
    using Counts = CountedEnds;
    struct State {
        Counts begun, ended;
    };
    struct Bin {
        Counts begun{}, ended{};
        float first_begin = infinity, first_end = infinity;
    };
    /// A bin that may hold the best gap.
    struct Promise {
        float least_price;
        std::uint32_t bin;
        State before;
    };
    /// Where a bin's bounds lie among those that are sorted.
    struct List {
        std::size_t begins, ends;
    };

    Bound bound_of(const Extent& e, float at) const {
        return {at, counts_as_one_ ? 1.0f : e.weight, e.blocks, e.lower == e.upper};
    }
    Bound begin_of(const Extent& e) const { return bound_of(e, e.lower); }
    Bound end_of(const Extent& e) const { return bound_of(e, e.upper); }

    /// Most cells of a tree hold few things, and to sort them by branches that nobody foresees would cost more than all
    /// else: the place of each is the number of those before it.
    void take_all() {
        const std::size_t n = things_.size();
        std::array<Bound, few> begins{}, ends{};
        std::array<float, few> begin_at{}, end_at{};
        std::array<std::uint32_t, few> begin_place{}, end_place{};
        for (std::size_t i = 0; i < n; ++i) {
            begin_at[i] = things_[i].lower;
            end_at[i] = things_[i].upper;
        }
        for (std::size_t j = 0; j < n; ++j) {
            const float begin = begin_at[j], end = end_at[j];
            for (std::size_t i = 0; i < j; ++i) begin_place[i] += begin < begin_at[i];
            for (std::size_t i = j + 1; i < n; ++i) begin_place[i] += begin <= begin_at[i];
            for (std::size_t i = 0; i < j; ++i) end_place[i] += end < end_at[i];
            for (std::size_t i = j + 1; i < n; ++i) end_place[i] += end <= end_at[i];
        }
        for (std::size_t i = 0; i < n; ++i) {
            begins[begin_place[i]] = begin_of(things_[i]);
            ends[end_place[i]] = end_of(things_[i]);
        }
        for (std::size_t i = 1; i < n; ++i) {
            for (std::size_t j = i; j > 0 && is_before(begins[j], begins[j - 1]); --j) {
                std::swap(begins[j], begins[j - 1]);
            }
        }
        scan({begins.data(), n}, {ends.data(), n}, {}, infinity);
    }

    // --- many

    void take_bins(float first, float bins_per_unit) {
        const auto bin_of = [&](float at) {
            const float bin = (at - first) * bins_per_unit;  // NaN beyond what single precision holds
            return std::uint16_t(bin > 0 ? std::min(bin, float(bins_ - 1)) : 0.0f);
        };
        bin_.assign(bins_, Bin{});
        places_.resize(things_.size());
        for (std::size_t i = 0; i < things_.size(); ++i) {
            const Extent& e = things_[i];
            places_[i] = {bin_of(e.lower), bin_of(e.upper)};
            Bin& b = bin_[places_[i][0]];
            b.begun.add(begin_of(e));
            b.first_begin = std::min(b.first_begin, e.lower);
            Bin& d = bin_[places_[i][1]];
            d.ended.add(end_of(e));
            d.first_end = std::min(d.first_end, e.upper);
        }
        promises_.clear();
        State state;
        for (std::size_t i = 0; i < bins_; ++i) {
            const State before = state;
            state.begun.add(bin_[i].begun);
            state.ended.add(bin_[i].ended);
            if (bin_[i].ended.things == 0) continue;
            const float least = least_price(before, state);
            if (least < infinity) promises_.push_back({least, std::uint32_t(i), before});
        }
        std::sort(promises_.begin(), promises_.end(), [](const Promise& a, const Promise& b) {
            return a.least_price != b.least_price ? a.least_price < b.least_price : a.bin < b.bin;
        });
        // The best bins mostly have the best gap, and then the others are not even gathered.
        std::size_t lists = 0, bounds = 0;
        for (const std::size_t most_bounds : {things_.size() / 32, std::max(things_.size() / 4, few_bounds)}) {
            const std::size_t first_list = lists;
            lists = number_bins(first_list, most_bounds, bounds);
            if (lists == first_list) return;
            gather_lists();
            for (std::size_t l = first_list; l < lists; ++l)
                scan_list(promises_[l], lists_[l - first_list], lists_[l - first_list + 1]);
        }
    }

    /// No gap in the bin costs less: at best everything that ends in it has ended, and the balance is the best that is
    /// met on the way.
    float least_price(const State& before, const State& after) const {
        const std::size_t open = before.begun.things - before.ended.things,
                          ends = after.ended.things - before.ended.things, crossed = open > ends ? open - ends : 0;
        const double from = share(before), to = share(after);
        return price(crossed, from > 0.5 ? from : std::min(to, 0.5));
    }

    /// Numbers the bins of the most promising lists from one on, as many as hold some bounds more than `most_bounds`
    /// with those before; returns the end of these lists.
    std::size_t number_bins(std::size_t first_list, std::size_t most_bounds, std::size_t& bounds) {
        list_.fill(0);
        lists_[0] = {};
        std::size_t end = first_list;
        for (; end < std::min(promises_.size(), most_lists); ++end) {
            const Promise& p = promises_[end];
            if ((end != 0 && bounds > most_bounds) || !(p.least_price < best_.price)) break;
            const Bin& bin = bin_[p.bin];
            const List& before = lists_[end - first_list];
            list_[p.bin] = std::uint8_t(end - first_list + 1);
            lists_[end - first_list + 1] = {before.begins + bin.begun.things, before.ends + bin.ended.things};
            bounds += bin.begun.things + bin.ended.things;
        }
        begins_.resize(lists_[end - first_list].begins);
        ends_.resize(lists_[end - first_list].ends);
        return end;
    }
    /// Puts the bounds of numbered bins into their lists.
    void gather_lists() {
        std::array<List, most_lists + 1> next = lists_;
        for (std::size_t i = 0; i < things_.size(); ++i) {
            const std::uint8_t begin = list_[places_[i][0]], end = list_[places_[i][1]];
            if (begin != 0) begins_[next[begin - 1u].begins++] = begin_of(things_[i]);
            if (end != 0) ends_[next[end - 1u].ends++] = end_of(things_[i]);
        }
    }
    void scan_list(const Promise& p, const List& from, const List& to) {
        if (!(p.least_price < best_.price)) return;
        const auto begins = std::span(begins_).subspan(from.begins, to.begins - from.begins),
                   ends = std::span(ends_).subspan(from.ends, to.ends - from.ends);
        std::sort(begins.begin(), begins.end(), is_before);
        std::sort(ends.begin(), ends.end(), [](const Bound& a, const Bound& b) { return a.at < b.at; });
        scan(begins, ends, p.before, next_begin(p.bin + 1));
    }

    /// Where something begins after a bin before anything ends; infinity if something ends first, which makes a better
    /// gap than one before it.
    float next_begin(std::size_t bin) const {
        while (bin < bins_ && bin_[bin].begun.things + bin_[bin].ended.things == 0) ++bin;
        if (bin == bins_) return infinity;
        return bin_[bin].first_begin <= bin_[bin].first_end ? bin_[bin].first_begin : infinity;
    }

    // --- the scan

    static constexpr auto is_before = [](const Bound& a, const Bound& b) {
        return a.at != b.at ? a.at < b.at : a.is_flat && !b.is_flat;
    };

    /// Goes through sorted bounds from what came before them; `next` is where something begins after them. At one place
    /// things without extent come first, whole, then all that end there, then all that begin: to touch is not to
    /// overlap.
    void scan(std::span<const Bound> begins, std::span<const Bound> ends, State state, float next) {
        std::size_t b = 0;
        for (std::size_t e = 0; e < ends.size();) {
            const float end = ends[e].at;
            while (b < begins.size() && (begins[b].at < end || (begins[b].at == end && begins[b].is_flat))) {
                state.begun.add(begins[b++]);
            }
            while (e < ends.size() && ends[e].at == end) state.ended.add(ends[e++]);
            const float begin = b < begins.size() ? begins[b].at : next;
            if (begin < infinity && !(e < ends.size() && ends[e].at < begin)) offer(state, end, begin);
        }
    }

    void offer(const State& state, float end, float begin) {
        if (state.ended.things == 0 || state.begun.things == things_.size()) return;
        if (state.begun.blocking != state.ended.blocking) return;
        const std::size_t crossed = state.begun.things - state.ended.things;
        const float p = price(crossed, share(state));
        if (!(p < best_.price)) return;
        // In the middle, as long as rounding leaves it before the next begin.
        const float middle = end * 0.5f + begin * 0.5f;
        best_.at = end < middle && middle < begin ? middle : end;
        best_.price = p;
        best_.active = crossed;
    }

    double share(const State& s) const { return 0.5 * (s.begun.weight + s.ended.weight) * per_weight_; }
    float price(std::size_t crossed, double share) const {
        if (crossed > most_crossed_) return infinity;
        // Next to nothing on one side is still worth something.
        const double balance = std::max(4 * share * (1 - share), 1e-9);
        return float((1 + double(price_of_split_) * double(crossed)) / balance);
    }

    float price_of_split_, most_active_;
    std::span<const Extent> things_{};
    Gap best_{};
    bool counts_as_one_ = false;  ///< nothing weighs anything
    double per_weight_ = 0;
    std::size_t most_crossed_ = 0, bins_ = 0;
    std::vector<Bin> bin_{};
    std::vector<std::array<std::uint16_t, 2>> places_{};  ///< bins of each thing's ends
    std::vector<Promise> promises_{};                     ///< best first
    std::array<std::uint8_t, most_bins> list_{};          ///< of a bin: 1 and more where its bounds are sorted
    std::array<List, most_lists + 1> lists_;              ///< where each begins, and the last one ends
    std::vector<Bound> begins_{}, ends_{};                ///< of these lists
};

}  // namespace farfield::detail
