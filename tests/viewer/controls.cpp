#include "controls.hpp"

#include <glm/geometric.hpp>

#include "catch.hpp"

using namespace viewer;

namespace {

struct Desk {
    Look look{};
    Navigator navigator{{{-1, -1, -1}, {1, 1, 1}}, {0, 1, 0}};
    Controls controls{look, navigator};

    Desk() { controls.set_size({800, 600}); }

    std::optional<Request> key(char c, bool control = false) {
        const auto request = controls.handle({.kind = Event::Kind::key_down, .key = key_of(c), .control = control});
        controls.handle({.kind = Event::Kind::key_up, .key = key_of(c)});
        return request;
    }
    std::optional<Request> drag(glm::dvec2 from, glm::dvec2 to, Button button = Button::left, bool shift = false) {
        controls.handle({.kind = Event::Kind::button_down, .shift = shift, .button = button, .at = from});
        controls.handle({.kind = Event::Kind::move, .at = 0.5 * (from + to)});
        controls.handle({.kind = Event::Kind::move, .at = to});
        return controls.handle({.kind = Event::Kind::button_up, .button = button, .at = to});
    }
    bool has_moved() const {
        const Navigator still{{{-1, -1, -1}, {1, 1, 1}}, {0, 1, 0}};
        return glm::length(still.eye() - navigator.eye()) > 1e-9 ||
               glm::length(still.target() - navigator.target()) > 1e-9;
    }
};

}  // namespace

TEST_CASE("a left drag orbits by as much as the navigator is told") {
    Desk desk;
    Navigator other = desk.navigator;
    CHECK_FALSE(desk.drag({400, 300}, {500, 240}));
    other.orbit({100.0 / 600, 60.0 / 600});
    CHECK(glm::length(desk.navigator.eye() - other.eye()) < 1e-12);
}

TEST_CASE("right drags and drags with shift pan, those in fly mode turn the head") {
    for (const bool with_shift : {false, true}) {
        Desk desk;
        const glm::dvec3 forward = desk.navigator.forward(), target = desk.navigator.target();
        desk.drag({400, 300}, {500, 240}, with_shift ? Button::left : Button::right, with_shift);
        CHECK(glm::length(desk.navigator.forward() - forward) < 1e-12);
        CHECK(glm::length(desk.navigator.target() - target) > 0.1);
    }
    Desk desk;
    desk.key('G');
    const glm::dvec3 eye = desk.navigator.eye();
    desk.drag({400, 300}, {500, 240});
    CHECK(glm::length(desk.navigator.eye() - eye) < 1e-12);
    CHECK(desk.has_moved());
}

TEST_CASE("a click picks and moves nothing, though the hand trembles") {
    Desk desk;
    const auto request = desk.drag({400, 300}, {402, 301});
    REQUIRE(request);
    CHECK(request->kind == Request::Kind::pick);
    CHECK(request->at == glm::dvec2(402, 301));
    CHECK_FALSE(desk.has_moved());
    CHECK_FALSE(desk.drag({400, 300}, {400, 300}, Button::right));
}

TEST_CASE("the wheel asks how deep the cursor is") {
    Desk desk;
    glm::dvec2 asked(0);
    desk.controls.depth_at = [&](glm::dvec2 at) {
        asked = at;
        return 2.0;
    };
    Navigator other = desk.navigator;
    desk.controls.handle({.kind = Event::Kind::wheel, .at = {600, 150}, .steps = 2});
    CHECK(asked == glm::dvec2(600, 150));
    other.zoom(2, {200.0 / 600, 150.0 / 600}, 2);
    CHECK(glm::length(desk.navigator.eye() - other.eye()) < 1e-12);
}

TEST_CASE("keys that are held walk, and stop when they are let go") {
    Desk desk;
    desk.controls.handle({.kind = Event::Kind::key_down, .key = key_of('W')});
    CHECK(desk.controls.is_moving());
    const double before = glm::length(desk.navigator.eye());
    desk.controls.advance(0.1);
    CHECK(glm::length(desk.navigator.eye()) < before);
    desk.controls.handle({.kind = Event::Kind::key_up, .key = key_of('W')});
    CHECK_FALSE(desk.controls.is_moving());
    const glm::dvec3 there = desk.navigator.eye();
    desk.controls.advance(1);
    CHECK(desk.navigator.eye() == there);
}

TEST_CASE("keys switch what is shown, and switch it back") {
    Desk desk;
    const auto toggles = [&](char c, const bool& shown) {
        const bool before = shown;
        CHECK_FALSE(desk.key(c));
        CHECK(shown != before);
        CHECK_FALSE(desk.key(c));
        CHECK(shown == before);
    };
    toggles(' ', desk.look.shows_exact);
    toggles('H', desk.look.hides_panels);
    toggles('C', desk.look.compares);
    toggles('L', desk.look.tints_levels);
    toggles('O', desk.look.outlines_cells);
    toggles('G', desk.look.flies);
    desk.key('Z');
    CHECK(desk.look.frozen);
    desk.key('Z');
    CHECK_FALSE(desk.look.frozen);
    desk.key('[');
    CHECK(desk.look.tolerance_px == 2.0f);
    desk.key(']');
    CHECK(desk.look.tolerance_px == 4.0f);
    CHECK(desk.controls.handle({.kind = Event::Kind::key_down, .key = Key::escape})->kind == Request::Kind::quit);
    CHECK(desk.key('S', true)->kind == Request::Kind::screenshot);
    CHECK_FALSE(desk.controls.is_moving());  // ctrl+S does not walk
    CHECK(desk.controls.handle({.kind = Event::Kind::drop, .file = "a.ply"})->file == "a.ply");
}

TEST_CASE("dividers are dragged, and do not pass one another") {
    Desk desk;
    desk.look.exact_until = 0.25;
    desk.look.variant_until = 0.75;
    CHECK(desk.controls.divider_at({200, 100}) == -1);  // there are none
    desk.look.compares = true;
    CHECK(desk.controls.divider_at({203, 100}) == 0);
    CHECK(desk.controls.divider_at({598, 500}) == 1);
    CHECK(desk.controls.divider_at({400, 500}) == -1);
    desk.drag({201, 100}, {320, 100});
    CHECK(desk.look.exact_until == Approx(0.4));
    desk.drag({320, 100}, {799, 100});
    CHECK(desk.look.exact_until == Approx(0.75));
    CHECK_FALSE(desk.has_moved());
}
