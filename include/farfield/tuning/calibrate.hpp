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
    double seconds = 0.6;  ///< about how long frames are measured; building scenes for them comes on top
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

/// The time that the second frame takes beyond the first one's. They take turns, so that a change of clock rate meets
/// both, and the median of their differences ignores interruptions.
template <class Frame, class OtherFrame>
double extra_nanoseconds(const CalibrationOptions& options, Frame&& few, OtherFrame&& many) {
    using Clock = std::chrono::steady_clock;
    constexpr double kinds = 6;  // shares of options.seconds
    const auto nanoseconds = [](auto&& frame) {
        const auto start = Clock::now();
        frame();
        return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
    };
    many();  // buffers grow
    few();
    std::vector<double> differences;
    const auto start = Clock::now();
    while (differences.size() < 3 ||
           (int(differences.size()) < options.repetitions &&
            std::chrono::duration<double>(Clock::now() - start).count() < options.seconds / kinds)) {
        const double without = nanoseconds(few);
        differences.push_back(nanoseconds(many) - without);
    }
    const auto middle = differences.begin() + std::ptrdiff_t(differences.size() / 2);
    std::nth_element(differences.begin(), middle, differences.end());
    return *middle;
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
        MeasuredTime prices;  // images and texels: no renderer has a hook for them yet
        prices.small_triangle = triangle_price(256, 0.6f);
        prices.near_triangle = triangle_price(64, 14.2f);  // half the square: 100 pixels
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

    static std::vector<Triangle> triangles(std::size_t n, float step, float side, std::size_t every) {
        std::vector<Triangle> all;
        for (std::size_t i = 0; i < n * n; i += every) {
            const glm::vec3 p = calibration_place(i, n, step) - glm::vec3(side / 3, side / 3, 0);
            all.push_back({{p, p + glm::vec3(side, 0, 0), p + glm::vec3(0, side, 0)}, {90, 120, 150, 255}});
        }
        return all;
    }

    /// Few and many draw into the same part of the picture: clearing and showing it cancels out.
    float triangle_price(std::size_t n, float side) {
        const float step = 2 * calibration_half_side / float(n);
        const Paged many(renderer_, triangles(n, step, side, 1)), few(renderer_, triangles(n, step, side, 8));
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
/// end_frame must not return before the picture is done. Images, texels, and whatever else the renderer does not draw
/// keep MeasuredTime's defaults; all prices are positive and finite. Leaves another picture in the renderer.
template <class R>
requires Renderer<R, Triangle> MeasuredTime calibrate(R& renderer, const CalibrationOptions& options = {}) {
    return detail::Calibration<R>(renderer, options).prices();
}

}  // namespace farfield
