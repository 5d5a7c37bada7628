#include "farfield/storage/file_format.hpp"

#include <bit>

#include "catch.hpp"
#include "farfield/storage/save.hpp"
#include "files.hpp"

using namespace farfield;
using namespace farfield::detail;

namespace {

struct NotTagged {
    struct stand_in_data {};
    static constexpr ApproximationFacts facts{};
};
struct PaddedRecords {
    struct stand_in_data {
        std::uint8_t a;
        std::uint32_t b;
    };
    static constexpr ApproximationFacts facts{.file_tag = 1};
};
struct UncheckedPool {
    struct stand_in_data {};
    static constexpr ApproximationFacts facts{.has_pool = true, .file_tag = 1};
};
struct NotTaggedCost {
    static constexpr const char* unit = "units";
    static constexpr std::uint32_t file_tag = 0;
    float cost(const Work&) const { return 1; }
};

}  // namespace

TEST_CASE("what can be stored is stated by concepts") {
    STATIC_REQUIRE(Storable<OctreeOfCubes>);
    STATIC_REQUIRE(Storable<OctreeOfTensors>);
    STATIC_REQUIRE(Storable<ExactSharedOctree>);
    STATIC_REQUIRE(Storable<HalvesOfPooledCubes>);
    STATIC_REQUIRE_FALSE(StorableApproximation<NotTagged>);
    STATIC_REQUIRE_FALSE(StorableApproximation<PaddedRecords>);
    STATIC_REQUIRE_FALSE(StorableApproximation<UncheckedPool>);
    STATIC_REQUIRE_FALSE(StorablePartition<BasicHalfSplit<false>>);
    STATIC_REQUIRE_FALSE(StorableCostModel<NotTaggedCost>);
    STATIC_REQUIRE_FALSE(Storable<SpatialHierarchy<Octree, NotTagged, TriangleCount>>);
}

// Byte by byte: whoever makes this test fail makes a new version of the format.
TEST_CASE("version 5 lies in files like this") {
    HierarchyData<Octree, ColorCube> parts;
    parts.nodes = {Node{1, 0, 1, 0b101, 0b100, 1, 0}, Node{0, 1, 0, 0, 0, 255, 0}, Node{0, 2, 0, 0, 0, 0, 0}};
    parts.stand_ins = {ColorCube::stand_in_data{Rgba8{1, 2, 3, 4}}, ColorCube::stand_in_data{Rgba8{5, 6, 7, 8}}};
    parts.order = {2, 0, 1};
    parts.facts.root_has_stand_in = 1;
    parts.facts.baked_light = BakedLight::directional;
    parts.facts.light = {{7, 8, 9}, 0.25f, 0.5f};
    parts.facts.bounds = {{-1, -2, -3}, {1, 2, 3}};
    parts.facts.root = {{0, 0, 0}, {3, 3, 3}, {0, 0, 0}, {6, 6, 6}, 0, 0};
    parts.facts.origin = {100, 200, 300};
    parts.facts.work.triangles = 3;
    parts.facts.primitive_count = 3;
    parts.facts.fingerprint = 0x1122334455667788u;
    parts.facts.report.primitives = 3;
    parts.facts.report.items = 3;
    parts.facts.report.polygons = 14;
    parts.facts.report.pieces = 15;
    parts.facts.report.nodes = 3;
    parts.facts.report.polygons_joined = 11;
    parts.facts.report.polygons_without_area = 12;
    parts.facts.report.cells_out_of_order = 13;
    const OctreeOfCubes h(Octree{.max_depth = 9}, ColorCube{.samples = 5, .inner = ColorCube::Inner::direct},
                          TriangleCount{}, parts);
    const TemporaryDirectory directory;
    save(h, directory / "h");
    const Bytes bytes = read_file(directory / "h");

    const auto at = [&]<class T>(std::size_t offset, T) {
        T v;
        std::memcpy(&v, &bytes.at(offset + sizeof v - 1) - (sizeof v - 1), sizeof v);
        return v;
    };
    const std::uint16_t u16 = 0;
    const std::uint32_t u32 = 0;
    const std::uint64_t u64 = 0;
    REQUIRE(std::endian::native == std::endian::little);
    CHECK(std::memcmp(bytes.data(),
                      "\x89"
                      "FFH\r\n\x1a\n",
                      8) == 0);
    CHECK(at(8, u32) == 5);
    CHECK(at(12, u32) == 0x01020304);
    CHECK(at(16, u32) == 664);
    CHECK(at(20, u32) == Octree::facts.file_tag);
    CHECK(at(24, u32) == ColorCube::facts.file_tag);
    CHECK(at(28, u32) == TriangleCount::file_tag);
    CHECK(at(32, u64) == bytes.size());
    const std::uint64_t expected[11][3] = {{704, 1, 8},  {768, 1, 15},  {832, 1, 24}, {896, 3, 16},
                                           {960, 0, 0},  {960, 2, 24},  {1024, 0, 0}, {1024, 3, 4},
                                           {1088, 0, 4}, {1088, 0, 12}, {1088, 0, 4}};
    for (std::size_t s = 0; s < 11; ++s) {
        INFO(section_names[s]);
        for (std::size_t i = 0; i < 3; ++i) CHECK(at(40 + 32 * s + 8 * i, u64) == expected[s][i]);
        // Beyond the end there is nothing to hash.
        const auto all = std::as_bytes(std::span(bytes));
        const std::uint64_t size = expected[s][1] * expected[s][2];
        CHECK(at(64 + 32 * s, u64) == Xxh64::of(size != 0 ? all.subspan(expected[s][0], size) : all.first(0)));
    }
    CHECK(at(392, 0.0) == 100);
    CHECK(at(400, 0.0) == 200);
    CHECK(at(408, 0.0) == 300);
    CHECK(at(416, u64) == 3);
    CHECK(at(424, u64) == 0x1122334455667788u);
    CHECK(at(432, u64) == 3);
    CHECK(at(440, u64) == 3);
    CHECK(at(448, u64) == 14);
    CHECK(at(456, u64) == 15);
    CHECK(at(464, u32) == 3);
    CHECK(at(504, u32) == 11);
    CHECK(at(508, u32) == 12);
    CHECK(at(512, u32) == 13);
    CHECK(at(516, u32) == 0);
    CHECK(at(520, 0.0f) == -1);
    CHECK(at(540, 0.0f) == 3);
    CHECK(at(556, 0.0f) == 3);
    CHECK(at(580, 0.0f) == 6);
    CHECK(at(596, 0.0f) == 3);
    CHECK(at(624, u32) == 1);
    CHECK(at(628, u32) == 2);
    CHECK(at(632, 0.0f) == 7);
    CHECK(at(636, 0.0f) == 8);
    CHECK(at(640, 0.0f) == 9);
    CHECK(at(644, 0.0f) == 0.25f);
    CHECK(at(648, 0.0f) == 0.5f);
    CHECK(at(652, u32) == 0);
    CHECK(at(656, u64) == Xxh64::of(std::as_bytes(std::span(bytes)).first(656)));
    CHECK(at(704, u32) == 9);
    CHECK(at(768, u32) == 5);
    CHECK(bytes[772] == 1);
    CHECK(at(896, u32) == 1);
    CHECK(bytes[908] == 0b101);
    CHECK(at(984, u16) == 0x0605);
    CHECK(at(1024, u32) == 2);
    CHECK(bytes.size() == 1036);
}
