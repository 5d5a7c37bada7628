#include "path_recorder.hpp"

#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>

#include "catch.hpp"
#include "navigator.hpp"
#include "support/temporary_directory.hpp"

using namespace viewer;
using farfield::Camera;
using farfield::scenes::CameraPath;
using farfield::test::TemporaryDirectory;

namespace {

Camera camera(double x) {
    return Camera::perspective({x, 1, 5}, {x, 0, 0}, {0, 1, 0}, 1);
}

bool is_same(const Camera& a, const Camera& b) {
    return glm::length(a.eye - b.eye) < 1e-6 && glm::length(a.forward - b.forward) < 1e-6f &&
           glm::length(a.up - b.up) < 1e-6f && std::abs(a.half_height - b.half_height) < 1e-6f;
}

}  // namespace

TEST_CASE("what was recorded is played again, in the same time") {
    PathRecorder recorder;
    CHECK_FALSE(recorder.advance(0.1, camera(0)));
    CHECK(recorder.path().is_empty());
    recorder.record();
    for (int i = 0; i < 10; ++i) CHECK_FALSE(recorder.advance(0.1, camera(i)));
    recorder.stop();
    CHECK(recorder.path().stops.size() == 10);
    CHECK(recorder.path().seconds() == Approx(0.9));
    recorder.play(recorder.path());
    for (int i = 0; i < 10; ++i) {
        REQUIRE(recorder.is_playing());
        const auto shown = recorder.advance(0.1, camera(-1));
        REQUIRE(shown);
        CHECK(is_same(*shown, camera(i)));
    }
    recorder.advance(0.1, camera(-1));
    CHECK_FALSE(recorder.is_playing());
    recorder.play({});
    CHECK_FALSE(recorder.is_playing());
}

TEST_CASE("a camera that stands is two stops, and still stands when it is played") {
    PathRecorder recorder;
    recorder.record();
    for (int i = 0; i < 100; ++i) recorder.advance(0.1, camera(0));
    recorder.advance(0.1, camera(1));
    CHECK(recorder.path().stops.size() == 3);
    CHECK(is_same(recorder.path().at(9.9), camera(0)));
    CHECK(is_same(recorder.path().at(9.95), camera(0.5)));
    CHECK(is_same(recorder.path().at(50), camera(1)));
    CHECK(is_same(recorder.path().at(-1), camera(0)));
}

TEST_CASE("a path goes through a file without a change that could be seen") {
    const TemporaryDirectory directory;
    Navigator navigator({{1e6, 0, 0}, {1e6 + 10, 5, 5}}, {0, 0, 1});
    CameraPath path;
    for (int i = 0; i < 20; ++i) {
        path.stops.push_back({0.25 * i, navigator.camera()});
        navigator.orbit({0.3, 0.05});
        navigator.zoom(1, {0.1, 0.1});
    }
    write_camera_path(path, directory / "path.json");
    const CameraPath again = farfield::scenes::read_camera_path(directory / "path.json");
    REQUIRE(again.stops.size() == path.stops.size());
    for (std::size_t i = 0; i < path.stops.size(); ++i) {
        CHECK(again.stops[i].seconds == path.stops[i].seconds);
        CHECK(is_same(again.stops[i].camera, path.stops[i].camera));
    }
    const auto cameras = again.cameras(39);
    REQUIRE(cameras.size() == 39);
    CHECK(is_same(cameras.front(), path.stops.front().camera));
    CHECK(is_same(cameras.back(), path.stops.back().camera));
    CHECK(is_same(cameras[2], path.stops[1].camera));
    for (const Camera& c : cameras) CHECK_NOTHROW(c.validate());
    CHECK(again.cameras(1).size() == 1);
}

TEST_CASE("a file that is no path is refused with its name and what is wrong") {
    using Catch::Matchers::Contains;
    const TemporaryDirectory directory;
    const auto read = [&](const std::string& text) {
        return farfield::scenes::read_camera_path(directory.write("path.json", text));
    };
    const std::string view = R"({"seconds": 1, "eye": [0,0,0], "forward": [0,0,-2], "up": [0,3,1]})";
    CHECK(read(R"({"camera_path": 1, "views": [)" + view + "]}").stops[0].camera.up == glm::vec3(0, 1, 0));
    for (
        const std::string& text : {
            std::string("nothing"),
            std::string("{}"),
            std::string(R"({"camera_path": 2, "views": []})"),
            std::string(R"({"camera_path": 1, "views": []})"),
            R"({"camera_path": 1, "views": [)" + view +
                R"(, {"seconds": 0, "eye": [0,0,0], "forward": [0,0,-1], "up": [0,1,0]}]})",
            std::string(
                R"({"camera_path": 1, "views": [{"seconds": 0, "eye": [0,0], "forward": [0,0,-1], "up": [0,1,0]}]})"),
            std::string(
                R"({"camera_path": 1, "views": [{"seconds": 0, "eye": [0,0,0], "forward": [0,1,0], "up": [0,1,0]}]})"),
            std::string(
                R"({"camera_path": 1, "views": [{"seconds": 0, "eye": [0,0,0], "forward": [0,0,-1], "up": [0,1,0], "half_height": 0}]})"),
        }) {
        CHECK_THROWS_WITH(read(text), Contains("path.json is no path of a camera"));
    }
    CHECK_THROWS_WITH(farfield::scenes::read_camera_path(directory / "none.json"), Contains("cannot read"));
    CHECK_THROWS_WITH(farfield::scenes::write_camera_path({}, directory / "none/path.json"), Contains("cannot write"));
}
