// Shade et al. 1996, section 5: a walk over an island of 40.6 million triangles, by images of cells and without, over
// exact geometry and over a far field, as a table. What a row compares is drawn in turns in one run; times are the
// processor's. "Exact" is frustum culling over the same BSP.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/image_cache.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/measure/flip.hpp"
#include "farfield/partition/gap_bsp.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/generate/island.hpp"
#include "scenes/object.hpp"
#include "support/image_meters.hpp"
#include "support/shaded_renderer.hpp"

using namespace farfield;
using namespace farfield::bench;

namespace {

using Far = OpacityTensor;
template <class A>
using Hierarchy = SpatialHierarchy<GapBsp, A, MeasuredTime>;
/// A tree's own: with a far field an octree, for cells between gaps are long, and few of their tensors are good at
/// several pixels (the far field over gaps alone is slower than exact geometry).
template <class A>
using TreeHierarchy = SpatialHierarchy<std::conditional_t<A::facts.stands_in, Octree, GapBsp>, A, MeasuredTime>;

/// Of this thread, on the processor.
double now_ms() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return double(t.tv_sec) * 1e3 + double(t.tv_nsec) * 1e-6;
}

/// A scene whose last group places the others.
template <class A>
struct Built {
    using Tree = TreeHierarchy<A>;
    using Object = scenes::Object<Tree>;

    std::vector<std::vector<VertexColoredTriangle>> trees;
    std::vector<Tree> kinds;
    std::vector<Object> objects;
    Hierarchy<A> hierarchy;
    double root_ms = 0;  ///< of building the outermost hierarchy

    Built(const scenes::Scene& scene, const A& approximation, const MeasuredTime& prices) {
        for (std::size_t g = 0; g + 1 < scene.groups.size(); ++g) trees.push_back(scene.groups[g].triangles);
        for (auto& tree : trees) {
            kinds.push_back(build_in_place<Tree>(tree, {.approximation = approximation, .cost_model = prices}));
        }
        for (const auto& t : scene.groups.back().triangles) objects.push_back({t});
        for (const auto& p : scene.groups.back().placements) {
            objects.push_back(
                {Instance<Tree, VertexColoredTriangle>{&kinds[p.group], trees[p.group], Similarity(p.to_parent)}});
        }
        const double start = now_ms();
        hierarchy = build_in_place<Hierarchy<A>>(objects, {.approximation = approximation, .cost_model = prices});
        root_ms = now_ms() - start;
    }
};

/// Of all z-buffers: the paper's peer was a scalar one.
Simd simd = Simd::automatic;

/// A hierarchy with a viewer and renderer of its own.
template <class A, class R = ZBufferRenderer>
struct Player {
    using Object = typename Built<A>::Object;

    Built<A> built;
    R renderer;
    Viewer<Hierarchy<A>, Object, R> viewer;

    explicit Player(const scenes::Scene& scene, const A& approximation = {}, int samples = 1,
                    const MeasuredTime& prices = {})
        : built(scene, approximation, prices),
          renderer(ZBufferOptions{.samples = samples, .simd = simd}),
          viewer(built.hierarchy, std::span<const Object>(built.objects), renderer) {}
};

template <class Inner>
ImageCache<Inner> with_images(const ImageCacheOptions& options) {
    ImageCache<Inner> a;
    a.image_options = options;
    return a;
}

double mean(std::span<const double> v) {
    return std::accumulate(v.begin(), v.end(), 0.0) / double(v.size());
}

/// What is drawn frame by frame, and what came of it.
struct Contestant {
    std::function<FrameStats(const View&)> frame;
    std::function<const Image&()> image;
    std::shared_ptr<void> player;
    float tolerance_px = 1;
    bool is_spread = false;  ///< drawn in some of the frames, spread over the path
    std::vector<double> ms{};
    std::vector<FrameStats> stats{};
    std::vector<double> flips{};        ///< against 64 samples a pixel
    std::vector<std::size_t> holes{};   ///< pixels without anything where exact has something in all within two
    std::vector<std::size_t> cracks{};  ///< the same where bare ground has

    double mean_ms() const { return mean(ms); }
    double made_a_frame() const {
        double sum = 0;
        for (const FrameStats& s : stats) sum += double(s.images_made);
        return sum / double(stats.size());
    }
    void draw(View view) {
        view.tolerance_px = tolerance_px;
        const double start = now_ms();
        const FrameStats drawn = frame(view);
        ms.push_back(now_ms() - start);
        stats.push_back(drawn);
    }
};

template <class A, class R = ZBufferRenderer>
Contestant contestant(std::shared_ptr<Player<A, R>> player, float tolerance_px = 1, bool is_spread = false) {
    const auto p = player.get();
    return {[p](const View& view) { return p->viewer.frame(view); },
            [p]() -> const Image& { return p->renderer.image(); }, std::move(player), tolerance_px, is_spread};
}

template <class A, class R = ZBufferRenderer, class... More>
std::shared_ptr<Player<A, R>> player(const scenes::Scene& scene, const A& approximation = {}, More... more) {
    return std::make_shared<Player<A, R>>(scene, approximation, more...);
}

/// Which frames of the path are drawn.
struct Plan {
    int frames = 1200;        ///< along the path
    int first = 0;            ///< drawn from this one on,
    int count = 1200;         ///< so many
    int spread_every = 24;    ///< those that are spread
    int quality_every = 120;  ///< pictures are compared

    int end() const { return std::min(frames, first + count); }
};

std::vector<View> views_of(int frames) {
    std::vector<View> views;
    for (const Camera& camera : scenes::walk_over_island(scenes::shade_island, frames)) {
        views.push_back({.camera = camera, .width = 640, .height = 480});
    }
    return views;
}

void draw_in_turns(std::span<const View> views, const Plan& plan, std::span<Contestant* const> all,
                   const std::function<void(const View&)>& compare = {}) {
    // Buffers grow. Of images the first frame is measured.
    for (Contestant* c : all) {
        if (c->is_spread) c->frame(views[std::size_t(plan.first)]);
    }
    for (int f = plan.first; f < plan.end(); ++f) {
        const View& view = views[std::size_t(f)];
        for (Contestant* c : all) {
            if (!c->is_spread || (f - plan.first) % plan.spread_every == 0) c->draw(view);
        }
        if (compare && (f - plan.first) % plan.quality_every == 0) compare(view);
    }
}

/// How many times as fast.
double speedup(const Contestant& c, const Contestant& over) {
    return over.mean_ms() / c.mean_ms();
}

constexpr Rgba8 sky{135, 180, 220, 255};

Image over_sky(const Image& image) {
    Image out = image;
    for (Rgba8& c : out.pixels()) {
        const auto over = [&](std::uint8_t front, std::uint8_t back) {
            return std::uint8_t(front + (back * (255 - c.a) + 127) / 255);
        };
        c = {over(c.r, sky.r), over(c.g, sky.g), over(c.b, sky.b), 255};
    }
    return out;
}

std::size_t holes(const Image& image, const Image& exact) {
    constexpr int reach = 2;
    std::size_t count = 0;
    for (int y = reach; y + reach < image.height(); ++y) {
        for (int x = reach; x + reach < image.width(); ++x) {
            if (image.at(x, y).a != 0) continue;
            bool covered = true;
            for (int dy = -reach; dy <= reach; ++dy) {
                for (int dx = -reach; dx <= reach; ++dx) covered &= exact.at(x + dx, y + dy).a != 0;
            }
            count += covered;
        }
    }
    return count;
}

/// The rows of bench/README.md.
class Table {
  public:
    Table() { std::printf("| what | paper | here | wanted |\n|---|---|---|---|\n"); }
    void row(const std::string& what, const char* paper, const std::string& here, const char* wanted) {
        std::printf("| %s | %s | %s | %s |\n", what.c_str(), paper, here.c_str(), wanted);
        std::fflush(stdout);
    }
};

std::string number(double v) {
    char text[32];
    const double size = std::abs(v);
    std::snprintf(text, sizeof text,
                  size >= 100 || v == std::floor(v) ? "%.0f"
                  : size >= 10                      ? "%.1f"
                  : size >= 1                       ? "%.2f"
                                                    : "%.2g",
                  v);
    return text;
}
/// Bold is what misses.
std::string at_least(double v, double wanted) {
    return v >= wanted ? number(v) : "**" + number(v) + "**";
}
std::string at_most(double v, double wanted) {
    return v <= wanted ? number(v) : "**" + number(v) + "**";
}

/// 99th percentile and slowest of the frames after the first, over their median.
std::array<double, 2> spikes(const Contestant& c) {
    std::vector<double> later(c.ms.begin() + 1, c.ms.end());
    std::sort(later.begin(), later.end());
    const double median = later[later.size() / 2];
    return {later[later.size() * 99 / 100] / median, later.back() / median};
}

std::string memory(const Contestant& c) {
    std::uint64_t most = 0;
    double drawn = 0;
    for (const FrameStats& s : c.stats) {
        most = std::max(most, s.image_bytes);
        drawn += double(s.images);
    }
    return number(drawn / double(c.stats.size())) + ", " + number(c.made_a_frame()) + ", " +
           number(double(most) / 1e6) + " MB";
}

class Bench {
  public:
    Bench(const Plan& plan, const ImageCacheOptions& images, const ImageCacheOptions& over_far)
        : plan_(plan), images_(images), over_far_(over_far) {}

    /// The far field at the tolerance that is fastest among those that err no more than exact does.
    void choose_far_field() {
        const auto exact = player<Exact>(scene_), finest = player<Exact>(scene_, {}, 64);
        const auto far = player<Far>(scene_);
        constexpr std::array<float, 4> tolerances{0.5f, 1, 2, 4};
        std::array<double, 4> ms{}, flips{};
        double exact_ms = 0, exact_flip = 0;
        constexpr int samples = 4;
        for (int i = 0; i < samples; ++i) {
            View view = views_[std::size_t(plan_.first + i * (plan_.end() - 1 - plan_.first) / (samples - 1))];
            finest->viewer.frame(view);
            const Image reference = over_sky(finest->renderer.image());
            const auto timed = [&](auto& who) {
                who.viewer.frame(view);
                const double start = now_ms();
                who.viewer.frame(view);
                return now_ms() - start;
            };
            exact_ms += timed(*exact) / samples;
            exact_flip += flip(over_sky(exact->renderer.image()), reference) / samples;
            for (std::size_t t = 0; t < tolerances.size(); ++t) {
                view.tolerance_px = tolerances[t];
                ms[t] += timed(*far) / samples;
                flips[t] += flip(over_sky(far->renderer.image()), reference) / samples;
            }
        }
        std::size_t best = 0;
        for (std::size_t t = 1; t < tolerances.size(); ++t) {
            if (flips[t] <= std::max(exact_flip, flips[0]) && ms[t] < ms[best]) best = t;
        }
        tolerance_px_ = tolerances[best];
        std::string times, errors;
        for (std::size_t t = 0; t < tolerances.size(); ++t) {
            times += (t > 0 ? ", " : "") + number(exact_ms / ms[t]);
            errors += (t > 0 ? ", " : "") + std::string(flips[t] < 0.0995 ? "0.0" : "0.") +
                      std::to_string(int(std::lround(flips[t] * 1000))).substr(0, 3);
        }
        table_.row("the far field, opacity tensors at 0.5, 1, 2, 4 pixels, over exact; FLIP (" +
                       number(double(tolerance_px_)) + " from here on)",
                   "", times + "; " + errors, "");
    }

    void walk() {
        const auto options = [&](float threshold, int samples = 1) {
            ImageCacheOptions o = images_;
            o.threshold_px = threshold;
            o.samples = samples;
            return o;
        };
        const auto far_options = [&](float threshold, int samples = 1) {
            ImageCacheOptions o = over_far_;
            o.threshold_px = threshold;
            o.samples = samples;
            return o;
        };
        ImageCacheOptions careful = options(2);
        careful.is_conservative = true;
        const auto with_ground = [&](float threshold) {
            ImageCacheOptions o = options(threshold);
            o.of_instances_only = false;
            o.most_ahead = 0;
            return o;
        };
        const float t = tolerance_px_;
        Contestant exact = contestant(player<Exact>(scene_), 1, true),
                   exact16 = contestant(player<Exact>(scene_, {}, 16), 1, true),
                   alone2 = contestant(player(scene_, with_images<Exact>(options(2)))),
                   alone8 = contestant(player(scene_, with_images<Exact>(options(8)))),
                   alone_careful = contestant(player(scene_, with_images<Exact>(careful))),
                   ground2 = contestant(player(scene_, with_images<Exact>(with_ground(2)))),
                   ground8 = contestant(player(scene_, with_images<Exact>(with_ground(8)))),
                   alone16 = contestant(player(scene_, with_images<Exact>(options(2, 16)))),
                   far = contestant(player<Far>(scene_), t), far16 = contestant(player<Far>(scene_, {}, 16), t, true),
                   far2 = contestant(player(scene_, with_images<Far>(far_options(2))), t),
                   far8 = contestant(player(scene_, with_images<Far>(far_options(8))), t),
                   far2_at_16 = contestant(player(scene_, with_images<Far>(far_options(2, 16))), t);
        scenes::Scene bare = scene_;
        bare.groups.back().placements.clear();
        const auto finest = player<Exact>(scene_, {}, 64), ground = player<Exact>(bare);
        const std::array compared{&exact, &exact16, &alone2, &ground2, &ground8, &alone16, &far, &far2, &far2_at_16};
        const std::array<Contestant*, 13> all{&exact,   &exact16, &alone2,    &alone8, &alone_careful,
                                              &ground2, &ground8, &alone16,   &far,    &far16,
                                              &far2,    &far8,    &far2_at_16};
        draw_in_turns(views_, plan_, all, [&](const View& view) {
            finest->viewer.frame(view);
            ground->viewer.frame(view);
            const Image reference = over_sky(finest->renderer.image());
            for (Contestant* c : compared) {
                c->flips.push_back(flip(over_sky(c->image()), reference));
                c->holes.push_back(holes(c->image(), exact.image()));
                c->cracks.push_back(holes(c->image(), ground->renderer.image()));
            }
        });
        const auto spread_ms = [&](const Contestant& c) { return number(c.mean_ms()); };
        table_.row("milliseconds a frame: exact, images alone, far field, images over it", "",
                   spread_ms(exact) + ", " + spread_ms(alone2) + ", " + spread_ms(far) + ", " + spread_ms(far2), "");
        table_.row("images drawn, made a frame, memory: alone; over the far field", "",
                   memory(alone2) + "; " + memory(far2), "");
        table_.row("2 pixels, images alone", "11.9", at_least(speedup(alone2, exact), 9), "9");
        table_.row("8 pixels, images alone; over the far field", "14.1",
                   at_least(speedup(alone8, exact), 14) + "; " + at_least(speedup(far8, exact), 45), "14; 45");
        std::size_t slower = 0;
        for (std::size_t i = 0; i < far.ms.size(); ++i) slower += far2.ms[i] > far.ms[i];
        table_.row("2 pixels, over the far field: over exact; over the far field alone", "",
                   at_least(speedup(far2, exact), 40) + "; " + at_least(speedup(far2, far), 1.3), "40; 1.3");
        table_.row("frames, of " + std::to_string(far.ms.size()) + ", in which images over the far field are slower",
                   "", at_most(double(slower), double(far.ms.size()) / 12), "100 of 1,200");
        table_.row("images of 16 samples over the far field: over exact at 16; over the far field at 16", "",
                   at_least(speedup(far2_at_16, exact16), 20) + "; " + at_least(speedup(far2_at_16, far16), 2.5),
                   "20; 2.5");
        table_.row("images of 16 samples alone, over exact at 16", "", number(speedup(alone16, exact16)), "");
        const double own = mean(exact.flips);
        const auto fixed = [](double v) {
            char text[16];
            std::snprintf(text, sizeof text, "%.3f", v);
            return std::string(text);
        };
        const auto quality = [&](const Contestant& c, double wanted) {
            const double v = mean(c.flips);
            return v <= wanted ? fixed(v) : "**" + fixed(v) + "**";
        };
        table_.row("mean FLIP against 64 samples: exact; exact at 16; far field", "",
                   fixed(own) + "; " + fixed(mean(exact16.flips)) + "; " + fixed(mean(far.flips)), "");
        table_.row("the same at 2 pixels: images alone; over the far field", "",
                   quality(alone2, own) + "; " + quality(far2, own), "exact's own");
        table_.row("the same with images of 16 samples: alone; over the far field", "",
                   quality(alone16, 0.040) + "; " + quality(far2_at_16, 0.040), "0.040");
        table_.row("the conservative metric's speed-up over that of the fast one", "",
                   at_least(speedup(alone_careful, alone2), 0.8), "0.8");
        table_.row("first frame / exact frame: alone; over the far field", "2",
                   at_most(alone2.ms[0] / exact.ms[0], 1.2) + "; " + at_most(far2.ms[0] / exact.ms[0], 1.2), "1.2");
        const auto slow = [&](const Contestant& c) {
            const auto [p99, most] = spikes(c);
            return at_most(most, 2.5) + ", " + at_most(p99, 2);
        };
        table_.row("slowest, 99th percentile / median after the first: alone; over the far field", "",
                   slow(alone2) + "; " + slow(far2), "2.5, 2");
        const auto mean_count = [](const std::vector<std::size_t>& counts) {
            return double(std::accumulate(counts.begin(), counts.end(), std::size_t(0))) / double(counts.size());
        };
        table_.row(
            "pixels of background where there is ground: images of trees alone; with the ground in images, 2 and 8 "
            "pixels",
            "\"cracks\"",
            at_most(mean_count(alone2.cracks), 0) + "; " + number(mean_count(ground2.cracks)) + ", " +
                number(mean_count(ground8.cracks)),
            "0");
        table_.row(
            "pixels of background where exact has none, mostly among leaves: the same; speed-up with the ground in "
            "images, 2 and 8 pixels",
            "",
            number(mean_count(alone2.holes)) + "; " + number(mean_count(ground2.holes)) + ", " +
                number(mean_count(ground8.holes)) + "; " + number(speedup(ground2, exact)) + ", " +
                number(speedup(ground8, exact)),
            "");
        alone_speedup_ = speedup(alone2, exact);
        far_speedup_ = speedup(far2, exact);
    }

    /// What of walk() is short enough for the whole path on a machine that others use.
    void alone() {
        ImageCacheOptions at_8 = images_;
        at_8.threshold_px = 8;
        Contestant exact = contestant(player<Exact>(scene_), 1, true),
                   alone2 = contestant(player(scene_, with_images<Exact>(images_))),
                   alone8 = contestant(player(scene_, with_images<Exact>(at_8)));
        const std::array<Contestant*, 3> all{&exact, &alone2, &alone8};
        draw_in_turns(views_, plan_, all);
        const auto [p99, most] = spikes(alone2);
        table_.row(number(double(alone2.ms.size())) +
                       " frames, images alone: 2 pixels, 8 pixels, over exact; first / exact; slowest, 99th "
                       "percentile / median",
                   "11.9, 14.1; 2",
                   at_least(speedup(alone2, exact), 9) + ", " + at_least(speedup(alone8, exact), 14) + "; " +
                       at_most(alone2.ms[0] / exact.ms[0], 1.2) + "; " + at_most(most, 2.5) + ", " + at_most(p99, 2),
                   "9, 14; 1.2; 2.5, 2");
        table_.row("images drawn, made a frame, memory", "", memory(alone2), "");
    }

    void short_walks() {
        std::string here;
        for (const int frames : {15, 30}) {
            const std::vector<View> views = views_of(frames);
            Contestant exact = contestant(player<Exact>(scene_)),
                       alone = contestant(player(scene_, with_images<Exact>(images_)));
            exact.frame(views.front());
            const std::array<Contestant*, 2> all{&exact, &alone};
            draw_in_turns(views, {.frames = frames, .count = frames}, all);
            here += (here.empty() ? "" : ", ") + at_least(speedup(alone, exact), frames == 15 ? 1.3 : 2);
        }
        table_.row("15, 30 frames along the path, images alone", "30 to break even", here, "1.3, 2");
    }

    void fewer_trees() {
        scenes::Scene scene = scene_;
        scene.groups.back().placements.resize(574);  // planted one by one, all over
        Contestant exact = contestant(player<Exact>(scene), 1, true),
                   alone = contestant(player(scene, with_images<Exact>(images_))),
                   far = contestant(player(scene, with_images<Far>(over_far_)), tolerance_px_);
        const std::array<Contestant*, 3> all{&exact, &alone, &far};
        draw_in_turns(views_, plan_, all);
        if (alone_speedup_ == 0) {
            Contestant more_exact = contestant(player<Exact>(scene_), 1, true),
                       more_alone = contestant(player(scene_, with_images<Exact>(images_))),
                       more_far = contestant(player(scene_, with_images<Far>(over_far_)), tolerance_px_);
            const std::array<Contestant*, 3> more{&more_exact, &more_alone, &more_far};
            draw_in_turns(views_, plan_, more);
            alone_speedup_ = speedup(more_alone, more_exact);
            far_speedup_ = speedup(more_far, more_exact);
        }
        table_.row("1,117 trees / 574, the speed-up over exact: alone; over the far field", "fell",
                   at_least(alone_speedup_ / speedup(alone, exact), 0.95) + "; " +
                       at_least(far_speedup_ / speedup(far, exact), 1),
                   "0.95; rises");
    }

    void displacement() {
        std::string here;
        for (const bool conservative : {false, true}) {
            ImageCacheOptions options = images_;
            options.is_conservative = conservative;
            const auto alone = player<ImageCache<Exact>, DisplacementMeter>(scene_, with_images<Exact>(options));
            for (int f = plan_.first; f < plan_.end(); ++f) alone->viewer.frame(views_[std::size_t(f)]);
            const double most = double(alone->renderer.largest_px());
            here += (here.empty() ? "" : "; ") +
                    (conservative ? at_most(most, double(options.threshold_px)) : number(most));
            if (conservative) here += " (" + number(double(alone->renderer.compared())) + " points)";
        }
        table_.row("largest displacement, pixels: fast metric; conservative", "not proven", here, "; 2");
    }

    /// By a renderer that shades each pixel it has to for 1 microsecond.
    void shading() {
        const DearShader shader = DearShader::taking_ns(1000);
        // What calibrate() would find: half of a triangle's pixels are seen, of small ones a few hundredths.
        MeasuredTime dear;
        dear.small_triangle = 20;
        dear.hit_triangle = 1000;
        dear.near_triangle = 16000;
        dear.splat = 800;
        const auto far_player = player<Far, ShadedRenderer>(scene_);
        const auto images_player =
            player<ImageCache<Far>, ShadedRenderer>(scene_, with_images<Far>(over_far_), 1, dear);
        far_player->renderer.set_shader(shader);
        images_player->renderer.set_shader(shader);
        Contestant far = contestant(far_player, tolerance_px_), images = contestant(images_player, tolerance_px_);
        const std::array<Contestant*, 2> all{&far, &images};
        std::vector<double> differences;
        draw_in_turns(views_, plan_, all, [&](const View&) {
            differences.push_back(flip(over_sky(images.image()), over_sky(far.image())));
        });
        const auto frames = double(far.ms.size());
        table_.row(
            "a shader of 1 microsecond a pixel: images over the far field, over it alone (pixels shaded, ms a frame; "
            "FLIP between the two)",
            "",
            at_least(speedup(images, far), 8) + " (" +
                number(std::round(double(images_player->renderer.shaded_pixels()) / frames)) + ", " +
                number(std::round(double(far_player->renderer.shaded_pixels()) / frames)) + "; " +
                number(images.mean_ms()) + ", " + number(far.mean_ms()) + "; " + number(mean(differences)) + ")",
            "8");
    }

    void standing_still() {
        const auto alone = player(scene_, with_images<Exact>(images_));
        const View& view = views_[std::size_t(plan_.first)];
        for (int i = 0; i < 8; ++i) alone->viewer.frame(view);
        const Image settled = alone->renderer.image();
        double made = 0, changed = 0;
        for (int i = 0; i < 12; ++i) {
            made += double(alone->viewer.frame(view).images_made);
            for (std::size_t p = 0; p < settled.pixels().size(); ++p) {
                changed += settled.pixels()[p] != alone->renderer.image().pixels()[p];
            }
        }
        table_.row("standing still, after the first frames: images made, pixels changed", "",
                   at_most(made, 0) + ", " + at_most(changed, 0), "0, 0");
    }

    void building() {
        const double island = player<Exact>(scene_)->built.root_ms / 1e3;
        std::mt19937 random(5);
        const auto in_cube = [&] { return float(random() % 1'000'000) * 1e-6f; };
        const auto point = [&] { return glm::vec3(in_cube(), in_cube(), in_cube()); };
        std::vector<Triangle> loose(1'000'000);
        for (Triangle& t : loose) {
            const glm::vec3 p = point();
            t = {{{p, p + 0.01f * point(), p + 0.01f * point()}}, {200, 200, 200, 255}};
        }
        const double start = now_ms();
        const auto hierarchy = build_in_place<Hierarchy<Exact>>(loose);
        const double seconds = (now_ms() - start) / 1e3;
        table_.row("BSP build, seconds: island; 1 M loose triangles of side 0.01", "46",
                   at_most(island, 0.1) + "; " + at_most(seconds, 2), "0.1; 2");
    }

  private:
    Plan plan_;
    ImageCacheOptions images_, over_far_;
    scenes::Scene scene_ = scenes::island(scenes::shade_island);
    std::vector<View> views_ = views_of(plan_.frames);
    Table table_;
    float tolerance_px_ = 1;
    double alone_speedup_ = 0, far_speedup_ = 0;
};

void print_usage() {
    std::puts(
        "bench_images: Shade et al. 1996, section 5, as a table. All of it takes about half an hour.\n"
        "  --quick          40 frames of the path\n"
        "  --frames N       along the path (1200)\n"
        "  --first N, --count N   those that are drawn\n"
        "  --only ROWS      one of: walk, alone, short, trees, displacement, shading, still, build\n"
        "  --slices N, --items N, --ground, --conservative   what all images are: of depth slices, of cells of at "
        "least\n"
        "                   N items (8192), of ground as well, good by the conservative metric\n"
        "  --ahead N        made ahead by so many hundredths of their lives (75)\n"
        "  --scalar         all z-buffers without vectors, as the paper's were");
}

}  // namespace

int main(int argc, char** argv) {
    Plan plan;
    // Over exact geometry trees have images and the ground has none: no image that holds both lives long, and none has
    // cracks. Over a far field, where trees are cheap, images pay for what is large.
    ImageCacheOptions over_far{.budget_bytes = std::uint64_t(256) << 20}, images = over_far;
    images.of_instances_only = true;
    images.most_ahead = over_far.most_ahead = 0.75f;
    images.least_items = 8192;
    std::string only;
    for (int i = 1; i < argc; ++i) {
        const std::string option = argv[i];
        const auto number_after = [&] { return i + 1 < argc ? std::atoi(argv[++i]) : 0; };
        if (option == "--quick") {
            plan.first = 300;
            plan.count = 40;
            plan.spread_every = plan.quality_every = 10;
        } else if (option == "--frames") {
            plan.frames = std::max(4, number_after());
        } else if (option == "--first") {
            plan.first = std::max(0, number_after());
        } else if (option == "--count") {
            plan.count = std::max(4, number_after());
            // At least 50 exact frames, or all.
            plan.spread_every = std::max(1, plan.count / 50);
            plan.quality_every = 5 * plan.spread_every;
        } else if (option == "--only") {
            only = i + 1 < argc ? argv[++i] : "";
        } else if (option == "--slices") {
            images.slices = over_far.slices = number_after();
        } else if (option == "--items") {
            images.least_items = std::uint32_t(std::max(1, number_after()));
        } else if (option == "--ground") {
            images.of_instances_only = false;
            images.most_ahead = 0;
        } else if (option == "--ahead") {
            images.most_ahead = over_far.most_ahead = 0.01f * float(number_after());
        } else if (option == "--scalar") {
            simd = Simd::scalar;
        } else if (option == "--conservative") {
            images.is_conservative = true;
        } else {
            print_usage();
            return option == "--help" ? 0 : 2;
        }
    }
    plan.first = std::min(plan.first, plan.frames - 4);
    Bench bench(plan, images, over_far);
    using Rows = void (Bench::*)();
    constexpr std::array<std::pair<const char*, Rows>, 8> rows{{{"walk", &Bench::walk},
                                                                {"alone", &Bench::alone},
                                                                {"short", &Bench::short_walks},
                                                                {"trees", &Bench::fewer_trees},
                                                                {"displacement", &Bench::displacement},
                                                                {"shading", &Bench::shading},
                                                                {"still", &Bench::standing_still},
                                                                {"build", &Bench::building}}};
    const bool wants_far = only.empty() || only == "walk" || only == "trees" || only == "shading";
    if (wants_far) bench.choose_far_field();
    for (const auto& [name, measure] : rows) {
        if (only.empty() || only == name) (bench.*measure)();
    }
    return 0;
}
