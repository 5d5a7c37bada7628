// What else needs neither window nor scene.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "catch.hpp"
#include "choices.hpp"
#include "comparison.hpp"
#include "farfield/measure/flip.hpp"
#include "history.hpp"
#include "outlines.hpp"
#include "resolution.hpp"
#include "script.hpp"
#include "script_player.hpp"
#include "support/random.hpp"
#include "support/temporary_directory.hpp"

using namespace viewer;
using farfield::Image;
using farfield::test::TemporaryDirectory;

TEST_CASE("pictures that move are as large as their time allows") {
    Resolution resolution(50);
    CHECK(resolution.moving() > 1);  // nothing is known
    resolution.took(2, 10);
    CHECK(resolution.moving() == 1);
    resolution.took(1, 400);
    const int coarse = resolution.moving();
    CHECK(coarse > 2);
    resolution.took(coarse, 400);
    CHECK(resolution.moving() == Resolution::coarsest);
    for (int i = 0; i < 20; ++i) resolution.took(Resolution::coarsest, 1);
    CHECK(resolution.moving() == 1);
}

TEST_CASE("a history keeps the last") {
    History history(3);
    for (const float v : {1.f, 5.f, 2.f, 3.f, 4.f}) history.add(v);
    CHECK(history.values() == std::vector<float>{2, 3, 4});
    CHECK(history.last() == 4);
    CHECK(history.largest() == 4);
}

TEST_CASE("equal pictures differ nowhere, others where they do") {
    Image a(40, 30, {100, 120, 140, 255}), b = a;
    for (const Difference kind : {Difference::flip, Difference::absolute}) {
        const Compared same = compare(a, b, kind);
        CHECK(same.rmse == 0);
        for (const auto& pixel : same.picture.pixels()) CHECK(pixel == tint_of_error(0));
    }
    CHECK(compare(a, b, Difference::absolute).flip < 0);
    b.at(20, 10) = {200, 120, 140, 255};
    const Compared one = compare(a, b, Difference::absolute);
    CHECK(one.picture.at(20, 10) == tint_of_error(1));
    CHECK(one.picture.at(21, 10) == tint_of_error(0));
    CHECK(one.rmse == Approx(std::sqrt(100.0 * 100 / (255.0 * 255) / (3 * 40 * 30))));
    CHECK(compare(a, b, Difference::flip).flip == Approx(farfield::flip(a, b)).epsilon(1e-4));
}

TEST_CASE("errors are told apart in gray, too") {
    int last = -1;
    for (int i = 0; i <= 100; ++i) {
        const farfield::Rgba8 c = tint_of_error(float(i) / 100);
        const int gray = 2126 * c.r + 7152 * c.g + 722 * c.b;
        CHECK(gray >= last);
        last = gray;
    }
}

TEST_CASE("lines are seen where points are, and end before the eye") {
    const auto camera = farfield::Camera::perspective({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1);
    const glm::dvec2 size(400, 300);
    const auto line = project(camera, size, {0, 0, 0}, {1, 0.5, 0});
    REQUIRE(line);
    CHECK(line->from == glm::dvec2(200, 150));
    const double focal = 150 / double(camera.half_height);
    CHECK(line->to.x == Approx(200 + focal / 5));
    CHECK(line->to.y == Approx(150 - focal / 10));
    CHECK_FALSE(project(camera, size, {0, 0, 6}, {1, 0, 7}));
    CHECK_FALSE(project(camera, size, {0, 0, 6}, {0, 0, 6}));
    const auto cut = project(camera, size, {0, 0.1, 0}, {0, 0.1, 10});
    REQUIRE(cut);
    CHECK(std::isfinite(cut->to.x));
    CHECK(cut->to.y < 0);
    std::vector<Line> lines;
    add_lines(camera, size,
              farfield::scenes::CellOutline{.center = {0, 0, 0},
                                            .half = {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)}},
              lines);
    CHECK(lines.size() == 12);
}

TEST_CASE("choices are taken by name, and refused by name") {
    using Words = std::vector<std::string>;
    Look look;
    Stage stage;
    stage.variants.resize(2);
    stage.variants[0].name = "exact";
    stage.variants[1].name = "color-cube";
    const auto set = [&](const Words& words) { choose(look, &stage, words); };
    set({"variant", "color-cube"});
    CHECK(look.variant == 1);
    set({"renderer", "coverage"});
    CHECK(look.renderer == farfield::scenes::RendererKind::coverage);
    set({"samples", "16"});
    CHECK(look.samples == 16);
    set({"tolerance", "2.5"});
    CHECK(look.tolerance_px == 2.5f);
    set({"error", "0.1"});
    CHECK((look.wanted == Wanted::value && look.wanted_rmse == 0.1f));
    set({"error", "any"});
    CHECK(look.wanted == Wanted::any);
    set({"budget", "20"});
    CHECK((look.has_budget && look.budget_ms == 20));
    set({"budget", "none"});
    CHECK_FALSE(look.has_budget);
    set({"difference", "absolute"});
    CHECK(look.difference == Difference::absolute);
    set({"dividers", "0.1", "0.2"});
    CHECK((look.exact_until == 0.1 && look.variant_until == 0.2));
    for (const Words& words : {Words{"variant", "x"}, Words{"renderer", ""}, Words{"samples", "0"}, Words{"samples"},
                               Words{"tolerance", "-1"}, Words{"tolerance", "2px"}, Words{"tolerance", "nan"},
                               Words{"dividers", "0.9", "0.1"}, Words{"color", "red"}, Words{"difference", "x"}}) {
        CHECK_THROWS_AS(set(words), std::runtime_error);
    }
    CHECK_THROWS_AS(choose(look, nullptr, Words{"variant", "exact"}), std::runtime_error);
}

namespace {

struct Recorder final : ScriptHost {
    std::vector<Event> events{};
    std::vector<std::string> done{};
    int frames_to_settle = 0;

    bool is_settled() const override { return frames_to_settle == 0; }
    bool is_playing() const override { return false; }
    void send(const Event& event) override { events.push_back(event); }
    void set(std::span<const std::string> words) override { done.push_back("set " + words[0]); }
    void take_screenshot(const std::filesystem::path& file) override { done.push_back(file.string()); }
    void begin_recording(const std::filesystem::path& file) override { done.push_back("record " + file.string()); }
    void end_recording() override { done.push_back("stop"); }
    void play(const std::filesystem::path& file) override { done.push_back("play " + file.string()); }
    void quit() override { done.push_back("quit"); }
};

}  // namespace

TEST_CASE("a script does what it says, one thing after another") {
    const TemporaryDirectory directory;
    const auto file = directory.write("script",
                                      "# a comment\n\nset tolerance 2\nwait\nkey ctrl+S\nhold W 0.1\n"
                                      "drag shift+left 10 20 30 40 # to there\nclick 5 6\nwheel -2 7 8\n"
                                      "screenshot a.png\nrecord p.json\nstop\nplay p.json\nquit\n");
    ScriptPlayer player(read_script(file));
    Recorder host;
    host.frames_to_settle = 5;
    int frames = 0;
    while (!player.is_over() && frames < 1000) {
        player.step(host);
        if (host.frames_to_settle > 0 && --host.frames_to_settle > 0) CHECK(host.events.empty());
        ++frames;
    }
    for (int i = 0; i < 20; ++i) player.step(host);
    CHECK(frames < 200);
    CHECK(host.done ==
          std::vector<std::string>{"set tolerance", "a.png", "record p.json", "stop", "play p.json", "quit"});
    REQUIRE(host.events.size() == 4 + 11 + 3 + 1);
    CHECK((host.events[0].key == key_of('S') && host.events[0].control));
    CHECK((host.events[2].key == key_of('W') && host.events[3].kind == Event::Kind::key_up));
    CHECK((host.events[5].kind == Event::Kind::button_down && host.events[5].shift));
    CHECK(host.events[14].at == glm::dvec2(30, 40));
    CHECK(host.events.back().steps == -2);
}

TEST_CASE("a script that makes no sense is refused with its line") {
    const TemporaryDirectory directory;
    using Catch::Matchers::Contains;
    CHECK_THROWS_WITH(read_script(directory / "none"), Contains("none"));
    CHECK_THROWS_WITH(read_script(directory.write("a", "wait\njump 3\n")), Contains("line 2") && Contains("jump 3"));
    CHECK_THROWS_WITH(read_script(directory.write("b", "drag left 3\n")), Contains("line 1"));
    ScriptPlayer player(read_script(directory.write("c", "\nkey Ctrl+S\n")));
    Recorder host;
    CHECK_THROWS_WITH(player.step(host), Contains("line 2") && Contains("Ctrl"));
}

TEST_CASE("a cell is outside only where no point of it is in the picture") {
    farfield::test::Random random(9);
    farfield::View view;
    view.camera = farfield::Camera::perspective({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1);
    view.width = 200;
    view.height = 100;
    int outside = 0, inside = 0;
    for (int i = 0; i < 2000; ++i) {
        farfield::scenes::CellOutline cell;
        cell.center = glm::dvec3(random.in_cube(12));
        const double half = double(random.between(0.1f, 2));
        cell.half = {glm::dvec3(half, 0, 0), glm::dvec3(0, half, 0), glm::dvec3(0, 0, half)};
        const bool is_outside = farfield::scenes::is_outside(view, cell);
        outside += is_outside;
        bool is_seen = false;
        for (int k = 0; k < 100 && !is_seen; ++k) {
            const glm::dvec3 p = cell.center + half * glm::dvec3(random.in_cube(1));
            const double depth = 5 - p.z, up = depth * double(view.camera.half_height);
            is_seen = depth > 0 && std::abs(p.x) < 2 * up && std::abs(p.y) < up;
        }
        inside += is_seen;
        CHECK_FALSE((is_outside && is_seen));
    }
    CHECK(outside > 200);
    CHECK(inside > 200);
}

TEST_CASE("what was culled has other colors than what was drawn") {
    farfield::scenes::CellOutline cell;
    const auto drawn = tint_of(cell);
    cell.is_hidden = true;
    const auto hidden = tint_of(cell);
    cell.is_hidden = false;
    cell.is_outside = true;
    const auto outside = tint_of(cell);
    CHECK((drawn != hidden && drawn != outside && hidden != outside));
}
