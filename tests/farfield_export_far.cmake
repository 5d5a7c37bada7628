# Models far from zero: cmake -DEXPORT=farfield_export -DBUILD=farfield_build -DDIRECTORY=SCRATCH -P farfield_export_far.cmake
#
# A tileset has its model's place in the root's transform, whatever the file's format and whether it went through pages,
# and its boxes are those of the same model at zero. BUILD may be empty.
cmake_minimum_required(VERSION 3.22)

function(expect_success)
  execute_process(
    COMMAND ${EMULATOR} ${ARGN}
    RESULT_VARIABLE status
    OUTPUT_VARIABLE out
    ERROR_VARIABLE out)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}: expected status 0, got ${status}:\n${out}")
  endif()
endfunction()

# What a tileset says: the root's translation in the model's axes (none: 0,0,0), and its box.
function(read_root folder place_variable box_variable)
  file(READ "${folder}/tileset.json" json)
  set(place)
  foreach(i IN ITEMS 12 14 13)
    string(JSON value ERROR_VARIABLE error GET "${json}" root transform ${i})
    if(error)
      set(value 0)
    endif()
    list(APPEND place "${value}")
  endforeach()
  string(JSON box GET "${json}" root boundingVolume box)
  set(${place_variable} "${place}" PARENT_SCOPE)
  set(${box_variable} "${box}" PARENT_SCOPE)
endfunction()

# The same two triangles at X 0 Z, and a file's own way to say so.
function(model format x z out)
  math(EXPR x1 "${x} + 1")
  math(EXPR z1 "${z} + 1")
  if(format STREQUAL "off")
    file(WRITE "${out}.off" "OFF\n4 2 0\n${x}.125 0 ${z}.25\n${x1}.5 0 ${z}.25\n${x1}.5 2 ${z1}.75\n${x}.125 2 ${z1}.75\n"
                            "3 0 1 2\n3 0 2 3\n")
  elseif(format STREQUAL "ply")
    file(WRITE "${out}.ply"
         "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
         "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
         "${x}.125 0 ${z}.25\n${x1}.5 0 ${z}.25\n${x1}.5 2 ${z1}.75\n${x}.125 2 ${z1}.75\n3 0 1 2\n3 0 2 3\n")
  elseif(format STREQUAL "gltf")
    # A triangle of three floats each: 0 0 0, 1 0 0, 0 1 0.
    set(data "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA")
    file(WRITE "${out}.gltf"
         "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
         "\"nodes\":[{\"children\":[1],\"translation\":[${x}.125,0,${z}.25]},{\"mesh\":0,\"translation\":[1,0,1],\"scale\":[1.5,1.5,1.5]}],"
         "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
         "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
         "\"min\":[0,0,0],\"max\":[1,1,0]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
         "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,${data}\"}]}")
  elseif(format STREQUAL "xyz") # points
    set(points)
    foreach(i RANGE 9)
      string(APPEND points "${x}.${i} 0.5 ${z}.25\n${x1}.${i} 0.25 ${z1}.75\n")
    endforeach()
    file(WRITE "${out}.xyz" "${points}")
  elseif(format STREQUAL "pts") # one point, which has no extent
    file(WRITE "${out}.pts" "1\n${x}.5 0 ${z}.25\n")
  elseif(format STREQUAL "dump") # atoms
    file(WRITE "${out}.dump" "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n"
                             "${x} ${x1}.5\n0 2\n${z} ${z1}.5\nITEM: ATOMS id type x y z\n"
                             "1 1 ${x}.5 0 ${z}.25\n2 1 ${x1}.75 1 ${z1}.25\n")
  endif()
endfunction()

file(REMOVE_RECURSE "${DIRECTORY}")
file(MAKE_DIRECTORY "${DIRECTORY}")
foreach(format IN ITEMS off ply gltf xyz pts dump)
  set(model "${DIRECTORY}/model")
  model(${format} 0 0 "${model}")
  expect_success("${EXPORT}" "${model}.${format}" "${DIRECTORY}/here")
  read_root("${DIRECTORY}/here" place box)
  if(NOT place STREQUAL "0;0;0")
    message(SEND_ERROR "${format}: a model at zero was moved by ${place}")
  endif()
  # Tiles' third axis is the model's second, and their second its third backward.
  model(${format} 500000 5400000 "${model}")
  expect_success("${EXPORT}" "${model}.${format}" "${DIRECTORY}/there" --variant color-cube)
  read_root("${DIRECTORY}/there" place there)
  if(NOT place MATCHES "^500000(\\.0)?;0(\\.0)?;-5400000(\\.0)?$" OR NOT there STREQUAL box)
    message(SEND_ERROR "${format}: at ${place}, expected 500000;0;-5400000; box ${there}, expected ${box}")
  endif()
  if(NOT BUILD)
    continue()
  endif()
  set(pages "${DIRECTORY}/model.farfield")
  expect_success("${BUILD}" "${model}.${format}" "${pages}")
  expect_success("${EXPORT}" "${pages}" "${DIRECTORY}/paged")
  read_root("${DIRECTORY}/paged" place there)
  if(NOT place MATCHES "^500000(\\.0)?;0(\\.0)?;-5400000(\\.0)?$" OR NOT there STREQUAL box)
    message(SEND_ERROR "${format}, pages: at ${place}, expected 500000;0;-5400000; box ${there}, expected ${box}")
  endif()
  # What an earlier model left behind says nothing of this one.
  model(${format} 0 0 "${model}")
  expect_success("${BUILD}" "${model}.${format}" "${pages}")
  expect_success("${EXPORT}" "${pages}" "${DIRECTORY}/paged")
  read_root("${DIRECTORY}/paged" place there)
  if(NOT place STREQUAL "0;0;0")
    message(SEND_ERROR "${format}, pages: a model at zero was moved by ${place}")
  endif()
endforeach()
