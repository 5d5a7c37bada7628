# An overlay port of the checkout that it lies in: vcpkg install farfield --overlay-ports=.packaging/vcpkg. A port of a
# release names the release's archive here instead, by vcpkg_from_github.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
set(VCPKG_BUILD_TYPE release) # header-only

vcpkg_cmake_configure(
    SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS -DFARFIELD_BUILD_TESTS=OFF -DFARFIELD_BUILD_EXAMPLES=OFF -DFARFIELD_BUILD_BENCH=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH share/cmake/farfield)
vcpkg_fixup_pkgconfig()
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
