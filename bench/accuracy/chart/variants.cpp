#include "variants.hpp"

#include <algorithm>

namespace farfield::bench {
namespace {

std::vector<AnyVariant> gather() {
    std::vector<std::pair<std::size_t, AnyVariant>> numbered;
    const auto add = [&](std::vector<std::pair<std::size_t, AnyVariant>> part) {
        for (auto& variant : part) numbered.push_back(std::move(variant));
    };
    [&]<unsigned... part>(std::integer_sequence<unsigned, part...>) {
        (add(variants_of_part<part>()), ...);
    }
    (std::make_integer_sequence<unsigned, FARFIELD_VARIANT_PARTS>());
    std::sort(numbered.begin(), numbered.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<AnyVariant> variants;
    for (auto& [place, variant] : numbered) variants.push_back(std::move(variant));
    return variants;
}

}  // namespace

const std::vector<AnyVariant>& all_variants() {
    static const std::vector<AnyVariant> variants = gather();
    return variants;
}

}  // namespace farfield::bench
