#include "farfield/camera_from_matrices.hpp"

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "farfield/raster/sample_projection.hpp"
#include "farfield/view/local_view.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Shifts and scales clip coordinates: of a tile, an eye, a jittered frame.
glm::dmat4 clip_moved(glm::dvec2 by, glm::dvec2 scale = glm::dvec2(1)) {
    return glm::translate(glm::dmat4(1), glm::dvec3(by, 0)) * glm::scale(glm::dmat4(1), glm::dvec3(scale, 1));
}
/// z from 1 to 0 instead of from 0 to 1.
const glm::dmat4 reversed =
    glm::translate(glm::dmat4(1), {0.0, 0.0, 1.0}) * glm::scale(glm::dmat4(1), {1.0, 1.0, -1.0});

struct Engine {
    const char* name;
    glm::dmat4 projection;
    ClipDepth depth;
    bool looks_along_plus_z = false;
    bool has_far_plane = true;
};

std::vector<Engine> engines() {
    const double fov = 0.9, aspect = 1.5, first = 0.5, last = 90;
    const auto zo = ClipDepth::zero_to_one, no = ClipDepth::minus_one_to_one;
    glm::dmat4 endless = glm::infinitePerspectiveRH(fov, aspect, first);
    glm::dmat4 endless_reversed(0);
    endless_reversed[0][0] = endless[0][0];
    endless_reversed[1][1] = endless[1][1];
    endless_reversed[2][3] = -1;
    endless_reversed[3][2] = first;
    return {{"right-handed, -1 to 1", glm::perspectiveRH_NO(fov, aspect, first, last), no},
            {"right-handed, 0 to 1", glm::perspectiveRH_ZO(fov, aspect, first, last), zo},
            {"left-handed, -1 to 1", glm::perspectiveLH_NO(fov, aspect, first, last), no, true},
            {"left-handed, 0 to 1", glm::perspectiveLH_ZO(fov, aspect, first, last), zo, true},
            {"reversed", reversed * glm::perspectiveRH_ZO(fov, aspect, first, last), zo},
            {"reversed, left-handed", reversed * glm::perspectiveLH_ZO(fov, aspect, first, last), zo, true},
            {"endless", endless, no, false, false},
            {"endless, reversed", endless_reversed, zo, false, false},
            {"off center", glm::frustumRH_NO(-0.3, 0.5, -0.1, 0.4, first, last), no},
            {"an eye of two", clip_moved({0.13, 0}) * glm::perspectiveRH_ZO(fov, aspect, first, last), zo},
            {"jitter", clip_moved({0.37 / 320, -0.81 / 200}) * glm::perspectiveRH_ZO(fov, aspect, first, last), zo},
            {"a tile", clip_moved({-3, 5}, {4, 6}) * glm::perspectiveRH_NO(fov, aspect, first, last), no},
            {"upside down",
             glm::scale(glm::dmat4(1), {1.0, -1.0, 1.0}) * glm::perspectiveRH_ZO(fov, aspect, first, last), zo},
            {"parallel, -1 to 1", glm::orthoRH_NO(-3.0, 4.0, -2.0, 5.0, first, last), no},
            {"parallel, 0 to 1", glm::orthoRH_ZO(-3.0, 4.0, -2.0, 5.0, first, last), zo},
            {"parallel, left-handed", glm::orthoLH_ZO(-3.0, 4.0, -2.0, 5.0, first, last), zo, true},
            {"parallel, reversed", reversed * glm::orthoRH_ZO(-3.0, 4.0, -2.0, 5.0, first, last), zo},
            {"parallel, from within", glm::orthoRH_NO(-3.0, 4.0, -2.0, 5.0, -last, last), no}};
}

/// Pixels from the upper left corner.
glm::dvec2 by_matrices(const glm::dmat4& view, const glm::dmat4& projection, glm::dvec3 p, const View& v) {
    const glm::dvec4 clip = projection * (view * glm::dvec4(p, 1));
    return {(clip.x / clip.w + 1) / 2 * v.width, (1 - clip.y / clip.w) / 2 * v.height};
}
glm::dvec2 by_camera(const LocalView& local, glm::dvec3 origin, glm::dvec3 p) {
    const detail::SampleProjection to(local, 1);
    const glm::vec3 w = to.project(glm::vec3(p - origin));
    const float inverse = to.inverse_w(w.z);
    return {double(w.x * inverse + to.offset_x) / 256 - to.first_x,
            double(w.y * inverse + to.offset_y) / 256 - to.first_y};
}
bool is_inside(const LocalView& local, glm::dvec3 p) {
    for (const glm::vec4& plane : local.planes) {
        if (glm::dot(glm::vec3(plane), glm::vec3(p)) + plane.w < 0) return false;
    }
    return true;
}

std::string refusal(const glm::dmat4& view, const glm::dmat4& projection) {
    try {
        Camera::from_matrices(view, projection);
        return "taken";
    } catch (const std::invalid_argument& e) {
        return e.what();
    }
}

}  // namespace

TEST_CASE("a camera shows points where an engine's matrices show them, and cuts what they cut") {
    Random random(160);
    for (const Engine& engine : engines()) {
        for (int i = 0; i < 60; ++i) {
            const bool is_single = i % 3 == 1;
            INFO(engine.name << ", " << i);
            const glm::dvec3 origin = i % 3 == 2 ? glm::dvec3(4e6, -3e5, 5e6) : glm::dvec3(0);
            const glm::dvec3 eye = origin + glm::dvec3(random.in_cube(4)),
                             target = eye + glm::dvec3(random.direction());
            const glm::dvec3 up(random.direction());
            glm::dmat4 view =
                engine.looks_along_plus_z ? glm::lookAtLH(eye, target, up) : glm::lookAtRH(eye, target, up);
            // The unit of length of view space, in which near and far are given, need not be the world's.
            const double scale = i % 4 == 3 ? 2.5 : 1;
            view = glm::scale(glm::dmat4(1), glm::dvec3(scale)) * view;
            if (i % 5 == 4) view = glm::scale(glm::dmat4(1), {-1.0, 1.0, 1.0}) * view;  // a mirror
            const auto depth = i % 2 ? engine.depth : ClipDepth::either;
            View v;
            v.camera = is_single ? Camera::from_matrices(glm::mat4(view), glm::mat4(engine.projection), depth)
                                 : Camera::from_matrices(view, engine.projection, depth);
            v.width = 320;
            v.height = 200;
            REQUIRE_NOTHROW(v.check());
            const bool is_mirrored =
                (engine.looks_along_plus_z != (i % 5 == 4)) != (std::string(engine.name) == "upside down");
            CHECK(v.camera.is_mirrored() == is_mirrored);
            const LocalView local(v, origin, 20.0f);
            int seen = 0;
            for (int k = 0; k < 200; ++k) {
                const glm::dvec3 p = eye + glm::dvec3(random.in_cube(30));
                const glm::dvec4 clip = engine.projection * (view * glm::dvec4(p, 1));
                if (!(clip.w > 0.01)) continue;
                const glm::dvec3 ndc = glm::dvec3(clip) / clip.w;
                const double nearest = engine.depth == ClipDepth::zero_to_one ? 0 : -1;
                const double margin = is_single ? 1e-3 : 1e-4;
                const double inside = std::min({1 - std::abs(ndc.x), 1 - std::abs(ndc.y)});
                const double between = std::min(ndc.z - nearest, 1 - ndc.z);
                const glm::dvec2 expected = by_matrices(view, engine.projection, p, v);
                if (inside > -2) {
                    const double limit = (is_single ? 0.02 : 0.004) + (origin.x != 0 ? 0.02 : 0);
                    CHECK(glm::length(by_camera(local, origin, p) - expected) < limit);
                }
                // What they show is inside. What `either` lets in is between two readings of the near plane.
                if (inside > margin && between > 1e-4) {
                    CHECK(is_inside(local, p - origin));
                    ++seen;
                }
                if (inside < -margin || (depth != ClipDepth::either && between < -1e-4)) {
                    CHECK_FALSE(is_inside(local, p - origin));
                }
            }
            CHECK(std::isfinite(v.camera.far_depth) == engine.has_far_plane);
            if (std::string(engine.name) == "right-handed, -1 to 1") CHECK(seen > 0);
        }
    }
}

TEST_CASE("near and far come in the world's units") {
    const glm::dmat4 view = glm::scale(glm::dmat4(1), glm::dvec3(4.0)) *
                            glm::lookAt(glm::dvec3(1, 2, 3), glm::dvec3(0), glm::dvec3(0, 1, 0));
    for (const auto& [projection, depth] :
         {std::pair(glm::perspectiveRH_NO(1.0, 1.5, 2.0, 80.0), ClipDepth::either),
          std::pair(glm::perspectiveRH_ZO(1.0, 1.5, 2.0, 80.0), ClipDepth::zero_to_one),
          std::pair(reversed * glm::perspectiveRH_ZO(1.0, 1.5, 2.0, 80.0), ClipDepth::either),
          std::pair(glm::orthoRH_ZO(-1.0, 1.0, -1.0, 1.0, 2.0, 80.0), ClipDepth::zero_to_one)}) {
        const Camera c = Camera::from_matrices(view, projection, depth);
        CHECK(c.near_depth == Approx(0.5));
        CHECK(c.far_depth == Approx(20));
        CHECK(glm::length(c.eye - glm::dvec3(1, 2, 3)) < 1e-9);
    }
    // Direct3D's near plane read as OpenGL's lies nearer: nothing is cut that either of them would show.
    const Camera c = Camera::from_matrices(view, glm::perspectiveRH_ZO(1.0, 1.5, 2.0, 80.0));
    CHECK(c.near_depth < 0.5f);
    CHECK(c.near_depth > 0.2f);
    CHECK(c.far_depth == Approx(20));
}

TEST_CASE("matrices that are no camera are refused by name") {
    const glm::dmat4 view = glm::lookAt(glm::dvec3(1, 2, 3), glm::dvec3(0), glm::dvec3(0, 1, 0));
    const glm::dmat4 projection = glm::perspective(1.0, 1.5, 0.1, 100.0);
    const std::string who = "farfield::Camera::from_matrices: ";
    CHECK(refusal(view, projection) == "taken");
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        for (int column = 0; column < 4; ++column) {
            for (int row = 0; row < 4; ++row) {
                glm::dmat4 m = view;
                m[column][row] = bad;
                CHECK(refusal(m, projection) == who + "the view matrix must be finite");
                m = projection;
                m[column][row] = bad;
                CHECK(refusal(view, m) == who + "the projection matrix must be finite");
            }
        }
    }
    CHECK(refusal(glm::dmat4(0), projection) == who + "the last row of the view matrix must be 0, 0, 0, 1");
    CHECK(refusal(glm::scale(glm::dmat4(1), {1.0, 1.0, 0.0}), projection) == who + "the view matrix is singular");
    CHECK(refusal(view, glm::dmat4(0)) == who + "the projection matrix is singular");
    CHECK(refusal(view, glm::scale(glm::dmat4(1), {1.0, 0.0, 1.0}) * projection) ==
          who + "the projection matrix is singular");
    glm::dmat4 skew(1);
    skew[0][1] = 0.1;
    CHECK(refusal(view, skew * projection) == who + "together the matrices skew the picture");
    CHECK(refusal(glm::scale(view, {2.0, 1.0, 1.0}), projection) == who + "together the matrices skew the picture");
    glm::dmat4 oblique = projection;  // Lengyel's near plane, of a mirror
    oblique[0][2] = 0.3;
    CHECK(refusal(view, oblique) == who + "an oblique near plane cannot be had");
    CHECK(refusal(view, glm::perspective(1.0, 1.5, -0.1, -100.0)) ==
          who + "no depth in front of the eye is between the near plane and the far one");
}
