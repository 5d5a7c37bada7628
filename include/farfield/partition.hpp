// A partition says how space is divided, and in which order its parts are visited: the first of the three policies.
//
// A policy announces itself by a `facts` constant. A flag that is set there makes the hooks beside it required, so that
// a misspelt hook does not compile instead of drawing nothing.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <type_traits>

#include "farfield/geometry/box.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/cell_polygons.hpp"
#include "farfield/geometry/visit_order.hpp"

namespace farfield {

namespace detail {
/// Policies and samplers may say what is wrong with their options: `const char* wrong_option() const`, null where all
/// is well. Builds ask before anything is done, open() of what files say.
template <class T>
concept ChecksOptions = requires(const T& policy) {
    { policy.wrong_option() } -> std::same_as<const char*>;
};
template <class T>
const char* wrong_option([[maybe_unused]] const T& policy) {
    if constexpr (ChecksOptions<T>) {
        return policy.wrong_option();
    } else {
        return nullptr;
    }
}
}  // namespace detail

/// Which cells get a primitive: every cell that it touches; one cell; or its polygons are cut and each piece has a
/// cell.
enum class Assignment : std::uint8_t { shared = 1, unique = 2, clipped = 4 };

/// A set of assignments: what a partition offers, what an approximation accepts.
class Assignments {
  public:
    // NOLINTNEXTLINE(google-explicit-constructor): one assignment is a set.
    constexpr Assignments(Assignment one) : bits_(static_cast<std::uint8_t>(one)) {}
    static constexpr Assignments all() { return from_bits(7); }

    constexpr bool contains(Assignment one) const { return (bits_ & static_cast<std::uint8_t>(one)) != 0; }
    constexpr bool is_empty() const { return bits_ == 0; }

    friend constexpr Assignments operator|(Assignments a, Assignments b) { return from_bits(a.bits_ | b.bits_); }
    friend constexpr Assignments operator&(Assignments a, Assignments b) { return from_bits(a.bits_ & b.bits_); }
    friend constexpr bool operator==(Assignments, Assignments) = default;

  private:
    static constexpr Assignments from_bits(int bits) {
        Assignments set(Assignment::unique);
        set.bits_ = static_cast<std::uint8_t>(bits);
        return set;
    }
    std::uint8_t bits_;
};
constexpr Assignments operator|(Assignment a, Assignment b) {
    return Assignments(a) | Assignments(b);
}

struct PartitionFacts {
    Assignments offers = Assignment::unique;
    OrderGuarantee ordering = OrderGuarantee::none;  ///< what front_to_back guarantees
    bool splits_for_order = false;                   ///< cells are split whether it pays or not
    /// Children are the octants of their cell: bits 0, 1, 2 of a child's number say whether it is the upper half in x,
    /// y and z.
    bool children_are_octants = false;
    /// choose() looks at the cell alone and not at its items: such a tree can be updated (update.hpp).
    bool chooses_by_cell = false;
    std::uint32_t file_tag = 0;  ///< names the policy in files; change it with the meaning of the data. 0: never stored
};

/// One primitive as a builder sees it. 32 bytes, for a build is a matter of streaming these.
struct Item {
    Box bounds;                ///< local coordinates; contents may stick out of their cell
    std::uint32_t source = 0;  ///< index of the primitive
    float cost = 0;            ///< of drawing it, in the cost model's unit
};

/// The answer of Partition::choose.
enum class Split : std::uint8_t {
    yes,     ///< the node's data is set and place() may be asked; whether it happens is the builder's question of cost
    always,  ///< as `yes`, whatever it costs
    no,      ///< the partition's own limit, as wished (a uniform depth)
    too_deep,     ///< a safety limit, which the build report counts
    inseparable,  ///< no plane tells the items apart: a limit of partitions that cut, which the build report counts
};

namespace archetype {
struct Emit {
    void operator()(unsigned) const {}
    void keep() const {}
    void drop() const {}
};
struct Touches {
    bool operator()(const Box&) const { return true; }
};
}  // namespace archetype

template <class T>
concept StatesPartitionFacts = requires {
    { T::facts } -> std::convertible_to<PartitionFacts>;
}
&&std::is_trivially_copyable_v<typename T::node_data>;

template <class T>
concept DescendsInOrder = requires(const T& t, const Cell& cell, const typename T::node_data& frozen,
                                   ChildOrder& order) {
    { t.root(Box{}) } -> std::same_as<Cell>;              // the tight bounds of everything
    { t.child(cell, frozen, 0u) } -> std::same_as<Cell>;  // computed again at every descent
    t.front_to_back(cell, frozen, glm::vec4(), order);  // all children, present or not; viewpoint as LocalView gives it
};

/// place(cell, data, item, touches, give) calls give(child) for each child that gets the item, or give.keep() to leave
/// it in the node's own run, or give.drop() where items are shared and another cell has it. touches(box) says whether
/// the primitive itself, not just its bounds, meets a box; of an instance it is always true.
template <class T>
concept PlacesItems = requires(const T& t, const Cell& cell, typename T::node_data& data,
                               const typename T::node_data& frozen, const Item& item, std::span<const Item> items) {
    { t.choose(cell, items, data) } -> std::same_as<Split>;
    t.place(cell, frozen, item, archetype::Touches{}, archetype::Emit{});
};

/// Partitions that offer `clipped` are asked this instead. An item goes to child_at(data, side of each plane), cut
/// where it crosses one; what lies on a plane, up to rounding, goes undivided. Cells stay around what is in them: fit()
/// may use that.
template <class T>
concept CutsItems = requires(const T& t, const Cell& cell, typename T::node_data& data,
                             const typename T::node_data& frozen, const ClippedItems& items,
                             std::span<const Box> children) {
    { t.choose(cell, items, data) } -> std::same_as<Split>;  // no: the items are in order as they are
    { t.cuts(cell, frozen) } -> std::same_as<Cuts>;
    { t.child_at(frozen, Sides{}) } -> std::same_as<unsigned>;
    t.fit(cell, data, children);  // bounds of what each child got, empty boxes included
};

namespace detail {
template <class T>
concept PlacesItemsIfOffered =
    (T::facts.offers & (Assignment::shared | Assignment::unique)).is_empty() || PlacesItems<T>;
template <class T>
concept CutsItemsIfOffered = !T::facts.offers.contains(Assignment::clipped) || CutsItems<T>;
}  // namespace detail

template <class T>
concept Partition =
    StatesPartitionFacts<T> && DescendsInOrder<T> && detail::PlacesItemsIfOffered<T> && detail::CutsItemsIfOffered<T>;

}  // namespace farfield
