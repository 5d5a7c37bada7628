// Primitives that nobody stores: a mesh, or any other object with state, answers for the primitive of an index, as
// the adaptors of nearest-neighbor libraries do for a point. A hierarchy over it takes four bytes a primitive, an index
// in its order, where an array of handles to a mesh would take sixteen more.
//
//   primitive_count()    -> an integer    how many there are, below 2^32 - 16
//   bounds(i)            -> Box or BoxD   required, as in primitive.hpp; so are the meanings of all others
//   polygons(i, sink)    -> void
//   color(i)             -> glm::vec4
//   work(i)              -> Work
//   key(i)               -> std::uint32_t
//   visit_instance(i, f) -> bool
//
// All are const, i is a std::uint32_t, and several threads ask at a time. What they answer stays as long as a hierarchy
// or a viewer is over it. build, make_viewer, make_banded_viewer, pick and Instance take such an object where they take
// an array; a renderer gets it as Source<IndexedPrimitive<Mesh>>, whose elements are made when they are asked for.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>
#include <type_traits>

#include "farfield/cost_model.hpp"
#include "farfield/primitive.hpp"

namespace farfield {

/// A source of primitives, which check_source_hooks() asks for the rest.
template <class S>
concept CountsPrimitives = requires(const S& s) {
    { s.primitive_count() } -> std::convertible_to<std::size_t>;
};

/// A primitive by its index, made when it is asked for. The source is borrowed.
template <class S>
struct IndexedPrimitive {
    const S* source = nullptr;
    std::uint32_t index = 0;
};

/// All primitives of a source, as a span of those that it makes: its elements are values, not references.
template <class S>
class IndexedSpan {
  public:
    using value_type = IndexedPrimitive<S>;

    IndexedSpan() = default;
    IndexedSpan(const S& source)  // NOLINT(google-explicit-constructor): as spans of arrays are
        : IndexedSpan(&source, std::size_t(source.primitive_count())) {}
    IndexedSpan(const S* source, std::size_t size) : source_(source), size_(size) {}
    IndexedSpan(const S&&) = delete;

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    /// Where the source lies, by which sources are told apart.
    const S* data() const { return source_; }
    value_type operator[](std::size_t i) const { return {source_, std::uint32_t(i)}; }

    struct Iterator {
        const S* source;
        std::uint32_t index;
        value_type operator*() const { return {source, index}; }
        Iterator& operator++() {
            ++index;
            return *this;
        }
        friend bool operator==(const Iterator&, const Iterator&) = default;
    };
    Iterator begin() const { return {source_, 0}; }
    Iterator end() const { return {source_, std::uint32_t(size_)}; }

  private:
    const S* source_ = nullptr;
    std::size_t size_ = 0;
};

namespace detail {
template <class P>
struct SpanOfPrimitives {
    using type = std::span<const P>;
    using element = const P*;
};
template <class S>
struct SpanOfPrimitives<IndexedPrimitive<S>> {
    using type = IndexedSpan<S>;
    using element = const S*;
};

template <class P>
inline constexpr bool is_indexed = false;
template <class S>
inline constexpr bool is_indexed<IndexedPrimitive<S>> = true;
}  // namespace detail

/// The borrowed primitives of a hierarchy: a span of an array or, for IndexedPrimitive, of a source.
template <class P>
using PrimitiveSpan = typename detail::SpanOfPrimitives<P>::type;

namespace detail {
/// The primitive's type, of any such span.
template <class Span>
using PrimitiveIn = std::remove_cvref_t<decltype(std::declval<const Span&>()[0])>;

/// The span that has this data() and size().
template <class P>
PrimitiveSpan<P> span_at(const void* data, std::size_t size) {
    return PrimitiveSpan<P>(static_cast<typename SpanOfPrimitives<P>::element>(data), size);
}

/// Asks for a primitive of an array before it is read. Those of sources are made, not read.
template <class P>
void prefetch_primitive([[maybe_unused]] const PrimitiveSpan<P>& primitives, [[maybe_unused]] std::size_t index) {
#if defined(__GNUC__)
    if constexpr (!is_indexed<P>) {
        const char* primitive = reinterpret_cast<const char*>(primitives.data() + index);
        __builtin_prefetch(primitive);
        if constexpr (sizeof(P) > 16) __builtin_prefetch(primitive + sizeof(P) - 1);
    }
#endif
}

template <class S>
concept AnswersBounds = requires(const S& s) {
    s.bounds(0u);
};
template <class S, class Sink>
concept AnswersPolygons = requires(const S& s, Sink& sink) {
    s.polygons(0u, sink);
};
template <class S>
concept AnswersColor = requires(const S& s) {
    { s.color(0u) } -> std::convertible_to<glm::vec4>;
};
template <class S>
concept AnswersWork = requires(const S& s) {
    { s.work(0u) } -> std::same_as<Work>;
};
template <class S>
concept AnswersKey = requires(const S& s) {
    { s.key(0u) } -> std::same_as<std::uint32_t>;
};
template <class S, class F>
concept AnswersVisitInstance = requires(const S& s, F& f) {
    { s.visit_instance(0u, f) } -> std::convertible_to<bool>;
};
}  // namespace detail

template <class S>
struct primitive_traits<IndexedPrimitive<S>> {
    using P = IndexedPrimitive<S>;
    // clang-format off
    static auto bounds(const P& p) requires detail::AnswersBounds<S> { return p.source->bounds(p.index); }
    template <class Sink>
    static void polygons(const P& p, Sink&& sink) requires detail::AnswersPolygons<S, Sink> { p.source->polygons(p.index, sink); }
    static glm::vec4 color(const P& p) requires detail::AnswersColor<S> { return p.source->color(p.index); }
    static Work work(const P& p) requires detail::AnswersWork<S> { return p.source->work(p.index); }
    static std::uint32_t key(const P& p) requires detail::AnswersKey<S> { return p.source->key(p.index); }
    template <class F>
    static bool visit_instance(const P& p, F&& f) requires detail::AnswersVisitInstance<S, F> { return p.source->visit_instance(p.index, f); }
    // clang-format on
};

}  // namespace farfield
