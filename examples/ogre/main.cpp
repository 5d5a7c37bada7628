// Draws a forest along a path in four ways - plain, levels of Ogre::MeshLodGenerator, Ogre::StaticGeometry, farfield -
// and prints what each takes and errs by. Needs a display, be it Xvfb's. See --help.
#include <array>
#include <memory>

#include "forest.hpp"
#include "stage.hpp"

int main(int argc, char** argv) {
    return farfield::engines::compare(argc, argv, "Ogre", [](const auto& trees, float tolerance_px) {
        far_ogre::start();
        const auto forest = std::make_shared<far_ogre::Forest>(trees);
        const auto way = [](const char* name, const far_ogre::Stage::Fill& fill) {
            return farfield::engines::Way{
                name, [=](int width, int height) { return std::make_unique<far_ogre::Stage>(fill, width, height); }};
        };
        return std::array{way("plain", [=](auto& scene) { return forest->plain(scene), nullptr; }),
                          way("LOD generated", [=](auto& scene) { return forest->with_levels(scene), nullptr; }),
                          way("StaticGeometry", [=](auto& scene) { return forest->static_geometry(scene), nullptr; }),
                          way("farfield", [=](auto& scene) { return forest->far_field(scene, tolerance_px); })};
    });
}
