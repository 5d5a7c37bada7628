# The arrows between the folders of include/farfield, and tests that mirror its headers. Run by ctest:
#
#     cmake -DSOURCE_DIRECTORY=... -P house.cmake
cmake_minimum_required(VERSION 3.20)

# --- what may include what: a folder, with all below it, or a header at the root

set(for_everyone fail.hpp geometry settings.hpp simd.hpp version.hpp)
# may_include(ROOM ROOM...): what else a room may include than itself and those. `everything` means that.
function(may_include room)
  set("arrows_of_${room}" ${ARGN} PARENT_SCOPE)
  set(rooms ${rooms} "${room}" PARENT_SCOPE)
endfunction()

set(contracts approximation.hpp camera.hpp camera_from_matrices.hpp composition.hpp cost_model.hpp drawables.hpp executor.hpp image.hpp image_cache_options.hpp missing_hooks.hpp partition.hpp
              primitive.hpp primitive_source.hpp renderer.hpp sampler.hpp view view.hpp wanted_error.hpp)
set(hierarchy hierarchy spatial_hierarchy.hpp ${contracts})
set(frame frame ${hierarchy})

may_include(fail.hpp)
may_include(settings.hpp)
may_include(simd.hpp)
may_include(version.hpp)
may_include(geometry)
foreach(contract IN LISTS contracts) # view/ is the value that most contracts pass, in local coordinates
  may_include(${contract} ${contracts})
endforeach()
foreach(models partition approximation cost_model sampler primitive)
  may_include(${models} ${contracts})
endforeach()
may_include(renderer coverage raster ${contracts})
may_include(coverage raster ${contracts})
may_include(raster ${contracts})
may_include(voxel coverage) # the same masks, one dimension up
may_include(measure image.hpp view.hpp)
may_include(hierarchy ${contracts})
may_include(spatial_hierarchy.hpp ${hierarchy})
may_include(build ${hierarchy})
may_include(build.hpp build sampler ${hierarchy}) # the sampler that a build takes where it is given none
may_include(update.hpp build build.hpp sampler ${hierarchy})
may_include(storage ${hierarchy})
may_include(paging storage frame ${hierarchy}) # a page is checked as a file is
may_include(build_pages build build.hpp sampler storage paging frame ${hierarchy})
may_include(build_pages.hpp build_pages build build.hpp sampler storage paging frame ${hierarchy})
may_include(adapters paging ${contracts}) # what needs another library: nothing includes it
may_include(frame ${hierarchy})
may_include(viewer.hpp ${frame})
may_include(pick.hpp ${frame})
may_include(banded_viewer.hpp viewer.hpp ${frame}) # bands are pictures of viewers
may_include(merged_viewer ${frame})
may_include(merged_viewer.hpp merged_viewer primitive ${frame}) # bodies are instances
may_include(tuning everything)
may_include(farfield.hpp everything)

# --- headers without a test of the same name

# tested_by(TEST HEADER...): tests/TEST.cpp is their test, of several or of one that goes by another name.
function(tested_by test)
  foreach(header IN LISTS ARGN)
    set("test_of_${header}" "${test}" PARENT_SCOPE)
  endforeach()
  set(tests_of_several ${tests_of_several} "${test}" PARENT_SCOPE)
  set(listed ${listed} ${ARGN} PARENT_SCOPE)
endfunction()

# Concepts are tested together: with types that keep every promise and types that miss it by one thing.
tested_by(composition missing_hooks approximation approximation/exact cost_model partition sampler)
tested_by(consumer/main farfield)
tested_by(consumer/settings settings)
# Records without functions are tested by what makes them.
tested_by(adapters/http_page_source adapters/curl_connection adapters/http_options)
tested_by(build build/build_progress)
tested_by(approximation/color_cube/cube_lanes approximation/placed/placed_splats)
tested_by(frame/kept_images frame/cell_image)
tested_by(frame/image_maker frame/image_choice)
tested_by(approximation/image_cache image_cache_options raster/samples/image_fill
          raster/samples/sliced_buffers)
tested_by(build/cell_splitter build/build_node build/cell_decision build/small_subtrees)
tested_by(build/move_up build/sample_race)
tested_by(sampler/paint_texture build/painted_contents)
tested_by(update build/cell_tree build/kept_cells build/kept_stand_ins build/version_before)
tested_by(spatial_hierarchy build/hierarchy_builder build/stand_in_drafter build/freeze build/idle_nodes geometry/visit_order hierarchy/build_report hierarchy/hierarchy_data)
tested_by(renderer/z_buffer_renderer raster/render_options)
# Parts that mean little by themselves are tested by what they are parts of, mostly against brute force.
tested_by(build/polygon_splitter build/polygon_subtree geometry/fragments)
tested_by(coverage/pixels/box_filter coverage/pixels/pixel_blocks)
tested_by(coverage/pixels/cosine_hump_filter coverage/pixels/cosine_hump)
tested_by(coverage/polygons/surface coverage/polygons/color_gradient coverage/polygons/scattered_samples)
tested_by(renderer/coverage_renderer coverage/polygons/far_polygons coverage/polygons/polygon_setup)
tested_by(coverage/tiler/mask_kernel simd)
tested_by(frame/selection frame/draw_now)
tested_by(frame/descent frame/stand_in_choice frame/item_runs)
tested_by(paging/paged_approximations frame/contents_box)
tested_by(frame/frame_budget frame/opened_cells frame/work_of_cut)
tested_by(tuning/measure_frame_prices frame/frame_prices)
tested_by(tuning/tuned_viewer tuning/viewers_by_samples)
tested_by(hierarchy/fingerprint geometry/mixed)
tested_by(measure/flip measure/flip_colors measure/flip_filters)
tested_by(merged_viewer merged_viewer/body_walker)
tested_by(partition/polygon_bsp partition/child_boxes)
tested_by(partition/gap_bsp partition/extent partition/gap_planes partition/plane_sides)
tested_by(pick geometry/ray view/pixel_ray)
tested_by(paging/page_cache paging/page_attempts paging/page_cache_options paging/page_demand paging/page_room paging/page_user
          paging/wanted_pages)
tested_by(paging/paged_hierarchy paging/check_pageable paging/open_pages paging/page_check paging/page_file_head paging/page_forest
          paging/page_format paging/write_pages)
tested_by(paging/packed_pages paging/packed_format paging/pack_pages paging/unpacked_pages)
tested_by(build_pages build_pages/build_journal build_pages/disk_room build_pages/file_in_place build_pages/group_builder build_pages/kept_share build_pages/ordered_results build_pages/page_build build_pages/page_share
          build_pages/scattered_file build_pages/scene_survey build_pages/share_builder build_pages/share_joiner
          build_pages/spare_buffers build_pages/stream_batches build_pages/top_pages build_pages/top_tree)
tested_by(raster/box_footprint raster/box_fronts)
tested_by(raster/far_field/far_samples raster/far_field/block_bits raster/far_field/far_sample raster/far_field/transmittance_lanes
          raster/far_field/transmittance_lanes_sse2)
tested_by(raster/triangles/small_triangles raster/triangles/sample_rows raster/triangles/colors_of_row
          raster/triangles/triangle_painter raster/triangles/triangle_runs raster/triangles/triangle_stream
          raster/triangles/triangle_triage)
tested_by(renderer/z_buffer_renderer raster/samples/depth_tested_fill raster/samples/far_deposits
          raster/samples/z_buffer_canvas)
tested_by(tuning/advise tuning/variants)
tested_by(view camera)
tested_by(voxel/voxel_pyramid voxel/voxel_masks)

# --- the check

set(include "${SOURCE_DIRECTORY}/include/farfield")
set(tests "${SOURCE_DIRECTORY}/tests")
set(faults)

macro(fault)
  string(APPEND faults "  " ${ARGN} "\n")
endmacro()

# The folder at the root, or the header there.
function(room_of path out)
  string(REGEX MATCH "^[^/]+" room "${path}")
  set(${out} "${room}" PARENT_SCOPE)
endfunction()
# The innermost folder, or the header at the root.
function(folder_of path out)
  string(REGEX REPLACE "/[^/]*$" "" folder "${path}")
  set(${out} "${folder}" PARENT_SCOPE)
endfunction()

file(GLOB_RECURSE headers RELATIVE "${include}" "${include}/*.hpp" "${include}/*.inl")
set(folders)
foreach(header IN LISTS headers)
  room_of("${header}" room)
  folder_of("${header}" folder)
  list(APPEND folders "${folder}")
  if(NOT room IN_LIST rooms)
    fault("${header}: house.cmake does not say what ${room} may include")
  endif()
  file(STRINGS "${include}/${header}" lines REGEX "^#include \"")
  file(STRINGS "${include}/${header}" first REGEX "^#include " LIMIT_COUNT 1)
  if(header MATCHES "\\.hpp$" AND NOT header MATCHES "^(settings|version)\\.hpp$"
     AND NOT first STREQUAL "#include \"farfield/settings.hpp\"")
    fault("${header} begins without settings.hpp, which protects what it includes from macros of others")
  endif()
  foreach(line IN LISTS lines)
    if(NOT line MATCHES "^#include \"farfield/([^\"]+)\"")
      fault("${header}: ${line}: not a path from include/")
      continue()
    endif()
    set(included "${CMAKE_MATCH_1}")
    room_of("${included}" room_included)
    folder_of("${included}" folder_included)
    if(NOT room_included STREQUAL room AND NOT room_included IN_LIST for_everyone
       AND NOT room_included IN_LIST arrows_of_${room} AND NOT arrows_of_${room} STREQUAL "everything")
      fault("${header} includes ${included}, but ${room} may not include ${room_included}")
    endif()
    if(NOT folder_included STREQUAL folder)
      list(APPEND "out_of_${folder}" "${folder_included}")
      set("because_${folder}_${folder_included}" "${header} includes ${included}")
    endif()
  endforeach()
endforeach()

# Folders that include none but such as were taken away already are taken away. From any that stays one comes, over
# others that stay, to a circle.
list(REMOVE_DUPLICATES folders)
set(count 0)
list(LENGTH folders left)
while(NOT count EQUAL left)
  set(count ${left})
  foreach(folder IN LISTS folders)
    unset("next_of_${folder}")
    foreach(other IN LISTS out_of_${folder})
      if(other IN_LIST folders)
        set("next_of_${folder}" "${other}")
      endif()
    endforeach()
    if(NOT DEFINED next_of_${folder})
      list(REMOVE_ITEM folders "${folder}")
    endif()
  endforeach()
  list(LENGTH folders left)
endwhile()
if(folders)
  list(GET folders 0 folder)
  set(passed)
  while(NOT folder IN_LIST passed)
    list(APPEND passed "${folder}")
    set(folder "${next_of_${folder}}")
  endwhile()
  set(start "${folder}")
  while(TRUE)
    set(next "${next_of_${folder}}")
    fault("a circle of folders: ${because_${folder}_${next}}")
    set(folder "${next}")
    if(folder STREQUAL start)
      break()
    endif()
  endwhile()
endif()

# --- tests mirror the headers

foreach(header IN LISTS headers)
  if(NOT header MATCHES "\\.hpp$")
    continue()
  endif()
  string(REGEX REPLACE "\\.hpp$" "" name "${header}")
  if(EXISTS "${tests}/${name}.cpp")
    if(DEFINED test_of_${name})
      fault("${header} has a test: take it off the list in house.cmake")
    endif()
  elseif(NOT DEFINED test_of_${name})
    fault("${header} has no test: tests/${name}.cpp is missing")
  elseif(NOT EXISTS "${tests}/${test_of_${name}}.cpp")
    fault("${header} is said to be tested by tests/${test_of_${name}}.cpp, which is missing")
  endif()
endforeach()

foreach(name IN LISTS listed)
  if(NOT EXISTS "${include}/${name}.hpp")
    fault("house.cmake names a header that is not there: ${name}.hpp")
  endif()
endforeach()

file(GLOB_RECURSE sources RELATIVE "${tests}" "${tests}/*.cpp")
foreach(source IN LISTS sources)
  room_of("${source}" room)
  string(REGEX REPLACE "\\.cpp$" "" name "${source}")
  if(NOT source MATCHES "/" OR IS_DIRECTORY "${include}/${room}")
    if(NOT EXISTS "${include}/${name}.hpp" AND NOT EXISTS "${include}/${name}.inl" AND NOT name IN_LIST tests_of_several)
      fault("tests/${source} names no header")
    endif()
  endif()
endforeach()

if(faults)
  message(FATAL_ERROR "include/farfield and tests/ are not as house.cmake says:\n${faults}")
endif()
