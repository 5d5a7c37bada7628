// The program itself, in a window that nobody sees: driven by a script, and by keys and a mouse as X has them.
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "catch.hpp"
#include "farfield/measure/flip.hpp"
#include "navigator.hpp"
#include "report/picture.hpp"
#include "scenes/load/texture.hpp"
#include "stage.hpp"
#include "support/display.hpp"
#include "support/temporary_directory.hpp"

using farfield::Image;
using farfield::test::Display;
using farfield::test::TemporaryDirectory;

namespace {

bool has(const std::string& program) {
    return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}
/// False where a package is missing, or the viewer was not built.
bool can_look() {
    if (std::string(VIEWER_PROGRAM).empty() || !has("Xvfb")) {
        WARN("skipped: the viewer, or Xvfb, is not there");
        return false;
    }
    return true;
}

std::string content_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

struct Outcome {
    int status = 0;
    std::string said;
};
Outcome run(const TemporaryDirectory& directory, const std::string& command) {
    const auto said = directory / "said";
    const std::string line = "cd '" + directory.path().string() + "' && { " + command + "; } >said 2>&1";
    const int status = std::system(line.c_str());
    return {WEXITSTATUS(status), content_of(said)};
}

const std::string program = "'" VIEWER_PROGRAM "' ";

Outcome play(const TemporaryDirectory& directory, const std::string& arguments, const std::string& script) {
    directory.write("script", script);
    const auto display = Display::open();
    return run(directory, program + arguments + " --script script");
}

Image read_png(const std::filesystem::path& file) {
    const auto decoded = farfield::scenes::detail::decoded(content_of(file));
    Image image(decoded.width, decoded.height);
    std::copy(decoded.texels.begin(), decoded.texels.end(), image.pixels().begin());
    return image;
}

struct Seen {
    std::shared_ptr<const viewer::Stage> stage;
    viewer::Navigator navigator;

    explicit Seen(const std::string& where) : stage(viewer::open_stage(where, 64)) {
        navigator = viewer::Navigator(stage->bounds, stage->up);
        if (stage->start) navigator.start_at(*stage->start);
    }
    /// As a program without a window draws it.
    Image picture(const std::string& variant, int width, int height, float tolerance_px) const {
        for (const auto& v : stage->variants) {
            if (v.name != variant) continue;
            farfield::View view{.camera = navigator.camera(), .width = width, .height = height};
            view.tolerance_px = tolerance_px;
            view.wanted = farfield::WantedError::any();
            view.distance = v.distance;
            const auto built = v.build({});
            const auto frames = built->viewer({.culls_back_faces = stage->culls_back_faces});
            frames->frame(view);
            return farfield::report::over_background(frames->image(), stage->background);
        }
        throw std::runtime_error("no variant " + variant);
    }
};

}  // namespace

TEST_CASE("screenshots show what a program without a window draws, from wherever a script has gone") {
    if (!can_look()) return;
    const TemporaryDirectory directory;
    const Outcome outcome = play(directory, "tree --size 320x240 --variant color-cube",
                                 "key H\nset tolerance 2\nwait\nscreenshot begin.png\n"
                                 "drag left 100 100 180 70\nwait\nscreenshot turned.png\n"
                                 "key space\nwait\nscreenshot exact.png\nkey space\n"
                                 "set renderer coverage\nwait\nscreenshot coverage.png\n"
                                 "set renderer opengl\nwait\nscreenshot opengl.png\n"
                                 "set renderer z-buffer\nset samples 16\nset threads 2\nwait\nscreenshot fine.png\n"
                                 "key R\nset samples 1\nwait\nscreenshot again.png\nquit\n");
    CHECK(outcome.said.empty());
    REQUIRE(outcome.status == 0);
    Seen seen("tree");
    const Image begin = read_png(directory / "begin.png");
    CHECK(begin == seen.picture("color-cube", 320, 240, 2));
    CHECK(read_png(directory / "again.png") == begin);
    seen.navigator.orbit({80.0 / 240, 30.0 / 240});
    CHECK(read_png(directory / "turned.png") == seen.picture("color-cube", 320, 240, 2));
    // Where there is no OpenGL to draw with, the last picture stays.
    CHECK(farfield::flip(read_png(directory / "opengl.png"), read_png(directory / "turned.png")) < 0.1);
    const Image exact = read_png(directory / "exact.png");
    CHECK(exact == seen.picture("exact", 320, 240, 0));
    CHECK(farfield::flip(read_png(directory / "coverage.png"), exact) < 0.1);
    CHECK(farfield::flip(read_png(directory / "fine.png"), exact) < 0.1);
}

TEST_CASE("all that can be shown is shown without an error of OpenGL, and what is dropped is opened") {
    if (!can_look()) return;
    const TemporaryDirectory directory;
    directory.write("one.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    directory.write("broken.ply", "no");
    const Outcome outcome =
        play(directory, "tree --size 400x300",
             "wait\nscreenshot start.png\nkey C\nwait\nscreenshot three.png\nset difference absolute\nwait\n"
             "drag left 133 200 200 200\nclick 200 150\nwait\nscreenshot picked.png\nkey C\n"
             "key L\nkey O\nwait\nscreenshot levels.png\nkey Z\nwheel -6 200 150\n"
             "drag left 200 150 300 120\nwait\nscreenshot outside.png\nkey Z\nkey L\nkey O\n"
             "set budget 40\nwait\nset budget none\nkey F1\nkey G\nhold W 0.2\nkey F\nwait\n"
             "set variant image-cache\nset threads 1\nwait\n"
             "drop broken.ply\nwait\nscreenshot broken.png\ndrop one.off\nwait\nscreenshot one.png\nquit\n");
    CHECK(outcome.said.empty());
    REQUIRE(outcome.status == 0);
    const auto differ = [&](const char* a, const char* b) {
        CHECK_FALSE(read_png(directory / a) == read_png(directory / b));
    };
    differ("start.png", "three.png");
    differ("three.png", "picked.png");
    differ("start.png", "levels.png");
    differ("levels.png", "outside.png");
    differ("start.png", "broken.png");
    differ("broken.png", "one.png");
}

TEST_CASE("a path that was recorded is flown again to its end") {
    if (!can_look()) return;
    const TemporaryDirectory directory;
    const Outcome outcome = play(directory, "cube --size 160x120",
                                 "key H\nwait\nrecord path.json\ndrag left 20 20 60 30\nwheel 3 80 60\nwait\nstop\n"
                                 "wait\nscreenshot end.png\nkey R\nplay path.json\nwait\nscreenshot again.png\nquit\n");
    CHECK(outcome.said.empty());
    REQUIRE(outcome.status == 0);
    CHECK(farfield::scenes::read_camera_path(directory / "path.json").stops.size() > 5);
    CHECK(farfield::flip(read_png(directory / "end.png"), read_png(directory / "again.png")) < 0.01);
}

TEST_CASE("keys and the mouse of X turn the view and take a picture of it") {
    if (!can_look()) return;
    if (!has("xdotool")) {
        WARN("skipped: xdotool is not there");
        return;
    }
    const TemporaryDirectory directory;
    const auto display = Display::open();
    // The drag begins where no panel is, should they still be there. Pictures are taken until three in a row are the
    // same: by then all has been drawn.
    directory.write(
        "hands",
        program +
            "tree --size 900x600 --tolerance 2 &\nviewer=$!\n"
            "window=$(timeout 60 xdotool search --sync --onlyvisible --name 'tree - farfield' | tail -1)\n"
            "xdotool windowfocus --sync $window\n"
            "xdotool key --delay 40 H\n"
            "xdotool mousemove --sync --window $window 400 400 mousedown 1\n"
            "xdotool mousemove --sync --window $window 420 394 mousemove --sync --window $window 520 360 mouseup 1\n"
            "for i in $(seq 1 60); do\n"
            "    xdotool key --delay 40 ctrl+s; sleep 0.4\n"
            "    set -- $(ls tree_*.png 2>/dev/null | tail -3)\n"
            "    [ $# = 3 ] && cmp -s $1 $2 && cmp -s $2 $3 && cp $3 last.png && break\n"
            "done\n"
            "xdotool key Escape\nwait $viewer\n");
    const Outcome outcome = run(directory, "sh hands");
    INFO(outcome.said);
    REQUIRE(outcome.status == 0);
    Seen seen("tree");
    seen.navigator.orbit({120.0 / 600, 40.0 / 600});
    CHECK(farfield::flip(read_png(directory / "last.png"), seen.picture("opacity-tensor", 900, 600, 2)) < 0.03);
}

TEST_CASE(
    "without a display, with an OpenGL that is too old, or with nothing to open there is one line, and status 2") {
    if (!can_look()) return;
    const TemporaryDirectory directory;
    const auto display = Display::open();
    const auto refuses = [&](const std::string& command, const std::string& why) {
        const Outcome outcome = run(directory, command);
        INFO(outcome.said);
        CHECK(outcome.status == 2);
        CHECK(std::count(outcome.said.begin(), outcome.said.end(), '\n') == 1);
        CHECK(outcome.said.find(why) != std::string::npos);
    };
    refuses("env -u DISPLAY -u WAYLAND_DISPLAY " + program, "there is no display");
    refuses("MESA_GL_VERSION_OVERRIDE=3.3 " + program, "OpenGL 4.5");
    refuses(program + "nothing.ply", "nothing.ply");
    refuses(program + "cube --variant sphere", "no variant 'sphere'");
    refuses(program + "--size big", "--size");
    refuses(program + "--script none", "none");
    directory.write("wrong", "wait\nkey Ctrl\n");
    refuses(program + "cube --script wrong", "line 2");
    CHECK(run(directory, program + "--help").status == 0);
}
