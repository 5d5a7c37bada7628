#include "paged_scene.hpp"

#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>

#ifdef FARFIELD_HAS_HTTP
#include "farfield/adapters/http_page_source.hpp"
#endif
#ifdef FARFIELD_HAS_OPENGL
#include "opengl/culled_in_software.hpp"
#include "opengl/gl_renderer.hpp"
#include "scenes/renderers/opengl_renderer.hpp"
#endif
#include "farfield/paging/file_page_source.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/pick.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/paged_variants.hpp"

namespace viewer {
namespace {

using farfield::FrameStats;
using farfield::Image;
using farfield::View;
using farfield::scenes::BuiltScene;
using farfield::scenes::PagedPrimitive;
using farfield::scenes::PickedInScene;
using farfield::scenes::RendererChoice;
using farfield::scenes::RendererKind;
using farfield::scenes::SceneViewer;

bool is_address(const std::string& where) {
    return where.rfind("http://", 0) == 0 || where.rfind("https://", 0) == 0;
}

struct ZBuffer {
    using Renderer = farfield::ZBufferRenderer;
    Renderer renderer;
    explicit ZBuffer(const RendererChoice& choice) : renderer({.samples = choice.samples}) {}
    const Image& image() const { return renderer.image(); }
    unsigned texture() const { return 0; }
    void finish() {}
};

#ifdef FARFIELD_HAS_OPENGL
struct OpenGl {
    using Renderer = farfield::opengl::CulledInSoftware<farfield::opengl::GlRenderer>;
    std::shared_ptr<void> context = farfield::scenes::opengl_context();
    farfield::opengl::GlRenderer shading;
    Renderer renderer;
    explicit OpenGl(const RendererChoice& choice)
        : shading({.samples = choice.samples}),
          renderer(shading, farfield::ZBufferOptions{.samples = choice.samples}) {}
    const Image& image() const { return shading.image(); }
    unsigned texture() const { return shading.texture(); }
    void finish() { glFinish(); }  // so that times are times
};
#endif

template <class Pages, class Drawn>
class PagedFrames final : public SceneViewer {
  public:
    PagedFrames(const Pages& pages, const RendererChoice& choice) : by_(choice), viewer_(pages, by_.renderer) {}
    FrameStats frame(const View& view) override {
        const FrameStats stats = viewer_.frame(view);
        by_.finish();
        return stats;
    }
    const Image& image() const override { return by_.image(); }
    unsigned texture() const override { return by_.texture(); }

  private:
    Drawn by_;
    farfield::Viewer<Pages, PagedPrimitive, typename Drawn::Renderer> viewer_;
};

template <class Pages>
class PagedBuilt final : public BuiltScene {
  public:
    explicit PagedBuilt(const Pages& pages) : pages_(pages) {
        facts_.bytes = pages.bytes();
        facts_.cells = pages.node_count();
        facts_.levels = pages.report().levels;
    }
    std::unique_ptr<SceneViewer> viewer(const RendererChoice& choice) const override {
        if (!draws_pages(choice.kind)) {
            throw std::invalid_argument("the renderer " + std::string(name_of(choice.kind)) +
                                        " does not draw from pages here");
        }
#ifdef FARFIELD_HAS_OPENGL
        if (choice.kind == RendererKind::opengl) return std::make_unique<PagedFrames<Pages, OpenGl>>(pages_, choice);
#endif
        return std::make_unique<PagedFrames<Pages, ZBuffer>>(pages_, choice);
    }
    std::optional<PickedInScene> pick(const View& view, glm::dvec2 pixel) const override {
        Pages own = pages_;  // whoever picks may be another thread
        const auto picked = farfield::pick(own, view, pixel);
        if (!picked) return std::nullopt;
        PickedInScene out;
        out.depth = picked->distance;
        out.point = farfield::ray_through(view, pixel).at(picked->distance);
        out.path = {picked->page, picked->item};
        for (const auto& v : picked->primitive.vertices) out.corners.push_back(glm::dvec3(v));
        return out;
    }

  private:
    Pages pages_;
};

template <class Source>
PagedScene open(const std::shared_ptr<Source>& source, const std::string& where, std::size_t cache_bytes) {
    PagedScene scene;
    const bool is_known = farfield::scenes::any_paged_variant([&](auto type, std::string_view name) {
        using H = typename decltype(type)::type;
        if (!farfield::holds_pages_of<H, PagedPrimitive>(*source)) return false;
        const auto pages = farfield::open_pages_of<H, PagedPrimitive>(source, where, {.most_bytes = cache_bytes});
        using Pages = std::remove_cvref_t<decltype(pages)>;
        scene.built = std::make_shared<PagedBuilt<Pages>>(pages);
        scene.variant = name;
        scene.bounds = {glm::dvec3(pages.bounds().lower) + pages.origin(),
                        glm::dvec3(pages.bounds().upper) + pages.origin()};
        scene.primitives = pages.primitive_count();
        scene.file_bytes = pages.bytes();
        scene.pages = pages.page_count();
        return true;
    });
    if (!is_known) throw std::runtime_error(where + " is no file of pages that farfield_build makes");
    return scene;
}

}  // namespace

bool is_paged_scene(const std::string& where) {
    constexpr std::string_view end = ".farfield";
    return is_address(where) ||
           (where.size() > end.size() && where.compare(where.size() - end.size(), end.size(), end) == 0);
}

bool draws_pages(RendererKind kind) {
#ifdef FARFIELD_HAS_OPENGL
    if (kind == RendererKind::opengl) return true;
#endif
    return kind == RendererKind::z_buffer;
}

PagedScene open_paged_scene(const std::string& where, std::size_t cache_bytes) {
    if (is_address(where)) {
#ifdef FARFIELD_HAS_HTTP
        return open(std::make_shared<farfield::HttpPageSource>(where), where, cache_bytes);
#else
        throw std::runtime_error(
            "this viewer was built without libcurl: give it a file, or install "
            "libcurl4-openssl-dev and build again");
#endif
    }
    return open(std::make_shared<farfield::FilePageSource>(where), where, cache_bytes);
}

}  // namespace viewer
