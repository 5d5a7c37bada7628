// How long images serve along a way, against asking frame by frame.
#include "farfield/frame/image_life.hpp"

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"
#include "support/scenes.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

LocalView from_origin() {
    View view;
    view.width = 640;
    view.height = 480;
    view.camera = Camera::perspective({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.7f);
    return LocalView(view, {}, 10);
}

struct Contents {
    glm::vec3 center, half;

    std::optional<CellImage> planned(const LocalView& view) const {
        const auto rect = image_rect(view, center, half);
        if (!rect) return {};
        return planned_image(view, center, half, *rect, 1);
    }
};

LocalView after(const LocalView& view, const ExpectedPath& path, std::uint32_t frames) {
    if (frames == 0) return view;
    const glm::vec3 moved = path.after(frames);
    return view.moved(view.right * moved.x + view.up * moved.y + view.forward * moved.z);
}

}  // namespace

TEST_CASE("an image serves for as long as it is good, also if it is made ahead", "[image_life]") {
    Random random(90);
    const LocalView view = from_origin();
    double longer = 0;
    int ahead = 0;
    for (int i = 0; i < 400; ++i) {
        ImageCacheOptions options{.threshold_px = random.between(1, 8), .is_conservative = random.below(2) == 0};
        options.most_ahead = random.below(2) == 0 ? 1 : random.unit();
        const Contents box{{random.between(-5, 5), random.between(-4, 4), -random.between(15, 40)},
                           glm::vec3(random.between(0.2f, 2), random.between(0.2f, 2), random.between(0.2f, 2))};
        ExpectedPath path{.step = random.in_cube(0.2f), .steady_frames = 100};
        const ImageLife life(options, path);
        const std::optional<CellImage> here = box.planned(view);
        REQUIRE(here);
        const std::uint32_t from_here = 1 + life.frames_served(*here, view);
        const ImageLife::Service service =
            life.service(*here, view, [&](const LocalView& there) { return box.planned(there); });
        INFO("box " << i << ": " << from_here << " frames, made " << service.ahead << " ahead " << service.lives);
        REQUIRE(service.lives >= from_here);
        REQUIRE(service.ahead <= 100);
        const std::optional<CellImage> image = box.planned(after(view, path, service.ahead));
        REQUIRE(image);
        for (std::uint32_t k = 0; k < service.lives; ++k) {
            const LocalView later = after(view, path, k);
            REQUIRE(is_good(*image, later, options));
        }
        if (service.lives <= ExpectedPath::farthest) {
            const LocalView later = after(view, path, service.lives);
            REQUIRE(!is_good(*image, later, options));
        }
        if (service.ahead == 0) continue;
        ++ahead;
        longer += double(service.lives) / double(from_here);
    }
    CHECK(ahead > 200);
    CHECK(longer > 1.4 * ahead);
}

TEST_CASE("nothing is made ahead of who stands, swings, or may go anywhere", "[image_life]") {
    const LocalView view = from_origin();
    const Contents box{{0, 0, -20}, glm::vec3(1)};
    const std::optional<CellImage> here = box.planned(view);
    REQUIRE(here);
    const auto ahead = [&](const ImageCacheOptions& options, const ExpectedPath& path, const LocalView& from) {
        const ImageLife life(options, path);
        const auto planned = box.planned(from);
        REQUIRE(planned);
        return life.service(*planned, from, [&](const LocalView& there) { return box.planned(there); }).ahead;
    };
    const ExpectedPath walks{.step = {0.05f, 0, 0}, .steady_frames = 100};
    ImageCacheOptions options{.most_ahead = 0.75f};
    CHECK(ahead(options, walks, view) > 1);
    CHECK(ahead(options, {.step = walks.step, .steady_frames = 0}, view) == 0);
    CHECK(ahead(options, {.step = walks.step, .steady_frames = 1}, view) == 1);
    CHECK(ahead(options, {.step = glm::vec3(0), .steady_frames = 100}, view) == 0);
    std::vector<glm::vec3> known;
    for (int i = 1; i <= 500; ++i) known.push_back(glm::vec3(0.05f * float(i), 0, 0));
    CHECK(ahead(options, {.known = known}, view) > 0);
    known.resize(3);  // and then it stays there, for which any image will do
    CHECK(ahead(options, {.known = known}, view) == 0);
    options.most_ahead = 0;
    CHECK(ahead(options, walks, view) == 0);
    options.most_ahead = 1;
    options.most_speed = 0.01f;
    CHECK(ahead(options, walks, view) == 0);
    options.most_speed = 0;
    View parallel;
    parallel.width = parallel.height = 100;
    parallel.camera = Camera::orthographic({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 5);
    CHECK(ahead(options, walks, LocalView(parallel, {}, 10)) == 0);
}
