// The last so many numbers, in the order in which they came: what plots show.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace viewer {

class History {
  public:
    explicit History(std::size_t most = 160) : most_(most) {}

    void add(float value) {
        if (values_.size() == most_) values_.erase(values_.begin());
        values_.push_back(value);
    }
    void clear() { values_.clear(); }

    const std::vector<float>& values() const { return values_; }
    float last() const { return values_.empty() ? 0 : values_.back(); }
    float largest() const { return values_.empty() ? 0 : *std::max_element(values_.begin(), values_.end()); }

  private:
    std::size_t most_;
    std::vector<float> values_;
};

}  // namespace viewer
