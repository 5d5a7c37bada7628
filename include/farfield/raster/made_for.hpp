// What buffers were made for, known only once all of them were.
#pragma once

#include "farfield/settings.hpp"

#include <optional>

namespace farfield::detail {

/// Memory may run out halfway through a set of buffers. They are then for nothing until all are made anew, so that the
/// next frame, whatever its size, finds none of another size.
template <class Key>
class MadeFor {
  public:
    /// Calls make() unless the buffers are for `key` already, and returns whether it did.
    template <class Make>
    bool operator()(const Key& key, Make&& make) {
        if (key_ == key) return false;
        key_.reset();
        make();
        key_ = key;
        return true;
    }

  private:
    std::optional<Key> key_;
};

/// Width and height.
struct BufferSize {
    int width = 0, height = 0;
    friend bool operator==(const BufferSize&, const BufferSize&) = default;
};

}  // namespace farfield::detail
