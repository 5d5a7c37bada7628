#include "farfield/raster/scan_conversion.hpp"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::detail;
using namespace farfield::test;

namespace {

struct Point {
    std::int32_t x, y;
};

SnappedTriangle clockwise(Point a, Point b, Point c) {
    SnappedTriangle t{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {1, 1, 1}};
    if (t.doubled_area() < 0) t.flip();
    return t;
}

SampleProjection image_of(int first_x, int first_y, int end_x, int end_y) {
    SampleProjection to;
    to.first_x = first_x;
    to.first_y = first_y;
    to.end_x = end_x;
    to.end_y = end_y;
    return to;
}

/// Inside, if the sample moved by (epsilon, epsilon squared) is: so each belongs to one of two triangles at an edge.
bool covers(const SnappedTriangle& t, int sample_x, int sample_y) {
    const std::int64_t px = std::int64_t(sample_x) * 256 + 128, py = std::int64_t(sample_y) * 256 + 128;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const std::int64_t dx = std::int64_t(t.x[j]) - t.x[i], dy = std::int64_t(t.y[j]) - t.y[i];
        const std::int64_t e = dx * (py - t.y[i]) - dy * (px - t.x[i]);
        const std::int64_t first = e != 0 ? e : dy != 0 ? -dy : dx;
        if (first <= 0) return false;
    }
    return true;
}

class Counts {
  public:
    explicit Counts(const SampleProjection& image)
        : image_(image), counts_(std::size_t(width()) * std::size_t(image.end_y - image.first_y)) {}
    void add(const SnappedTriangle& t) {
        scan_convert(t, image_, [&](int y, int begin, int end) {
            REQUIRE(image_.first_x <= begin);
            REQUIRE(begin < end);
            REQUIRE(end <= image_.end_x);
            REQUIRE(image_.first_y <= y);
            REQUIRE(y < image_.end_y);
            for (int x = begin; x < end; ++x) ++at(x, y);
        });
    }
    int& at(int x, int y) {
        return counts_[std::size_t(y - image_.first_y) * std::size_t(width()) + std::size_t(x - image_.first_x)];
    }
    const std::vector<int>& all() const { return counts_; }

  private:
    int width() const { return image_.end_x - image_.first_x; }
    SampleProjection image_;
    std::vector<int> counts_;
};

std::size_t differences_from_oracle(const SnappedTriangle& t, const SampleProjection& image) {
    Counts counts(image);
    counts.add(t);
    std::size_t wrong = 0;
    for (int y = image.first_y; y < image.end_y; ++y) {
        for (int x = image.first_x; x < image.end_x; ++x) wrong += counts.at(x, y) != int(covers(t, x, y));
    }
    return wrong;
}

}  // namespace

TEST_CASE("covered samples are those of exact edge functions, at every size", "[raster]") {
    Random random(50);
    const auto image = image_of(-24, -17, 25, 20);
    for (int i = 0; i < 6000; ++i) {
        // From a part of a sample to as far as coordinates reach; corners on centers and on rows of centers too.
        const std::int32_t reach = std::int32_t(1) << (6 + i % 16);
        const auto coordinate = [&] {
            const auto v = std::int32_t(random.below(2 * std::uint32_t(reach) + 1)) - reach;
            return i % 3 == 0 ? (v & ~255) + 128 : v;
        };
        Point p[3];
        for (Point& c : p) {
            c.x = coordinate();
            c.y = coordinate();
        }
        const SnappedTriangle t = clockwise(p[0], p[1], p[2]);
        if (t.doubled_area() == 0) continue;
        INFO("triangle " << i << " within " << reach);
        CHECK(differences_from_oracle(t, image) == 0);
    }
}

TEST_CASE("slivers cover what exact edge functions say", "[raster]") {
    Random random(51);
    const auto image = image_of(-40, -40, 40, 40);
    for (int i = 0; i < 2000; ++i) {
        const auto far = [&] { return std::int32_t(random.below(40001)) - 20000; };
        const Point a{far(), far()}, b{far(), far()};
        const Point c{(a.x + b.x) / 2 + std::int32_t(random.below(5)) - 2,
                      (a.y + b.y) / 2 + std::int32_t(random.below(5)) - 2};
        const SnappedTriangle t = clockwise(a, b, c);
        if (t.doubled_area() != 0) CHECK(differences_from_oracle(t, image) == 0);
    }
}

TEST_CASE("both forms of the scan agree where one hands over to the other", "[raster]") {
    Random random(52);
    const auto image = image_of(-100, -100, 100, 100);
    for (int i = 0; i < 200; ++i) {
        const std::int32_t size = (1 << 14) + std::int32_t(random.below(5)) - 2;
        const std::int32_t x = -std::int32_t(random.below(16000)), y = -std::int32_t(random.below(16000));
        const Point corners[4] = {{x, y}, {x + size, y}, {x + size, y + size}, {x, y + size}};
        const std::uint32_t out = random.below(4);
        CHECK(differences_from_oracle(clockwise(corners[(out + 1) % 4], corners[(out + 2) % 4], corners[(out + 3) % 4]),
                                      image) == 0);
    }
}

TEST_CASE("triangles around a point cover each sample once", "[raster]") {
    Random random(53);
    for (int round = 0; round < 60; ++round) {
        const auto image = image_of(-30, -30, 30, 30);
        Counts counts(image);
        const bool on_sample = round % 2 == 0;
        const Point center{std::int32_t(random.below(4000)) - 2000, std::int32_t(random.below(4000)) - 2000};
        const Point middle = on_sample ? Point{(center.x & ~255) + 128, (center.y & ~255) + 128} : center;
        // A rim far outside, so that every sample of the image is inside.
        std::vector<Point> rim;
        const int n = 3 + int(random.below(60));
        for (int i = 0; i < n; ++i) {
            const double angle = 6.283185307179586 * (i + 0.9 * double(random.unit())) / n;
            rim.push_back(
                {middle.x + std::int32_t(90000 * std::cos(angle)), middle.y + std::int32_t(90000 * std::sin(angle))});
        }
        for (int i = 0; i < n; ++i) {
            const SnappedTriangle t = clockwise(middle, rim[std::size_t(i)], rim[std::size_t((i + 1) % n)]);
            if (t.doubled_area() != 0) counts.add(t);
        }
        INFO("round " << round << ", " << n << " triangles");
        CHECK(std::count(counts.all().begin(), counts.all().end(), 1) == 3600);
    }
}

TEST_CASE("a random triangulation covers each sample once", "[raster]") {
    Random random(54);
    for (int round = 0; round < 20; ++round) {
        const auto image = image_of(-32, -32, 32, 32);
        // Corners outside the image; then points inside triangles, wherever they fall, which makes many slivers, and on
        // edges that two triangles share.
        std::vector<Point> p{{-10000, -9000}, {9000, -10000}, {10000, 9500}, {-9500, 10000}};
        std::vector<std::array<std::size_t, 3>> triangles{{0, 1, 2}, {0, 2, 3}};
        for (int i = 0; i < 400; ++i) {
            const std::size_t k = random.below(std::uint32_t(triangles.size()));
            const auto t = triangles[k];
            const auto u = std::int64_t(random.below(1000)), v = std::int64_t(random.below(1000 - std::uint32_t(u)));
            const auto mix = [&](std::int64_t a, std::int64_t b, std::int64_t c) {
                return std::int32_t((a * (1000 - u - v) + b * u + c * v) / 1000);
            };
            Point inside{mix(p[t[0]].x, p[t[1]].x, p[t[2]].x), mix(p[t[0]].y, p[t[1]].y, p[t[2]].y)};
            if (i % 2) inside = {(inside.x & ~255) + 128, (inside.y & ~255) + 128};
            const auto area = [&](Point a, Point b, Point c) {
                return SnappedTriangle{{a.x, b.x, c.x}, {a.y, b.y, c.y}, {}}.doubled_area();
            };
            if (area(p[t[0]], p[t[1]], inside) <= 0 || area(p[t[1]], p[t[2]], inside) <= 0 ||
                area(p[t[2]], p[t[0]], inside) <= 0) {
                continue;
            }
            p.push_back(inside);
            const std::size_t n = p.size() - 1;
            triangles[k] = {t[0], t[1], n};
            triangles.push_back({t[1], t[2], n});
            triangles.push_back({t[2], t[0], n});
        }
        Counts counts(image);
        for (const auto& t : triangles) counts.add(clockwise(p[t[0]], p[t[1]], p[t[2]]));
        INFO("round " << round << ", " << triangles.size() << " triangles");
        CHECK(std::count(counts.all().begin(), counts.all().end(), 1) == 64 * 64);
    }
}

TEST_CASE("depth between corners is that of the plane, and never beyond them", "[raster]") {
    Random random(55);
    for (int i = 0; i < 3000; ++i) {
        SnappedTriangle t;
        for (int c = 0; c < 3; ++c) {
            t.x[c] = std::int32_t(random.below(60000)) - 30000;
            t.y[c] = std::int32_t(random.below(60000)) - 30000;
            t.q[c] = random.between(0.1f, 10.0f);
        }
        if (t.doubled_area() < 0) t.flip();
        if (t.doubled_area() == 0) continue;
        const DepthPlane plane(t, t.doubled_area());
        const double span = double(plane.highest) - double(plane.lowest);
        for (int y = -120; y < 120; y += 7) {
            for (int x = -120; x < 120; x += 7) {
                const float q = plane.at(plane.row(y), x);
                CHECK((plane.lowest <= q && q <= plane.highest));
                if (!covers(t, x, y)) continue;
                double exact = 0;
                for (int c = 0; c < 3; ++c) {
                    const int a = (c + 1) % 3, b = (c + 2) % 3;
                    const double px = x * 256.0 + 128, py = y * 256.0 + 128;
                    exact += double(t.q[c]) * ((t.x[b] - t.x[a]) * (py - t.y[a]) - (t.y[b] - t.y[a]) * (px - t.x[a])) /
                             double(t.doubled_area());
                }
                // Slivers' planes are steep: what rounding does to them grows with their length over their width.
                const double steepness = 1 + 1e9 / double(t.doubled_area());
                CHECK(std::abs(double(q) - exact) <= 3e-6 * (10 + span) * steepness);
            }
        }
    }
}
