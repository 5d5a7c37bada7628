#include "result.hpp"

#include <algorithm>
#include <numeric>

namespace walkthrough {

Choice MeasuredErrors::choice_for(farfield::WantedError error) const {
    error.samples = by_tolerance.fewest_samples();
    const Choice alone{by_tolerance.cheapest_for(error), false}, both{wanted.cheapest_for(error), true};
    // A cost below exact's without the error that is wanted is worth nothing.
    if (alone.tolerance.keeps_error() != both.tolerance.keeps_error()) {
        return alone.tolerance.keeps_error() ? alone : both;
    }
    return both.cost < alone.cost ? both : alone;
}

double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size());
}

double median(std::vector<double> values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (values.size() % 2 != 0) return *middle;
    return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double speedup(const Result& result) {
    return median(result.exact_ms) / median(result.paired_ms);
}

}  // namespace walkthrough
