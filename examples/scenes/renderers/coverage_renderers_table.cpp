#include "scenes/renderers/coverage_renderers.hpp"

namespace farfield::scenes {
namespace {

struct TableCoverage : LazyCoverage {
    static constexpr MaskSource masks = MaskSource::table;
};

}  // namespace

std::unique_ptr<AnyRenderer> make_table_coverage_renderer(const RendererChoice& choice) {
    if (choice.samples != 64 || choice.maps_work) {
        throw std::invalid_argument("coverage masks by a table have 64 samples a pixel and map no work");
    }
    return std::make_unique<RendererBehind<BasicCoverageRenderer<TableCoverage>>>(detail::coverage_options(choice));
}

}  // namespace farfield::scenes
