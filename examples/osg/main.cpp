// Draws a forest along a path in four ways - plain, osg::LOD over osgUtil::Simplifier, osgSim::Impostor, farfield - and
// prints what each takes and errs by. Needs a display, be it Xvfb's. See --help.
#include <array>
#include <memory>

#include "forest.hpp"
#include "stage.hpp"

int main(int argc, char** argv) {
    return farfield::engines::compare(argc, argv, "osg", [](const auto& trees, float tolerance_px) {
        const auto forest = std::make_shared<far_osg::Forest>(trees);
        const auto way = [](const char* name, auto scene_of) {
            return farfield::engines::Way{name, [=](int width, int height) {
                                              return std::make_unique<far_osg::Stage>(scene_of(), width, height);
                                          }};
        };
        return std::array{way("plain", [=] { return forest->plain(); }),
                          way("LOD of Simplifier", [=] { return forest->with_levels(); }),
                          way("Impostor", [=] { return forest->with_impostors(); }),
                          farfield::engines::Way{"farfield", [=](int width, int height) {
                                                     const auto drawable = forest->far_field(tolerance_px);
                                                     return std::make_unique<far_osg::Stage>(
                                                         forest->with_far_field(drawable), width, height, drawable);
                                                 }}};
    });
}
