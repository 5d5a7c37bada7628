#include "farfield/view/view_matrix.hpp"

#include "catch.hpp"
#include "farfield/view/local_view.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;

TEST_CASE("a view's matrix takes points where the camera sees them, in instances too and from very far") {
    Random random(4);
    for (int i = 0; i < 200; ++i) {
        View view;
        const glm::dvec3 away = glm::dvec3(random.in_cube(1)) * (i % 3 == 0 ? 1e5 : 3.0), target(random.in_cube(1));
        view.camera = Camera::perspective(target + away, target, {0, 1, 0}, 0.8f);
        const glm::dvec3 origin(random.in_cube(5)), inner_origin(random.in_cube(5));
        const LocalView outermost(view, origin, 4, glm::vec3(target - origin));
        const Similarity placed(glm::mat3(1), random.between(0.3f, 3), glm::dvec3(random.in_cube(2)));
        const LocalView inside = outermost.inside(placed, origin, inner_origin);
        const glm::vec3 p = random.in_cube(2);  // the instance's coordinates
        const glm::dvec3 world = placed.apply(glm::dvec3(p) + inner_origin), from_eye = world - view.camera.eye;
        const Camera& camera = view.camera;
        const glm::dvec3 wanted(glm::dot(from_eye, glm::dvec3(camera.right)), glm::dot(from_eye, glm::dvec3(camera.up)),
                                -glm::dot(from_eye, glm::dvec3(camera.forward)));
        const glm::dvec3 got(view_matrix(inside) * glm::dvec4(p, 1)),
            outer(view_matrix(outermost) * glm::dvec4(world - origin, 1));
        // Single precision of the coordinates and, far away, of the axes and the depth.
        const double allowed = 1e-6 * (20 + glm::length(away));
        CHECK(glm::length(got - wanted) < allowed);
        CHECK(glm::length(outer - wanted) < allowed);
    }
}
