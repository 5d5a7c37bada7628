// The program: a table of four ways, and their pictures.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "catch.hpp"
#include "support/display.hpp"
#include "support/temporary_directory.hpp"

TEST_CASE("the program draws a forest in Ogre in four ways, prints a table and writes pictures") {
    const auto display = farfield::test::Display::open();
    if (!display) return;
    const farfield::test::TemporaryDirectory directory;
    const std::string command = "cd '" + directory.path().string() +
                                "' && '" FOREST_PROGRAM
                                "' --trees 6 --triangles 2000 --kinds 2 --width 96 --height 64 "
                                "--frames 2 --compared 1 --out . >said 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream in(directory / "said");
    const std::string said{std::istreambuf_iterator<char>(in), {}};
    INFO(said);
    REQUIRE(status == 0);
    for (const char* way : {"\nplain ", "\nLOD generated ", "\nStaticGeometry ", "\nfarfield "})
        CHECK(said.find(way) != std::string::npos);
    for (const char* file : {"frame001_64_samples.png", "frame001_plain.png", "frame001_LOD.png",
                             "frame001_StaticGeometry.png", "frame001_farfield.png", "frame001_side_by_side.png"})
        CHECK(std::filesystem::file_size(directory / file) > 500);
}
