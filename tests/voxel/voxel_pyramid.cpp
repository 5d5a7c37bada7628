#include "farfield/voxel/voxel_pyramid.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

using Planes = std::vector<VoxelPlane>;

glm::vec3 random_point(Random& random, glm::vec3 size) {
    const float x = random.between(-0.2f, 1.2f), y = random.between(-0.2f, 1.2f), z = random.between(-0.2f, 1.2f);
    return glm::vec3(x, y, z) * size;
}

/// In 1/256 voxel.
glm::ivec3 snapped_point(glm::vec3 p) {
    return glm::ivec3(glm::floor(p * 256.0f + 0.5f));
}

Planes box(glm::vec3 lower, glm::vec3 upper) {
    Planes planes;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec4 plane(0);
        plane[axis] = 1;
        plane.w = -double(lower[axis]);
        planes.push_back(VoxelPlane::snapped(plane));
        plane.w = -double(upper[axis]);
        planes.push_back(VoxelPlane::snapped(-plane));
    }
    return planes;
}

/// Corners in 1/256 voxel, in any order; without volume if they are in one plane.
Planes tetrahedron(std::array<glm::ivec3, 4> p) {
    const glm::dvec3 u(p[1] - p[0]), v(p[2] - p[0]), w(p[3] - p[0]);
    const double volume = glm::dot(glm::cross(u, v), w);
    if (volume == 0) return {{-1, 0, 0, 0}};
    // Seen from outside, face 0 1 2 is counter-clockwise if 3 is behind it.
    if (volume > 0) std::swap(p[0], p[1]);
    return {VoxelPlane::through(p[0], p[1], p[2]), VoxelPlane::through(p[0], p[3], p[1]),
            VoxelPlane::through(p[1], p[3], p[2]), VoxelPlane::through(p[2], p[3], p[0])};
}

/// Planes that touch a ball or lie a bit outside of it.
Planes faceted_ball(Random& random, glm::vec3 center, float radius, int faces) {
    Planes planes;
    for (int i = 0; i < faces; ++i) {
        const glm::vec3 out = random.direction();
        const float distance = radius * random.between(1, 1.1f);
        planes.push_back(VoxelPlane::snapped(glm::dvec4(-out, glm::dot(out, center) + distance)));
    }
    return planes;
}

Planes random_polyhedron(Random& random, glm::vec3 size) {
    const glm::vec3 a = random_point(random, size), b = random_point(random, size);
    switch (random.below(4)) {
        case 0:
            return box(glm::min(a, b), glm::max(a, b));
        case 1: {
            const glm::vec3 c = random_point(random, size), d = random_point(random, size);
            return tetrahedron({snapped_point(a), snapped_point(b), snapped_point(c), snapped_point(d)});
        }
        case 2: {
            const float radius = random.between(0.05f, 0.6f) * size.x;
            return faceted_ball(random, a, radius, 5 + int(random.below(60)));
        }
        default: {  // a slab, or a wedge: not bounded
            const glm::vec3 n = random.direction(), m = random.direction();
            return {VoxelPlane::snapped(glm::dvec4(n, -glm::dot(n, a))),
                    VoxelPlane::snapped(glm::dvec4(m, -glm::dot(m, b)))};
        }
    }
}

bool contains(const Planes& planes, glm::ivec3 voxel) {
    for (const VoxelPlane& p : planes) {
        if (!p.contains(voxel)) return false;
    }
    return true;
}

/// Every voxel by itself.
class BruteForce {
  public:
    explicit BruteForce(glm::ivec3 size)
        : size_(size), owner_(std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z), 0) {}

    void tile(const Planes& planes, int owner) {
        for_each([&](glm::ivec3 v) {
            if (at(v) == 0 && contains(planes, v)) at(v) = owner;
        });
    }
    template <class F>
    void for_each(F&& f) const {
        for (int z = 0; z < size_.z; ++z) {
            for (int y = 0; y < size_.y; ++y) {
                for (int x = 0; x < size_.x; ++x) f(glm::ivec3(x, y, z));
            }
        }
    }
    int& at(glm::ivec3 v) {
        return owner_[(std::size_t(v.z) * std::size_t(size_.y) + std::size_t(v.y)) * std::size_t(size_.x) +
                      std::size_t(v.x)];
    }
    bool is_inside(glm::ivec3 v) const {
        return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < size_.x && v.y < size_.y && v.z < size_.z;
    }
    const std::vector<int>& owners() const { return owner_; }

  private:
    glm::ivec3 size_;
    std::vector<int> owner_;
};

/// Whoever is given a voxel, and what should not happen while giving.
class Painted {
  public:
    explicit Painted(glm::ivec3 size) : grid(size) {}

    void tile(VoxelPyramid& pyramid, const Planes& planes, int owner) {
        pyramid.tile(std::span<const VoxelPlane>(planes), [&](const VoxelCubes& cubes) { paint(cubes, owner); });
    }
    void paint(const VoxelCubes& cubes, int owner) {
        // A power of 4, and aligned to it.
        misplaced += cubes.mask == 0 || !std::has_single_bit(unsigned(cubes.side)) ||
                     std::countr_zero(unsigned(cubes.side)) % 2 != 0 || cubes.first % (4 * cubes.side) != glm::ivec3(0);
        std::int64_t voxels = 0;
        cubes.for_each([&](glm::ivec3 first) {
            for (int z = 0; z < cubes.side; ++z) {
                for (int y = 0; y < cubes.side; ++y) {
                    for (int x = 0; x < cubes.side; ++x, ++voxels) {
                        const glm::ivec3 v = first + glm::ivec3(x, y, z);
                        if (!grid.is_inside(v)) {
                            ++misplaced;
                        } else {
                            written_twice += grid.at(v) != 0;
                            grid.at(v) = owner;
                        }
                    }
                }
            }
        });
        misplaced += voxels != cubes.voxels();
    }

    BruteForce grid;
    int misplaced = 0, written_twice = 0;
};

int wrongly_occupied(const VoxelPyramid& pyramid, BruteForce& expected) {
    int wrong = 0;
    expected.for_each([&](glm::ivec3 v) { wrong += pyramid.occupied(v) != (expected.at(v) != 0); });
    return wrong;
}

Planes ball_of_100_faces(int n) {
    Random random(7);
    return faceted_ball(random, glm::vec3(float(n) * 0.5f), float(n) * 0.4f, 100);
}

}  // namespace

TEST_CASE("Voxel masks: both ways give the same signs") {
    Random random(1);
    int wrong = 0;
    for (int n = 0; n < 20000; ++n) {
        const int shift = int(random.below(60));
        std::int64_t v[4];
        for (std::int64_t& x : v) x = std::int64_t(random.bits()) >> (4 + shift);
        v[0] = n % 3 == 0 ? -v[1] - 2 * v[2] + std::int64_t(random.below(3)) - 1 : v[0];
        std::uint64_t expected = 0;
        for (int bit = 0; bit < 64; ++bit) {
            expected |= std::uint64_t(v[0] + v[1] * (bit & 3) + v[2] * (bit >> 2 & 3) + v[3] * (bit >> 4) < 0) << bit;
        }
        wrong += negative_voxels(v[0], v[1], v[2], v[3]) != expected;
        wrong += negative_voxels_scalar(v[0], v[1], v[2], v[3]) != expected;
    }
    CHECK(wrong == 0);
    int wrong_corners = 0;
    for (int z = -1; z < 6; ++z) {
        for (int y = -1; y < 6; ++y) {
            for (int x = -1; x < 6; ++x) {
                std::uint64_t expected = 0;
                for (int bit = 0; bit < 64; ++bit) {
                    expected |= std::uint64_t((bit & 3) < x && (bit >> 2 & 3) < y && bit >> 4 < z) << bit;
                }
                wrong_corners += voxel_corner({x, y, z}) != expected;
            }
        }
    }
    CHECK(wrong_corners == 0);
}

TEST_CASE("Voxel pyramid: random polyhedra, front to back, in grids of any size") {
    Random random(2);
    const glm::ivec3 sizes[] = {{64, 64, 64}, {16, 16, 16}, {4, 4, 4},  {1, 1, 1},    {3, 5, 2},   {17, 16, 15},
                                {65, 63, 3},  {1, 100, 1},  {7, 1, 70}, {40, 20, 30}, {5, 33, 65}, {16, 4, 64}};
    for (const glm::ivec3 size : sizes) {
        VoxelPyramid pyramid(size);
        for (int scene = 0; scene < 6; ++scene) {
            // Cleared, not made anew.
            pyramid.clear();
            Painted painted(size);
            BruteForce expected(size);
            for (int n = 1; n <= 8; ++n) {
                const Planes planes = random_polyhedron(random, glm::vec3(size));
                painted.tile(pyramid, planes, n);
                expected.tile(planes, n);
            }
            CAPTURE(size.x, size.y, size.z, scene);
            CHECK(painted.misplaced == 0);
            CHECK(painted.written_twice == 0);
            CHECK(painted.grid.owners() == expected.owners());
            CHECK(wrongly_occupied(pyramid, expected) == 0);

            // Whatever is left, to the last voxel; then nothing.
            painted.tile(pyramid, {}, 9);
            expected.tile({}, 9);
            CHECK(painted.written_twice == 0);
            CHECK(painted.grid.owners() == expected.owners());
            CHECK(wrongly_occupied(pyramid, expected) == 0);
            const std::uint64_t visited = pyramid.cells_visited();
            painted.tile(pyramid, random_polyhedron(random, glm::vec3(size)), 10);
            CHECK(painted.written_twice == 0);
            CHECK(pyramid.cells_visited() == visited + 1);
        }
    }
}

TEST_CASE("Voxel pyramid: polyhedra that adjoin share no voxel and leave none") {
    Random random(3);
    // Space parted again and again by planes, some of them through rows of centers.
    for (int scene = 0; scene < 20; ++scene) {
        std::vector<Planes> cells{{}};
        for (int cut = 0; cut < 40; ++cut) {
            const std::size_t parted = random.below(std::uint32_t(cells.size()));
            glm::dvec4 plane(random.direction(), random.between(-20, 20));
            if (cut % 2 == 0)
                plane = glm::dvec4(int(random.below(5)) - 2, int(random.below(5)) - 2, 1, -int(random.below(40)));
            if (cut % 4 == 0) plane = glm::dvec4(1, 0, 0, -double(random.below(64)) * 0.5);
            Planes rest = cells[parted];
            cells[parted].push_back(VoxelPlane::snapped(plane));
            rest.push_back(VoxelPlane::snapped(-plane));
            cells.push_back(rest);
        }
        const glm::ivec3 size(31, 32, 33);
        BruteForce counts(size);
        for (const Planes& cell : cells) {
            VoxelPyramid pyramid(size);
            pyramid.tile(std::span<const VoxelPlane>(cell), [&](const VoxelCubes& cubes) {
                cubes.for_each([&](glm::ivec3 first) {
                    for (int i = 0; i < cubes.side * cubes.side * cubes.side; ++i) {
                        ++counts.at(first + glm::ivec3(i % cubes.side, i / cubes.side % cubes.side,
                                                       i / cubes.side / cubes.side));
                    }
                });
            });
        }
        CHECK(counts.owners() == std::vector<int>(counts.owners().size(), 1));
    }
}

TEST_CASE("Voxel pyramid: tetrahedra with corners, edges and faces on centers of voxels") {
    Random random(4);
    for (int scene = 0; scene < 30; ++scene) {
        // A box of 12 x 12 x 12 voxels around a grid of 3 x 3 x 3 points that are moved by whole voxels or by a bit,
        // six tetrahedra a cell (Kuhn): the hull stays where it was, at halves.
        glm::ivec3 point[27];
        for (int i = 0; i < 27; ++i) {
            const glm::ivec3 place(i % 3, i / 3 % 3, i / 9);
            glm::ivec3 moved(0);
            for (int axis = 0; axis < 3; ++axis) {
                const int by = scene % 2 == 0 ? 256 * (int(random.below(3)) - 1) : int(random.below(400)) - 200;
                if (place[axis] == 1) moved[axis] = by;
            }
            point[i] = place * 1536 + 128 + moved;
        }
        const int axes[6][3] = {{1, 3, 9}, {1, 9, 3}, {3, 1, 9}, {3, 9, 1}, {9, 1, 3}, {9, 3, 1}};
        const glm::ivec3 size(14, 14, 14);
        VoxelPyramid pyramid(size);
        std::vector<Planes> all;
        for (int cell = 0; cell < 8; ++cell) {
            const int first = (cell & 1) + (cell >> 1 & 1) * 3 + (cell >> 2) * 9;
            for (const auto& [u, v, w] : axes) {
                all.push_back(
                    tetrahedron({point[first], point[first + u], point[first + u + v], point[first + u + v + w]}));
            }
        }
        BruteForce counts(size);
        for (const Planes& planes : all) {
            counts.for_each([&](glm::ivec3 v) { counts.at(v) += contains(planes, v); });
        }
        int gaps = 0, overlaps = 0;
        counts.for_each([&](glm::ivec3 v) {
            // The box is from center 0 to center 12: what moved a little towards +x, +y, +z is inside.
            const bool inside = v.x < 12 && v.y < 12 && v.z < 12;
            gaps += inside && counts.at(v) == 0;
            overlaps += counts.at(v) > int(inside);
        });
        CHECK(gaps == 0);
        CHECK(overlaps == 0);

        Painted painted(size);
        BruteForce expected(size);
        for (std::size_t i = 0; i < all.size(); ++i) {
            painted.tile(pyramid, all[i], int(i) + 1);
            expected.tile(all[i], int(i) + 1);
        }
        CHECK(painted.written_twice == 0);
        CHECK(painted.grid.owners() == expected.owners());
    }
}

TEST_CASE("Voxel pyramid: only cells that faces cross are visited") {
    std::uint64_t visited_before = 0;
    for (const int n : {64, 128, 256, 512}) {
        VoxelPyramid pyramid(glm::ivec3(n, n, n));
        std::int64_t voxels = 0;
        const Planes planes = ball_of_100_faces(n);
        pyramid.tile(std::span<const VoxelPlane>(planes), [&](const VoxelCubes& cubes) { voxels += cubes.voxels(); });
        const std::uint64_t visited = pyramid.cells_visited();
        // The ball has a volume of 0.27 n^3 to 0.36 n^3 and a surface of 2 n^2 to 2.4 n^2. A surface meets up to 3
        // blocks for each that its projections have, and blocks are 16 times fewer than voxels.
        CHECK(double(voxels) > 0.26 * n * n * n);
        CHECK(double(visited) < 0.3 * n * n);
        if (visited_before != 0) {
            CHECK(double(visited) / double(visited_before) > 3.6);
            CHECK(double(visited) / double(visited_before) < 4.2);
        }
        visited_before = visited;
    }
    // Cells of any size that have voxels inside and voxels outside have to be visited; hardly any others are, those
    // beside edges of the polyhedron, which no plane alone excludes.
    for (const int n : {64, 100}) {
        const Planes planes = ball_of_100_faces(n);
        BruteForce ball(glm::ivec3(n, n, n));
        ball.tile(planes, 1);
        std::uint64_t mixed = 0;
        for (int side = 4; side < 4 * n; side *= 4) {
            const int cells = (n + side - 1) / side;
            std::vector<int> inside(std::size_t(cells) * std::size_t(cells) * std::size_t(cells)), all = inside;
            ball.for_each([&](glm::ivec3 v) {
                const glm::ivec3 cell = v / side;
                const auto i = std::size_t((cell.z * cells + cell.y) * cells + cell.x);
                inside[i] += ball.at(v);
                ++all[i];
            });
            for (std::size_t i = 0; i < all.size(); ++i) mixed += inside[i] != 0 && inside[i] != all[i];
        }
        VoxelPyramid pyramid(glm::ivec3(n, n, n));
        pyramid.tile(std::span<const VoxelPlane>(planes), [](const VoxelCubes&) {});
        CAPTURE(n, mixed);
        CHECK(pyramid.cells_visited() >= mixed);
        CHECK(double(pyramid.cells_visited()) < 1.05 * double(mixed));
    }
    // Boxes between blocks cross none; a grid is one cube of cubes.
    VoxelPyramid pyramid(glm::ivec3(256, 256, 256));
    int calls = 0;
    std::int64_t voxels = 0;
    const auto count = [&](const VoxelCubes& cubes) {
        ++calls;
        voxels += cubes.voxels();
    };
    const Planes aligned = box({64, 0, 128}, {192, 256, 192});
    pyramid.tile(std::span<const VoxelPlane>(aligned), count);
    CHECK(pyramid.cells_visited() == 1);
    CHECK(calls == 1);
    CHECK(voxels == 128 * 256 * 64);
    pyramid.tile(std::span<const VoxelPlane>(), count);
    CHECK(pyramid.cells_visited() == 2);
    CHECK(voxels == 256 * 256 * 256);
}

TEST_CASE("Voxel pyramid: hidden polyhedra are not visited") {
    VoxelPyramid pyramid(glm::ivec3(256, 256, 256));
    std::int64_t voxels = 0;
    const auto count = [&](const VoxelCubes& cubes) { voxels += cubes.voxels(); };
    const Planes large = box({1, 1, 1}, {255, 255, 255}), small = ball_of_100_faces(200);
    pyramid.tile(std::span<const VoxelPlane>(large), count);
    CHECK(voxels == 254 * 254 * 254);
    const std::uint64_t visited = pyramid.cells_visited();
    pyramid.tile(std::span<const VoxelPlane>(small), count);
    CHECK(voxels == 254 * 254 * 254);
    // Subcells of the root that the box does not fill altogether, and below them the blocks that it leaves open.
    CHECK(pyramid.cells_visited() < visited + 60);
}

TEST_CASE("Voxel pyramid: nothing inside, nothing outside") {
    const glm::ivec3 size(50, 60, 70);
    const float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    VoxelPyramid pyramid(size);
    std::int64_t voxels = 0;
    const auto tiled = [&](const std::vector<glm::vec4>& planes) {
        voxels = 0;
        pyramid.clear();
        pyramid.tile(std::span<const glm::vec4>(planes), [&](const VoxelCubes& cubes) { voxels += cubes.voxels(); });
        return voxels;
    };
    const std::int64_t all = 50 * 60 * 70;
    CHECK(tiled({}) == all);
    CHECK(tiled({{0, 0, 0, 0}}) == all);
    CHECK(tiled({{0, 0, 0, -1}}) == 0);
    CHECK(tiled({{1, 0, 0, 1e30f}, {0, 1, 0, 1e30f}}) == all);
    CHECK(tiled({{1, 0, 0, -1e30f}}) == 0);
    CHECK(pyramid.cells_visited() == 1);
    CHECK(tiled({{1, 2, 3, nan}}) == 0);
    CHECK(tiled({{1, infinity, 3, 4}}) == 0);
    CHECK(tiled({{1, 1, 1, -30}, {-1, -1, -1, 29}}) == 0);    // they exclude each other
    CHECK(tiled({{1, 0, 0, -7.6f}, {-1, 0, 0, 8.4f}}) == 0);  // a slab between centers
    CHECK(tiled({{1, 0, 0, -7.5f}, {-1, 0, 0, 7.5f}}) == 0);  // a plane, though through centers
    CHECK(tiled({{1, 0, 0, -7.5f}, {-1, 0, 0, 8.5f}}) == 60 * 70);
    CHECK(tiled({{1, 0, 0, -49.25f}}) == 60 * 70);
    CHECK(tiled({{1, 0, 0, -50}}) == 0);
    CHECK(tiled({{-1, 0, 0, 1}, {0, -1, 0, 1}, {0, 0, -1, 1}}) == 1);
    CHECK(pyramid.occupied({0, 0, 0}));
    CHECK_FALSE(pyramid.occupied({1, 0, 0}));
    for (const glm::ivec3 beyond : {glm::ivec3(-1, 0, 0), glm::ivec3(0, 60, 0), glm::ivec3(50, 60, 70)}) {
        CHECK_FALSE(pyramid.occupied(beyond));
    }
    pyramid.clear();
    CHECK_FALSE(pyramid.occupied({0, 0, 0}));
    CHECK(pyramid.cells_visited() == 0);

    // Many times the same plane, and both sides of it.
    const std::vector<glm::vec4> twice(300, glm::vec4(0.3f, -0.2f, 0.9f, -20));
    const std::int64_t one = tiled({twice[0]});
    CHECK(tiled(twice) == one);
    CHECK(tiled({-twice[0]}) == all - one);
}

TEST_CASE("Voxel pyramid: grids without voxels, and grids that cannot be") {
    for (const glm::ivec3 size : {glm::ivec3(0, 0, 0), glm::ivec3(0, 5, 5), glm::ivec3(16, 16, 0)}) {
        VoxelPyramid pyramid(size);
        int calls = 0;
        pyramid.tile(std::span<const VoxelPlane>(), [&](const VoxelCubes&) { ++calls; });
        CHECK(calls == 0);
        CHECK_FALSE(pyramid.occupied({0, 0, 0}));
        CHECK(pyramid.bytes() == 0);
    }
    CHECK_THROWS_AS(VoxelPyramid(glm::ivec3(-1, 4, 4)), std::invalid_argument);
    CHECK_THROWS_AS(VoxelPyramid(glm::ivec3(4, 16385, 4)), std::invalid_argument);
    // The longest grid there is, to its last voxel.
    VoxelPyramid pyramid(glm::ivec3(1, 16384, 1));
    std::int64_t voxels = 0;
    const std::vector<glm::vec4> planes{{0, 1, 0, -16000.25f}};
    pyramid.tile(std::span<const glm::vec4>(planes), [&](const VoxelCubes& cubes) { voxels += cubes.voxels(); });
    CHECK(voxels == 384);
    CHECK(pyramid.occupied({0, 16383, 0}));
    CHECK_FALSE(pyramid.occupied({0, 15999, 0}));
}

TEST_CASE("Voxel pyramid: memory is what the header says") {
    const VoxelPyramid pyramid(glm::ivec3(256, 256, 256));
    const double bits = 8 * double(pyramid.bytes()) / (256.0 * 256 * 256);
    CHECK(bits > 1 + 2.0 / 64);
    CHECK(bits <= 1 + 2.0 / 63);
    CHECK(VoxelPyramid(glm::ivec3(4, 4, 4)).bytes() == 8);
    CHECK(VoxelPyramid(glm::ivec3(5, 4, 4)).bytes() == 2 * 8 + 16);
}
