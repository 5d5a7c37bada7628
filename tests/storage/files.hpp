// What the tests of storage/ share: places for files, files with a byte changed, scenes, and policies that use all that
// a file can hold.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/storage/checksum.hpp"
#include "farfield/storage/file_format.hpp"
#include "farfield/viewer.hpp"
#include "support/temporary_directory.hpp"

using Bytes = std::vector<char>;

using farfield::test::TemporaryDirectory;

inline Bytes read_file(const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}
inline void write_file(const std::filesystem::path& path, const Bytes& bytes) {
    // File systems wait for the disk where a file is cut to nothing and written again, in case power fails.
    std::filesystem::remove(path);
    std::ofstream out(path, std::ios::binary);
    out.write(bytes.data(), std::streamsize(bytes.size()));
    if (!out.flush()) throw std::runtime_error("cannot write " + path.string());
}

inline farfield::detail::FileHeader header_of(const Bytes& bytes) {
    farfield::detail::FileHeader header;
    std::memcpy(&header, bytes.data(), sizeof header);
    return header;
}

/// With checksums that agree, as somebody who damages files on purpose would write them.
inline Bytes sealed(Bytes bytes, farfield::detail::FileHeader header) {
    using namespace farfield::detail;
    const auto all = std::as_bytes(std::span(bytes));
    for (SectionEntry& s : header.sections) {
        if (s.offset <= all.size() && s.count <= all.size() && s.record_bytes <= all.size() &&
            s.bytes() <= all.size() - s.offset) {
            s.checksum = Xxh64::of(all.subspan(s.offset, s.bytes()));
        }
    }
    header.checksum = Xxh64::of(std::as_bytes(std::span(&header, 1)).first(offsetof(FileHeader, checksum)));
    std::memcpy(bytes.data(), &header, sizeof header);
    return bytes;
}
inline Bytes sealed(Bytes bytes) {
    const auto header = header_of(bytes);
    return sealed(std::move(bytes), header);
}

/// What open() says about it, without the path; empty if it opens.
template <class Open>
std::string refusal(const std::filesystem::path& path, Open&& open) {
    try {
        open(path);
        return {};
    } catch (const std::runtime_error& e) {
        const std::string start = "farfield::open: " + path.string() + ": ", what = e.what();
        if (what.substr(0, start.size()) != start || what.find('\n') != std::string::npos) return "MISSING: " + what;
        return what.substr(start.size());
    }
}

/// Small and large, with duplicates and triangles without an area among them.
inline std::vector<farfield::Triangle> scene(std::size_t count, unsigned seed = 1) {
    std::mt19937 random(seed);
    const auto number = [&] { return float(random() >> 8) * 0x1p-24f; };
    const auto point = [&] { return glm::vec3(number(), number(), number()); };
    std::vector<farfield::Triangle> triangles;
    while (triangles.size() < count) {
        const glm::vec3 at = point();
        const float size = random() % 16 == 0 ? 0.3f : 0.03f;
        farfield::Triangle t{{at, at + (point() - 0.5f) * size, at + (point() - 0.5f) * size}, {}};
        const auto color = random();
        t.rgba = {std::uint8_t(color), std::uint8_t(color >> 8), std::uint8_t(color >> 16), 255};
        if (random() % 16 == 0) t.vertices[2] = t.vertices[1];
        if (random() % 32 == 0) t.vertices[1] = t.vertices[2] = t.vertices[0];
        triangles.push_back(t);
        if (random() % 32 == 0 && triangles.size() < count) triangles.push_back(t);
    }
    return triangles;
}

/// From near and from far, all in one row.
template <class H>
std::vector<farfield::Image> pictures(const H& hierarchy, const std::vector<farfield::Triangle>& triangles,
                                      int size = 48) {
    std::vector<farfield::Image> images;
    farfield::ZBufferRenderer renderer;
    auto viewer = farfield::make_viewer(hierarchy, triangles, renderer);
    for (const double distance : {0.1, 1.2, 3.0, 9.0}) {
        for (const float tolerance_px : {0.0f, 1.5f, 20.0f}) {
            const auto camera =
                farfield::Camera::perspective({0.4, 0.6, 0.5 + distance}, {0.5, 0.5, 0.5}, {0, 1, 0}, 1);
            viewer.frame({.camera = camera, .width = size, .height = size, .tolerance_px = tolerance_px});
            images.push_back(renderer.image());
        }
    }
    return images;
}

/// Halves a cell along its longest side, and stores where.
template <bool is_checked>
struct BasicHalfSplit {
    std::uint32_t max_depth = 40;
    bool is_eager = false;  ///< only to have an option that not every byte is a value of
    struct node_data {
        std::uint32_t axis = 0;
        float at = 0;
    };
    static constexpr farfield::PartitionFacts facts{.ordering = farfield::OrderGuarantee::cells,
                                                    .file_tag = 0x48530001u};

    static farfield::Cell cell(const farfield::Box& b, unsigned depth) {
        const glm::vec3 center = b.center(), half = 0.5f * b.size();
        return {center, half, center, 2.0f * half, std::uint16_t(depth), 0};
    }
    farfield::Cell root(const farfield::Box& bounds) const {
        return bounds.is_empty() ? farfield::Cell{} : cell(bounds, 0);
    }
    farfield::Split choose(const farfield::Cell& c, std::span<const farfield::Item>, node_data& data) const {
        if (c.depth >= max_depth) return farfield::Split::too_deep;
        data.axis = c.half.x >= c.half.y ? (c.half.x >= c.half.z ? 0u : 2u) : (c.half.y >= c.half.z ? 1u : 2u);
        data.at = c.center[int(data.axis)];
        return farfield::Split::yes;
    }
    template <class Touches, class Emit>
    void place(const farfield::Cell& c, const node_data& data, const farfield::Item& item, Touches&&,
               Emit&& emit) const {
        glm::vec3 room = 2.0f * c.half;
        room[int(data.axis)] *= 0.5f;
        const glm::vec3 size = item.bounds.size();
        if (size.x > room.x || size.y > room.y || size.z > room.z) return emit.keep();
        emit(item.bounds.center()[int(data.axis)] >= data.at ? 1u : 0u);
    }
    farfield::Cell child(const farfield::Cell& c, const node_data& data, unsigned i) const {
        farfield::Box b = c.box();
        (i == 0 ? b.upper : b.lower)[int(data.axis)] = data.at;
        return cell(b, c.depth + 1u);
    }
    void front_to_back(const farfield::Cell&, const node_data& data, glm::vec4 v, farfield::ChildOrder& order) const {
        order = {0, 1, 2, 3, 4, 5, 6, 7};
        if (v[int(data.axis)] > data.at * v.w) std::swap(order[0], order[1]);
    }
    bool is_sound(const node_data& data) const requires(is_checked) { return data.axis < 3 && std::isfinite(data.at); }
};
using HalfSplit = BasicHalfSplit<true>;

/// A color cube that is kept in the pool.
struct PooledCube {
    farfield::ColorCube cube;
    struct stand_in_data {
        std::uint32_t at;
    };
    using pool_element = std::array<farfield::Rgba8, 6>;
    using stand_in_draft = farfield::ColorCube::stand_in_draft;
    static constexpr farfield::ApproximationFacts facts{
        .needs_polygons = true, .stands_in = true, .merges_octants = true, .has_pool = true, .file_tag = 0x50430001u};

    bool merges_children() const { return cube.merges_children(); }
    template <class Contents, class Sampler>
    stand_in_draft sample(const farfield::Cell& c, Contents&& contents, Sampler& sampler) const {
        return cube.sample(c, contents, sampler);
    }
    void merge(const farfield::Cell& c, stand_in_draft& d,
               std::span<const farfield::ChildDraft<stand_in_draft>> children) const {
        cube.merge(c, d, children);
    }
    stand_in_data finish(const farfield::Cell& c, const stand_in_draft& d, std::vector<pool_element>& pool) const {
        pool.push_back(cube.finish(c, d));
        return {std::uint32_t(pool.size() - 1)};
    }
    farfield::Work expected_work() const { return cube.expected_work(); }
    farfield::Work work(const stand_in_data&) const { return expected_work(); }
    float error_px(const stand_in_data&, const farfield::Cell& c, const farfield::LocalView& v) const {
        return cube.error_px({}, c, v);
    }
    template <class Sink>
    void draw_stand_in(const stand_in_data& d, std::span<const pool_element> pool, const farfield::Cell& c,
                       const farfield::LocalView& v, Sink&& sink) const {
        cube.draw_stand_in(pool[d.at], c, v, sink);
    }
    template <class Sink>
    void polygons(const stand_in_data& d, std::span<const pool_element> pool, const farfield::Cell& c,
                  Sink&& sink) const {
        cube.polygons(pool[d.at], c, sink);
    }
    bool is_sound(const stand_in_data& d, std::span<const pool_element> pool) const { return d.at < pool.size(); }
};

using OctreeOfCubes = farfield::SpatialHierarchy<farfield::Octree, farfield::ColorCube, farfield::TriangleCount>;
using OctreeOfTensors = farfield::SpatialHierarchy<farfield::Octree, farfield::OpacityTensor, farfield::TriangleCount>;
using SharedOctreeOfCubes =
    farfield::SpatialHierarchy<farfield::SharedOctree, farfield::ColorCube, farfield::TriangleCount>;
using ExactOctree = farfield::SpatialHierarchy<farfield::Octree, farfield::Exact, farfield::TriangleCount>;
using ExactSharedOctree = farfield::SpatialHierarchy<farfield::SharedOctree, farfield::Exact, farfield::TriangleCount>;
using HalvesOfPooledCubes = farfield::SpatialHierarchy<HalfSplit, PooledCube, farfield::TriangleCount>;
using ExactBsp = farfield::SpatialHierarchy<farfield::PolygonBsp, farfield::Exact, farfield::TriangleCount>;
using BspOfPooledCubes = farfield::SpatialHierarchy<farfield::PolygonBsp, PooledCube, farfield::TriangleCount>;
using OctreeOfBspsOfCubes = farfield::SpatialHierarchy<farfield::Nested<farfield::Octree, farfield::PolygonBsp>,
                                                       farfield::ColorCube, farfield::TriangleCount>;

template <class H>
H built(const std::vector<farfield::Triangle>& triangles) {
    return build<H>(triangles);
}
