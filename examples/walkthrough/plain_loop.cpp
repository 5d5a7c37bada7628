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
    };

    std::unique_ptr<farfield::bench::PlainZBuffer> z_buffer;
    farfield::Box bounds;
    std::vector<Group> groups;
    std::uint64_t all = 0, drawn = 0;
    double part = 1;  ///< of the instances of groups without instances, evenly, in no step with how they are lined up
    double turn = 0;

    bool is_left_out(const Group& group) {
        if (!group.instances.empty()) return false;
        turn += 0.6180339887498949;
        turn -= std::floor(turn);
        return turn >= part;
    }
    void count(const Group& group) {
        drawn += group.triangles.size();
        for (const Instance& instance : group.instances) {
            if (!is_left_out(groups[instance.group])) count(groups[instance.group]);
        }
    }
    /// The view is set already.
    void draw(const Group& group, const farfield::LocalView& view) {
        z_buffer->draw(group.triangles);
        for (const Instance& instance : group.instances) {
            if (is_left_out(groups[instance.group])) continue;
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
    for (const auto& from : scene.groups) {
        Parts::Group group;
        group.triangles = farfield::bench::plain_triangles(from.triangles);
        for (const auto& placement : from.placements) {
            group.instances.push_back({placement.group, farfield::Similarity(placement.to_parent)});
        }
        parts_->groups.push_back(std::move(group));
    }
    parts_->part = std::min(1.0, double(most_triangles) / double(std::max(parts_->all, std::uint64_t(1))));
    parts_->count(parts_->groups.back());
    if (parts_->drawn > 0) return;
    parts_->part = 1;  // there are few, all large
    parts_->count(parts_->groups.back());
}

PlainLoop::~PlainLoop() = default;

double PlainLoop::ms(const farfield::View& view) {
    parts_->turn = 0;
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
    return parts_->drawn;
}

}  // namespace walkthrough
