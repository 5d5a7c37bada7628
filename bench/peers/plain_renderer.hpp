// The plain z-buffer as a renderer: a viewer hands it the same ranges of primitives, culled by the frustum, as the
// library's z-buffer gets, and list_drawer makes it a loop over all triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/renderer.hpp"
#include "plain_z_buffer.hpp"

namespace farfield::bench {

struct PlainOptions {
    int samples = 1;  ///< a pixel: 1 or 64
    bool is_native = true;
};

/// Adds a polygon, in the color of its first corner.
inline void add_plain_triangles(const Polygon& polygon, std::vector<PlainTriangle>& triangles) {
    for_each_triangle(polygon.vertices.size(), [&](std::size_t a, std::size_t b, std::size_t c) {
        PlainTriangle t{{}, polygon.colors[0]};
        for (int axis = 0; axis < 3; ++axis) {
            t.vertices[0][axis] = polygon.vertices[a][axis];
            t.vertices[1][axis] = polygon.vertices[b][axis];
            t.vertices[2][axis] = polygon.vertices[c][axis];
        }
        triangles.push_back(t);
    });
}

template <class P>
std::vector<PlainTriangle> plain_triangles(const std::vector<P>& primitives) {
    std::vector<PlainTriangle> result;
    for (const P& p : primitives) {
        p.polygons([&](const Polygon& polygon) { add_plain_triangles(polygon, result); });
    }
    return result;
}

class PlainRenderer {
  public:
    static constexpr RendererFacts facts{.keeps_sources = true};

    explicit PlainRenderer(const PlainOptions& options)
        : z_buffer_(
              (options.is_native ? native_plain_z_buffer : portable_plain_z_buffer)(options.samples == 1 ? 1 : 8)) {}

    template <class P>
    std::uint32_t upload(const Source<P>& source) {
        Uploaded uploaded;
        for (std::uint32_t i = 0; i < source.item_count; ++i) {
            uploaded.first.push_back(std::uint32_t(uploaded.triangles.size()));
            source.polygons(i, [&](const Polygon& polygon) { add_plain_triangles(polygon, uploaded.triangles); });
        }
        uploaded.first.push_back(std::uint32_t(uploaded.triangles.size()));
        sources_.emplace(++last_, std::move(uploaded));
        return last_;
    }
    void release(std::uint32_t id) { sources_.erase(id); }

    void begin_frame(const LocalView& view) { z_buffer_->begin_frame(view); }
    void set_view(const LocalView& view) { z_buffer_->set_view(view); }
    void end_frame() { z_buffer_->end_frame(); }
    template <class P>
    void draw(const Source<P>& source, std::span<const Range> ranges) {
        const Uploaded& from = sources_.at(source.id);
        for (const Range& range : ranges) {
            const std::uint32_t first = from.first[range.first], end = from.first[range.first + range.count];
            z_buffer_->draw(std::span(from.triangles).subspan(first, end - first));
        }
    }
    const Image& image() const { return z_buffer_->image(); }

  private:
    struct Uploaded {
        std::vector<PlainTriangle> triangles;
        std::vector<std::uint32_t> first;  ///< triangle of each position, and the end
    };

    std::unique_ptr<PlainZBuffer> z_buffer_;
    std::map<std::uint32_t, Uploaded> sources_;
    std::uint32_t last_ = 0;
};

}  // namespace farfield::bench
