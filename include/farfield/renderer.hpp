// The user brings a renderer to draw with: ranges of primitives always; faces, splats, deposits of primitives and
// answers about occlusion where the renderer's facts say so.
#pragma once

#include "farfield/settings.hpp"

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "farfield/drawables.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/geometry/light.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/geometry/visit_order.hpp"
#include "farfield/view/local_view.hpp"

namespace farfield {

/// Promises and demands of a renderer. Each flag makes the hook beside it required, so that a misspelt hook is an
/// error and not silence.
struct RendererFacts {
    VisitOrder order = VisitOrder::any;                    ///< in which cells' primitives are wanted
    OrderGuarantee needs_ordering = OrderGuarantee::none;  ///< how strict that order has to be, within ranges too
    VisitOrder far_field_order =
        VisitOrder::front_to_back;  ///< back_to_front: stand-ins are replayed after everything else
    bool keeps_sources = false;     ///< std::uint32_t upload(Source<P>) once a source, release(id) when it goes
    /// It keeps nothing of sources that change (Source::changes), for which upload() gives it a number and no more, and
    /// reads their primitives whenever it draws them. Not needed where it keeps no sources.
    bool draws_changing_sources = false;
    bool shares_sources = false;  ///< std::uint32_t share(const R& other, id): upload what another has uploaded
    bool tells_lifetime = false;  ///< std::weak_ptr<const void> lifetime() const: expires when the renderer goes
    bool tells_light =
        false;  ///< std::optional<DirectionalLight> light() const: what primitives get and stand-ins have
    bool draws_faces = false;   ///< draw(std::span<const Face>)
    bool draws_splats = false;  ///< draw(std::span<const Splat>), float largest_splat_px()
    /// draw(const PlacedStandIns&), bool shapes_stand_ins() const, asked of each batch: whether stand-ins that would
    /// come as splats come as they are stored, where an approximation can, and the renderer makes splats of them.
    bool shapes_stand_ins = false;
    bool draws_polygons = false;  ///< draw(std::span<const Polygon>): pieces made for this frame, local coordinates
    bool answers_hidden = false;  ///< bool hidden(const Cell&, CellId): may err only towards false
    /// bool deposits_primitives() const, asked once a frame or selection: whether its ranges carry their cell's law
    /// where it is known. Cells with a law come front to back, in order with the stand-ins among them.
    bool deposits_primitives = false;
    /// Images of parts of the scene, in this order; draw(std::span<const ImageQuad>) in frames and in images:
    ///
    ///     begin_image(const LocalView&, float quad_depth, int samples)   after begin_frame, before anything is drawn
    ///     end_image() -> std::uint32_t                                   a handle; 0: it could not be made
    ///     free_image(handle)
    ///     image_bytes(int width, int height) -> std::size_t              the most memory that one takes
    ///
    /// What is drawn between begin_image and end_image goes into a picture of its own, of the view's size, transparent
    /// where nothing is drawn, with so many samples a pixel. Its rectangle will lie at `quad_depth`, local units; a
    /// renderer may remember how much nearer or farther each pixel's contents are.
    bool keeps_images = false;
    /// Several depth slices of an image are made at once, and not by drawing the contents once for each:
    ///
    ///     begin_image(const LocalView&, std::span<const ImageSlice>, int samples)   front to back
    ///     end_image(std::span<std::uint32_t> handles)                               one a slice; 0: it was not made
    bool slices_images = false;
};

template <class R>
concept StatesItsFacts = requires {
    { R::facts } -> std::convertible_to<RendererFacts>;
};

template <class R>
concept HasFrames = requires(R& r, const LocalView& view) {
    r.begin_frame(view);  // the outermost hierarchy's coordinates
    r.set_view(view);     // what follows is in this view's coordinates
    r.end_frame();
};

/// Ranges come in groups, which are in the order that `facts` asks for; within a group it is free for VisitOrder::any.
template <class R, class P>
concept DrawsRuns = requires(R& r, const Source<P>& source, std::span<const Range> ranges) {
    r.draw(source, ranges);
};

template <class R, class P>
concept KeepsSources = requires(R& r, const Source<P>& source, std::uint32_t id) {
    { r.upload(source) } -> std::same_as<std::uint32_t>;
    r.release(id);
};

/// The other renderer may go first. Whoever shares releases what it got, as if uploaded.
template <class R>
concept SharesSources = requires(R& r, const R& other, std::uint32_t id) {
    { r.share(other, id) } -> std::same_as<std::uint32_t>;
};

template <class R>
concept TellsLifetime = requires(const R& r) {
    { r.lifetime() } -> std::same_as<std::weak_ptr<const void>>;
};

template <class R>
concept TellsLight = requires(const R& r) {
    { r.light() } -> std::convertible_to<std::optional<DirectionalLight>>;
};

template <class R>
concept DrawsFaces = requires(R& r, std::span<const Face> faces) {
    r.draw(faces);
};

template <class R>
concept DrawsSplats = requires(R& r, std::span<const Splat> splats) {
    r.draw(splats);
    { r.largest_splat_px() } -> std::convertible_to<float>;
};

template <class R>
concept ShapesStandIns = requires(R& r, const R& known, const PlacedStandIns& placed) {
    r.draw(placed);
    { known.shapes_stand_ins() } -> std::same_as<bool>;
};

template <class R>
concept DrawsPolygons = requires(R& r, std::span<const Polygon> polygons) {
    r.draw(polygons);
};

template <class R>
concept AnswersHidden = requires(R& r, const Cell& cell, CellId id) {
    { r.hidden(cell, id) } -> std::same_as<bool>;
};

template <class R>
concept DepositsPrimitives = requires(const R& r) {
    { r.deposits_primitives() } -> std::same_as<bool>;
};

template <class R>
concept KeepsImages = requires(R& r, const R& known, const LocalView& view, std::uint32_t image,
                               std::span<const ImageQuad> quads) {
    r.begin_image(view, 1.0f, 1);
    { r.end_image() } -> std::same_as<std::uint32_t>;
    r.free_image(image);
    { known.image_bytes(1, 1) } -> std::convertible_to<std::size_t>;
    r.draw(quads);
};

template <class R>
concept SlicesImages = requires(R& r, const LocalView& view, std::span<const ImageSlice> slices,
                                std::span<std::uint32_t> handles) {
    r.begin_image(view, slices, 1);
    r.end_image(handles);
};

namespace detail {
template <class R, class P>
concept KeepsSourcesIfStated = !R::facts.keeps_sources || KeepsSources<R, P>;
template <class R>
concept SharesSourcesIfStated = !R::facts.shares_sources || (R::facts.keeps_sources && SharesSources<R>);
template <class R>
concept TellsLifetimeIfStated = !R::facts.tells_lifetime || TellsLifetime<R>;
template <class R>
concept TellsLightIfStated = !R::facts.tells_light || TellsLight<R>;
template <class R>
concept DrawsFacesIfStated = !R::facts.draws_faces || DrawsFaces<R>;
template <class R>
concept DrawsSplatsIfStated = !R::facts.draws_splats || DrawsSplats<R>;
template <class R>
concept ShapesStandInsIfStated = !R::facts.shapes_stand_ins || (R::facts.draws_splats && ShapesStandIns<R>);
template <class R>
concept DrawsChangingSources = !R::facts.keeps_sources || R::facts.draws_changing_sources;
template <class R>
concept DrawsPolygonsIfStated = !R::facts.draws_polygons || DrawsPolygons<R>;
template <class R>
concept AnswersHiddenIfStated = !R::facts.answers_hidden || AnswersHidden<R>;

template <class R>
concept DepositsPrimitivesIfStated = !R::facts.deposits_primitives || DepositsPrimitives<R>;
template <class R>
concept KeepsImagesIfStated = !R::facts.keeps_images || KeepsImages<R>;
template <class R>
concept SlicesImagesIfStated = !R::facts.slices_images || (R::facts.keeps_images && SlicesImages<R>);
}  // namespace detail

template <class R, class P>
concept Renderer = StatesItsFacts<R> && HasFrames<R> && DrawsRuns<R, P> && detail::KeepsSourcesIfStated<R, P> &&
    detail::SharesSourcesIfStated<R> && detail::TellsLifetimeIfStated<R> && detail::TellsLightIfStated<R> &&
    detail::DrawsFacesIfStated<R> && detail::DrawsSplatsIfStated<R> && detail::ShapesStandInsIfStated<R> &&
    detail::DrawsPolygonsIfStated<R> && detail::AnswersHiddenIfStated<R> && detail::DepositsPrimitivesIfStated<R> &&
    detail::KeepsImagesIfStated<R> && detail::SlicesImagesIfStated<R>;

}  // namespace farfield
