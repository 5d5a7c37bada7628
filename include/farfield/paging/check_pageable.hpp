// Why something cannot lie in pages, said by the compiler.
#pragma once

#include "farfield/settings.hpp"

#include <type_traits>

#include "farfield/paging/page_format.hpp"
#include "farfield/partition.hpp"
#include "farfield/primitive.hpp"
#include "farfield/storage/file_format.hpp"

namespace farfield::detail {

/// True, or a static_assert fails that names what is wrong.
template <class H, class P>
constexpr bool check_pageable() {
    static_assert(Storable<H>, "farfield: pages need a hierarchy that save() takes, see storage/file_format.hpp");
    static_assert(H::assignment == Assignment::unique,
                  "farfield: each primitive lies in one page, so pages need a partition that neither shares nor cuts "
                  "primitives, such as Octree");
    static_assert(H::approximation_type::facts.stands_in,
                  "farfield: what is drawn while a page is missing is a stand-in, and this approximation has none");
    static_assert(!H::approximation_type::facts.has_pool,
                  "farfield: a page is read alone, and stand-ins of an approximation with a pool refer to others");
    static_assert(!H::approximation_type::facts.caches_images,
                  "farfield: images are kept of cells that stay, and those in pages do not: page what `Inner` is");
    static_assert(!PrimitiveWithInstance<P>,
                  "farfield: an instance borrows its hierarchy, which does not lie in the page: write the primitives "
                  "that it shows");
    static_assert(std::is_trivially_copyable_v<P>, "farfield: a primitive in a page is its bytes: no pointers it owns");
    static_assert(alignof(P) <= 64, "farfield: pages are aligned to 64 bytes, and this primitive asks for more");
    return Pageable<H> && PageablePrimitive<P>;
}

}  // namespace farfield::detail
