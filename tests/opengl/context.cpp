#include <cstdlib>
#include <stdexcept>
#include <string>

#include "opengl/setting.hpp"

using namespace farfield;
using namespace farfield::test;

namespace {

std::string failure(const opengl::HeadlessOptions& options) {
    try {
        const opengl::HeadlessContext context(options);
    } catch (const std::runtime_error& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("a context of too low a version is refused in one line that says what was found", "[opengl]") {
    if (!OpenGl()) return;
    // No driver has this one.
    const std::string text = failure({.major = 9, .minor = 9});
    CHECK(text.find("OpenGL 9.9 core wanted, ") == 0);
    CHECK(text.find(" found") != std::string::npos);
    CHECK(text.find('\n') == std::string::npos);
    CHECK(failure({}) == "");
}

TEST_CASE("a driver that says it has 3.3 is refused", "[opengl]") {
    if (!OpenGl()) return;
    setenv("MESA_GL_VERSION_OVERRIDE", "3.3", 1);
    const std::string text = failure({});
    unsetenv("MESA_GL_VERSION_OVERRIDE");
    if (text == "") return;  // it does not listen: not Mesa
    CHECK(text.find("OpenGL 4.5 core wanted, 3.3") == 0);
    CHECK(text.find('\n') == std::string::npos);
}

TEST_CASE("errors are told while somebody listens", "[opengl]") {
    OpenGl gl;
    if (!gl) return;
    glEnable(GL_TEXTURE_2D_ARRAY);  // is nothing to be enabled
    CHECK(gl.errors->count() == 1);
    CHECK(glGetError() == GLenum(GL_INVALID_ENUM));
}
