// A context for tests, and what must hold after each.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/image.hpp"
#include "farfield/renderer.hpp"
#include "farfield/view/local_view.hpp"
#include "opengl/context.hpp"
#include "opengl/gl_renderer.hpp"
#include "opengl/objects.hpp"

namespace farfield::test {

/// Where there is no OpenGL 4.5 the test says so and ends.
struct OpenGl {
    std::optional<opengl::HeadlessContext> context;
    std::optional<opengl::ErrorLog> errors;

    OpenGl() {
        try {
            context.emplace(opengl::HeadlessOptions{.debug = true});
            errors.emplace();
        } catch (const std::runtime_error& e) {
            WARN("not tested: " << e.what());
        }
    }
    explicit operator bool() const { return context.has_value(); }
    /// Call it when all that a test made is gone.
    void check_clean() const {
        for (const std::string& message : errors->messages()) CHECK(message == "");
        CHECK(errors->count() == 0);
        CHECK(glGetError() == GLenum(GL_NO_ERROR));
        const auto live = opengl::live_objects();
        CHECK(std::accumulate(live.begin(), live.end(), std::size_t(0)) == 0);
    }
};

/// What is drawn without a hierarchy: draw(renderer) between the beginning and the end of a frame.
template <class R, class Draw>
const Image& picture_of(R& renderer, const LocalView& view, Draw&& draw) {
    renderer.begin_frame(view);
    renderer.set_view(view);
    draw(renderer);
    renderer.end_frame();
    return renderer.image();
}

inline double mean_difference(const Image& a, const Image& b) {
    REQUIRE(a.pixels().size() == b.pixels().size());
    double sum = 0;
    for (std::size_t i = 0; i < a.pixels().size(); ++i) {
        const Rgba8 p = a.pixels()[i], q = b.pixels()[i];
        sum += std::abs(p.r - q.r) + std::abs(p.g - q.g) + std::abs(p.b - q.b) + std::abs(p.a - q.a);
    }
    return sum / (4 * 255.0 * double(a.pixels().size()));
}

}  // namespace farfield::test
