#include "farfield/frame/draw_queue.hpp"

#include <vector>

#include "catch.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/primitive/triangle.hpp"
#include "support/views.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

/// Writes down calls, one after the other.
struct Log {
    struct Call {
        enum { ranges, faces, splats, view } what;
        std::vector<Range> drawn{};
        std::vector<std::uint8_t> marks{};  ///< of faces their side, of splats their alpha
        float eye = 0;
    };
    std::vector<Call> calls;

    void begin_frame(const LocalView&) {}
    void end_frame() {}
    void set_view(const LocalView& v) { calls.push_back({Call::view, {}, {}, v.eye.x}); }
    template <class P>
    void draw(const Source<P>&, std::span<const Range> ranges) {
        calls.push_back({Call::ranges, {ranges.begin(), ranges.end()}, {}, 0});
    }
    void draw(std::span<const Face> faces) {
        calls.push_back({Call::faces, {}, {}, 0});
        for (const Face& f : faces) calls.back().marks.push_back(f.side);
    }
    void draw(std::span<const Splat> splats) {
        calls.push_back({Call::splats, {}, {}, 0});
        for (const Splat& s : splats) calls.back().marks.push_back(s.rgb.a);
    }
    float largest_splat_px() const { return 3; }
};
template <RendererFacts stated>
struct Logging : Log {
    static constexpr RendererFacts facts = stated;
};
using AnyOrder = Logging<RendererFacts{.draws_faces = true, .draws_splats = true}>;
using FrontToBack =
    Logging<RendererFacts{.order = VisitOrder::front_to_back, .draws_faces = true, .draws_splats = true}>;
using Deferring = Logging<RendererFacts{.order = VisitOrder::back_to_front,
                                        .far_field_order = VisitOrder::back_to_front,
                                        .draws_faces = true,
                                        .draws_splats = true}>;

const Source<Triangle> source{};

Face face(std::uint8_t mark) {
    return {{}, {}, {}, mark};
}
Splat splat(std::uint8_t mark) {
    return {{}, {1, 1}, 1, {0, 0, 0, mark}};
}
LocalView view(double eye_x) {
    return LocalView(looking({eye_x, 0, 5}, {eye_x, 0, 0}), glm::dvec3(0), 1);
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> places(const Log::Call& call) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
    for (const Range& r : call.drawn) out.emplace_back(r.first, r.first + r.count);
    return out;
}
using Places = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

template <class R>
struct Queue {
    R renderer;
    FrameStats stats{};
    DrawQueue<R> queue{renderer, stats};

    Queue() { queue.begin_frame(); }
    Queue(const Queue&) = delete;
    void run(std::uint32_t first, std::uint32_t end, std::optional<AreaLaw> law = {}) {
        queue.add_run(source, first, end, law);
    }
    const std::vector<Log::Call>& flushed() {
        queue.flush(source);
        return renderer.calls;
    }
};

}  // namespace

TEST_CASE("nothing comes of nothing") {
    Queue<AnyOrder> q;
    q.run(5, 5);
    CHECK(q.flushed().empty());
    CHECK((q.stats.primitives == 0 && q.stats.runs == 0));
}

TEST_CASE("runs that follow one another are one, and where order does not matter all that touch are") {
    Queue<AnyOrder> q;
    q.run(10, 20);
    q.run(20, 25);
    q.run(40, 50);
    q.run(0, 10);
    q.run(30, 40);
    REQUIRE(q.flushed().size() == 1);
    CHECK(places(q.renderer.calls[0]) == Places{{0, 25}, {30, 50}});
    CHECK(q.stats.primitives == 45);
    CHECK(q.stats.runs == 2);
    CHECK(q.flushed().size() == 1);  // nothing waits any more
}

TEST_CASE("a renderer that wants an order gets it") {
    Queue<FrontToBack> q;
    q.run(40, 50);
    q.run(0, 10);
    q.run(10, 12);
    q.run(30, 40);
    REQUIRE(q.flushed().size() == 1);
    CHECK(places(q.renderer.calls[0]) == Places{{40, 50}, {0, 12}, {30, 40}});
    CHECK(q.stats.runs == 3);
}

TEST_CASE("runs with a law keep their order, and each stays one of its own") {
    Queue<AnyOrder> q;
    q.run(40, 50, AreaLaw::coherent);
    q.run(0, 10, AreaLaw::coherent);
    q.run(10, 20, AreaLaw::independent);
    q.run(20, 30, AreaLaw::independent);
    q.run(30, 35);
    REQUIRE(q.flushed().size() == 1);
    CHECK(places(q.renderer.calls[0]) == Places{{40, 50}, {0, 10}, {10, 20}, {20, 30}, {30, 35}});
    CHECK(q.renderer.calls[0].drawn[0].law == AreaLaw::coherent);
    CHECK(q.renderer.calls[0].drawn[2].law == AreaLaw::independent);
    CHECK(q.renderer.calls[0].drawn[3].law == AreaLaw::independent);
    CHECK_FALSE(q.renderer.calls[0].drawn[4].law);
    // The next batch has none with a law, and is put in order again.
    q.run(40, 50);
    q.run(0, 10);
    REQUIRE(q.flushed().size() == 2);
    CHECK(places(q.renderer.calls[1]) == Places{{0, 10}, {40, 50}});
}

TEST_CASE("runs and stand-ins keep their order among one another, with a law and without") {
    Queue<AnyOrder> q;
    q.run(0, 10);
    q.queue.add(source, face(1));
    q.run(20, 30);
    REQUIRE(q.flushed().size() == 3);
    CHECK(places(q.renderer.calls[0]) == Places{{0, 10}});
    CHECK(q.renderer.calls[1].what == Log::Call::faces);
    CHECK(places(q.renderer.calls[2]) == Places{{20, 30}});
    q.renderer.calls.clear();
    q.queue.add(source, face(2));
    q.run(40, 50, AreaLaw::mixed);
    q.queue.add(source, splat(3));
    q.run(60, 70, AreaLaw::mixed);
    REQUIRE(q.flushed().size() == 4);
    CHECK(q.renderer.calls[0].what == Log::Call::faces);
    CHECK(q.renderer.calls[1].what == Log::Call::ranges);
    CHECK(q.renderer.calls[2].what == Log::Call::splats);
    CHECK(places(q.renderer.calls[3]) == Places{{60, 70}});
}

TEST_CASE("faces and splats keep their order among one another") {
    Queue<AnyOrder> q;
    q.queue.add(source, face(1));
    q.queue.add(source, face(2));
    q.queue.add(source, splat(3));
    q.queue.add(source, face(4));
    REQUIRE(q.flushed().size() == 3);
    CHECK(q.renderer.calls[0].marks == std::vector<std::uint8_t>{1, 2});
    CHECK(q.renderer.calls[1].marks == std::vector<std::uint8_t>{3});
    CHECK(q.renderer.calls[2].marks == std::vector<std::uint8_t>{4});
    CHECK((q.stats.faces == 3 && q.stats.splats == 1));
    CHECK(q.queue.splat_limit_px() == 3);
}

TEST_CASE("batches are handed over when they are full, and nothing is lost") {
    Queue<FrontToBack> q;
    std::vector<std::uint8_t> marks;
    for (std::uint32_t i = 0; i < 1000; ++i) {
        q.run(10 * i, 10 * i + 1);
        q.queue.add(source, face(std::uint8_t(i)));
        marks.push_back(std::uint8_t(i));
    }
    const auto before = q.renderer.calls.size();
    CHECK(before > 2);
    std::uint32_t next = 0;
    std::vector<std::uint8_t> drawn;
    for (const Log::Call& call : q.flushed()) {
        CHECK(std::max(call.drawn.size(), call.marks.size()) <= 256);
        for (const Range& r : call.drawn) CHECK(r.first == 10 * next++);
        drawn.insert(drawn.end(), call.marks.begin(), call.marks.end());
    }
    CHECK(next == 1000);
    CHECK(drawn == marks);
    CHECK(q.stats.runs == 1000);
}

TEST_CASE("stand-ins for who blends back to front come after all, reversed, each in its view") {
    Queue<Deferring> q;
    CHECK(q.queue.splat_limit_px() == 0);
    q.queue.set_view(view(1));
    for (int i = 0; i < 300; ++i) q.queue.add(source, face(std::uint8_t(i % 200)));
    q.run(0, 5);
    q.queue.flush(source);
    q.queue.set_view(view(2));
    q.queue.add(source, face(201));
    q.queue.add(source, face(202));
    q.run(5, 7);
    q.flushed();
    // So far only views and geometry.
    REQUIRE(q.renderer.calls.size() == 4);
    for (const Log::Call& call : q.renderer.calls) CHECK(call.marks.empty());
    q.queue.replay();
    std::vector<std::uint8_t> marks, expected{202, 201};
    for (int i = 300; i-- > 0;) expected.push_back(std::uint8_t(i % 200));
    float eye = 0;
    for (std::size_t i = 4; i < q.renderer.calls.size(); ++i) {
        const Log::Call& call = q.renderer.calls[i];
        if (call.what == Log::Call::view) eye = call.eye;
        for (const std::uint8_t mark : call.marks) {
            CHECK(eye == (mark > 200 ? 2.0f : 1.0f));
            marks.push_back(mark);
        }
    }
    CHECK(marks == expected);
    CHECK(q.stats.faces == 302);
    // The next frame knows nothing of them.
    q.renderer.calls.clear();
    q.queue.begin_frame();
    q.queue.replay();
    CHECK(q.renderer.calls.empty());
}

namespace {
/// A policy whose stand-ins wait as one word, a mark.
struct Marks {
    void place(const std::uint8_t& mark, const Cell&, std::uint32_t* words) const { words[0] = mark; }
    template <class Sink>
    void draw_placed(const std::uint32_t* words, std::size_t count, const LocalView&, Sink&& sink) const {
        for (std::size_t i = 0; i < count; ++i) {
            if (words[i] != 0) sink(splat(std::uint8_t(words[i])));  // 0 draws nothing
        }
    }
};
}  // namespace

TEST_CASE("stand-ins that wait for others keep their place among splats, faces and runs", "[frame]") {
    Queue<AnyOrder> q;
    const Marks one, other;
    const LocalView from = view(0);
    const auto place = [&](const Marks& policy, std::uint8_t mark) {
        q.queue.add_placed(source, from, policy, mark, Cell{});
    };
    place(one, 1);
    place(one, 0);
    place(one, 2);
    place(other, 3);  // another policy's
    q.queue.add(source, splat(4));
    place(one, 5);
    q.queue.add(source, face(6));
    place(one, 7);
    q.run(0, 2);
    q.run(5, 6, AreaLaw::mixed);
    place(one, 8);
    const auto& calls = q.flushed();
    std::vector<std::vector<std::uint8_t>> marks;
    for (const Log::Call& c : calls) {
        if (c.what != Log::Call::ranges) marks.push_back(c.marks);
    }
    CHECK(marks == std::vector<std::vector<std::uint8_t>>{{1, 2}, {3}, {4}, {5}, {6}, {7}, {8}});
    CHECK(q.stats.splats == 7);
    CHECK(q.stats.faces == 1);
}

TEST_CASE("as many stand-ins wait as splats would", "[frame]") {
    Queue<AnyOrder> q;
    const Marks policy;
    const LocalView from = view(0);
    for (int i = 0; i < 600; ++i) q.queue.add_placed(source, from, policy, std::uint8_t(1 + i % 255), Cell{});
    const auto& calls = q.flushed();
    REQUIRE(calls.size() == 3);
    int at = 0;
    for (const Log::Call& c : calls) {
        for (const std::uint8_t mark : c.marks) CHECK(mark == 1 + at++ % 255);
    }
    CHECK(at == 600);
}

namespace {
/// Takes tensors as they are stored, if it is told to.
struct TakesPlaced : Log {
    static constexpr RendererFacts facts{.draws_faces = true, .draws_splats = true, .shapes_stand_ins = true};
    using Log::draw;
    void draw(const PlacedStandIns& p) {
        for (std::size_t i = 0; i < p.count; ++i) placed.push_back(p.words[2 * PlacedStandIns::stride + i]);
        gain = p.sheet_gain;
    }
    bool shapes_stand_ins() const { return shapes; }
    bool shapes = true;
    std::vector<std::uint32_t> placed;  ///< the third words
    float gain = 0;
};
}  // namespace

TEST_CASE("stand-ins come as they are stored to a renderer that shapes them", "[frame]") {
    const OpacityTensor policy{.sheet_gain = 1.25f};
    TensorShape shape;
    shape.root = {1, 0, 0, 1, 0, 1};
    shape.extent = glm::vec3(1);
    StoredTensor tensor = StoredTensor::packed(shape);
    const Cell cell{{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {1, 1, 1}};
    const LocalView from = view(0);
    for (const bool shapes : {true, false}) {
        Queue<TakesPlaced> q;
        q.renderer.shapes = shapes;
        for (int i = 0; i < 300; ++i) q.queue.add_placed(source, from, policy, tensor, cell);
        q.queue.flush(source);
        CHECK(q.stats.splats == 300);
        if (shapes) {
            CHECK(q.renderer.calls.empty());
            CHECK(q.renderer.placed == std::vector<std::uint32_t>(300, std::uint32_t(tensor.second)));
            CHECK(q.renderer.gain == 1.25f);
        } else {
            CHECK(q.renderer.calls.size() == 2);
            CHECK(q.renderer.placed.empty());
        }
    }
}
