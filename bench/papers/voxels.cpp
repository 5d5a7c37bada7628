// Polyhedra into voxels: the pyramid of masks against loops over bounding boxes, in turns in one run.
//
// `brute` asks every voxel of the bounding box about every plane until one excludes it. `rows` is the better loop: each
// plane shortens a row of voxels to what is inside, by a division.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>
#include <vector>

#include "farfield/voxel/voxel_pyramid.hpp"
#include "support/seconds.hpp"

namespace farfield::bench {
namespace {

constexpr int side = 256, repeats = 10;

struct Polyhedron {
    std::vector<VoxelPlane> planes;
    glm::ivec3 lower, upper;  ///< half open
};
using Scene = std::vector<Polyhedron>;

void bound(Polyhedron& p, glm::vec3 lower, glm::vec3 upper) {
    p.lower = glm::clamp(glm::ivec3(glm::floor(lower)), 0, side);
    p.upper = glm::clamp(glm::ivec3(glm::ceil(upper)), 0, side);
}

/// Planes that touch a ball, spread evenly.
Scene ball(int faces) {
    const glm::dvec3 center(0.501 * side, 0.499 * side, 0.5003 * side);
    const double radius = 0.4 * side;
    Polyhedron p;
    for (int i = 0; i < faces; ++i) {
        const double z = 1 - (2 * i + 1) / double(faces), r = std::sqrt(1 - z * z), angle = 2.399963229728653 * i;
        const glm::dvec3 out(r * std::cos(angle), r * std::sin(angle), z);
        p.planes.push_back(VoxelPlane::snapped(glm::dvec4(-out, glm::dot(out, center) + radius)));
    }
    bound(p, glm::vec3(center - 1.1 * radius), glm::vec3(center + 1.1 * radius));
    return {p};
}

/// Boxes turned about two axes, of one size, on a jittered lattice: they hide parts of each other.
Scene boxes(int lattice, double half) {
    Scene scene;
    for (int i = 0; i < lattice * lattice * lattice; ++i) {
        const glm::dvec3 place(i % lattice, i / lattice % lattice, i / lattice / lattice);
        const glm::dvec3 center = (place + 0.5) * (double(side) / lattice);
        const double u = 0.7 * (i + 1), v = 1.3 * (i + 1);
        const glm::dvec3 axes[3] = {{std::cos(u), std::sin(u), 0},
                                    {-std::sin(u) * std::cos(v), std::cos(u) * std::cos(v), std::sin(v)},
                                    {std::sin(u) * std::sin(v), -std::cos(u) * std::sin(v), std::cos(v)}};
        Polyhedron p;
        glm::dvec3 reach(0);
        for (const glm::dvec3& axis : axes) {
            for (const double sign : {-1.0, 1.0}) {
                p.planes.push_back(VoxelPlane::snapped(glm::dvec4(sign * axis, half - sign * glm::dot(axis, center))));
            }
            reach += half * glm::abs(axis);
        }
        bound(p, glm::vec3(center - reach), glm::vec3(center + reach));
        scene.push_back(p);
    }
    return scene;
}

/// One bit a voxel.
class Bits {
  public:
    Bits() : words_(std::size_t(side) * side * side / 64) {}
    void clear() { std::fill(words_.begin(), words_.end(), 0); }
    void set(int x, int y, int z) { words_[word(x, y, z)] |= std::uint64_t(1) << (x & 63); }
    void set(int first, int end, int y, int z) {
        for (int x = first; x < end; x = (x | 63) + 1) {
            const int last = std::min(end - 1, x | 63);
            words_[word(x, y, z)] |= ~std::uint64_t(0) << (x & 63) & ~std::uint64_t(0) >> (63 - (last & 63));
        }
    }
    bool operator()(glm::ivec3 v) const { return words_[word(v.x, v.y, v.z)] >> (v.x & 63) & 1; }

  private:
    static std::size_t word(int x, int y, int z) {
        return ((std::size_t(z) * side + std::size_t(y)) * side + std::size_t(x)) / 64;
    }
    std::vector<std::uint64_t> words_;
};

void tile_brute(const Scene& scene, Bits& bits) {
    bits.clear();
    for (const Polyhedron& p : scene) {
        for (int z = p.lower.z; z < p.upper.z; ++z) {
            for (int y = p.lower.y; y < p.upper.y; ++y) {
                for (int x = p.lower.x; x < p.upper.x; ++x) {
                    const auto has_outside = [&](const VoxelPlane& plane) { return !plane.contains({x, y, z}); };
                    if (std::none_of(p.planes.begin(), p.planes.end(), has_outside)) bits.set(x, y, z);
                }
            }
        }
    }
}

void tile_rows(const Scene& scene, Bits& bits) {
    bits.clear();
    for (const Polyhedron& p : scene) {
        for (int z = p.lower.z; z < p.upper.z; ++z) {
            for (int y = p.lower.y; y < p.upper.y; ++y) {
                std::int64_t first = p.lower.x, end = p.upper.x;
                for (const VoxelPlane& plane : p.planes) {
                    const std::int64_t v = plane.at({0, y, z});
                    if (plane.a > 0) {
                        if (v < 0) first = std::max(first, (-v + plane.a - 1) / plane.a);
                    } else if (v < 0) {
                        end = 0;
                    } else if (plane.a < 0) {
                        end = std::min(end, v / -plane.a + 1);
                    }
                    if (first >= end) break;
                }
                if (first < end) bits.set(int(first), int(end), y, z);
            }
        }
    }
}

void tile_pyramid(const Scene& scene, VoxelPyramid& pyramid, std::int64_t& voxels) {
    pyramid.clear();
    voxels = 0;
    for (const Polyhedron& p : scene) {
        pyramid.tile(std::span<const VoxelPlane>(p.planes), [&](const VoxelCubes& cubes) { voxels += cubes.voxels(); });
    }
}

void in_turns(benchmark::State& state, const Scene& scene) {
    VoxelPyramid pyramid(glm::ivec3(side, side, side));
    Bits brute_bits, row_bits;
    std::int64_t voxels = 0;
    double brute = 0, rows = 0, masks = 0;
    for (auto _ : state) {
        brute += seconds([&] { tile_brute(scene, brute_bits); });
        rows += seconds([&] { tile_rows(scene, row_bits); });
        // Several times, as the loops have time enough to find their data in caches.
        const double taken = seconds([&] {
            for (int i = 0; i < repeats; ++i) tile_pyramid(scene, pyramid, voxels);
        });
        masks += taken / repeats;
        state.SetIterationTime(taken / repeats);
    }
    for (int i = 0; i < side * side * side; ++i) {
        const glm::ivec3 v(i % side, i / side % side, i / side / side);
        if (brute_bits(v) != pyramid.occupied(v) || row_bits(v) != pyramid.occupied(v)) {
            state.SkipWithError("the loops and the pyramid disagree");
            break;
        }
    }
    state.counters["voxels"] = double(voxels);
    state.counters["cells_visited"] = double(pyramid.cells_visited());
    state.counters["ns_per_cell"] = masks * 1e9 / double(state.iterations()) / double(pyramid.cells_visited());
    state.counters["brute_over_masks"] = brute / masks;
    state.counters["rows_over_masks"] = rows / masks;
}
BENCHMARK_CAPTURE(in_turns, ball_of_100_faces, ball(100))
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(5);
BENCHMARK_CAPTURE(in_turns, one_box, boxes(1, 80))->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(5);
BENCHMARK_CAPTURE(in_turns, boxes_216, boxes(6, 17))->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(5);
BENCHMARK_CAPTURE(in_turns, boxes_8000, boxes(20, 5))->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace
}  // namespace farfield::bench
