// The sources that a renderer keeps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "farfield/primitive.hpp"
#include "farfield/raster/triangles/triangle_stream.hpp"
#include "farfield/renderer.hpp"

namespace farfield {

class TriangleStreams {
  public:
    template <PrimitiveWithPolygons P>
    std::uint32_t upload(const Source<P>& source) {
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            if (!streams_[i]) return streams_[i] = std::make_unique<TriangleStream>(source), std::uint32_t(i);
        }
        streams_.push_back(std::make_unique<TriangleStream>(source));
        return std::uint32_t(streams_.size() - 1);
    }
    void release(std::uint32_t id) { streams_[id].reset(); }

    const TriangleStream& operator[](std::uint32_t id) const { return *streams_[id]; }

  private:
    std::vector<std::unique_ptr<TriangleStream>> streams_;
};

}  // namespace farfield
