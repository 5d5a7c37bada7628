// A camera that stands still, trembles or travels: what may change from frame to frame.
#include <cmath>
#include <cstring>
#include <iterator>

#include "catch.hpp"
#include "farfield/measure/flicker.hpp"
#include "farfield/measure/image_error.hpp"
#include "gallery/subjects.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

bool same(const FrameStats& a, const FrameStats& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

/// Sum over pixels of the largest change of a channel: the area that changed, in pixels, if changes are complete.
double changed_px(const Image& a, const Image& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) {
        const Rgba8 p = a.pixels()[i], q = b.pixels()[i];
        int largest = 0;
        for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b, p.a - q.a}) largest = std::max(largest, std::abs(d));
        sum += largest;
    }
    return sum / 255;
}

}  // namespace

TEST_CASE("gallery: on a frozen camera nothing changes") {
    std::size_t images = 0;
    for (const Subject& subject : subjects(3000, {0.0f, 0.5f, 1.0f})) {
        for (const test::Variant& variant : gallery_variants()) {
            const auto h = variant.build(subject.triangles);
            ZBufferRenderer renderer;
            const auto viewer = h->viewer(renderer);
            for (const float tolerance : {0.0f, 1.0f, 4.0f}) {
                for (const View& view : {subject.view(3, 64, tolerance), subject.view(20, 64, tolerance),
                                         subject.orthographic_view(64, tolerance)}) {
                    INFO(subject.name << ": " << variant.name << ", tolerance " << tolerance);
                    const FrameStats first = viewer->settle(view);
                    images += first.images;
                    const Image image = renderer.image();
                    for (int i = 0; i < 3; ++i) {
                        CHECK(same(viewer->frame(view), first));
                        CHECK(renderer.image() == image);
                    }
                }
            }
        }
    }
    CHECK(images > 100);
}

// The eye moves by 1e-3 of its distance. Of a cell no nearer than a third of that distance the error changes by at most
// three parts in a thousand: only cells whose error lies so near to the tolerance may flip. The picture, at 9 samples
// a pixel, changes by no more than the sum of
//
//   - what the exact picture changes, for primitives may be drawn;
//   - the area of the bounds of what flips, which are twice as large as its cell where that is loose, and a pixel more;
//   - the way that everything moves (a thousandth of the focal length, half as much again for what is nearest) times
//     the outline of all faces drawn, each at most the tolerance long on four sides;
//   - what rounding to 8 bits may do to each pixel that is covered.
//
// Where stand-ins are drawn for the levels below them, sides are twice as long for each level.
TEST_CASE("gallery: where the camera trembles only what is at the threshold may flip, and comes back") {
    constexpr double tremble = 1e-3;
    const ZBufferOptions options{.samples = 9};
    for (const Subject& subject : subjects(3000, {0.0f, 0.5f, 1.0f})) {
        for (const double distance : {5.0, 11.0}) {
            Random random(7);
            const glm::dvec3 aside = glm::dvec3(random.direction()) * (tremble * distance);
            const View at_zero = subject.view(distance, 48, 0);
            View moved_at_zero = at_zero;
            moved_at_zero.camera.eye += aside;
            const Image exact = plain_picture<Triangle>(subject.triangles, at_zero, options);
            const double exact_change =
                changed_px(exact, plain_picture<Triangle>(subject.triangles, moved_at_zero, options));
            for (const test::Variant& variant : gallery_variants()) {
                if (!is_told_by_view(variant)) continue;
                const auto h = variant.build(subject.triangles);
                const std::vector<NodeRef> nodes = all_nodes(*h);
                ZBufferRenderer renderer(options);
                const auto viewer = h->viewer(renderer);
                double primitives_change = exact_change;
                if (variant.is_clipped) {  // fragments are snapped to 1/256 sample, each by itself
                    viewer->frame(at_zero);
                    const Image own = renderer.image();
                    viewer->frame(moved_at_zero);
                    primitives_change = changed_px(own, renderer.image());
                }
                for (const float tolerance : {1.0f, 4.0f}) {
                    INFO(subject.name << ": " << variant.name << ", tolerance " << tolerance << ", from " << distance);
                    View here = at_zero, there = moved_at_zero;
                    here.tolerance_px = there.tolerance_px = tolerance;
                    const LocalView local = local_view<Triangle>(subject.triangles, here);
                    const auto cut = cut_of(*h, nodes, local),
                               moved_cut = cut_of(*h, nodes, local_view<Triangle>(subject.triangles, there));
                    Recorder recorder;
                    CHECK(h->frame(here, recorder).approximations == cut.size());

                    std::vector<std::size_t> flipped;
                    std::set_symmetric_difference(cut.begin(), cut.end(), moved_cut.begin(), moved_cut.end(),
                                                  std::back_inserter(flipped));
                    // Whatever lies below a cell at the threshold is left out or taken in with it.
                    std::vector<char> below_threshold(h->nodes().size(), 0), may_flip(h->stand_in_count(), 0);
                    for (const NodeRef& node : nodes) {
                        bool at_threshold = false;
                        if (node.stand_in >= 0) {
                            const float error = drawn_error_px(*h, node, local);
                            at_threshold = std::abs(error / tolerance - 1) <= 3 * tremble;
                        }
                        below_threshold[node.index] = at_threshold || below_threshold[node.parent];
                        if (node.stand_in >= 0) may_flip[std::size_t(node.stand_in)] = below_threshold[node.index];
                    }
                    CHECK(std::all_of(flipped.begin(), flipped.end(), [&](std::size_t s) { return may_flip[s] != 0; }));

                    const FrameStats stats = viewer->frame(here);
                    const Image image = renderer.image();
                    const FrameStats moved_stats = viewer->frame(there);
                    const double change = changed_px(image, renderer.image());
                    int reach = 0;
                    for (const Node& node : h->nodes()) reach = std::max(reach, int(node.levels_replaced));
                    const double side_px = double(tolerance) * std::ldexp(1.0, reach);
                    const double flip_px = 2 * 1.01 * side_px + 2;
                    const double way_px = tremble * double(local.focal_px) * 1.5;
                    const double faces =
                        double(std::max(stats.faces, moved_stats.faces) + std::max(stats.splats, moved_stats.splats));
                    // Triangles smaller than two samples are deposited where the cell's law is known, and move as
                    // stand-ins do; point sampled they are in the exact change.
                    const bool deposits = variant.name.find("OpacityTensor") != std::string::npos;
                    const double small = deposits ? double(std::max(stats.primitives, moved_stats.primitives)) : 0;
                    const double bound = primitives_change + double(flipped.size()) * flip_px * flip_px +
                                         way_px * (faces * 4 * side_px + small * 4 * 2) + 2 * coverage(image) / 255;
                    INFO("changed " << change << " of at most " << bound << " pixels; exact " << primitives_change);
                    CHECK(change <= bound);
                    CHECK(same(viewer->frame(here), stats));
                    CHECK(renderer.image() == image);
                }
            }
        }
    }
}

// From 2 to 32 radii at 12 % a frame, through all levels. What changes from a frame to the next, and does not in the
// exact pictures, is the difference of two errors: where they have nothing in common, as on a checkered wall that moves
// by half a square a frame, it is sqrt(2) times as large as they are. A pop of more would be two errors that are
// opposed.
TEST_CASE("gallery: on a dolly no frame is blank and no pop is larger than errors make it") {
    constexpr int frames = 25;
    int vanished = 0;
    const ZBufferOptions options{.samples = 9};
    for (const Subject& subject : subjects(3000, {0.0f, 0.5f, 1.0f})) {
        std::vector<View> views;
        std::vector<Image> exact;
        for (int i = 0; i < frames; ++i) {
            views.push_back(subject.view(2 * std::pow(16.0, double(i) / (frames - 1)), 40, 0));
            exact.push_back(plain_picture<Triangle>(subject.triangles, views.back(), options));
        }
        for (const test::Variant& variant : gallery_variants()) {
            const auto h = variant.build(subject.triangles);
            ZBufferRenderer renderer(options);
            const auto viewer = h->viewer(renderer);
            int blank = 0;
            for (const float tolerance : {1.0f, 4.0f}) {
                Flicker flicker;
                double largest_error = 0;
                for (int i = 0; i < frames; ++i) {
                    View view = views[std::size_t(i)];
                    view.tolerance_px = tolerance;
                    viewer->frame(view);
                    const Image& reference = exact[std::size_t(i)];
                    flicker.add(renderer.image(), reference);
                    largest_error = std::max(largest_error, rmse(renderer.image(), reference));
                    blank += coverage(reference) > 0 && coverage(renderer.image()) == 0;
                }
                INFO(subject.name << ": " << variant.name << ", tolerance " << tolerance << ": error to "
                                  << largest_error << ", change to " << flicker.largest_pop_rms() << " at frame "
                                  << flicker.largest_pop_frame());
                // Errors of two frames that have nothing to do with each other differ by the root of two. An image and
                // the one that replaces it err at the same edges, a little to either side at times.
                const bool may_be_opposed = is_known_to_oppose(variant, subject) || is_known_to_turn(variant, subject);
                const double apart = may_be_opposed ? 2 : is_told_by_view(variant) ? 1.42 : 1.5;
                CHECK(flicker.largest_pop_rms() <= apart * largest_error + 0.5 / 255);
            }
            INFO(subject.name << ": " << variant.name);
            if (is_known_to_vanish(variant, subject)) {
                vanished += blank;
            } else {
                CHECK(blank == 0);
            }
        }
    }
    CHECK(vanished > 0);
}
