#include "plain_loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "farfield/geometry/similarity.hpp"
#include "farfield/view/local_view.hpp"
#include "peers/plain_renderer.hpp"

namespace walkthrough {

struct PlainLoop::Parts {
    struct Instance {
        std::size_t group;
        farfield::Similarity to_parent;
    };
    struct Group {
        std::vector<farfield::bench::PlainTriangle> triangles;
        std::vector<Instance> instances;
        std::uint64_t count = 0;  ///< triangles, those of instances included
    };

    std::unique_ptr<farfield::bench::PlainZBuffer> z_buffer;
    farfield::Box bounds;
    std::vector<Group> groups;
    std::uint64_t all = 0;

    /// The view is set already.
    void draw(const Group& group, const farfield::LocalView& view) {
        z_buffer->draw(group.triangles);
        for (const Instance& instance : group.instances) {
            const auto inner = view.inside(instance.to_parent, glm::dvec3(0), glm::dvec3(0));
            z_buffer->set_view(inner);
            draw(groups[instance.group], inner);
        }
    }
};

PlainLoop::PlainLoop(const farfield::scenes::Scene& scene, int samples, std::uint64_t most_triangles)
    : parts_(std::make_unique<Parts>()) {
    parts_->z_buffer = farfield::bench::native_plain_z_buffer(samples == 1 ? 1 : 8);
    parts_->bounds = farfield::scenes::bounds(scene);
    parts_->all = farfield::scenes::triangle_count(scene);
    const double part = std::min(1.0, double(most_triangles) / double(std::max(parts_->all, std::uint64_t(1))));
    for (const auto& from : scene.groups) {
        Parts::Group group;
        group.triangles = farfield::bench::plain_triangles(from.triangles);
        group.count = group.triangles.size();
        const bool is_root = &from == &scene.groups.back();
        double turn = 0;
        for (const auto& placement : from.placements) {
            // Evenly over all of them, in no step with how they are lined up.
            turn += 0.6180339887498949;
            turn -= std::floor(turn);
            if (is_root && turn >= part) continue;
            group.instances.push_back({placement.group, farfield::Similarity(placement.to_parent)});
            group.count += parts_->groups[placement.group].count;
        }
        parts_->groups.push_back(std::move(group));
    }
}

PlainLoop::~PlainLoop() = default;

double PlainLoop::ms(const farfield::View& view) {
    const auto begin = std::chrono::steady_clock::now();
    const farfield::LocalView local(view, glm::dvec3(0), parts_->bounds);
    parts_->z_buffer->begin_frame(local);
    parts_->draw(parts_->groups.back(), local);
    parts_->z_buffer->end_frame();
    const double drawn_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    return drawn_triangles() > 0 ? drawn_ms * double(triangles()) / double(drawn_triangles()) : drawn_ms;
}

const farfield::Image& PlainLoop::image() const {
    return parts_->z_buffer->image();
}
std::uint64_t PlainLoop::triangles() const {
    return parts_->all;
}
std::uint64_t PlainLoop::drawn_triangles() const {
    return parts_->groups.back().count;
}

}  // namespace walkthrough
