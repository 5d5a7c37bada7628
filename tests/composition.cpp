// Each condition on policies, with types that meet it and types that miss it by one thing.
#include "farfield/composition.hpp"

#include <span>
#include <vector>

#include "catch.hpp"
#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/sample_set.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/nested.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/partition/polygon_bsp.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/spatial_hierarchy.hpp"
#include "farfield/viewer.hpp"
#include "support/recorder.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

// --- partitions ------------------------------------------------------------------------------------------------------

struct GoodPartition {
    struct node_data {};
    static constexpr PartitionFacts facts{};
    Cell root(const Box&) const { return {}; }
    Split choose(const Cell&, std::span<const Item>, node_data&) const { return Split::no; }
    template <class Touches, class Emit>
    void place(const Cell&, const node_data&, const Item&, Touches&&, Emit&& emit) const {
        emit.keep();
    }
    Cell child(const Cell& c, const node_data&, unsigned) const { return c; }
    void front_to_back(const Cell&, const node_data&, glm::vec4, ChildOrder&) const {}
};
struct WithoutFacts : GoodPartition {
    int facts;
};
struct WithOddFacts : GoodPartition {
    static constexpr int facts = 3;
};
struct WithMemory : GoodPartition {
    struct node_data {
        std::vector<int> planes;
    };
    Split choose(const Cell&, std::span<const Item>, node_data&) const { return Split::no; }
    template <class Touches, class Emit>
    void place(const Cell&, const node_data&, const Item&, Touches&&, Emit&&) const {}
    Cell child(const Cell& c, const node_data&, unsigned) const { return c; }
    void front_to_back(const Cell&, const node_data&, glm::vec4, ChildOrder&) const {}
};
struct SaysYesOrNo : GoodPartition {
    bool choose(const Cell&, std::span<const Item>, node_data&) const { return false; }
};
struct WithoutRoot : GoodPartition {
    void root() const {}
};
struct WithoutOrder : GoodPartition {
    void front_to_back() const {}
};
struct ChangesWhenAsked : GoodPartition {
    Cell child(const Cell& c, const node_data&, unsigned) { return c; }
};
struct SharedOnly : GoodPartition {
    static constexpr PartitionFacts facts{.offers = Assignment::shared};
};
struct Ordered : GoodPartition {
    static constexpr PartitionFacts facts{.ordering = OrderGuarantee::primitives};
};
struct ClipsWithoutHooks : GoodPartition {
    static constexpr PartitionFacts facts{.offers = Assignment::clipped};
};
struct MisspeltFit : PolygonBsp {
    void fit() const {}
};
struct AlsoClips : PolygonBsp {
    static constexpr PartitionFacts facts{.offers = Assignment::clipped | Assignment::unique};
};

static_assert(Partition<PolygonBsp> && Partition<Nested<Octree, PolygonBsp>> && CutsItems<PolygonBsp>);
static_assert(!Partition<ClipsWithoutHooks> && !Partition<MisspeltFit>);
static_assert(!Partition<AlsoClips> && detail::CutsItemsIfOffered<AlsoClips> &&
              !detail::PlacesItemsIfOffered<AlsoClips>);
static_assert(Partition<Octree> && Partition<SharedOctree> && Partition<GoodPartition> && Partition<SharedOnly>);
static_assert(!Partition<WithoutFacts> && !Partition<WithOddFacts> && !Partition<WithMemory> &&
              !Partition<SaysYesOrNo>);
static_assert(!Partition<WithoutRoot> && !Partition<WithoutOrder> && !Partition<ChangesWhenAsked>);
static_assert(!Partition<int> && !Partition<ColorCube> && !Partition<TriangleCount>);

// --- approximations --------------------------------------------------------------------------------------------------

struct Nothing {
    struct stand_in_data {};
    static constexpr ApproximationFacts facts{};
};
struct StandsInWithoutHooks : Nothing {
    static constexpr ApproximationFacts facts{.stands_in = true};
};
struct BoundsErrorWithoutHook : Nothing {
    static constexpr ApproximationFacts facts{.bounds_error = true};
};
struct MisspeltLeastError : Nothing {
    static constexpr ApproximationFacts facts{.bounds_error = true};
    float least_error(const Cell&, unsigned, const LocalView&) const { return 0; }
};
struct CubeWithMisspeltFinish : ColorCube {
    void finish() const {}
};
struct CubeWithMisspeltError : ColorCube {
    float error_px(const stand_in_data&, const Cell&) const { return 0; }
};
struct CubeWithoutBound : ColorCube {
    void least_error_px() const {}
};
struct CubeWithoutPolygons : ColorCube {
    void polygons() const {}
};
struct CubeWithMisspeltLaw : ColorCube {
    void area_law() const {}
};
struct CubeWithMisspeltExpectation : ColorCube {
    void expected_rmse() const {}
};
struct CubeWithNumberForLaw : ColorCube {
    float area_law(const stand_in_data&) const { return 0.5f; }
};
struct LawWithoutStandIns : Nothing {
    static constexpr ApproximationFacts facts{.provides_area_law = true};
    std::optional<AreaLaw> area_law(const stand_in_data&) const { return AreaLaw::mixed; }
};
struct CubeThatDoesNotSay : CubeWithoutBound {
    static constexpr ApproximationFacts facts{.needs_polygons = true, .stands_in = true};
};
struct PoolWithoutElement : Nothing {
    static constexpr ApproximationFacts facts{.stands_in = true, .has_pool = true};
};
struct OwnsMemory : Nothing {
    struct stand_in_data {
        std::vector<int> v;
    };
};
struct UniqueOnly : Nothing {
    static constexpr ApproximationFacts facts{.accepts = Assignment::unique};
};
struct ClippedOnly : Nothing {
    static constexpr ApproximationFacts facts{.accepts = Assignment::clipped};
};
struct NeedsStrictOrder : Nothing {
    static constexpr ApproximationFacts facts{.needs_ordering = OrderGuarantee::primitives};
};
struct NeedsCellOrder : Nothing {
    static constexpr ApproximationFacts facts{.needs_ordering = OrderGuarantee::cells};
};

struct SamplesWithoutHooks : ColorCube {
    static constexpr ApproximationFacts facts{
        .accepts = Assignment::unique, .needs_polygons = true, .stands_in = true, .samples_primitives = true};
};
struct SamplesThatAreShared : SampleSet<> {
    static constexpr ApproximationFacts facts{.needs_polygons = true, .stands_in = true, .samples_primitives = true};
};
struct SamplesWithMisspeltSize : SampleSet<> {
    void sample_size() const {}
};

static_assert(Approximation<SampleSet<>> && Approximation<SampleSet<ColorCube>> && SamplesPrimitives<SampleSet<>>);
static_assert(!Approximation<SamplesWithoutHooks> && !Approximation<SamplesThatAreShared> &&
              !Approximation<SamplesWithMisspeltSize>);
static_assert(Approximation<Exact> && Approximation<ColorCube> && Approximation<ColorCubeCluster<2>> &&
              Approximation<Nothing>);
static_assert(!Approximation<StandsInWithoutHooks>, "a flag makes its hooks required");
static_assert(!Approximation<BoundsErrorWithoutHook> && !Approximation<MisspeltLeastError>);
static_assert(!Approximation<CubeWithMisspeltFinish> && !Approximation<CubeWithMisspeltError>);
static_assert(!Approximation<CubeWithoutBound>);
static_assert(!Approximation<CubeWithMisspeltLaw> && !Approximation<CubeWithNumberForLaw> &&
              !Approximation<LawWithoutStandIns>);
static_assert(ProvidesAreaLaw<ColorCube> && !ProvidesAreaLaw<ColorCubeCluster<4>> && !ProvidesAreaLaw<Exact> &&
              detail::ProvidesAreaLawIfStated<Exact> && !detail::ProvidesAreaLawIfStated<CubeWithMisspeltLaw>);
static_assert(ExpectsError<ColorCube> && !ExpectsError<Exact> && !Approximation<CubeWithMisspeltExpectation>);
static_assert(Approximation<CubeThatDoesNotSay>, "without the flag the hook is not missed");
static_assert(!Approximation<PoolWithoutElement> && !Approximation<OwnsMemory> && !Approximation<Octree> &&
              !Approximation<int>);

// --- cost models -----------------------------------------------------------------------------------------------------

struct GoodCost {
    static constexpr const char* unit = "joules";
    static constexpr std::uint32_t file_tag = 1;
    float cost(const Work&) const { return 1; }
};
struct CostWithoutUnit {
    [[maybe_unused]] static constexpr std::uint32_t file_tag = 1;
    float cost(const Work&) const { return 1; }
};
struct CostWithoutTag {
    static constexpr const char* unit = "joules";
    float cost(const Work&) const { return 1; }
};
struct MisspeltCost : GoodCost {
    float cost() const { return 1; }
};
struct CostWithState : GoodCost {
    std::vector<float> table;
};

static_assert(CostModel<TriangleCount> && CostModel<MeasuredTime> && CostModel<GoodCost>);
static_assert(!CostModel<CostWithoutUnit> && !CostModel<CostWithoutTag> && !CostModel<MisspeltCost>);
static_assert(!CostModel<CostWithState> && !CostModel<ColorCube> && !CostModel<float>);

// --- what goes together ----------------------------------------------------------------------------------------------

static_assert(Composable<Octree, ColorCube, TriangleCount> &&
              Composable<SharedOctree, ColorCubeCluster<4>, MeasuredTime>);
static_assert(!Composable<ColorCube, Octree, TriangleCount>, "policies in the wrong places");
static_assert(AssignmentAgreed<SharedOctree, Exact> && !AssignmentAgreed<SharedOctree, UniqueOnly>);
static_assert(!Composable<SharedOctree, UniqueOnly, TriangleCount> && Composable<Octree, UniqueOnly, TriangleCount>);
static_assert(!Composable<Octree, ClippedOnly, TriangleCount> && !Composable<SharedOnly, ClippedOnly, TriangleCount>);
static_assert(OrderSufficient<Octree, NeedsCellOrder> && !OrderSufficient<GoodPartition, NeedsCellOrder>);
static_assert(!Composable<Octree, NeedsStrictOrder, TriangleCount> &&
              Composable<Ordered, NeedsStrictOrder, TriangleCount>);
static_assert(Composable<Octree, SampleSet<>, TriangleCount> && !AssignmentAgreed<SharedOctree, SampleSet<>> &&
                  !AssignmentAgreed<PolygonBsp, SampleSet<>>,
              "a primitive moves up whole, and is in one place");
static_assert(SpatialHierarchy<Octree, ColorCube, TriangleCount>::assignment == Assignment::unique);
static_assert(SpatialHierarchy<SharedOctree, ColorCube, TriangleCount>::assignment == Assignment::shared);
static_assert(SpatialHierarchy<Octree, ColorCube, TriangleCount>::ordering == OrderGuarantee::cells);
static_assert(SpatialHierarchy<PolygonBsp, Exact, TriangleCount>::assignment == Assignment::clipped);
static_assert(SpatialHierarchy<PolygonBsp, Exact, TriangleCount>::ordering == OrderGuarantee::primitives);
static_assert(SpatialHierarchy<PolygonBsp, ColorCube, TriangleCount>::ordering == OrderGuarantee::cells,
              "boxes of cells overlap, and a stand-in fills its box");

// --- drawing ---------------------------------------------------------------------------------------------------------

using ExactHierarchy = SpatialHierarchy<Octree, Exact, TriangleCount>;
using Cubes = SpatialHierarchy<Octree, ColorCube, TriangleCount>;
using Plain = BasicRecorder<RendererFacts{}>;
using Strict =
    BasicRecorder<RendererFacts{.order = VisitOrder::front_to_back, .needs_ordering = OrderGuarantee::primitives}>;
using CellOrder = BasicRecorder<RendererFacts{
    .order = VisitOrder::front_to_back, .needs_ordering = OrderGuarantee::cells, .draws_faces = true}>;

static_assert(DrawableWith<ExactHierarchy, Triangle, ZBufferRenderer> &&
              DrawableWith<Cubes, Triangle, ZBufferRenderer>);
static_assert(DrawableWith<ExactHierarchy, Triangle, Plain>);
static_assert(!DrawableWith<Cubes, Triangle, Plain>, "a renderer without faces cannot draw color cubes");
static_assert(detail::DrawsStandInsIfAny<Plain, Exact> && !detail::DrawsStandInsIfAny<Plain, ColorCube>);
static_assert(DrawableWith<Cubes, Triangle, CellOrder>);
static_assert(!DrawableWith<ExactHierarchy, Triangle, Strict>, "octree cells are unordered inside");
using OrderedSamples = SpatialHierarchy<Ordered, SampleSet<>, TriangleCount>;
static_assert(OrderedSamples::ordering == OrderGuarantee::none && !OrderGoodEnough<CellOrder, OrderedSamples> &&
                  !DrawableWith<OrderedSamples, Triangle, CellOrder>,
              "samples that moved up lie among what is below them, whatever order the partition keeps");
static_assert(DrawableWith<SpatialHierarchy<Ordered, Exact, TriangleCount>, Triangle, Strict>);
static_assert(DrawableWith<SpatialHierarchy<PolygonBsp, Exact, TriangleCount>, Triangle, Strict> &&
              !DrawableWith<SpatialHierarchy<PolygonBsp, ColorCube, TriangleCount>, Triangle, Strict>);

struct BoxOnly {
    Box box;
    Box bounds() const { return box; }
};
static_assert(BuildableFrom<ExactHierarchy, BoxOnly> &&
                  !BuildableFrom<SpatialHierarchy<PolygonBsp, Exact, TriangleCount>, BoxOnly>,
              "there is nothing to cut");
static_assert(!DrawableWith<SpatialHierarchy<GoodPartition, Exact, TriangleCount>, Triangle, CellOrder>);
static_assert(traversal_order<ExactHierarchy, Plain> == VisitOrder::any);
static_assert(traversal_order<ExactHierarchy, Strict> == VisitOrder::front_to_back);
static_assert(traversal_order<Cubes, BackToFrontRecorder> == VisitOrder::front_to_back);
static_assert(traversal_order<ExactHierarchy, BackToFrontRecorder> == VisitOrder::back_to_front);

}  // namespace

TEST_CASE("a partition that never splits is a hierarchy of one cell") {
    const std::vector<Triangle> triangles(500);
    const auto h = build<SpatialHierarchy<GoodPartition, Exact, GoodCost>>(triangles);
    CHECK(h.nodes().size() == 1);
    CHECK(h.item_count() == 500);
    CHECK(h.report().leaves == 1);
}
