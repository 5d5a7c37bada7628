// A hierarchy that lies in a file of pages, with its primitives, and is in memory only where frames look.
//
// To a descent it is a hierarchy like any other: nodes, stand-ins and primitives are arrays, those of a cache's whole
// memory, and whatever lies in a page that is there has its index in them. Where a node's contents are in another page,
// follow() gives the index that they have now; or they are missing, the node's stand-in is drawn, which lies in its
// parent's page, and there is never a hole (Klein et al. 2002, section 6).
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/frame/subtree.hpp"
#include "farfield/frame/view_ahead.hpp"
#include "farfield/geometry/mixed.hpp"
#include "farfield/paging/page_cache.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/paging/page_source.hpp"
#include "farfield/paging/page_user.hpp"
#include "farfield/storage/notes.hpp"

namespace farfield {

/// Every viewer takes a copy of its own, which is cheap; copies share the cache. A copy is not to be used by two
/// threads at once.
template <Pageable H, PageablePrimitive P>
class PagedHierarchy {
  public:
    using partition_type = typename H::partition_type;
    using approximation_type = typename H::approximation_type;
    using cost_model_type = typename H::cost_model_type;
    using node_data = typename H::node_data;
    using stand_in_data = typename H::stand_in_data;
    using pool_element = typename H::pool_element;
    using primitive_type = P;
    static constexpr Assignment assignment = H::assignment;
    static constexpr OrderGuarantee ordering = H::ordering;

    /// A copy, with a use of the cache for itself.
    PagedHierarchy(const PagedHierarchy& other) : file_(other.file_), user_(file_->cache), waits_(other.waits_) {}
    PagedHierarchy& operator=(const PagedHierarchy&) = delete;

    const partition_type& partition_policy() const { return file_->partition; }
    const approximation_type& approximation_policy() const { return file_->approximation; }
    const cost_model_type& cost_policy() const { return file_->cost; }
    const HierarchyFacts& facts() const { return file_->header.facts; }
    const BuildReport& report() const { return facts().report; }
    const Cell& root_cell() const { return facts().root; }
    const Box& bounds() const { return facts().bounds; }
    glm::dvec3 origin() const { return facts().origin; }
    std::uint64_t primitive_count() const { return facts().primitive_count; }
    std::uint64_t fingerprint() const { return facts().fingerprint; }
    std::uint64_t node_count() const { return file_->header.node_count; }
    const Work& whole_work() const { return facts().work; }
    /// What is said of it in its file.
    const Notes& notes() const { return file_->notes; }
    /// Bytes of the file, without notes.
    std::uint64_t bytes() const { return file_->header.file_bytes; }
    std::uint32_t page_count() const { return file_->header.page_count; }
    std::uint32_t page_bytes() const { return file_->header.page_bytes; }
    bool keeps_strict_order() const { return false; }
    bool is_from_file() const { return true; }

    /// What pages are in memory, and how they came there. Of all copies together.
    PageCacheStats cache_stats() const { return file_->cache->stats(); }
    /// Loads what the last frames wanted, on this thread, until nothing is left that can be loaded now; returns the
    /// number of pages. Frames after it are the same as if nothing had been missing, once it returns 0.
    std::size_t load_wanted() { return file_->cache->load_wanted(); }
    /// Whether frames wait for pages instead of drawing something coarser: for pictures, not for walks. It counts for
    /// copies that are made afterwards too.
    void wait_for_pages(bool waits) { waits_ = waits; }
    bool waits_for_pages() const { return waits_; }

    // What a descent asks.

    /// Arrays of the cache's memory. Only what has been reached through follow() may be looked at, until the frame
    /// ends.
    std::span<const Node> nodes() const { return memory_as<Node>(); }
    std::span<const stand_in_data> stand_ins() const { return memory_as<stand_in_data>(); }
    std::span<const P> primitives() const { return memory_as<P>(); }
    std::span<const std::uint32_t> order() const { return {}; }
    std::span<const pool_element> pool() const { return {}; }
    Fragments fragments() const { return {}; }
    /// Positions, used or not.
    std::uint32_t item_count() const {
        return facts().report.items == 0 ? 0u : std::uint32_t(std::min<std::size_t>(primitives().size(), 0xffffffffu));
    }
    node_data data_of(std::uint32_t node) const {
        if constexpr (std::is_empty_v<node_data>) {
            return {};
        } else {
            const std::size_t at = std::size_t(node) * sizeof(Node), begin = at / page_bytes() * page_bytes();
            const auto first = std::uint32_t((begin + sizeof(detail::PageHeader)) / sizeof(Node));
            const detail::PageLayout layout = Records::layout(header_at(begin).node_count, 0, 0);
            node_data data;
            std::memcpy(&data, memory() + begin + layout.node_data + std::size_t(node - first) * sizeof data,
                        sizeof data);
            return data;
        }
    }
    void prefetch_data_of(std::uint32_t) const {}
    /// The same wherever its page lies.
    std::uint32_t name_of(std::uint32_t node) const {
        const std::size_t at = std::size_t(node) * sizeof(Node), in_page = at % page_bytes();
        return std::uint32_t(detail::mixed(header_at(at - in_page).number, std::uint64_t(in_page)));
    }

    std::uint64_t name_of_item(std::uint32_t position) const {
        const std::size_t at = std::size_t(position) * sizeof(primitive_type), in_page = at % page_bytes();
        return detail::mixed(header_at(at - in_page).number, std::uint64_t(in_page));
    }

    /// The root, which is always there: its own stand-in is not needed.
    Subtree whole() const {
        Subtree s;
        s.cell = root_cell();
        enter_unit(s, 0, detail::portal_of(file_->header.root).unit);
        return s;
    }
    /// Whether a node's contents are in another page.
    static bool is_portal(const Node& node) { return detail::is_portal(node); }
    static std::uint32_t items_below(const Node& portal) { return detail::portal_of(portal).items; }
    /// A box that holds what lies there and the portal's cell.
    static Box reach_of(const Node& portal, const Cell& cell) { return detail::portal_of(portal).reach.box(cell); }
    /// Turns a portal into the node that it stands for. False, and nothing is done, if the page is missing or not what
    /// it should be: it has been asked for, the more urgently the larger `weight` is. A page counts no more than the
    /// one that leads to it, so that nothing is left in memory that nothing leads to.
    bool follow(Subtree& subtree, float weight) const {
        const detail::Portal to = detail::portal_of(nodes()[subtree.node]);
        weight = user_.within(slot_of(subtree.node), weight);
        return enter(subtree, to, waits_ ? user_.find_or_wait(to.page, weight) : user_.find(to.page, weight));
    }
    /// The same, of what frames to come may draw: it is asked for less urgently than anything that a frame needs.
    bool expect(Subtree& subtree, float weight) const {
        const detail::Portal to = detail::portal_of(nodes()[subtree.node]);
        weight = user_.within(slot_of(subtree.node), detail::PageUser::when_expected(weight));
        return enter(subtree, to, user_.find(to.page, weight));
    }
    /// The page that a position lies in, and which of its primitives is there.
    std::array<std::uint32_t, 2> place_in_file(std::uint32_t position) const {
        const std::size_t byte = std::size_t(position) * sizeof(P), begin = byte / page_bytes() * page_bytes();
        const detail::PageHeader& header = header_at(begin);
        const std::size_t items = begin + Records::layout(header.node_count, header.stand_in_count, 0).items;
        return {header.number, std::uint32_t((byte - items) / sizeof(P))};
    }
    /// Tells what a frame shows, which begins: the motion since the last one says what those to come will show.
    void look_ahead(const View& view) const {
        constexpr float frames = 6;
        const std::optional<View> ahead = motion_.ahead(view, frames);
        view_ahead_.reset();
        if (ahead) view_ahead_.emplace(*ahead, origin(), bounds());
    }
    /// The view that is expected a few frames from now; null while it stands still.
    const LocalView* view_ahead() const { return view_ahead_ ? &*view_ahead_ : nullptr; }
    void begin_frame() const { user_.begin_frame(); }
    void end_frame() const { user_.end_frame(); }
    /// Nothing that it has looked at is kept for it any more.
    void forget() const { user_.forget(); }
    bool is_in_frame() const { return user_.is_in_frame(); }

  private:
    using Records = detail::PageRecords<H, P>;
    template <Pageable H2, PageablePrimitive P2, PageSource S>
    friend PagedHierarchy<H2, P2> open_pages_of(std::shared_ptr<S>, const std::string&, const PageCacheOptions&);

    struct File {
        detail::PageFileHeader header;
        partition_type partition{};
        approximation_type approximation{};
        cost_model_type cost{};
        Notes notes;
        std::shared_ptr<detail::PageCache> cache;
    };
    explicit PagedHierarchy(std::shared_ptr<const File> file) : file_(std::move(file)), user_(file_->cache) {}

    bool has_root() const { return detail::portal_of(file_->header.root).unit < header_at(0).unit_count; }

    const std::byte* memory() const { return file_->cache->memory(); }
    template <class T>
    std::span<const T> memory_as() const {
        return {reinterpret_cast<const T*>(memory()), file_->cache->memory_bytes() / sizeof(T)};
    }
    const detail::PageHeader& header_at(std::size_t begin) const {
        return *reinterpret_cast<const detail::PageHeader*>(memory() + begin);
    }
    std::uint32_t slot_of(std::uint32_t node) const { return node / (page_bytes() / std::uint32_t(sizeof(Node))); }
    void enter_unit(Subtree& s, std::uint32_t slot, std::uint32_t unit) const {
        const auto first =
            std::uint32_t((std::size_t(slot) * page_bytes() + sizeof(detail::PageHeader)) / sizeof(Node));
        s.node = first + unit;
        s.end_item = nodes()[s.node + 1].first_item;
    }

    bool enter(Subtree& subtree, const detail::Portal& to, std::uint32_t slot) const {
        if (slot == detail::PageSlots::none) return false;
        const detail::PageHeader& header = header_at(std::size_t(slot) * page_bytes());
        // A descent is a recursion, and no file decides how deep it goes, nor how long it takes.
        if (to.unit >= header.unit_count || subtree.cell.depth >= most_levels_in_files ||
            !user_.may_enter(to.page, header.unit_count)) {
            return false;
        }
        enter_unit(subtree, slot, to.unit);
        return true;
    }

    std::shared_ptr<const File> file_;
    mutable detail::PageUser user_;
    mutable detail::Motion motion_;
    mutable std::optional<LocalView> view_ahead_;
    bool waits_ = false;
};

}  // namespace farfield
