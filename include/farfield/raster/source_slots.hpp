// Keeps a renderer's sources in the form that it draws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "farfield/renderer.hpp"

namespace farfield::detail {

/// Numbers each source with the first free slot. A Stream is constructed from a Source<P>.
template <class Stream>
class SourceSlots {
  public:
    template <class P>
    std::uint32_t upload(const Source<P>& source) {
        for (std::size_t i = 0; i < streams_.size(); ++i) {
            if (!streams_[i]) return streams_[i] = std::make_unique<Stream>(source), std::uint32_t(i);
        }
        streams_.push_back(std::make_unique<Stream>(source));
        return std::uint32_t(streams_.size() - 1);
    }
    void release(std::uint32_t id) { streams_[id].reset(); }

    const Stream& operator[](std::uint32_t id) const { return *streams_[id]; }

  private:
    std::vector<std::unique_ptr<Stream>> streams_;
};

}  // namespace farfield::detail
