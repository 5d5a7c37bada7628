# cmake -DSETTING=... -P settings.cmake: builds settings.cpp, a small program that draws by every renderer, as an engine
# with such settings would, and compares its pictures with those of the setting `plain`, which comes first.
cmake_minimum_required(VERSION 3.22)

set(directory "${WORK_DIRECTORY}/${SETTING}")
file(MAKE_DIRECTORY "${directory}")
set(standard -std=c++20)

# What compilers of their own say of GLM's or the system's macros is not the matter here: -w, unless a setting asks.
set(plain_flags -O0 -D_GLIBCXX_ASSERTIONS)
set(strict_flags
    -std=c++2b
    -fno-exceptions
    -fno-rtti
    -DWITH_ENGINE_MACROS
    -Werror
    -Wall
    -Wextra
    -Wpedantic
    -Wold-style-cast
    -Wconversion
    -Wsign-conversion
    -Wdouble-promotion
    -Wundef
    -Wshadow
    -Wnon-virtual-dtor
    -Woverloaded-virtual
    -Wcast-align
    -Wcast-qual
    -Wextra-semi
    -Wredundant-decls
    -Wmissing-declarations
    -Wzero-as-null-pointer-constant
    -Wunused-macros)
set(glm_forces_flags
    -DGLM_FORCE_XYZW_ONLY
    -DGLM_FORCE_EXPLICIT_CTOR
    -DGLM_FORCE_SIZE_T_LENGTH
    -DGLM_FORCE_LEFT_HANDED
    -DGLM_FORCE_DEPTH_ZERO_TO_ONE)
# Vectors that are aligned, on the machine at hand: one program for what goes together.
set(native_flags
    -march=native
    -O1
    -ftree-vectorize
    -DNDEBUG
    -DGLM_FORCE_SWIZZLE
    -DGLM_FORCE_DEFAULT_ALIGNED_GENTYPES
    -DGLM_FORCE_INTRINSICS)
set(fast_math_flags -ffast-math)

# Other processors, where there are a cross compiler and an emulator (Debian: g++-aarch64-linux-gnu and qemu-user;
# g++-multilib, which excludes the former). A processor of 32 bits must not count with more of them in between.
set(aarch64_flags -O1 -Wno-psabi)
set(i686_flags -O1 -m32 -msse2 -mfpmath=sse)
set(runner)
if(SETTING STREQUAL "aarch64")
  find_program(COMPILER_OF_SETTING aarch64-linux-gnu-g++ NO_CACHE)
  find_program(runner NAMES qemu-aarch64 qemu-aarch64-static NO_CACHE)
  if(NOT COMPILER_OF_SETTING OR NOT runner)
    message(STATUS "skipped: needs aarch64-linux-gnu-g++ and qemu-aarch64")
    return()
  endif()
  list(APPEND runner -L /usr/aarch64-linux-gnu)
  set(COMPILER "${COMPILER_OF_SETTING}")
  # It does not look among the headers of this machine; those of GLM are the same for all.
  find_path(directory_of_glm glm/glm.hpp PATHS ${GLM_INCLUDE} /usr/local/include /usr/include NO_CACHE REQUIRED)
  file(CREATE_LINK "${directory_of_glm}/glm" "${WORK_DIRECTORY}/aarch64/glm" SYMBOLIC)
  set(GLM_INCLUDE "${WORK_DIRECTORY}/aarch64")
elseif(SETTING STREQUAL "i686")
  file(WRITE "${WORK_DIRECTORY}/i686.cpp" "#include <thread>\n#include <vector>\nint main() {}\n")
  execute_process(COMMAND "${COMPILER}" -m32 "${WORK_DIRECTORY}/i686.cpp" -o "${WORK_DIRECTORY}/i686.program"
                  RESULT_VARIABLE result OUTPUT_QUIET ERROR_QUIET)
  if(NOT result EQUAL 0)
    message(STATUS "skipped: ${COMPILER} makes no programs of 32 bits")
    return()
  endif()
endif()

set(compile ${LAUNCHER} "${COMPILER}" -c "-I${SOURCE_DIRECTORY}/include" -ffp-contract=off -w)
foreach(directory_of_glm IN LISTS GLM_INCLUDE)
  list(APPEND compile -isystem "${directory_of_glm}")
endforeach()
if(NOT DEFINED ${SETTING}_flags)
  message(FATAL_ERROR "there is no setting '${SETTING}'")
endif()
set(flags ${standard} ${${SETTING}_flags})
if("-Werror" IN_LIST flags)
  list(REMOVE_ITEM compile -w)
endif()

if(SETTING STREQUAL "fast_math")
  execute_process(
    COMMAND ${compile} ${flags} -fsyntax-only -Wfatal-errors "${CMAKE_CURRENT_LIST_DIR}/another_file.cpp"
    RESULT_VARIABLE result
    ERROR_VARIABLE errors)
  if(result EQUAL 0 OR NOT errors MATCHES "error: .*farfield is wrong under -ffast-math")
    message(FATAL_ERROR "-ffast-math was not refused by name:\n${errors}")
  endif()
  list(APPEND flags -fno-finite-math-only)
  if(COMPILER MATCHES "clang")
    list(APPEND flags -DFARFIELD_ALLOW_FAST_MATH)
  endif()
  execute_process(COMMAND ${compile} ${flags} -fsyntax-only "${CMAKE_CURRENT_LIST_DIR}/another_file.cpp"
                  RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "what the message says does not help")
  endif()
  return()
endif()

# That two files link is seen once, and warnings are those of each; for the rest the headers are parsed once.
set(names settings another_file)
if(NOT SETTING STREQUAL "strict")
  set(names settings)
  list(APPEND flags -include "${CMAKE_CURRENT_LIST_DIR}/another_file.cpp")
endif()
set(objects)
foreach(name IN LISTS names)
  set(object "${directory}/${name}.o")
  execute_process(COMMAND ${compile} ${flags} "${CMAKE_CURRENT_LIST_DIR}/${name}.cpp" -o "${object}"
                  RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${name}.cpp does not compile with ${flags}")
  endif()
  list(APPEND objects "${object}")
endforeach()
set(link_flags ${flags})
list(FILTER link_flags INCLUDE REGEX "^-m32$")

# An emulator of a processor may die of a signal where the program has no fault: QEMU 7.2 does, one run of hundreds, by
# where it happens to lay out memory. So such an end is no verdict, and the program is run again, linked the other way,
# which lays out memory differently. What the program itself says, by its pictures or its exit status, is never passed over.
set(ways -dynamic)
if(runner)
  set(ways -static -dynamic -static -dynamic)
endif()
foreach(way IN LISTS ways)
  if(way STREQUAL "-dynamic")
    set(way)
  endif()
  execute_process(COMMAND "${COMPILER}" ${objects} ${link_flags} ${way} -pthread -o "${directory}/program"
                  RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "does not link with ${flags} ${way}")
  endif()
  execute_process(COMMAND ${runner} "${directory}/program" RESULT_VARIABLE result OUTPUT_VARIABLE pictures)
  if(NOT runner OR result MATCHES "^[0-9]+$")
    break()
  endif()
endforeach()
if(runner AND NOT result MATCHES "^[0-9]+$")
  message(STATUS "skipped: the emulator died in every run (${result})")
  return()
endif()
if(NOT result EQUAL 0)
  message(FATAL_ERROR "exit status ${result} with ${flags}")
endif()
set(file_of_plain "${WORK_DIRECTORY}/pictures.txt")
if(SETTING STREQUAL "plain")
  file(WRITE "${file_of_plain}" "${pictures}")
  return()
endif()
file(READ "${file_of_plain}" pictures_of_plain)
if(NOT pictures STREQUAL pictures_of_plain)
  message(FATAL_ERROR "other pictures with ${flags}: ${pictures} in place of ${pictures_of_plain}")
endif()
