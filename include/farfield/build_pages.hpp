// A file of pages from more primitives than memory holds (Klein et al. 2002, section 5).
//
//     build_pages<H, Triangle>([&](auto&& take) { for (const Triangle& t : anything) take(t); }, "scene.farfield");
//
// The stream is read three times: for the bounds of the scene, for the number of primitives in each cell of its first
// levels, and to put primitives where they belong in a temporary file. Cells of few enough primitives are parts: each
// is built in memory as it would be in the whole, for what a cell becomes depends on what it holds alone, and its pages
// are written. Its root's stand-in is kept, and what that was made from; cells above are made of those, last of all.
// (The paper splits and writes recursively; a count beforehand replaces that, and everything is written twice at most.)
//
// What is on the disk is written down, so that a build that was stopped, by whatever, goes on where it was. Several
// processes may build a share each (build_page_share), on one machine or many, which are joined (join_page_shares): the
// file is the same, byte for byte, however many there were, and however many threads.
#pragma once

#include "farfield/settings.hpp"

#include <cstdint>
#include <filesystem>

#include "farfield/build_pages/page_build.hpp"
#include "farfield/build_pages/page_share.hpp"
#include "farfield/build_pages/share_builder.hpp"
#include "farfield/build_pages/share_joiner.hpp"
#include "farfield/sampler/grid_sampler.hpp"

namespace farfield {

/// Bytes of the disk that a share of a build takes at most while it is built, as build_page_share() looks for before it
/// moves anything; a build of all takes as much as its only share. The stream is called twice. More, and it is looked
/// for again, where one cell needs larger pages than wanted; and where thousands of primitives as large as a cell, or
/// larger, lie together in one that is smaller than a 128th of the scene.
template <BuildsInParts H, PageablePrimitive P, OrthographicSampler Sampler = GridSampler, class Stream>
std::uint64_t disk_bytes_of_build(Stream&& stream, const PageBuildOptions<H, Sampler>& options = {},
                                  PageShare share = {}) {
    const std::filesystem::path nowhere;
    detail::PageBuild<H, P, Sampler> build(nowhere, options);
    return detail::ShareBuilder{build}.disk_bytes(stream, share);
}

/// Builds a share of a file of pages, and leaves it beside where that will be (`path.0-of-2.pages`, and so on). A share
/// that was stopped goes on where it was when it is built again, and one that is there already is left as it is. See
/// build_pages() for what it throws.
template <BuildsInParts H, PageablePrimitive P, OrthographicSampler Sampler = GridSampler, class Stream>
void build_page_share(Stream&& stream, const std::filesystem::path& path, PageShare share,
                      const PageBuildOptions<H, Sampler>& options = {}) {
    detail::PageBuild<H, P, Sampler> build(path, options);
    detail::ShareBuilder{build}(stream, share);
}

/// Joins all shares of a file and removes what they left. The options are those of the shares. Throws
/// std::runtime_error that names the share which is missing, not finished, or of another build.
template <BuildsInParts H, PageablePrimitive P, OrthographicSampler Sampler = GridSampler>
void join_page_shares(const std::filesystem::path& path, std::uint32_t share_count,
                      const PageBuildOptions<H, Sampler>& options = {}) {
    detail::PageBuild<H, P, Sampler> build(path, options);
    detail::ShareJoiner{build}(share_count);
}

/// Builds a file of pages. stream(take) calls take(const P&) with every primitive; it is called three times or more,
/// and must give the same each time, in the same order. The same stream and options give the same bytes, on any number
/// of threads, in any number of shares, and after any number of builds of it that were stopped: whatever is left beside
/// `path` by one goes into the next. `path` itself is only there when all of it is.
///
/// Throws std::invalid_argument that names a primitive which cannot be built from, as build() does, or where the stream
/// does not keep to that, or if one cell by itself holds more than 64 MiB; std::runtime_error that names the file if
/// the disk is too small or fails; BuildCanceled.
template <BuildsInParts H, PageablePrimitive P, OrthographicSampler Sampler = GridSampler, class Stream>
void build_pages(Stream&& stream, const std::filesystem::path& path, const PageBuildOptions<H, Sampler>& options = {}) {
    detail::PageBuild<H, P, Sampler> build(path, options);
    detail::ShareBuilder{build}(stream, PageShare{});
    detail::ShareJoiner{build}(1);
}

}  // namespace farfield
