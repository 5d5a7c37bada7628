// Each promise of a renderer, with types that keep it and types that miss it by one thing.
#include "farfield/renderer.hpp"

#include <cstdint>
#include <memory>
#include <span>

#include "catch.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "support/recorder.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

struct Frames {
    void begin_frame(const LocalView&) {}
    void set_view(const LocalView&) {}
    void end_frame() {}
};
struct Runs : Frames {
    template <class P>
    void draw(const Source<P>&, std::span<const Range>) {}
};
struct Least : Runs {
    static constexpr RendererFacts facts{};
};
struct WithoutFacts : Runs {};
struct WithoutFrames {
    static constexpr RendererFacts facts{};
    template <class P>
    void draw(const Source<P>&, std::span<const Range>) {}
};
struct WithoutEnd {
    [[maybe_unused]] static constexpr RendererFacts facts{};
    void begin_frame(const LocalView&) {}
    void set_view(const LocalView&) {}
    template <class P>
    void draw(const Source<P>&, std::span<const Range>) {}
};
struct WithoutRuns : Frames {
    static constexpr RendererFacts facts{};
};
struct WrongRuns : Frames {
    static constexpr RendererFacts facts{};
    template <class P>
    void draw(const Source<P>&, Range) {}
};
/// Draws triangles and nothing else.
struct TrianglesOnly : Frames {
    static constexpr RendererFacts facts{};
    void draw(const Source<Triangle>&, std::span<const Range>) {}
};

struct KeepsNothing : Runs {
    static constexpr RendererFacts facts{.keeps_sources = true};
};
struct MisspeltPageOut : Runs {
    static constexpr RendererFacts facts{.keeps_sources = true};
    template <class P>
    std::uint32_t upload(const Source<P>&) {
        return 0;
    }
    void pageout(std::uint32_t) {}
};
struct PageInGivesNothing : Runs {
    static constexpr RendererFacts facts{.keeps_sources = true};
    template <class P>
    void upload(const Source<P>&) {}
    void release(std::uint32_t) {}
};
struct MisspeltLifetime : Runs {
    static constexpr RendererFacts facts{.tells_lifetime = true};
    std::weak_ptr<const void> life() const { return {}; }
};
struct LifetimeWithoutFlag : Runs {
    static constexpr RendererFacts facts{};
    int lifetime() const { return 0; }
};
struct MisspeltFaces : Runs {
    static constexpr RendererFacts facts{.draws_faces = true};
    void draw_faces(std::span<const Face>) {}
};
struct SplatsOfUnknownSize : Runs {
    static constexpr RendererFacts facts{.draws_splats = true};
    using Runs::draw;
    void draw(std::span<const Splat>) {}
};
struct ShapesWithoutSaying : Runs {
    static constexpr RendererFacts facts{.draws_splats = true, .shapes_stand_ins = true};
    using Runs::draw;
    void draw(std::span<const Splat>) {}
    void draw(const PlacedStandIns&) {}
    float largest_splat_px() const { return 2; }
};
struct MisspeltHidden : Runs {
    static constexpr RendererFacts facts{.answers_hidden = true};
    bool is_hidden(const Cell&, CellId) { return false; }
};
struct HiddenPerhaps : Runs {
    static constexpr RendererFacts facts{.answers_hidden = true};
    float hidden(const Cell&, CellId) { return 0.5f; }
};
struct MisspeltDeposits : Runs {
    static constexpr RendererFacts facts{.deposits_primitives = true};
    bool deposits_primitive() const { return true; }
};
struct DepositsPerhaps : Runs {
    static constexpr RendererFacts facts{.deposits_primitives = true};
    float deposits_primitives() const { return 0.5f; }
};
struct ChangesWhenAskedForDeposits : Runs {
    static constexpr RendererFacts facts{.deposits_primitives = true};
    bool deposits_primitives() { return true; }
};
struct HiddenWithoutFlag : Runs {
    static constexpr RendererFacts facts{};
    bool is_hidden(const Cell&, CellId) { return false; }
};

static_assert(Renderer<Least, Triangle> && Renderer<ZBufferRenderer, Triangle> && Renderer<Recorder, Triangle>);
static_assert(!Renderer<WithoutFacts, Triangle> && !StatesItsFacts<WithoutFacts>);
static_assert(!Renderer<WithoutFrames, Triangle> && !HasFrames<WithoutFrames> && !HasFrames<WithoutEnd>);
static_assert(!Renderer<WithoutRuns, Triangle> && !Renderer<WrongRuns, Triangle> && !DrawsRuns<WrongRuns, Triangle>);
static_assert(Renderer<TrianglesOnly, Triangle> && !Renderer<TrianglesOnly, VertexColoredTriangle>);
static_assert(!Renderer<KeepsNothing, Triangle> && !Renderer<MisspeltPageOut, Triangle> &&
              !Renderer<PageInGivesNothing, Triangle>);
static_assert(!detail::KeepsSourcesIfStated<KeepsNothing, Triangle> && detail::KeepsSourcesIfStated<Least, Triangle>);
static_assert(!Renderer<MisspeltLifetime, Triangle> && !detail::TellsLifetimeIfStated<MisspeltLifetime> &&
              Renderer<LifetimeWithoutFlag, Triangle> && TellsLifetime<ZBufferRenderer>);
static_assert(!Renderer<MisspeltFaces, Triangle> && !detail::DrawsFacesIfStated<MisspeltFaces>);
static_assert(!Renderer<SplatsOfUnknownSize, Triangle> && !detail::DrawsSplatsIfStated<SplatsOfUnknownSize>);
static_assert(!Renderer<ShapesWithoutSaying, Triangle> && !detail::ShapesStandInsIfStated<ShapesWithoutSaying>);
static_assert(!Renderer<MisspeltHidden, Triangle> && !Renderer<HiddenPerhaps, Triangle> &&
              !detail::AnswersHiddenIfStated<MisspeltHidden>);
static_assert(!Renderer<MisspeltDeposits, Triangle> && !Renderer<DepositsPerhaps, Triangle> &&
              !Renderer<ChangesWhenAskedForDeposits, Triangle> &&
              !detail::DepositsPrimitivesIfStated<MisspeltDeposits>);
static_assert(Renderer<HiddenWithoutFlag, Triangle>, "a hook without its flag is not looked at");
static_assert(!Renderer<Triangle, Triangle> && !Renderer<int, Triangle>);

struct NoPolygons {
    Box bounds() const { return {}; }
};
static_assert(!Renderer<ZBufferRenderer, NoPolygons>, "the z-buffer asks for polygons");
static_assert(Renderer<Least, NoPolygons>);

}  // namespace

TEST_CASE("a source maps positions to primitives") {
    const Triangle triangles[3] = {{{}, {1, 0, 0, 255}}, {{}, {2, 0, 0, 255}}, {{}, {3, 0, 0, 255}}};
    const std::uint32_t order[4] = {2, 0, 1, 2};
    const Source<Triangle> with{triangles, order, 4, {}, 0}, without{triangles, {}, 3, {}, 0};
    CHECK(with[0].rgba.r == 3);
    CHECK(with[3].rgba.r == 3);
    CHECK(without[1].rgba.r == 2);
}
