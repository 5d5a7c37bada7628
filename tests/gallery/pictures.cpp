// What the failure gallery may do to a picture of any variant, and what it may not.
#include <cmath>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "gallery/subjects.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

std::vector<View> views_of(const Subject& s, int size, float tolerance) {
    std::vector<View> views{s.view(1.3, size, tolerance), s.view(4, size, tolerance), s.view(40, size, tolerance),
                            s.orthographic_view(size, tolerance)};
    views[1].distance = DistanceMeasure::depth;
    return views;
}

bool finite(glm::vec3 v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool finite(const Recording& r) {
    return std::all_of(r.faces.begin(), r.faces.end(),
                       [](const Face& f) { return finite(f.lower) && finite(f.upper) && f.rgba.a > 0; }) &&
           std::all_of(r.splats.begin(), r.splats.end(), [](const Splat& s) {
               return finite(s.center) && s.opacity >= 0 && s.opacity <= 1 && std::isfinite(s.size.x) &&
                      std::isfinite(s.size.y) && s.size.x > 0 && s.size.y > 0;
           });
}

/// No color brighter than its coverage, up to rounding.
bool premultiplied(const Image& image) {
    return std::all_of(image.pixels().begin(), image.pixels().end(),
                       [](Rgba8 c) { return c.r <= c.a + 1 && c.g <= c.a + 1 && c.b <= c.a + 1; });
}

}  // namespace

TEST_CASE("gallery: at any tolerance what is drawn is defined, and no primitive is drawn twice") {
    for (const Subject& subject : subjects(3000, {0.0f, 0.5f, 1.0f})) {
        for (const test::Variant& variant : gallery_variants()) {
            const auto h = variant.build(subject.triangles);
            const std::vector<NodeRef> nodes = all_nodes(*h);
            ZBufferRenderer renderer;
            const auto viewer = h->viewer(renderer);
            for (const float tolerance : {0.0f, 0.25f, 1.0f, 4.0f, 64.0f}) {
                for (const View& view : views_of(subject, 64, tolerance)) {
                    INFO(subject.name << ": " << variant.name << ", tolerance " << tolerance << ", from "
                                      << glm::length(view.camera.eye));
                    const LocalView local = local_view<Triangle>(subject.triangles, view);
                    bool errors_are_numbers = true;
                    for (const NodeRef& node : nodes) {
                        if (node.stand_in < 0) continue;
                        errors_are_numbers &= h->error_px(std::size_t(node.stand_in), node.cell, local) >= 0;
                    }
                    CHECK(errors_are_numbers);
                    for (const float splat : {0.0f, 2.0f}) {
                        Recorder recorder;
                        recorder.largest_splat = splat;
                        const FrameStats stats = h->frame(view, recorder);
                        CHECK(finite(recorder));
                        CHECK(stats.primitives <= (variant.is_clipped ? h->item_count() : subject.triangles.size()));
                        if (tolerance == 0) CHECK(stats.approximations == 0);
                    }
                    viewer->arrive(view);
                    CHECK(premultiplied(renderer.image()));
                }
            }
        }
    }
}

TEST_CASE("gallery: without tolerance the picture is that of a plain loop, byte for byte") {
    const std::vector<ZBufferOptions> sampled{{.samples = 1}, {.samples = 4}};
    for (const Subject& subject : subjects(3000, {0.0f, 0.4f, 1.0f})) {
        const std::vector<View> views = views_of(subject, 96, 0);
        std::vector<Image> plain;
        for (const ZBufferOptions& options : sampled) {
            for (const View& view : views) plain.push_back(plain_picture<Triangle>(subject.triangles, view, options));
        }
        for (const test::Variant& variant : gallery_variants()) {
            if (!is_told_by_view(variant)) continue;
            const auto h = variant.build(subject.triangles);
            for (std::size_t k = 0; k < sampled.size(); ++k) {
                const ZBufferOptions& options = sampled[k];
                ZBufferRenderer renderer(options);
                const auto viewer = h->viewer(renderer);
                for (std::size_t i = 0; i < views.size(); ++i) {
                    INFO(subject.name << ": " << variant.name << ", view " << i << ", " << options.samples
                                      << " samples");
                    viewer->frame(views[i]);
                    CHECK(variant.is_plain(renderer.image(), plain[k * views.size() + i]));
                }
            }
        }
    }
}

namespace {

struct Seen {
    View view;
    std::vector<std::pair<int, int>> inside;  ///< by a pixel at least
};
Seen seen_from(const Subject& subject, double distance) {
    Seen seen{subject.view(distance, 96, 0), {}};
    const Image finest = plain_picture<Triangle>(subject.triangles, seen.view, {.samples = 64});
    for (int y = 1; y + 1 < finest.height(); ++y) {
        for (int x = 1; x + 1 < finest.width(); ++x) {
            bool covered = true;
            for (int dy = -1; dy <= 1; ++dy) {
                for (int dx = -1; dx <= 1; ++dx) covered &= finest.at(x + dx, y + dy).a == 255;
            }
            if (covered) seen.inside.emplace_back(x, y);
        }
    }
    return seen;
}

}  // namespace

TEST_CASE("gallery: without tolerance no background shows through a closed surface") {
    for (const Subject& subject : subjects(5000, {0.0f, 0.5f, 1.0f})) {
        if (!subject.is_opaque) continue;
        const std::vector<Seen> from{seen_from(subject, 1.9), seen_from(subject, 4), seen_from(subject, 12)};
        for (const test::Variant& variant : gallery_variants()) {
            const auto h = variant.build(subject.triangles);
            for (const Seen& seen : from) {
                INFO(subject.name << ": " << variant.name << ", from " << glm::length(seen.view.camera.eye));
                const Image image = h->picture(seen.view);
                // Two images that end in the same pixel are blended, as if what each leaves of it were elsewhere: at a
                // seam a part of the background shows, and where it opens more than that.
                const int least = is_told_by_view(variant) ? 255 : 128;
                std::size_t torn = 0;
                for (const auto& [x, y] : seen.inside) torn += image.at(x, y).a < least;
                CHECK(seen.inside.size() > 20);
                // Where an edge is cut for one of its neighbors only, both are snapped to 1/256 sample by themselves.
                const bool may_tear = variant.is_clipped || !is_told_by_view(variant);
                CHECK(torn <= (may_tear ? seen.inside.size() / 200 : 0));
            }
        }
    }
}
