"""Conan 2 recipe: conan create .packaging/conan"""
import os
import re

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain
from conan.tools.files import copy, load, rmdir


class FarfieldConan(ConanFile):
    name = "farfield"
    description = "Spatial hierarchies for rendering scenes too complex to draw primitive by primitive"
    license = "MIT"
    topics = ("graphics", "rendering", "level-of-detail", "header-only")
    package_type = "header-library"
    settings = "os", "compiler", "build_type", "arch"
    options = {"http": [True, False]}
    default_options = {"http": False}
    no_copy_source = True

    @property
    def _root(self):
        return os.path.join(self.recipe_folder, "..", "..")

    def set_version(self):
        text = load(self, os.path.join(self._root, "include", "farfield", "version.hpp"))
        parts = [re.search(rf"FARFIELD_VERSION_{p} (\d+)", text)[1] for p in ("MAJOR", "MINOR", "PATCH")]
        self.version = ".".join(parts)

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", ".cmake/*", "include/*"):
            copy(self, pattern, src=self._root, dst=self.export_sources_folder)

    def requirements(self):
        self.requires("glm/[>=0.9.9.8]", transitive_headers=True)
        if self.options.http:
            self.requires("libcurl/[>=7.68 <9]", transitive_headers=True, transitive_libs=True)

    def validate(self):
        check_min_cppstd(self, 20)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for part in ("TESTS", "EXAMPLES", "BENCH"):
            toolchain.variables[f"FARFIELD_BUILD_{part}"] = False
        toolchain.generate()

    def build(self):
        CMake(self).configure()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", src=self.source_folder, dst=os.path.join(self.package_folder, "licenses"))
        rmdir(self, os.path.join(self.package_folder, "share"))  # CMakeDeps writes the package files

    def package_id(self):
        self.info.clear()

    def package_info(self):
        self.cpp_info.bindirs = self.cpp_info.libdirs = []
        main = self.cpp_info.components["farfield"]
        main.bindirs = main.libdirs = []
        main.requires = ["glm::glm"]
        main.set_property("cmake_target_name", "farfield::farfield")
        if self.options.http:
            http = self.cpp_info.components["http"]
            http.bindirs = http.libdirs = []
            http.requires = ["farfield", "libcurl::libcurl"]
            http.set_property("cmake_target_name", "farfield::http")
