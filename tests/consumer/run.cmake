# cmake -DMODE=... -P run.cmake: one consumer test, see CMakeLists.txt beside this file.

set(prefix "${WORK_DIRECTORY}/prefix")
set(build "${WORK_DIRECTORY}/build-${MODE}")

function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "exit status ${result}: ${ARGV}")
  endif()
endfunction()

set(configure
    "${CMAKE_COMMAND}"
    -S
    "${CMAKE_CURRENT_LIST_DIR}"
    -B
    "${build}"
    -G
    "${GENERATOR}"
    "-DCMAKE_MAKE_PROGRAM=${MAKE_PROGRAM}"
    "-DCMAKE_CXX_COMPILER=${COMPILER}"
    "-DCMAKE_BUILD_TYPE=${CONFIG}"
    # That it compiles and runs is the matter, not how fast.
    -DCMAKE_CXX_FLAGS_RELEASE=-O0
    "-Dglm_DIR=${GLM_DIRECTORY}")

set(GLM_FLAGS)
foreach(directory IN LISTS GLM_INCLUDE)
  list(APPEND GLM_FLAGS "-I${directory}")
endforeach()

# CMake puts the configuration's name between only for generators that hold several.
function(build_and_run)
  run("${CMAKE_COMMAND}" --build "${build}" --config "${CONFIG}")
  find_program(
    program consumer
    PATHS "${build}" "${build}/${CONFIG}"
    NO_DEFAULT_PATH REQUIRED NO_CACHE)
  run("${program}")
endfunction()

file(REMOVE_RECURSE "${build}")

if(MODE STREQUAL "subdirectory")
  run(${configure} "-DFARFIELD_SOURCE_DIRECTORY=${SOURCE_DIRECTORY}")
  build_and_run()
  # What exports a target that links to farfield installs farfield with it.
  run("${CMAKE_COMMAND}" --install "${build}" --config "${CONFIG}" --prefix "${build}/prefix")
  file(GLOB found "${build}/prefix/lib/cmake/engine/engine-targets.cmake"
       "${build}/prefix/share/cmake/farfield/farfield-config.cmake" "${build}/prefix/include/farfield/farfield.hpp"
       "${build}/prefix/include/farfield/coverage/tiler/mask_kernel.inl")
  list(LENGTH found count)
  if(NOT count EQUAL 4)
    message(FATAL_ERROR "an exporting project installed no more than ${found}")
  endif()
elseif(MODE STREQUAL "install")
  # Installed in one place and moved to another: an installed package must not remember where it was built.
  file(REMOVE_RECURSE "${prefix}" "${prefix}-first")
  run("${CMAKE_COMMAND}" --install "${BINARY_DIRECTORY}" --config "${CONFIG}" --prefix "${prefix}-first")
  file(RENAME "${prefix}-first" "${prefix}")
elseif(MODE STREQUAL "package")
  run(${configure} "-DCMAKE_PREFIX_PATH=${prefix}" -DFARFIELD_REQUESTED_VERSION=0.1)
  build_and_run()
elseif(MODE STREQUAL "pkg_config")
  find_program(pkg_config NAMES pkg-config pkgconf NO_CACHE)
  if(NOT pkg_config)
    message(STATUS "skipped: there is no pkg-config")
    return()
  endif()
  set(ENV{PKG_CONFIG_PATH} "${prefix}/share/pkgconfig")
  execute_process(
    COMMAND "${pkg_config}" --cflags farfield
    OUTPUT_VARIABLE flags
    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  run("${COMPILER}" -std=c++20 -fsyntax-only ${flags} ${GLM_FLAGS} "${CMAKE_CURRENT_LIST_DIR}/main.cpp")
elseif(MODE STREQUAL "single_header")
  find_program(bash bash NO_CACHE)
  if(NOT bash)
    message(STATUS "skipped: there is no bash")
    return()
  endif()
  file(MAKE_DIRECTORY "${build}/farfield")
  run("${bash}" "${SOURCE_DIRECTORY}/.packaging/single_header.sh" farfield/farfield.hpp "${build}/farfield/farfield.hpp")
  run("${COMPILER}" -std=c++20 -fsyntax-only "-I${build}" ${GLM_FLAGS} "${SOURCE_DIRECTORY}/examples/quickstart.cpp")
elseif(MODE STREQUAL "refused_versions")
  foreach(version IN ITEMS 0.0 0.1.999 0.2 1.0)
    file(REMOVE_RECURSE "${build}")
    execute_process(
      COMMAND ${configure} "-DCMAKE_PREFIX_PATH=${prefix}" -DFARFIELD_REQUESTED_VERSION=${version}
      RESULT_VARIABLE result
      OUTPUT_QUIET
      ERROR_VARIABLE errors)
    if(result EQUAL 0)
      message(FATAL_ERROR "find_package(farfield ${version}) was not refused")
    endif()
    # It must be refused for its version, not because the package was not found.
    string(REGEX REPLACE "[ \n]+" " " errors "${errors}")
    if(NOT errors MATCHES "not accepted" OR NOT errors MATCHES "farfield-config.cmake, version:")
      message(FATAL_ERROR "find_package(farfield ${version}) failed for another reason:\n${errors}")
    endif()
    message(STATUS "version ${version} refused")
  endforeach()
else()
  message(FATAL_ERROR "unknown MODE '${MODE}'")
endif()
