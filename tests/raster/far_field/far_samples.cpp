// The far field against sixteen transmittances a sample in double precision, deposit by deposit.
#include "farfield/raster/far_field/far_samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

constexpr AreaLaw laws[] = {AreaLaw::independent, AreaLaw::mixed, AreaLaw::coherent};
constexpr float infinity = std::numeric_limits<float>::infinity();

struct Square {
    float left, top, right, bottom;
    Loss loss;
    glm::vec3 rgb{1};
    float q = 1;
};

Square square(float x, float y, float side, Loss loss) {
    return {x - side / 2, y - side / 2, x + side / 2, y + side / 2, loss};
}

/// As FarSamples without its roundings.
struct Model {
    static constexpr int side = lanes::side;
    int width, height;
    std::vector<double> t, color;

    Model(int w, int h)
        : width(w), height(h), t(std::size_t(w * h * side * side), 1.0), color(std::size_t(w * h), 0.0) {}

    double& lane(int x, int y) { return t[std::size_t(y * width * side + x)]; }
    double transmittance(int x, int y) {
        double sum = 0;
        for (int i = 0; i < side * side; ++i) sum += lane(x * side + i % side, y * side + i / side);
        return sum / (side * side);
    }
    static double overlap(double begin, double end, int at) {
        return std::clamp(end * side - at, 0.0, 1.0) - std::clamp(begin * side - at, 0.0, 1.0);
    }
    void deposit(const Square& s) {
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const double before = transmittance(x, y);
                if (before < double(closed_transmittance)) continue;
                for (int i = 0; i < side * side; ++i) {
                    const int lx = x * side + i % side, ly = y * side + i / side;
                    const double part =
                        overlap(double(s.left), double(s.right), lx) * overlap(double(s.top), double(s.bottom), ly);
                    double& left = lane(lx, ly);
                    left = std::max(
                        0.0, left - part * std::min(1.0, left * double(s.loss.relative) + double(s.loss.absolute)));
                }
                color[std::size_t(y * width + x)] += (before - transmittance(x, y)) * double(s.rgb.g);
            }
        }
    }
};

struct Canvas {
    int width, height;
    std::vector<float> depth;
    FarSamples far;

    Canvas(int w, int h) : width(w), height(h), depth(std::size_t(w * h), -infinity) {
        far.resize(w, h);
        far.begin();
    }
    /// What FarSamples asks of SampleBlocks.
    struct Depths {
        const std::vector<float>& of;
        int width;

        float depth(int x, int y) const { return of[std::size_t(y * width + x)]; }
        std::uint64_t farther(int x, int y, std::uint64_t wanted, float q) const {
            return farther_in(x, y, wanted, [q](int) { return q; });
        }
        template <class Depth>
        std::uint64_t farther_in_row(int x, int y, std::uint64_t wanted, const Depth& q) const {
            return farther_in(x, y & -8, wanted, q);
        }
        template <class Depth>
        std::uint64_t farther_in(int x, int y, std::uint64_t wanted, const Depth& q) const {
            std::uint64_t bits = 0;
            for (int i = 0; i < 64; ++i) {
                const std::uint64_t bit = std::uint64_t(1) << i;
                if ((wanted & bit) != 0 && !(q(x + i % 8) <= depth(x + i % 8, y + i / 8))) bits |= bit;
            }
            return bits;
        }
    };
    Depths depths() const { return {depth, width}; }
    void deposit(const Square& s) {
        far.deposit_square(depths(), s.left, s.top, s.right, s.bottom, s.q, s.loss, s.rgb);
    }
    FarSamples::Sample at(int x, int y) const {
        const FarSamples::Sample* s = far.over(-infinity, x, y);
        return s ? *s : FarSamples::Sample::fresh();
    }
    double taken() const {
        double sum = 0;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) sum += 1 - double(at(x, y).transmittance);
        }
        return sum;
    }
    bool is_untouched() const {
        int touched = 0;
        far.for_touched([&](int, int) { ++touched; });
        return touched == 0 && taken() == 0 && far.rect().is_empty();
    }
};

bool same(const FarSamples::Sample& a, const FarSamples::Sample& b) {
    return a.r == b.r && a.g == b.g && a.b == b.b && a.transmittance == b.transmittance;
}

}  // namespace

TEST_CASE("bits of a block are those of its samples inside a rectangle", "[raster]") {
    Random random(74);
    for (int i = 0; i < 20000; ++i) {
        const auto any = [&] { return int(random.below(40)) - 8; };
        const SampleRect r{any(), any(), any(), any()};
        const int x = 8 * int(random.below(3)), y = 8 * int(random.below(3));
        std::uint64_t inside = 0;
        for (int v = y; v < y + 8; ++v) {
            for (int u = x; u < x + 8; ++u) {
                if (u >= r.x0 && u < r.x1 && v >= r.y0 && v < r.y1) inside |= block_bits::of(u, v);
            }
        }
        REQUIRE(block_bits::inside(r, x, y) == inside);
    }
}

TEST_CASE("squares of any place and size leave what sixteen exact transmittances a sample do", "[raster]") {
    Random random(60);
    for (int round = 0; round < 60; ++round) {
        const AreaLaw law = laws[round % 3];
        const int width = 5 + round % 4, height = 7;
        Canvas canvas(width, height);
        Model model(width, height);
        const float largest = round % 2 ? 2.0f : 6.0f;
        for (int i = 0; i < 150; ++i) {
            const float alpha = random.unit(), side = largest * random.unit() * random.unit();
            Square s = square(random.between(-1, float(width) + 1), random.between(-1, float(height) + 1), side,
                              i % 2 ? loss_of_opacity(alpha, law) : loss_of_area(alpha, law));
            s.rgb.g = random.unit();
            canvas.deposit(s);
            model.deposit(s);
        }
        double transmittance = 0, color = 0;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const FarSamples::Sample got = canvas.at(x, y);
                transmittance =
                    std::max(transmittance, std::abs(double(got.transmittance) - model.transmittance(x, y)));
                color = std::max(color, std::abs(double(got.g) - model.color[std::size_t(y * width + x)]));
                // The whole of what was taken is colored.
                CHECK(std::abs(got.r + got.transmittance - 1) < 1e-5f);
                CHECK(canvas.far.is_open(x, y) == (got.transmittance > 0));
            }
        }
        INFO("law " << int(law) << ", sides up to " << largest);
        CHECK(transmittance < 1.0 / 500);
        CHECK(color < 1.0 / 500);
    }
}

TEST_CASE("eight lanes at a time compute the same bits as one", "[raster]") {
    namespace one = one_lane_at_a_time;
    namespace many = native_lanes;
    Random random(61);
    int checked = 0;
    for (int i = 0; i < 40000; ++i) {
        FarSample a = FarSample::fresh(), b;
        FarLanes a_lanes, b_lanes;
        for (std::uint16_t& t : a_lanes.lane) {
            const std::uint32_t kind = random.below(6);
            t = kind == 0 ? std::uint16_t(0) : kind == 1 ? std::uint16_t(65535) : std::uint16_t(random.bits());
            if (i % 5 == 0) t = std::uint16_t(t >> random.below(16));
        }
        a.transmittance = random.unit();
        b = a;
        b_lanes = a_lanes;
        const auto some = [&] {
            const float odd[] = {0, 1, 1e-5f, 7, infinity, -1, std::numeric_limits<float>::quiet_NaN()};
            return random.below(4) == 0 ? odd[random.below(7)] : random.unit();
        };
        const Loss loss{some(), some()};
        const glm::vec3 rgb(random.unit(), random.unit(), random.unit());
        const bool large = random.below(8) == 0;
        const int width = large ? 16000 : 9, height = large ? 16000 : 6;
        const float x = random.between(-3, float(width) + 2), y = random.between(-3, float(height) + 2);
        const float w = (large ? 5000 : 4) * some(), h = (large ? 5000 : 4) * some();
        const one::Square p(x, y, x + w, y + h, width, height);
        const many::Square q(x, y, x + w, y + h, width, height);
        REQUIRE(p.is_empty() == q.is_empty());
        if (p.is_empty()) continue;
        REQUIRE((p.x0 == q.x0 && p.y0 == q.y0 && p.x1 == q.x1 && p.y1 == q.y1));
        REQUIRE((p.x0 >= 0 && p.y0 >= 0 && p.x1 < width && p.y1 < height && p.x0 <= p.x1 && p.y0 <= p.y1));
        REQUIRE(p.is_small() == q.is_small());
        REQUIRE(p.starts_at_column() == q.starts_at_column());
        REQUIRE(p.starts_at_row() == q.starts_at_row());
        REQUIRE(p.ends_at_column() == q.ends_at_column());
        REQUIRE(p.ends_at_row() == q.ends_at_row());
        if (!p.is_small()) continue;
        ++checked;
        const int column = int(random.below(std::uint32_t(p.x1 - p.x0 + 1))),
                  row = int(random.below(std::uint32_t(p.y1 - p.y0 + 1)));
        const bool closed = one::Deposit(loss, rgb).into(a, a_lanes, p.columns(column), p.rows(row));
        CHECK(closed == many::Deposit(loss, rgb).into(b, b_lanes, q.columns(column), q.rows(row)));
        CHECK(std::memcmp(&a, &b, sizeof a) == 0);
        CHECK(std::memcmp(&a_lanes, &b_lanes, sizeof a_lanes) == 0);
        int sum = 0;
        for (const std::uint16_t t : a_lanes.lane) sum += t;
        CHECK(a.transmittance == Approx(closed ? 0 : float(sum) / (65535.0f * 16)).margin(1e-6));
    }
    CHECK(checked > 10000);
}

TEST_CASE("a sample whose lanes are alike needs none of them", "[raster]") {
    namespace one = one_lane_at_a_time;
    namespace many = native_lanes;
    Random random(72);
    const one::Columns columns(0, lanes::sample_width);
    const one::Rows rows(0, lanes::sample_height);
    for (int i = 0; i < 3000; ++i) {
        FarSample a = FarSample::fresh(), b = a, c = a, d = a, e = a;
        FarLanes a_lanes, d_lanes, e_lanes;
        for (FarLanes* all : {&a_lanes, &d_lanes, &e_lanes}) all->fill(lanes::one);
        for (bool is_closed = false; !is_closed;) {
            const float part = random.unit() * (i % 2 ? 1.0f : 0.1f) + 1e-4f, relative = random.unit();
            const Loss loss{part * relative, part * (1 - relative)};
            const glm::vec3 rgb(random.unit(), random.unit(), random.unit());
            is_closed = one::Deposit(loss, rgb).into(a, a_lanes, columns, rows);
            REQUIRE(one::Deposit(loss, rgb).into(b) == is_closed);
            REQUIRE(many::Deposit(loss, rgb).into(c) == is_closed);
            REQUIRE(one::Deposit(loss, rgb).into(d, d_lanes) == is_closed);
            REQUIRE(many::Deposit(loss, rgb).into(e, e_lanes) == is_closed);
            REQUIRE(std::memcmp(&a, &b, sizeof a) == 0);
            REQUIRE(std::memcmp(&a, &c, sizeof a) == 0);
            REQUIRE(std::memcmp(&a, &d, sizeof a) == 0);
            REQUIRE(std::memcmp(&a, &e, sizeof a) == 0);
            REQUIRE(std::memcmp(&a_lanes, &d_lanes, sizeof a_lanes) == 0);
            REQUIRE(std::memcmp(&a_lanes, &e_lanes, sizeof a_lanes) == 0);
            if (!is_closed) REQUIRE(lane_of(a.transmittance) == int(a_lanes.lane[0]));
        }
    }
}

TEST_CASE("large squares leave what their samples, deposited one by one, do", "[raster]") {
    Random random(73);
    for (int round = 0; round < 60; ++round) {
        const int width = 150, height = 40;
        // The second is a part of a larger picture.
        Canvas whole(width, height), one_by_one(width, height), part(70, 30);
        const int left = 50, top = 7;
        part.far.place(left, top, width, height);
        for (int i = 0; i < width * height; ++i) {
            if (random.below(3) != 0 && round % 3 != 0) continue;
            whole.depth[std::size_t(i)] = one_by_one.depth[std::size_t(i)] = random.unit();
            const int x = i % width - left, y = i / width - top;
            if (x >= 0 && y >= 0 && x < 70 && y < 30) {
                part.depth[std::size_t(y * 70 + x)] = whole.depth[std::size_t(i)];
            }
        }
        for (int i = 0; i < 12; ++i) {
            const float x = random.between(-40, 150), y = random.between(-30, 40);
            Square s{x, y, x + 100 * random.unit() * random.unit(), y + 80 * random.unit() * random.unit(),
                     loss_of_opacity(random.unit() * 0.6f, laws[random.below(3)])};
            if (random.below(3) == 0) s.left = std::floor(s.left), s.bottom = std::floor(s.bottom);
            s.rgb = {random.unit(), random.unit(), random.unit()};
            s.q = 1 - float(i) / 12;
            whole.deposit(s);
            part.deposit(s);
            for (int v = 0; v < height; ++v) {
                for (int u = 0; u < width; ++u) {
                    Square of = s;
                    of.left = std::max(s.left, float(u)), of.right = std::min(s.right, float(u + 1));
                    of.top = std::max(s.top, float(v)), of.bottom = std::min(s.bottom, float(v + 1));
                    one_by_one.deposit(of);
                }
            }
        }
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                REQUIRE(same(whole.at(x, y), one_by_one.at(x, y)));
                REQUIRE(whole.far.is_open(x, y) == one_by_one.far.is_open(x, y));
                float first = -infinity, first_of_one = -infinity;
                whole.far.raise_to_first(y, x, x + 1, &first);
                one_by_one.far.raise_to_first(y, x, x + 1, &first_of_one);
                REQUIRE(first == first_of_one);
                const int u = x - left, v = y - top;
                if (u >= 0 && v >= 0 && u < 70 && v < 30) REQUIRE(same(whole.at(x, y), part.at(u, v)));
            }
        }
    }
}

TEST_CASE("what is opaque covers once where it lies twice, and both halves where it lies in both", "[raster]") {
    for (const AreaLaw law : laws) {
        Canvas canvas(3, 3);
        const Loss opaque = loss_of_opacity(1, law);
        canvas.deposit({1, 1, 1.5f, 2, opaque});
        canvas.deposit({1, 1, 1.5f, 2, opaque});
        CHECK(canvas.at(1, 1).transmittance == Approx(0.5f).margin(1e-4));
        CHECK(canvas.far.is_open(1, 1));
        canvas.deposit({1.5f, 1, 2, 2, opaque});
        CHECK(canvas.at(1, 1).transmittance == 0);
        CHECK_FALSE(canvas.far.is_open(1, 1));
        CHECK(canvas.taken() == 1);
    }
}

TEST_CASE("squares that tile a picture close all of it", "[raster]") {
    Random random(62);
    for (int round = 0; round < 200; ++round) {
        const int width = 70, height = 20;
        Canvas canvas(width, height);
        const float side = round % 2 ? random.between(0.06f, 1) : random.between(1, 40);
        const float x0 = -random.unit() * side, y0 = -random.unit() * side;
        std::vector<Square> squares;
        const auto edge = [&](float from, int i) { return from + float(i) * side; };
        for (int y = 0; edge(y0, y) < float(height); ++y) {
            for (int x = 0; edge(x0, x) < float(width); ++x) {
                squares.push_back({edge(x0, x), edge(y0, y), edge(x0, x + 1), edge(y0, y + 1), {0, 1}});
            }
        }
        random.shuffle(squares);
        for (const Square& s : squares) canvas.deposit(s);
        INFO("squares of " << side);
        bool is_open = false;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) is_open |= canvas.far.is_open(x, y);
        }
        CHECK_FALSE(is_open);
        CHECK(canvas.taken() == width * height);
        double color = 0;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) color = std::max(color, std::abs(double(canvas.at(x, y).g) - 1));
        }
        CHECK(color < 1e-5);
    }
}

TEST_CASE("no sample is touched that is not covered", "[raster]") {
    // Edges on a border of samples, and so little beyond it that they are rounded to it.
    for (const float beyond : {0.0f, 1e-5f, 4e-4f}) {
        for (int i = 0; i < 16; ++i) {
            const auto edge = [&](float at, int bit, float outwards) { return i >> bit & 1 ? at + outwards : at; };
            Canvas canvas(5, 5);
            canvas.deposit({edge(1, 0, -beyond), edge(1, 1, -beyond), edge(3, 2, beyond), edge(3, 3, beyond), {0, 1}});
            int touched = 0;
            canvas.far.for_touched([&](int x, int y) {
                ++touched;
                CHECK((x >= 1 && x <= 2 && y >= 1 && y <= 2));
            });
            CHECK(touched == 4);
            CHECK(canvas.taken() == 4);
        }
    }
}

TEST_CASE("equal colors may come in any order", "[raster]") {
    Random random(63);
    for (int round = 0; round < 40; ++round) {
        const AreaLaw law = laws[round % 3];
        std::vector<Square> squares;
        for (int i = 0; i < 60; ++i) {
            squares.push_back(square(random.between(0, 6), random.between(0, 6), random.between(0.05f, 2),
                                     loss_of_opacity(random.unit(), law)));
        }
        Canvas a(6, 6), b(6, 6);
        for (const Square& s : squares) a.deposit(s);
        random.shuffle(squares);
        for (const Square& s : squares) b.deposit(s);
        double difference = 0;
        for (int i = 0; i < 36; ++i) {
            const FarSamples::Sample p = a.at(i % 6, i / 6), q = b.at(i % 6, i / 6);
            difference = std::max(difference, std::abs(double(p.transmittance) - double(q.transmittance)));
            difference = std::max(difference, std::abs(double(p.g) - double(q.g)));
        }
        INFO("law " << int(law));
        CHECK(difference < 1.0 / 255);
    }
}

TEST_CASE("a coherent square takes its area wherever it lies", "[raster]") {
    Random random(64);
    for (const float side : {0.02f, 0.1f, 0.3f, 0.8f, 1.5f, 2.0f, 5.0f, 33.0f}) {
        double taken = 0, each = 0;
        const int count = side < 0.05f ? 20000 : 400;
        Canvas canvas(36, 36);
        for (int i = 0; i < count; ++i) {
            canvas.far.clear();
            canvas.far.begin();
            canvas.deposit(square(random.between(17, 19), random.between(17, 19), side, {0, 1}));
            const double got = canvas.taken();
            taken += got;
            each = std::max(each, std::abs(got / double(side * side) - 1));
        }
        INFO("side " << side);
        CHECK(std::abs(taken / (count * double(side) * double(side)) - 1) < 0.002);
        CHECK(each < 0.003 / double(side) + 0.0025);
    }
}

TEST_CASE("many tiny deposits take as much as they should", "[raster]") {
    Random random(65);
    for (const AreaLaw law : laws) {
        for (const float area : {1e-3f, 1e-4f}) {
            for (const float alpha : {1.0f, 0.1f}) {
                const Loss loss = loss_of_opacity(alpha, law);
                Canvas canvas(3, 3);
                Model model(3, 3);
                for (float covered = 0; covered < 0.3f * 9; covered += area * alpha) {
                    const Square s =
                        square(random.between(0.1f, 2.9f), random.between(0.1f, 2.9f), std::sqrt(area), loss);
                    canvas.deposit(s);
                    model.deposit(s);
                }
                double taken = 9;
                for (int i = 0; i < 9; ++i) taken -= model.transmittance(i % 3, i / 3);
                INFO("law " << int(law) << ", area " << area << ", opacity " << alpha);
                CHECK(taken > 2);
                CHECK(std::abs(canvas.taken() / taken - 1) < 0.005);
            }
        }
    }
}

TEST_CASE("a row of whole samples is a square that covers them", "[raster]") {
    Random random(66);
    for (const AreaLaw law : laws) {
        Canvas row(30, 3), squares(30, 3);
        for (int i = 0; i < 200; ++i) {
            const int y = int(random.below(3)), begin = int(random.below(30)), end = begin + int(random.below(31)) % 9;
            if (end > 30 || begin == end) continue;
            const Loss loss = loss_of_opacity(random.unit() * 0.4f, law);
            const glm::vec3 rgb(random.unit(), random.unit(), random.unit());
            row.far.deposit_row(
                row.depths(), y, begin, end, [](int x) { return float(x); }, FarSamples::Deposit(loss, rgb));
            for (int x = begin; x < end; ++x) {
                squares.deposit({float(x), float(y), float(x + 1), float(y + 1), loss, rgb, float(x)});
            }
        }
        for (int i = 0; i < 90; ++i) CHECK(same(row.at(i % 30, i / 30), squares.at(i % 30, i / 30)));
    }
}

TEST_CASE("a square is cut off at the picture's borders, however large", "[raster]") {
    for (const float far : {60.0f, 1e6f, 1e30f, infinity}) {
        Canvas canvas(40, 23);
        canvas.deposit({-far, -far, far, far, {0, 0.25f}});
        for (int i = 0; i < 40 * 23; ++i) CHECK(canvas.at(i % 40, i / 40).transmittance == Approx(0.75f).margin(1e-4));
        canvas.deposit({-far, 22.5f, 0.5f, far, {0, 0.5f}});
        canvas.deposit({39.5f, -far, far, 0.5f, {0, 0.5f}});
        CHECK(canvas.at(0, 22).transmittance == Approx(0.625f).margin(1e-4));
        CHECK(canvas.at(39, 0).transmittance == Approx(0.625f).margin(1e-4));
        CHECK(canvas.taken() == Approx(40 * 23 * 0.25 + 0.25).margin(0.01));
    }
    Canvas canvas(40, 23);
    for (const float far : {41.0f, 1e6f, 1e30f}) {
        for (const float side : {0.5f, 1.0f}) {
            canvas.deposit(square(far, 3, side, {0, 1}));
            canvas.deposit(square(-far, 3, side, {0, 1}));
            canvas.deposit(square(3, far, side, {0, 1}));
            canvas.deposit(square(3, -far, side, {0, 1}));
        }
    }
    canvas.deposit({40, 0, 41, 23, {0, 1}});
    canvas.deposit({-1, 0, 0, 23, {0, 1}});
    canvas.deposit({0, -1, 40, 0, {0, 1}});
    canvas.deposit({0, 23, 40, 24, {0, 1}});
    canvas.deposit({3, 3, 3, 4, {0, 1}});
    CHECK(canvas.is_untouched());
}

TEST_CASE("odd numbers do no harm", "[raster]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    Canvas canvas(5, 4);
    for (const float odd : {nan, infinity, -infinity}) {
        for (int i = 0; i < 4; ++i) {
            float edge[4] = {1, 1, 3, 3};
            edge[i] = odd;
            canvas.deposit({edge[0], edge[1], edge[2], edge[3], {0.1f, 0}});
        }
        canvas.deposit({1, 1, 3, 3, {0.1f, 0}, glm::vec3(1), odd});
        canvas.deposit({0, 0, 1, 1, {odd, 0}});
        canvas.deposit({0, 0, 1, 1, {0, odd}});
    }
    for (int i = 0; i < 20; ++i) {
        const FarSamples::Sample s = canvas.at(i % 5, i / 5);
        CHECK((s.transmittance >= 0 && s.transmittance <= 1));
        CHECK((s.g >= 0 && s.g <= 1.0001f));
    }
}

TEST_CASE("nearer geometry keeps a deposit out, as if it had never come", "[raster]") {
    Canvas canvas(3, 1);
    canvas.depth[1] = 2;
    const Loss half = loss_of_opacity(0.5f, AreaLaw::coherent);
    canvas.deposit({0, 0, 3, 1, half, glm::vec3(1), 2});
    CHECK(canvas.far.over(1, 0, 0) != nullptr);
    CHECK(canvas.far.over(1, 1, 0) == nullptr);
    CHECK(canvas.far.is_open(0, 0));
    CHECK(canvas.far.is_open(1, 0));
    // Geometry drawn later hides what was deposited behind it, while more might come.
    CHECK(canvas.far.over(1.5f, 0, 0) != nullptr);
    CHECK(canvas.far.over(2, 0, 0) == nullptr);
    canvas.deposit({0, 0, 3, 1, half, glm::vec3(1), 1});
    CHECK_FALSE(canvas.far.is_open(0, 0));
    CHECK(canvas.far.is_open(1, 0));
    canvas.deposit({0, 0, 3, 1, half, glm::vec3(9), 1});  // comes too late
    CHECK(canvas.at(0, 0).g == Approx(1).margin(1e-4));
    // Closed or not, geometry in front of the first deposit is seen; nothing behind it changes a closed sample, as
    // whoever asks what is hidden relies on.
    CHECK(canvas.far.over(2, 0, 0) == nullptr);
    CHECK(canvas.far.settled_behind(-infinity, 0, 0) == 2);
    CHECK(canvas.far.settled_behind(3, 0, 0) == 3);
    CHECK(canvas.far.settled_behind(2, 1, 0) == 2);
    // What lies in front of the geometry is seen, whatever was dropped before it.
    canvas.deposit({1, 0, 2, 1, half, glm::vec3(1), 3});
    CHECK(canvas.far.over(2, 1, 0) != nullptr);
}

TEST_CASE("clearing leaves nothing of a frame", "[raster]") {
    Random random(67);
    Canvas canvas(150, 40), fresh(150, 40);
    for (int frame = 0; frame < 20; ++frame) {
        canvas.far.clear();
        CHECK_FALSE(canvas.far.has_begun());
        CHECK(canvas.is_untouched());
        for (int i = 0; i < 150 * 40; ++i) REQUIRE(canvas.far.is_open(i % 150, i / 150));
        canvas.far.begin();
        fresh = Canvas(150, 40);
        canvas.depth = fresh.depth;
        for (int i = 0; i < 200; ++i) {
            const std::size_t near = random.below(150 * 40);
            canvas.depth[near] = fresh.depth[near] = random.unit();
            Square s = square(random.between(0, 150), random.between(0, 40), random.between(0, 8),
                              loss_of_opacity(random.unit(), laws[random.below(3)]));
            s.q = 1 - float(i) / 200;
            canvas.deposit(s);
            fresh.deposit(s);
        }
        for (int i = 0; i < 150 * 40; ++i) {
            const int x = i % 150, y = i / 150;
            REQUIRE(same(canvas.at(x, y), fresh.at(x, y)));
            REQUIRE(canvas.far.is_open(x, y) == fresh.far.is_open(x, y));
        }
    }
}

TEST_CASE("what is no larger than a lane goes into the one its center lies in, all of it", "[raster]") {
    Random random(71);
    for (const AreaLaw law : laws) {
        const int width = 6, height = 5;
        Canvas canvas(width, height);
        Model model(width, height);
        int asked = 0;
        for (int i = 0; i < 3000; ++i) {
            const float x = random.between(-1, float(width) + 1), y = random.between(-1, float(height) + 1);
            const float area = random.unit() / lanes::count, alpha = random.unit();
            const Loss loss = loss_of_opacity(alpha, law);
            canvas.far.deposit_in_lane(canvas.depths(), x, y, area, 1, loss, [&] {
                ++asked;
                return glm::vec3(0, 1, 0);
            });
            if (!(x >= 0 && y >= 0 && x < float(width) && y < float(height))) continue;
            if (model.transmittance(int(x), int(y)) < double(closed_transmittance)) continue;
            double& left = model.lane(int(x * lanes::side), int(y * lanes::side));
            left = std::max(
                0.0, left - double(area) * lanes::count * (left * double(loss.relative) + double(loss.absolute)));
        }
        double off = 0;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                const FarSamples::Sample got = canvas.at(x, y);
                off = std::max(off, std::abs(double(got.transmittance) - model.transmittance(x, y)));
                CHECK(std::abs(got.g + got.transmittance - 1) < 1e-4f);
            }
        }
        CHECK(off < 1.0 / 500);
        CHECK(asked > 500);
    }
    // Behind geometry, beyond the picture, or nowhere: nothing.
    Canvas canvas(2, 2);
    std::fill(canvas.depth.begin(), canvas.depth.end(), 2.0f);
    for (const float x : {0.5f, -1.0f, 7.0f, std::numeric_limits<float>::quiet_NaN()}) {
        canvas.far.deposit_in_lane(canvas.depths(), x, 0.5f, 0.05f, 1, {0, 1}, [] { return glm::vec3(1); });
    }
    CHECK(canvas.taken() == 0);
    CHECK(canvas.far.is_open(0, 0));
    CHECK(canvas.far.is_open(1, 1));
}
