#include <vector>

#include "farfield/farfield.hpp"

int main() {
    using namespace farfield;
    const std::vector<Triangle> triangles{{{glm::vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {200, 100, 50}}};
    const auto hierarchy = build<SpatialHierarchy<Octree, OpacityTensor, TriangleCount>>(triangles);
    return hierarchy.primitive_count() == 1 ? 0 : 1;
}
