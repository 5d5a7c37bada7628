// What bench/accuracy/fidelity.cpp measures: ways to draw a scene, and scenes with their references.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "support/seconds.hpp"
#if __has_include("farfield/approximation/opacity_tensor.hpp")
#include "farfield/approximation/opacity_tensor.hpp"
#endif

namespace farfield::bench {

/// A scene under one kind of hierarchy, built on one core. Surfaces that are closed are drawn from the front only.
class Drawing {
  public:
    struct BuildFacts {
        double seconds = 0;
        std::size_t bytes = 0;  ///< of nodes and data; primitives are in the hierarchy's order
        std::size_t nodes = 0, stand_ins = 0;
    };

    virtual ~Drawing() = default;
    const BuildFacts& built() const { return built_; }
    virtual const Box& bounds() const = 0;
    virtual FrameStats frame(const View& view, int samples) = 0;
    virtual const Image& image() const = 0;  ///< of the last frame; there must be one

  protected:
    BuildFacts built_;
};

template <class Approximation>
class DrawingBy final : public Drawing {
  public:
    DrawingBy(std::span<const VertexColoredTriangle> triangles, bool is_closed, const Approximation& approximation)
        : triangles_(triangles.begin(), triangles.end()), is_closed_(is_closed) {
        const std::span<VertexColoredTriangle> in_place(triangles_);
        built_.seconds =
            seconds([&] { hierarchy_ = build_in_place<Hierarchy>(in_place, {.approximation = approximation}); });
        built_.bytes = hierarchy_.bytes();
        built_.nodes = hierarchy_.nodes().size();
        built_.stand_ins = hierarchy_.stand_ins().size();
    }
    const Box& bounds() const override { return hierarchy_.bounds(); }
    FrameStats frame(const View& view, int samples) override {
        auto& canvas = canvases_[samples];
        if (!canvas) {
            const ZBufferOptions options{.samples = samples, .culls_back_faces = is_closed_};
            canvas = std::make_unique<Canvas>(hierarchy_, triangles_, options);
        }
        last_ = &canvas->renderer.image();
        return canvas->viewer.frame(view);
    }
    const Image& image() const override { return *last_; }

  private:
    using Hierarchy = SpatialHierarchy<Octree, Approximation, TriangleCount>;
    struct Canvas {
        ZBufferRenderer renderer;
        Viewer<Hierarchy, VertexColoredTriangle, ZBufferRenderer> viewer;
        Canvas(const Hierarchy& h, std::span<const VertexColoredTriangle> triangles, const ZBufferOptions& options)
            : renderer(options), viewer(h, triangles, renderer) {}
    };

    std::vector<VertexColoredTriangle> triangles_;
    bool is_closed_;
    Hierarchy hierarchy_;
    std::map<int, std::unique_ptr<Canvas>> canvases_;  ///< by samples
    const Image* last_ = nullptr;
};

/// A way to draw a scene, as tables call it.
struct Method {
    std::string name;
    std::function<std::unique_ptr<Drawing>(std::span<const VertexColoredTriangle>, bool is_closed)> draw;
};

/// `of_closed` is what stands for closed surfaces.
template <class Approximation>
Method method(const char* name, const Approximation& of_open, const Approximation& of_closed) {
    return {name, [=](std::span<const VertexColoredTriangle> triangles, bool is_closed) {
                return std::make_unique<DrawingBy<Approximation>>(triangles, is_closed,
                                                                  is_closed ? of_closed : of_open);
            }};
}
template <class Approximation>
Method method(const char* name, const Approximation& approximation) {
    return method(name, approximation, approximation);
}

/// What is measured against exact. A new one is one line here.
inline const std::vector<Method>& methods() {
    static const std::vector<Method> all {
        method("color-cube", ColorCube{}),
#if __has_include("farfield/approximation/opacity_tensor.hpp")
            method("opacity-tensor", OpacityTensor{}, OpacityTensor{.closed_surfaces = true}),
#endif
    };
    return all;
}

/// A scene, everything that draws it, and references.
class Subject {
  public:
    Subject(std::vector<VertexColoredTriangle> triangles, bool is_closed)
        : triangles_(std::move(triangles)), is_closed_(is_closed), exact_(triangles_, is_closed, Exact{}) {}

    std::span<const VertexColoredTriangle> triangles() const { return triangles_; }
    bool is_closed() const { return is_closed_; }
    const Box& bounds() const { return exact_.bounds(); }
    Drawing& exact() { return exact_; }
    /// Built when it is first asked for.
    Drawing& by(const Method& method) {
        auto& drawing = by_method_[method.name];
        if (!drawing) drawing = method.draw(triangles_, is_closed_);
        return *drawing;
    }
    /// Every triangle, 64 samples a pixel.
    const Image& reference(const View& view) {
        for (const auto& [seen, image] : references_) {
            if (seen.width == view.width && seen.height == view.height && seen.camera.eye == view.camera.eye &&
                seen.camera.forward == view.camera.forward && seen.camera.half_height == view.camera.half_height) {
                return *image;
            }
        }
        exact_.frame(view, 64);
        references_.emplace_back(view, std::make_unique<Image>(exact_.image()));
        return *references_.back().second;
    }

  private:
    std::vector<VertexColoredTriangle> triangles_;
    bool is_closed_;
    DrawingBy<Exact> exact_;
    std::map<std::string, std::unique_ptr<Drawing>> by_method_;
    std::vector<std::pair<View, std::unique_ptr<Image>>> references_;
};

/// Exact at one sample a pixel and another drawing, in turns: the machine has slow and fast phases, and only ratios of
/// neighboring frames mean something.
class Turns {
  public:
    Turns(Drawing& exact, Drawing& other, const View& view, int samples)
        : exact_(exact), other_(other), view_(view), samples_(samples) {}

    /// Seconds of the other's frame, which is its last.
    double take() {
        exact_seconds_.push_back(seconds_in_turn(last(exact_seconds_), [&] { exact_.frame(view_, 1); }));
        seconds_.push_back(seconds_in_turn(last(seconds_), [&] { stats_ = other_.frame(view_, samples_); }));
        speedups_.push_back(exact_seconds_.back() / seconds_.back());
        return seconds_.back();
    }
    double exact_seconds() const { return median(exact_seconds_); }
    double other_seconds() const { return median(seconds_); }
    double speedup() const { return median(speedups_); }  ///< of the other over exact, turn by turn
    const FrameStats& stats() const { return stats_; }    ///< of the other's last frame

  private:
    static double last(const std::vector<double>& v) { return v.empty() ? 0 : v.back(); }

    Drawing& exact_;
    Drawing& other_;
    View view_;
    int samples_;
    FrameStats stats_;
    std::vector<double> exact_seconds_, seconds_, speedups_;
};

}  // namespace farfield::bench
