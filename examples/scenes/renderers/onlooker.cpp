#include "scenes/renderers/onlooker.hpp"

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "farfield/geometry/similarity.hpp"

namespace farfield::scenes {
namespace {

glm::mat3 axes(const LocalView& view) {
    return {view.right, view.up, view.forward};
}

}  // namespace

glm::vec3 Onlooker::outside(const LocalView& view, glm::vec3 p) const {
    return outermost_.eye + axes(outermost_) * (glm::transpose(axes(view)) * (p - view.eye)) * view.scale;
}

std::array<glm::vec3, 4> Onlooker::corners(const LocalView& view, const ImageQuad& q) const {
    return {outside(view, q.corner), outside(view, q.corner + q.across), outside(view, q.corner + q.across + q.down),
            outside(view, q.corner + q.down)};
}

float Onlooker::reach() const {
    std::vector<float> depths;
    for (const Batch& b : batches_) {
        for (const ImageQuad& q : b.quads) depths.push_back(b.view.depth(q.corner) * b.view.scale);
    }
    if (depths.empty()) return 0;
    const auto most = depths.begin() + std::ptrdiff_t(depths.size() * 9 / 10);
    std::nth_element(depths.begin(), most, depths.end());
    return *most;
}

/// From above and beside, behind the eye that drew the frame, onto the middle of what it sees.
LocalView Onlooker::outer_view(float reach) const {
    LocalView v = outermost_;
    const glm::vec3 eye = v.eye, target = eye + v.forward * (0.5f * reach);
    v.eye += (v.right * 0.55f + v.up * 0.5f - v.forward * 0.35f) * reach;
    v.forward = glm::normalize(target - v.eye);
    v.right = glm::normalize(glm::cross(v.forward, outermost_.up));
    v.up = glm::cross(v.right, v.forward);
    v.anchor = v.eye;
    v.anchor_depth = 0;
    v.tolerance_px = 0;
    return v.rectangle(0, 0, v.width, v.height);  // sets its planes anew
}

/// As strips that face the viewer, a pixel and a half wide.
std::optional<std::uint32_t> Onlooker::draw_lines(const LocalView& view, std::span<const Segment> segments,
                                                  Rgba8 color) {
    std::vector<VertexColoredTriangle> strips;
    for (const Segment& s : segments) {
        const glm::vec3 along = s[1] - s[0];
        const auto aside = [&](glm::vec3 p) {
            const glm::vec3 across = glm::cross(along, p - view.eye);
            const float length = glm::length(across);
            return length > 0 ? across * (0.75f * std::abs(view.depth(p)) / (view.focal_px * length)) : glm::vec3(0);
        };
        const glm::vec3 a = aside(s[0]), b = aside(s[1]);
        strips.push_back({{s[0] - a, s[0] + a, s[1] + b}, {color, color, color}});
        strips.push_back({{s[0] - a, s[1] + b, s[1] - b}, {color, color, color}});
    }
    if (strips.empty()) return std::nullopt;
    const auto count = std::uint32_t(strips.size());
    const Source<VertexColoredTriangle> source{strips, {}, count};
    const std::uint32_t id = renderer_->upload(AnySource(source));
    renderer_->set_view(view);
    const Range all{0, count};
    renderer_->draw(id, std::span(&all, 1));
    return id;
}

const Image* Onlooker::from_outside(const LocalView* from) {
    float far = reach();
    if (from == nullptr && !(far > 0)) return nullptr;
    // Without images the frustum is shown as long as whoever looks on is away, so that it does not shrink to a point.
    if (!(far > 0)) far = glm::max(glm::length(from->eye - outermost_.eye), outermost_.near_depth);
    const LocalView view = from != nullptr ? *from : outer_view(far);
    std::vector<Segment> images, frustum;
    renderer_->begin_frame(view);
    for (Batch& b : batches_) {
        // The instance's similarity is what takes the axes of one view to those of the other.
        const glm::mat3 rotation = axes(outermost_) * glm::transpose(axes(b.view));
        const glm::dvec3 moved =
            glm::dvec3(outermost_.eye) - glm::dmat3(rotation) * glm::dvec3(b.view.eye) * double(b.view.scale);
        renderer_->set_view(view.inside(Similarity(rotation, b.view.scale, moved), {}, {}));
        for (Range& r : b.ranges) r.law.reset();  // laws hold in the order of the first view
        if (!b.ranges.empty()) renderer_->draw(b.source, b.ranges);
        if (!b.faces.empty()) renderer_->draw(b.faces);
        if (!b.splats.empty()) renderer_->draw(b.splats);
        b.placed.words = b.words.data();
        if (b.placed.count != 0) renderer_->draw(b.placed);
        if (!b.quads.empty()) renderer_->draw(b.quads);
        for (const ImageQuad& q : b.quads) {
            const std::array<glm::vec3, 4> c = corners(b.view, q);
            for (std::size_t i = 0; i < 4; ++i) images.push_back({c[i], c[(i + 1) % 4]});
        }
    }
    const LocalView& own = outermost_;
    const glm::vec2 half = glm::vec2(own.width, own.height) / (2 * own.focal_px * own.squeeze) * far;
    const glm::vec2 axis = glm::vec2(own.off_center) * half;
    std::array<glm::vec3, 4> ends;
    for (std::size_t i = 0; i < 4; ++i) {
        const glm::vec2 side((i == 1 || i == 2 ? half.x : -half.x) + axis.x, (i < 2 ? half.y : -half.y) + axis.y);
        ends[i] = own.eye + own.forward * far + own.right * side.x + own.up * side.y;
    }
    for (std::size_t i = 0; i < 4; ++i) {
        frustum.push_back({own.eye, ends[i]});
        frustum.push_back({ends[i], ends[(i + 1) % 4]});
    }
    const auto red = draw_lines(view, images, {220, 30, 30, 255}),
               green = draw_lines(view, frustum, {20, 150, 50, 255});
    renderer_->end_frame();
    for (const auto& id : {red, green}) {
        if (id) renderer_->release(*id);
    }
    return &renderer_->image();
}

}  // namespace farfield::scenes
