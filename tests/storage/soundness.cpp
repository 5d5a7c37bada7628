#include "farfield/storage/soundness.hpp"

#include <cstddef>
#include <limits>

#include "catch.hpp"
#include "farfield/storage/open.hpp"
#include "farfield/storage/save.hpp"
#include "files.hpp"

using namespace farfield;
using namespace farfield::detail;

namespace {

// Root, two children, of which the second has three.
const std::vector<Node> good_nodes{
    {.first_child = 1, .first_child_data = 1, .child_mask = 0b1001, .stand_in_mask = 0b1000},
    {.first_item = 2},
    {.first_child = 3, .first_item = 5, .first_child_data = 2, .child_mask = 0b111, .stand_in_mask = 0b101},
    {.first_item = 5},
    {.first_item = 7},
    {.first_item = 7}};
constexpr std::uint32_t good_items = 9;
constexpr std::uint64_t good_stand_ins = 4;

template <class Change>
std::string changed(Change&& change) {
    std::vector<Node> nodes = good_nodes;
    change(nodes);
    const char* why = unsound_nodes(nodes, good_items, good_stand_ins, true);
    return why ? why : "";
}

// Draws whatever opens; whoever reads outside of a span is stopped where assertions are on.
template <class H>
bool opens_and_draws(const std::filesystem::path& path, const std::vector<Triangle>& triangles, bool verify) {
    try {
        const H opened = open<H>(path, {.verify_checksums = verify});
        pictures(opened, triangles, 16);
        return true;
    } catch (const std::runtime_error&) {
        return false;
    } catch (const std::invalid_argument&) {  // the Viewer: other primitives
        return false;
    }
}

struct Damage {
    Bytes bytes;
    FileHeader header = header_of(bytes);

    char& at(Section s, std::size_t byte) { return bytes[header.sections[std::size_t(s)].offset + byte]; }
};

}  // namespace

TEST_CASE("nodes that lead somewhere else are found") {
    CHECK(changed([](auto&) {}).empty());
    CHECK(changed([](auto& n) { n.clear(); }) == "it has no root");
    CHECK(changed([](auto& n) { n[0].first_item = 1; }) == "the root's items do not start at 0");
    CHECK(changed([](auto& n) { n[0].first_child = 0; }) == "nodes are out of order");
    CHECK(changed([](auto& n) { n[2].first_child = 1; }) == "nodes are out of order");
    CHECK(changed([](auto& n) { n[2].first_child = 0xffffffffu; }) == "nodes are out of order");
    CHECK(changed([](auto& n) { n[1] = {1, 2, 0, 0b11, 0, 0, 0}; }) == "nodes are out of order");
    CHECK(changed([](auto& n) { n[2].child_mask = 0b1111; }) == "a node's child does not exist");
    CHECK(changed([](auto& n) { n[2].child_mask = 0b101; }) == "it has nodes without a parent");
    CHECK(changed([](auto& n) { n.pop_back(); }) == "a node's child does not exist");
    CHECK(changed([](auto& n) { n.emplace_back(); }) == "it has nodes without a parent");
    CHECK(changed([](auto& n) { n[1].first_item = 6; }) == "a node's items are out of order");
    CHECK(changed([](auto& n) { n[5].first_item = 10; }) == "a node's items are out of order");
    CHECK(changed([](auto& n) { n[4].first_item = 4; }) == "a node's items are out of order");
    CHECK(changed([](auto& n) { n[0].stand_in_mask = 0b100; }) == "a stand-in belongs to a child that does not exist");
    CHECK(changed([](auto& n) { n[0].first_child_data = 0; }) == "stand-ins are out of order");
    CHECK(changed([](auto& n) { n[2].first_child_data = 3; }) == "stand-ins are out of order");
    CHECK(changed([](auto& n) { n[2].stand_in_mask = 0b111; }) == "a node's stand-in does not exist");
    CHECK(changed([](auto& n) { n[2].stand_in_mask = 0b001; }) == "it has stand-ins that belong to no node");
    CHECK(unsound_nodes(std::vector<Node>(1), 0, 0, true) == std::string("the root's stand-in is missing"));
}

TEST_CASE("the last item, level and node that may be are sound, and one more is not") {
    CHECK(changed([](auto& n) { n[5].first_item = good_items; }).empty());
    CHECK(changed([](auto& n) { n[5].first_item = good_items + 1; }) == "a node's items are out of order");
    CHECK(changed([](auto& n) { n[0].levels_replaced = 1; }).empty());
    CHECK(changed([](auto& n) { n[0].levels_replaced = 2; }) == "a stand-in replaces more than one level");
    CHECK(changed([](auto& n) { n[5].levels_replaced = 255; }) == "a stand-in replaces more than one level");

    std::vector<Node> chain;
    for (std::uint32_t i = 1; i <= most_levels_in_files; ++i) chain.push_back({.first_child = i, .child_mask = 1});
    chain.back() = {};
    CHECK(unsound_nodes(chain, 0, 0, false) == nullptr);
    chain.back() = {.first_child = std::uint32_t(most_levels_in_files), .child_mask = 1};
    CHECK(unsound_nodes(chain, 0, 0, false) == std::string("a node's child does not exist"));
    chain.push_back({});
    CHECK(unsound_nodes(chain, 0, 0, false) == std::string("it has more than 1024 levels"));
}

TEST_CASE("what a builder makes is sound") {
    for (const std::size_t count : {0u, 1u, 7u, 5000u}) {
        for (unsigned seed = 1; seed < 4; ++seed) {
            const auto h = built<SharedOctreeOfCubes>(scene(count, seed));
            CHECK(unsound_nodes(h.nodes(), h.item_count(), h.stand_ins().size(), h.root_stand_in() != nullptr) ==
                  nullptr);
        }
    }
}

TEST_CASE("files whose checksums agree are not believed") {
    const TemporaryDirectory directory;
    save(built<HalvesOfPooledCubes>(scene(500)), directory / "h");
    const Bytes bytes = read_file(directory / "h");
    const auto why = [&](auto&& change) {
        Damage damage{bytes};
        change(damage);
        write_file(directory / "changed", sealed(damage.bytes, damage.header));
        return refusal(directory / "changed", [](auto& p) { open<HalvesOfPooledCubes>(p); });
    };
    using S = Section;
    const float infinity = std::numeric_limits<float>::infinity();
    CHECK(why([](Damage&) {}).empty());
    CHECK(why([](Damage& d) { d.at(S::partition_options, 4) = 2; }) ==
          "is damaged: an option is neither true nor false");
    CHECK(why([](Damage& d) { d.at(S::node_data, 0) = 3; }) == "is damaged: the partition refuses a node's data");
    CHECK(why([](Damage& d) { d.at(S::stand_ins, 3) = 1; }) == "is damaged: the approximation refuses a stand-in");
    CHECK(why([](Damage& d) { d.at(S::order, 3) = 1; }) ==
          "is damaged: its order names a primitive that does not exist");
    CHECK(why([](Damage& d) { d.at(S::nodes, 7) = 1; }) == "is damaged: the root's items do not start at 0");
    CHECK(why([](Damage& d) { d.header.facts.report.items -= 1; }) != "");
    CHECK(why([](Damage& d) { d.header.facts.report.items = 1ull << 32; }) ==
          "is damaged: it has more than 2^32 nodes or items");
    CHECK(why([](Damage& d) { d.header.facts.primitive_count -= 1; }) ==
          "is damaged: its order names a primitive that does not exist");
    CHECK(why([](Damage& d) { d.header.facts.root_has_stand_in = 2; }) == "is damaged: a flag has no known meaning");
    CHECK(why([](Damage& d) { d.header.facts.baked_light = BakedLight(3); }) ==
          "is damaged: the light of its stand-ins is none");
    CHECK(why([&](Damage& d) { d.header.facts.light.ambient = infinity; }) ==
          "is damaged: the light of its stand-ins is none");
    CHECK(why([](Damage& d) { d.header.facts.light.towards = glm::vec3(0); }) ==
          "is damaged: the light of its stand-ins is none");
    CHECK(why([](Damage& d) { d.header.facts.root_has_stand_in = 0; }) == "is damaged: stand-ins are out of order");
    CHECK(why([&](Damage& d) { d.header.facts.root.half.y = infinity; }) ==
          "is damaged: the root's cell is not finite");
    CHECK(why([&](Damage& d) { d.header.facts.root.center.x = infinity - infinity; }) ==
          "is damaged: the root's cell is not finite");
    CHECK(why([](Damage& d) { d.header.facts.root.bounds_half.z = -1; }) ==
          "is damaged: the root's cell has a negative size");
    CHECK(why([](Damage& d) { d.header.facts.root.depth = 1; }) == "is damaged: the root's depth is not 0");
    CHECK(why([&](Damage& d) { d.header.facts.bounds.upper.x = infinity; }) == "is damaged: its bounds are not finite");
    CHECK(why([](Damage& d) { d.header.header_bytes = 256; }) == "is damaged: its header has another size");
    for (std::size_t s = 0; s < section_count; ++s) {
        INFO(section_names[s]);
        for (const std::uint64_t count : {std::uint64_t(1) << 60, ~std::uint64_t(0), std::uint64_t(1) << 32}) {
            CHECK(why([&](Damage& d) { d.header.sections[s].count = count; }).rfind("is damaged: section ", 0) == 0);
            CHECK(why([&](Damage& d) { d.header.sections[s].offset = count; }).rfind("is damaged: section ", 0) == 0);
        }
        CHECK_FALSE(why([&](Damage& d) { d.header.sections[s].count += 1; }).empty());
        if (header_of(bytes).sections[s].count > 0) {
            CHECK_FALSE(why([&](Damage& d) { d.header.sections[s].count -= 1; }).empty());
        }
        CHECK_FALSE(why([&](Damage& d) { d.header.sections[s].offset += 64; }).empty());
    }
}

TEST_CASE("options that no build takes are refused, too") {
    const TemporaryDirectory directory;
    save(built<OctreeOfCubes>(scene(100)), directory / "h");
    const auto why = [&](auto&& change) {
        Damage damage{read_file(directory / "h")};
        change(damage);
        write_file(directory / "changed", sealed(damage.bytes, damage.header));
        return refusal(directory / "changed", [](auto& p) { open<OctreeOfCubes>(p); });
    };
    CHECK(why([](Damage& d) { d.at(Section::approximation_options, 0) = 77; }) ==
          "is damaged: ColorCube: samples must be at most 8");
    CHECK(why([](Damage& d) { d.at(Section::cost_options, 3) = char(0xff); }) ==
          "is damaged: TriangleCount: prices must be 0 or more and finite");
}

TEST_CASE("a stand-in whose approximation has no pool is refused too") {
    const TemporaryDirectory directory;
    const auto h = built<OctreeOfTensors>(scene(500));
    REQUIRE(h.stand_ins().size() > 1);
    save(h, directory / "h");
    Damage damage{read_file(directory / "h")};
    const std::size_t law = sizeof(StoredTensor) + offsetof(StoredTensor, second) + 6;  // the second one's: bits 54, 55
    damage.at(Section::stand_ins, law) = char(damage.at(Section::stand_ins, law) | 0xc0);
    write_file(directory / "changed", sealed(damage.bytes, damage.header));
    const std::string refused = "the approximation refuses a stand-in";
    CHECK(refusal(directory / "changed", [](auto& p) { open<OctreeOfTensors>(p); }) == "is damaged: " + refused);

    HierarchyData<Octree, OpacityTensor> data{.facts = h.facts()};
    const auto& arrays = h.arrays();
    data.nodes.assign(arrays.nodes.begin(), arrays.nodes.end());
    data.order.assign(arrays.order.begin(), arrays.order.end());
    data.stand_ins.assign(arrays.stand_ins.begin(), arrays.stand_ins.end());
    CHECK_NOTHROW(saved_size(OctreeOfTensors({}, {}, {}, data)));
    data.stand_ins[1].second |= std::uint64_t(3) << 54;
    CHECK_THROWS_WITH(saved_size(OctreeOfTensors({}, {}, {}, data)),
                      "farfield::save: memory: the hierarchy cannot be stored: " + refused);
}

TEMPLATE_TEST_CASE("whatever byte is changed, frames stay within the arrays", "", OctreeOfCubes, OctreeOfTensors,
                   ExactSharedOctree, HalvesOfPooledCubes, BspOfPooledCubes) {
    const TemporaryDirectory directory;
    const auto triangles = scene(60);
    save(built<TestType>(triangles), directory / "h");
    const Bytes bytes = read_file(directory / "h");
    std::mt19937 random(3);
    std::size_t opened = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        for (const int flip : {0xff, 1 << random() % 8}) {
            INFO("byte " << i << " ^ " << flip);
            Bytes changed = bytes;
            changed[i] = char(changed[i] ^ flip);
            write_file(directory / "changed", changed);
            opened += opens_and_draws<TestType>(directory / "changed", triangles, false);
            if (i + 8 >= sizeof(FileHeader) || i < 40) continue;
            write_file(directory / "changed", sealed(changed));
            opened += opens_and_draws<TestType>(directory / "changed", triangles, true);
        }
    }
    CHECK(opened > 0);  // colors, prices, the report
}

TEST_CASE("whatever bytes are changed together, frames stay within the arrays") {
    const TemporaryDirectory directory;
    const auto triangles = scene(60);
    save(built<OctreeOfCubes>(triangles), directory / "h");
    const Bytes bytes = read_file(directory / "h");
    const SectionEntry nodes = header_of(bytes).sections[std::size_t(Section::nodes)];
    std::mt19937 random(4);
    for (int round = 0; round < 3000; ++round) {
        Bytes changed = bytes;
        for (auto n = 1 + random() % 3; n > 0; --n) {
            changed[nodes.offset + random() % nodes.bytes()] = char(random() % 4 == 0 ? random() : random() % 8);
        }
        write_file(directory / "changed", sealed(changed));
        opens_and_draws<OctreeOfCubes>(directory / "changed", triangles, true);
    }
}

TEST_CASE("fragments that are none are found") {
    const std::vector<std::uint32_t> first{0, 3, 3, 7};
    const std::vector<glm::vec3> vertices(7);
    const std::vector<Rgba8> colors(7);
    const auto why = [&](auto&& change) {
        std::vector<std::uint32_t> f = first;
        std::vector<glm::vec3> v = vertices;
        std::vector<Rgba8> c = colors;
        change(f, v, c);
        const char* found = unsound_fragments({f, v, c}, 3);
        return std::string(found ? found : "");
    };
    CHECK(why([](auto&, auto&, auto&) {}).empty());
    CHECK(unsound_fragments({}, 0) == nullptr);
    CHECK(why([](auto& f, auto&, auto&) { f.clear(); }) == "its fragments are missing");
    CHECK(why([](auto& f, auto&, auto&) { f.pop_back(); }) == "it does not have as many fragments as items");
    CHECK(why([](auto& f, auto&, auto&) { f[0] = 1; }).rfind("its fragments do not have", 0) == 0);
    CHECK(why([](auto& f, auto&, auto&) { f[3] = 8; }).rfind("its fragments do not have", 0) == 0);
    CHECK(why([](auto&, auto& v, auto&) { v.pop_back(); }).rfind("its fragments do not have", 0) == 0);
    CHECK(why([](auto&, auto&, auto& c) { c.pop_back(); }).rfind("its fragments do not have", 0) == 0);
    CHECK(why([](auto& f, auto&, auto&) { f[1] = 4; }) == "its fragments are out of order");
    CHECK(why([](auto& f, auto&, auto&) { f[1] = 0xffffffffu; }) == "its fragments are out of order");
    CHECK(why([](auto& f, auto&, auto&) { f[1] = 2; }) == "a fragment has fewer than three vertices");
    CHECK(why([](auto&, auto& v, auto&) { v[2].y = std::numeric_limits<float>::quiet_NaN(); }) ==
          "a fragment's vertex is not finite");
}

TEST_CASE("as deep as a file may be, a frame ends") {
    const TemporaryDirectory directory;
    HierarchyData<Octree, Exact> parts;
    const auto triangles = scene(400);
    for (std::uint32_t i = 0; i < most_levels_in_files; ++i) {
        parts.nodes.push_back({.first_child = i + 1, .child_mask = 1});
    }
    parts.nodes.back() = {};
    for (std::uint32_t i = 0; i < triangles.size(); ++i) parts.order.push_back(i);
    parts.facts.root = {glm::vec3(0.5f), glm::vec3(0.5f), glm::vec3(0.5f), glm::vec3(1), 0, 0};
    parts.facts.bounds = {glm::vec3(0), glm::vec3(1)};
    parts.facts.primitive_count = parts.facts.report.items = triangles.size();
    parts.facts.fingerprint = fingerprint_of(std::span<const Triangle>(triangles));
    save(ExactOctree({}, {}, {}, parts), directory / "h");
    CHECK(opens_and_draws<ExactOctree>(directory / "h", triangles, true));
}
