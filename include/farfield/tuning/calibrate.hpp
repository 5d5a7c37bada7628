// Measures the cost of each kind of work on this machine, with this renderer, before a walkthrough starts (Shade et al.
// 1996, section 3.3). Beside this header, advise.hpp, error_table.hpp and measure_error_table.hpp look at a clock, and
// no others.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/price_file.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/viewer.hpp"

namespace farfield {

struct CalibrationOptions {
    double seconds = 1;    ///< about how long frames are measured; building scenes for them comes on top
    int repetitions = 51;  ///< of each frame at most; at least 3 are made, however long they take
};

namespace detail {

/// A view of 512 x 512 pixels, of which a unit of length takes one in the plane z = 0.
inline constexpr float calibration_half_side = 256;
inline LocalView calibration_view() {
    const Camera camera{.eye = glm::dvec3(0, 0, calibration_half_side), .half_height = 1};
    return LocalView(View{.camera = camera}, glm::dvec3(0), 4 * calibration_half_side);
}

/// The place of the i-th of n x n things that lie `step` apart, row by row about the center.
inline glm::vec3 calibration_place(std::size_t i, std::size_t n, float step) {
    const float first = 0.5f * (step - float(n) * step);
    return {first + float(i % n) * step, first + float(i / n) * step, 0};
}

/// The time that the second frame takes beyond the first one's: least times, for whatever interrupts makes them longer.
/// They take turns, so that a change of clock rate meets both.
template <class Frame, class OtherFrame>
double extra_nanoseconds(const CalibrationOptions& options, Frame&& few, OtherFrame&& many) {
    using Clock = std::chrono::steady_clock;
    constexpr double kinds = 11;  // shares of options.seconds
    const auto nanoseconds = [](auto&& frame) {
        const auto start = Clock::now();
        frame();
        return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
    };
    many();  // buffers grow
    few();
    double least_few = nanoseconds(few), least_many = nanoseconds(many);
    const auto start = Clock::now();
    for (int i = 1; i < 3 || (i < options.repetitions &&
                              std::chrono::duration<double>(Clock::now() - start).count() < options.seconds / kinds);
         ++i) {
        least_few = std::min(least_few, nanoseconds(few));
        least_many = std::min(least_many, nanoseconds(many));
    }
    return least_many - least_few;
}

/// No work takes less than a tenth of a nanosecond: a smaller price is noise, and 0 would be nonsense.
inline float price(double nanoseconds, std::size_t count) {
    return float(std::max(nanoseconds / double(count), 0.1));
}

template <class R>
class Calibration {
  public:
    Calibration(R& renderer, const CalibrationOptions& options) : renderer_(renderer), options_(options) {}

    MeasuredTime prices() {
        MeasuredTime prices;
        prices.small_triangle = triangle_price(256, 0.6f);
        // Half the square each. Those of one pixel lie where they please, or all would hold a sample, or none.
        prices.hit_triangle = triangle_price(128, 1.4142f, /*strewn=*/true);
        prices.near_triangle = triangle_price(64, 8);
        static_assert(MeasuredTime::near_px == 8 * 8 / 2);
        prices.run = run_price();
        const auto [cell, stand_in] = cell_and_stand_in_prices();
        prices.cell = cell;
        if constexpr (R::facts.draws_faces) {
            prices.face = far_field_price<Face>([](glm::vec3 p) {
                return Face{p - glm::vec3(0.5f, 0.5f, 0), p + glm::vec3(0.5f, 0.5f, 0), Rgba8{60, 60, 60, 120}, 5};
            });
            prices.splat = stand_in + 3 * prices.face;  // renderers without splats get faces instead
        }
        if constexpr (R::facts.draws_splats) {
            prices.splat = stand_in + far_field_price<Splat>([](glm::vec3 p) {
                               return Splat{p, glm::vec2(1), 0.5f, Rgba8{60, 60, 60, std::uint8_t(AreaLaw::mixed)}};
                           });
        }
        if constexpr (R::facts.keeps_images) set_image_prices(prices);
        return prices;
    }

  private:
    /// Triangles as a source of the renderer, uploaded where it keeps sources.
    class Paged {
      public:
        Paged(R& renderer, std::vector<Triangle> triangles) : renderer_(renderer), triangles_(std::move(triangles)) {
            source_.primitives = triangles_;
            source_.item_count = std::uint32_t(triangles_.size());
            if constexpr (R::facts.keeps_sources) source_.id = renderer_.upload(source_);
        }
        ~Paged() {
            if constexpr (R::facts.keeps_sources) renderer_.release(source_.id);
        }
        Paged(const Paged&) = delete;
        Paged& operator=(const Paged&) = delete;
        const Source<Triangle>& source() const { return source_; }

      private:
        R& renderer_;
        std::vector<Triangle> triangles_;
        Source<Triangle> source_;
    };

    /// Hands over cells as a Viewer does and draws nothing of them.
    struct VisitOnly {
        static constexpr RendererFacts facts{
            .draws_faces = true, .draws_splats = true, .answers_hidden = R::facts.answers_hidden};
        R& renderer;
        void begin_frame(const LocalView& view) { renderer.begin_frame(view); }
        void set_view(const LocalView& view) { renderer.set_view(view); }
        void end_frame() { renderer.end_frame(); }
        void draw(const Source<Triangle>&, std::span<const Range>) {}
        void draw(std::span<const Face>) {}
        void draw(std::span<const Splat>) {}
        float largest_splat_px() const { return std::numeric_limits<float>::max(); }
        bool hidden(const Cell& cell, CellId id) requires(R::facts.answers_hidden) { return renderer.hidden(cell, id); }
    };
    struct Unseen : ColorCube {
        template <class Sink>
        void draw_stand_in(const stand_in_data&, const Cell&, const LocalView&, Sink&&) const {}
    };

    template <class Draw>
    auto frame(Draw&& draw) {
        return [this, &draw] {
            const LocalView view = calibration_view();
            renderer_.begin_frame(view);
            renderer_.set_view(view);
            draw();
            renderer_.end_frame();
        };
    }

    static std::vector<Triangle> triangles(std::size_t n, float step, float side, std::size_t every,
                                           bool strewn = false) {
        std::vector<Triangle> all;
        for (std::size_t i = 0; i < n * n; i += every) {
            glm::vec3 p = calibration_place(i, n, step) - glm::vec3(side / 3, side / 3, 0);
            // Multiples of the golden ratio's inverse, and of its square, fill the unit evenly.
            const auto part = [&](double of) { return float(std::fmod(of * double(i), 1.0)); };
            if (strewn) p += glm::vec3(part(0.6180339887498949), part(0.7548776662466927), 0);
            all.push_back({{p, p + glm::vec3(side, 0, 0), p + glm::vec3(0, side, 0)}, {90, 120, 150, 255}});
        }
        return all;
    }

    /// Few and many draw into the same part of the picture: clearing and showing it cancels out.
    float triangle_price(std::size_t n, float side, bool strewn = false) {
        const float step = 2 * calibration_half_side / float(n);
        const Paged many(renderer_, triangles(n, step, side, 1, strewn)),
            few(renderer_, triangles(n, step, side, 8, strewn));
        const auto all_of = [this](const Paged& p) {
            const Range range{0, p.source().item_count};
            renderer_.draw(p.source(), std::span(&range, 1));
        };
        const auto draw_few = [&] { all_of(few); };
        const auto draw_many = [&] { all_of(many); };
        return price(extra_nanoseconds(options_, frame(draw_few), frame(draw_many)), n * n - n * n / 8);
    }

    /// The same triangles in one run and in many, handed over as a Viewer does.
    float run_price() {
        constexpr std::uint32_t length = 11, batch = 256;  // not a multiple of what renderers take at a step
        // Hardly any holds a sample, and all are near each other, so that little else takes time.
        const Paged small_ones(renderer_, triangles(256, 0.25f, 0.05f, 1));
        const Range whole{0, small_ones.source().item_count};
        std::vector<Range> ranges;
        for (std::uint32_t first = 0; first < whole.count; first += length) {
            ranges.push_back({first, std::min(length, whole.count - first)});
        }
        const auto draw_one = [&] { renderer_.draw(small_ones.source(), std::span(&whole, 1)); };
        const auto draw_many = [&] {
            for (std::size_t i = 0; i < ranges.size(); i += batch) {
                const std::span<const Range> rest = std::span<const Range>(ranges).subspan(i);
                renderer_.draw(small_ones.source(), rest.first(std::min<std::size_t>(batch, rest.size())));
            }
        };
        return price(extra_nanoseconds(options_, frame(draw_one), frame(draw_many)), ranges.size());
    }

    /// Images that tile a picture half of which is triangles, as half of what most images show is: `a_side` of them on
    /// a side.
    class Tiles {
      public:
        Tiles(R& renderer, std::size_t a_side)
            : renderer_(renderer), a_side_(a_side), source_(renderer, sorted(a_side)) {}
        ~Tiles() { free(); }
        Tiles(const Tiles&) = delete;
        Tiles& operator=(const Tiles&) = delete;

        std::size_t count() const { return a_side_ * a_side_; }
        /// As much drawn into the picture, and no image made.
        void draw_contents() const {
            for (std::size_t i = 0; i < count(); ++i) draw_contents(i);
        }
        void make(const LocalView& view) {
            const auto width = int(side_px());
            for (std::size_t i = 0; i < count(); ++i) {
                const LocalView part = view.rectangle(int(i % a_side_) * width, int(i / a_side_) * width, width, width);
                if constexpr (R::facts.slices_images) {
                    const ImageSlice whole{.depth = calibration_half_side};
                    renderer_.begin_image(part, std::span(&whole, 1), 1);
                } else {
                    renderer_.begin_image(part, calibration_half_side, 1);
                }
                renderer_.set_view(part);
                draw_contents(i);
                std::uint32_t image = 0;
                if constexpr (R::facts.slices_images) {
                    renderer_.end_image(std::span(&image, 1));
                } else {
                    image = renderer_.end_image();
                }
                if (image != 0) images_.push_back({image, corner(i), {side_px(), 0, 0}, {0, -side_px(), 0}});
            }
            renderer_.set_view(view);
        }
        void free() {
            for (const ImageQuad& quad : images_) renderer_.free_image(quad.image);
            images_.clear();
        }
        void draw_images() const {
            for (const ImageQuad& quad : images_) renderer_.draw(std::span(&quad, 1));
        }

      private:
        static constexpr std::size_t n = 64;  // of triangles on a side, eight pixels each
        float side_px() const { return 2 * calibration_half_side / float(a_side_); }
        glm::vec3 corner(std::size_t i) const {
            return {float(i % a_side_) * side_px() - calibration_half_side,
                    calibration_half_side - float(i / a_side_) * side_px(), 0};
        }
        void draw_contents(std::size_t i) const {
            const auto each = std::uint32_t(n * n / count());
            const Range range{std::uint32_t(i) * each, each};
            renderer_.draw(source_.source(), std::span(&range, 1));
        }
        /// Those of one tile after those of another.
        static std::vector<Triangle> sorted(std::size_t a_side) {
            const std::vector<Triangle> rows = triangles(n, 8, 8, 1);
            const std::size_t in_tile = n / a_side;
            std::vector<Triangle> all;
            for (std::size_t tile = 0; tile < a_side * a_side; ++tile) {
                for (std::size_t i = 0; i < in_tile * in_tile; ++i) {
                    const std::size_t x = tile % a_side * in_tile + i % in_tile;
                    const std::size_t from_top = tile / a_side * in_tile + i / in_tile;
                    all.push_back(rows[(n - 1 - from_top) * n + x]);
                }
            }
            return all;
        }

        R& renderer_;
        std::size_t a_side_;
        Paged source_;
        std::vector<ImageQuad> images_;
    };

    /// Few large images and many small ones of the same picture tell what an image takes from what a texel does.
    void set_image_prices(MeasuredTime& prices) {
        Tiles large_ones(renderer_, 8), many(renderer_, 32);
        const LocalView view = calibration_view();
        // Something is behind images, so that finishing the picture takes the same without them.
        std::vector<Triangle> wall;
        for (const float way : {-1.0f, 1.0f}) {
            const glm::vec3 corner = glm::vec3(way, way, -0.25f) * (2 * calibration_half_side);
            wall.push_back({{corner, corner * glm::vec3(-1, 1, 1), corner * glm::vec3(1, -1, 1)}, {20, 30, 40, 255}});
        }
        const Paged backdrop(renderer_, std::move(wall));
        const auto making = [&](Tiles& tiles) {
            const auto contents = [&] { tiles.draw_contents(); };
            const auto images = [&] {
                tiles.make(view);
                tiles.free();
            };
            return extra_nanoseconds(options_, frame(contents), frame(images));
        };
        const auto drawing = [&](Tiles& tiles) {
            const auto behind = [&] {
                const Range range{0, backdrop.source().item_count};
                renderer_.draw(backdrop.source(), std::span(&range, 1));
            };
            const auto images = [&] {
                behind();
                tiles.draw_images();
            };
            const auto make = [&] { tiles.make(view); };
            tiles.free();
            frame(make)();
            return extra_nanoseconds(options_, frame(behind), frame(images));
        };
        constexpr double texels = 4.0 * double(calibration_half_side) * double(calibration_half_side);
        const auto prices_of = [&](double few_images, double many_images, float& an_image, float& a_texel) {
            const auto more = double(many.count() - large_ones.count());
            an_image = price(many_images - few_images, std::size_t(more));
            a_texel = price(few_images - double(an_image) * double(large_ones.count()), std::size_t(texels));
        };
        const double few_made = making(large_ones), many_made = making(many);
        prices_of(few_made, many_made, prices.made_image, prices.made_texel);
        const double few_drawn = drawing(large_ones), many_drawn = drawing(many);
        prices_of(few_drawn, many_drawn, prices.image, prices.texel);
    }

    /// The price of faces or splats about a pixel wide, side by side: cells stand in when they are that large.
    template <class Drawn, class Make>
    float far_field_price(Make&& make) {
        constexpr std::size_t n = 128;
        std::vector<Drawn> many, few;
        for (std::size_t i = 0; i < n * n; ++i) {
            many.push_back(make(calibration_place(i, n, 1.25f)));
            if (i % 8 == 0) few.push_back(many.back());
        }
        const auto draw_few = [&] { renderer_.draw(std::span<const Drawn>(few)); };
        const auto draw_many = [&] { renderer_.draw(std::span<const Drawn>(many)); };
        return price(extra_nanoseconds(options_, frame(draw_few), frame(draw_many)), many.size() - few.size());
    }

    /// The prices of visiting a cell, and of an approximation's own work until its stand-in reaches the renderer.
    std::pair<float, float> cell_and_stand_in_prices() {
        constexpr std::size_t side = 32;
        std::vector<Triangle> scene;
        for (std::size_t i = 0; i < side * side * side; ++i) {
            const glm::vec3 p(float(i % side), float(i / side % side), float(i / side / side));
            scene.push_back({{p, p + glm::vec3(0.1f, 0, 0), p + glm::vec3(0, 0.1f, 0)}, {}});
        }
        // Orthographic: every cell of a level has the same error, and the lowest level alone is within tolerance.
        constexpr double half = double(side) / 2;
        View view{.camera =
                      Camera::orthographic({half, half, 4 * half}, {half, half, half}, {0, 1, 0}, 4 * float(half))};
        view.tolerance_px = 1.5f * float(view.height) / (4 * float(half));
        const auto unseen = hierarchy<Unseen>(scene, 5), few = hierarchy<Unseen>(scene, 2);
        const auto seen = hierarchy<ColorCube>(scene, 5);
        VisitOnly renderer{renderer_};
        auto visit_few = make_viewer(few, scene, renderer);
        auto visit_many = make_viewer(unseen, scene, renderer);
        auto visit_seen = make_viewer(seen, scene, renderer);
        FrameStats s_few, s_many, s_seen;
        const auto frame_few = [&] { s_few = visit_few.frame(view); };
        const auto frame_many = [&] { s_many = visit_many.frame(view); };
        const auto frame_seen = [&] { s_seen = visit_seen.frame(view); };
        const double cells = extra_nanoseconds(options_, frame_few, frame_many);
        const double stand_ins = extra_nanoseconds(options_, frame_many, frame_seen);
        return {price(cells, s_many.cells_visited - s_few.cells_visited), price(stand_ins, s_seen.approximations)};
    }

    template <class A>
    static auto hierarchy(const std::vector<Triangle>& scene, std::uint32_t depth) {
        // Stand-ins cost nothing, so each is kept; analytic ones are made without sampling.
        using H = SpatialHierarchy<Octree, A, TriangleCount>;
        A approximation;
        approximation.samples = 0;
        return build<H>(scene, {.partition = {.uniform_depth = depth},
                                .approximation = approximation,
                                .cost_model = {.triangles_per_splat = 0}});
    }

    R& renderer_;
    const CalibrationOptions& options_;
};

}  // namespace detail

/// Measures prices for builds that suit this machine, this renderer and its options (samples, light). The renderer's
/// end_frame must not return before the picture is done. Whatever the renderer does not draw
/// keeps MeasuredTime's defaults; all prices are positive and finite. Leaves another picture in the renderer.
template <class R>
requires Renderer<R, Triangle> MeasuredTime calibrate(R& renderer, const CalibrationOptions& options = {}) {
    return detail::Calibration<R>(renderer, options).prices();
}

}  // namespace farfield
