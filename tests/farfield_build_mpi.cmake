# farfield_build under MPI: on 1, 2 and 4 ranks the file is the same, byte for byte, as from one process alone, and a
# share that is there already is used.
#
#     cmake -DPROGRAM=farfield_build -DMPIRUN=mpirun -DDIRECTORY=SCRATCH -P farfield_build_mpi.cmake
#
# Without MPIRUN it says that it was skipped.
cmake_minimum_required(VERSION 3.22)

if(NOT MPIRUN)
  message("skipped: farfield_build was built without MPI, or there is no mpirun (Debian and Ubuntu: openmpi-bin "
          "libopenmpi-dev)")
  return()
endif()

# Open MPI of any version takes these from its environment, and others pass them over: as many ranks as are asked for on
# any number of cores, by root in a container too, and memory of other processes is not read, which containers forbid.
set(ENV{OMPI_ALLOW_RUN_AS_ROOT} 1)
set(ENV{OMPI_ALLOW_RUN_AS_ROOT_CONFIRM} 1)
set(ENV{OMPI_MCA_rmaps_base_oversubscribe} 1)
set(ENV{OMPI_MCA_hwloc_base_binding_policy} none)
set(ENV{OMPI_MCA_btl_vader_single_copy_mechanism} none)
set(ENV{PRTE_MCA_rmaps_default_mapping_policy} ":oversubscribe")

execute_process(
  COMMAND "${MPIRUN}" -np 2 "${CMAKE_COMMAND}" --version
  RESULT_VARIABLE status
  OUTPUT_VARIABLE out
  ERROR_VARIABLE err)
if(NOT status EQUAL 0)
  message("skipped: mpirun starts no two processes here: ${out}${err}")
  return()
endif()

# So little memory that a small scene has many parts.
set(scene chessboard:20k)
set(options --memory 1 --threads 1)

# run(DESCRIPTION COMMAND...)
function(run description)
  execute_process(
    COMMAND ${ARGN}
    RESULT_VARIABLE status
    OUTPUT_VARIABLE out
    ERROR_VARIABLE err)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${description}: status ${status}:\n${out}${err}")
  endif()
endfunction()

file(REMOVE_RECURSE "${DIRECTORY}")
file(MAKE_DIRECTORY "${DIRECTORY}")
run("alone" "${PROGRAM}" ${scene} "${DIRECTORY}/alone.farfield" ${options})
file(SHA256 "${DIRECTORY}/alone.farfield" expected)

foreach(ranks IN ITEMS 1 2 4)
  set(out "${DIRECTORY}/ranks_${ranks}.farfield")
  if(ranks EQUAL 4)
    run("the last of 4 shares" "${PROGRAM}" ${scene} "${out}" ${options} --share 3/4)
    file(SIZE "${out}.3-of-4.pages" bytes)
    if(bytes LESS 100000)
      message(SEND_ERROR "the last of 4 shares has no part of the scene: ${bytes} bytes")
    endif()
  endif()
  run("${ranks} ranks" "${MPIRUN}" -np ${ranks} "${PROGRAM}" ${scene} "${out}" ${options})
  file(SHA256 "${out}" found)
  if(NOT found STREQUAL expected)
    message(SEND_ERROR "${ranks} ranks built other bytes than one process")
  endif()
  file(GLOB left "${out}.*")
  if(left)
    message(SEND_ERROR "${ranks} ranks left ${left}")
  endif()
endforeach()

# One rank that fails ends them all, with a line that says why.
execute_process(
  COMMAND "${MPIRUN}" -np 2 "${PROGRAM}" no-such-scene "${DIRECTORY}/none.farfield" ${options}
  RESULT_VARIABLE status
  OUTPUT_VARIABLE out
  ERROR_VARIABLE err)
if(status EQUAL 0 OR NOT err MATCHES "farfield_build: [^\n]*no-such-scene")
  message(SEND_ERROR "a scene that is not there: status ${status}:\n${out}${err}")
endif()
