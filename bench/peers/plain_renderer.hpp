// The plain z-buffer as a renderer: a viewer hands it the same ranges of primitives, culled by the frustum, as the
// library's z-buffer gets, and list_drawer makes it a loop over all triangles.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "farfield/drawables.hpp"
#include "farfield/renderer.hpp"
#include "peers/plain_z_buffer.hpp"

namespace farfield::bench {

struct PlainOptions {
    int samples = 1;  ///< a pixel: 1 or 64
    bool is_native = true;
};

/// Polygons get the color of their first corner.
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
            source.polygons(i, [&](const Polygon& polygon) {
                const auto& v = polygon.vertices;
                for (std::size_t c = 2; c < v.size(); ++c) {
                    PlainTriangle t{{}, polygon.colors[0]};
                    const glm::vec3 corners[3] = {v[0], v[c - 1], v[c]};
                    for (int k = 0; k < 3; ++k) {
                        for (int axis = 0; axis < 3; ++axis) t.vertices[k][axis] = corners[k][axis];
                    }
                    uploaded.triangles.push_back(t);
                }
            });
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
