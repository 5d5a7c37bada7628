// What is chosen from frame to frame, cell by cell: a descent's calls, without a renderer.
#include "farfield/frame/image_chooser.hpp"

#include <cstdint>
#include <optional>

#include "catch.hpp"
#include "farfield/frame/safety_zone.hpp"
#include "support/image_walk.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

/// Makes nothing.
struct Maker {
    std::uint64_t path_of(std::uint32_t) const { return 0; }
    void draw_contents(const auto&...) {}
};

/// The whole and a cell in it, as if there were nothing else. The whole gets an image from the test alone.
struct TwoCells {
    CachedImages hierarchy =
        build<CachedImages>(balls(), {.approximation = with({.least_items = 64}), .cost_model = free_images()});
    ImageCacheOptions options{.least_items = 64};
    ExpectedPath path;
    KeptImages kept;
    ImageChoice<Maker> choice;
    LocalView view{seen_from({0, 0, 0}), hierarchy.origin(), hierarchy.bounds()};
    Entered<CachedImages, Triangle> entered{
        hierarchy, Source<Triangle>{balls(), hierarchy.order(), hierarchy.item_count()}, view, 0};
    Subtree outer = whole_of(hierarchy), inner;

    TwoCells() { look_for_inner(outer); }
    /// The one with most in it whose image fits into the picture.
    void look_for_inner(const Subtree& subtree) {
        for_each_child<VisitOrder::any>(hierarchy, subtree, glm::vec4(0), [&](const Subtree& child) {
            const Cell& c = child.cell;
            if (!fitting_rect(view, c.bounds_center, c.bounds_half)) return look_for_inner(child);
            if (items(child) > items(inner)) inner = child;
        });
    }
    std::uint32_t items(const Subtree& s) const {
        return s.end_item == 0 ? 0 : s.end_item - hierarchy.nodes()[s.node].first_item;
    }
    KeptCell& cell(const Subtree& s) { return kept.cell(kept.index_of({0, s.node})); }
    /// A frame; false where the outer cell's image is drawn. Whether the inner one is wanted is told by choice.wanted.
    bool choose() {
        kept.begin_frame();
        cell(outer).refused_frame = kept.frame();
        ImageChooser<Maker> chooser(kept, options, path, choice);
        if (chooser.begin_cell(entered, outer) == CellDrawn::by_image) return false;
        if (!chooser.hidden(entered, inner) && chooser.begin_cell(entered, inner) == CellDrawn::in_parts) {
            chooser.run(entered, inner, hierarchy.nodes()[inner.node].first_item, inner.end_item, {});
            chooser.end_cell(entered, inner);
        }
        chooser.end_cell(entered, outer);
        return true;
    }
    void give_image_to_outer() {
        const glm::vec3 center = outer.cell.bounds_center, half = outer.cell.bounds_half;
        const std::optional<ImageRect> rect = image_rect(view, center, half);
        REQUIRE(rect);
        CellImage image = planned_image(view, center, half, *rect, 1);
        set_safety_zone(image, view, options);
        kept.keep(cell(outer), image);
    }
};

}  // namespace

TEST_CASE("a cell that an image of a larger one has shown is not taken for one that comes into sight",
          "[image_chooser]") {
    TwoCells cells;
    const auto wanted_as_new = [&]() -> std::optional<bool> {
        CHECK(cells.choose());
        if (cells.choice.wanted.size() != 1) return {};
        return cells.choice.wanted[0].is_new;
    };
    CHECK(wanted_as_new() == true);
    CHECK(wanted_as_new() == false);
    cells.give_image_to_outer();
    for (int frame = 0; frame < 3; ++frame) CHECK(!cells.choose());
    cells.kept.forget(cells.cell(cells.outer), [](std::uint32_t) {});
    // It was seen all the time.
    CHECK(wanted_as_new() == false);
    for (int frame = 0; frame < 3; ++frame) cells.kept.begin_frame();
    // Neither was.
    CHECK(wanted_as_new() == true);
}

TEST_CASE("a cell of which something was hidden is looked at part by part again", "[image_chooser]") {
    TwoCells cells;
    cells.options.most_making = 0;
    cells.choose();
    CHECK(cells.cell(cells.outer).parts_frame == 0);
    cells.cell(cells.inner).hidden_frame = cells.kept.frame();
    cells.choose();
    CHECK(cells.cell(cells.outer).parts_frame == cells.kept.frame());
    // It is hidden no more: nobody has said so in the last frame.
    cells.choose();
    CHECK(cells.cell(cells.outer).parts_frame + 1 == cells.kept.frame());
}
