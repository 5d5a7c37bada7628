// A program of somebody else, built against farfield as its users build it.
#include <cstdio>

#include "farfield/geometry/triangle.hpp"

int main() {
    const farfield::Triangle triangle{{glm::vec3(0, 0, 0), glm::vec3(2, 0, 0), glm::vec3(0, 2, 0)}, {}};
    const farfield::Box box = triangle.bounds();
    std::printf("area %g, upper corner (%g, %g, %g)\n", double(triangle.area()), double(box.upper.x),
                double(box.upper.y), double(box.upper.z));
    return triangle.area() == 2.0f && box.upper == glm::vec3(2, 2, 0) ? 0 : 1;
}
