# The chart's command line: cmake -DCHART=PROGRAM -DDIRECTORY=SCRATCH -DGNUPLOT=PROGRAM -P chart_cli.cmake
#
# What cannot be ends with one line on stderr, nothing on stdout and exit status 2; what can be leaves numbers, charts,
# pictures and a page, cut short or not.
cmake_minimum_required(VERSION 3.22)

function(expect_refusal)
  execute_process(
    COMMAND "${CHART}" ${ARGN}
    RESULT_VARIABLE status
    OUTPUT_VARIABLE out
    ERROR_VARIABLE err)
  if(NOT status EQUAL 2
     OR NOT out STREQUAL ""
     OR NOT err MATCHES "^chart: [^\n]+\n$")
    message(SEND_ERROR "chart ${ARGN}: expected status 2 and one line, got status ${status}:\n${out}${err}")
  endif()
endfunction()

function(expect_success)
  execute_process(
    COMMAND ${ARGN}
    RESULT_VARIABLE status
    OUTPUT_VARIABLE out
    ERROR_VARIABLE err)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}: expected status 0, got ${status}:\n${out}${err}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

# All files of a kind, at least so many, must match.
function(expect_files at_least regex glob)
  file(GLOB files "${glob}")
  list(LENGTH files count)
  if(count LESS at_least)
    message(SEND_ERROR "${count} files ${glob}, expected ${at_least}")
  endif()
  foreach(file IN LISTS files)
    file(READ "${file}" text)
    if(NOT text MATCHES "${regex}")
      message(SEND_ERROR "${file} is not what it should be")
    endif()
  endforeach()
endfunction()

file(REMOVE_RECURSE "${DIRECTORY}")
file(MAKE_DIRECTORY "${DIRECTORY}")
file(WRITE "${DIRECTORY}/not_a_directory" "")
file(WRITE "${DIRECTORY}/not_a_chart.csv" "a,b\n1,2\n")

expect_refusal(--no-such-option)
expect_refusal(stray)
expect_refusal(--scenes no-such-scene)
expect_refusal(--scenes tree,no-such-scene)
expect_refusal(--scenes "")
expect_refusal(--growth no-such-series)
expect_refusal(--variants color-cube,no-such-variant)
foreach(number IN ITEMS 0 -1 nan inf far)
  expect_refusal(--distances 7,${number})
endforeach()
foreach(number IN ITEMS -1 nan inf coarse)
  expect_refusal(--tolerances 1,${number})
endforeach()
foreach(number IN ITEMS 0 3 81 -1 4x)
  expect_refusal(--samples 1,${number})
endforeach()
expect_refusal(--angle nan)
foreach(number IN ITEMS 0 -1 2.5 many)
  expect_refusal(--repetitions ${number})
endforeach()
expect_refusal(--size 7)
expect_refusal(--size 1001)
expect_refusal(--out "${DIRECTORY}/not_a_directory")
expect_refusal(--from "${DIRECTORY}/no_such.csv")
expect_refusal(--from "${DIRECTORY}/not_a_chart.csv")

expect_success("${CHART}" --help)
expect_success("${CHART}" --list)
foreach(part IN ITEMS tree quadrupled-forest exact color-cube exact[+]masks exact[+]masks-by-table ${STRICT})
  if(NOT out MATCHES "${part}")
    message(SEND_ERROR "--list does not tell about ${part}")
  endif()
endforeach()

function(expect_chart directory)
  expect_files(1 "^chart,scene,.*\naccuracy,tree,52470," "${directory}/chart.csv")
  expect_files(1 "</html>" "${directory}/index.html")
  expect_files(3 "set output" "${directory}/charts/*.gp")
  if(GNUPLOT)
    expect_files(3 "</svg>" "${directory}/charts/*.svg")
    file(READ "${directory}/index.html" html)
    if(NOT html MATCHES "<img src=\"charts/time_tree_14_radii.svg\"")
      message(SEND_ERROR "${directory}/index.html does not show its charts")
    endif()
  endif()
endfunction()

set(tiny --quick --scenes tree --growth tree --variants color-cube --distances 14 --tolerances 1,4 --samples 1
    --repetitions 2 --size 32)
expect_success("${CHART}" ${tiny} --out "${DIRECTORY}/tiny")
expect_chart("${DIRECTORY}/tiny")
file(STRINGS "${DIRECTORY}/tiny/chart.csv" lines)
list(LENGTH lines count)
# The header; exact at 1, 4, 16 and 64 samples; the peer at 1 and 64; two tolerances; exact, cubes and peer over three trees.
if(NOT count EQUAL 18)
  message(SEND_ERROR "${count} lines in chart.csv, expected 18")
endif()
foreach(picture IN ITEMS reference exact exact_difference color-cube color-cube_difference)
  if(NOT EXISTS "${DIRECTORY}/tiny/pictures/tree_${picture}.png")
    message(SEND_ERROR "there is no picture of tree: ${picture}")
  endif()
endforeach()

# Each row of accuracy has its picture, and the page finds it.
file(GLOB pictures "${DIRECTORY}/tiny/pictures/points/*.png")
list(LENGTH pictures count)
file(READ "${DIRECTORY}/tiny/index.html" html)
if(NOT count EQUAL 9
   OR NOT html MATCHES "\"pictures/points/tree_14_radii_color-cube_1_4.png\",\"pictures/points/tree_14_radii_reference.png\"")
  message(SEND_ERROR "${count} pictures of points, expected those of eight rows and the reference, which the page shows")
endif()
if(html MATCHES "https?:")
  message(SEND_ERROR "the page wants a network")
endif()

# With coverage masks, once, at 64 samples whatever is asked for.
expect_success("${CHART}" --scenes tree --growth none --variants exact+masks --distances 14 --samples 1,4 --repetitions 1
               --size 32 --out "${DIRECTORY}/masks")
file(STRINGS "${DIRECTORY}/masks/chart.csv" lines REGEX "exact[+]masks,64,")
list(LENGTH lines count)
if(NOT count EQUAL 1 OR NOT EXISTS "${DIRECTORY}/masks/pictures/tree_exact+masks.png")
  message(SEND_ERROR "expected one row and a picture with masks, got ${count} rows")
endif()

# Drawn again, elsewhere, from a file that was cut short in its last line.
file(READ "${DIRECTORY}/tiny/chart.csv" csv)
string(LENGTH "${csv}" length)
math(EXPR length "${length} - 20")
string(SUBSTRING "${csv}" 0 ${length} csv)
file(WRITE "${DIRECTORY}/cut.csv" "${csv}")
expect_success("${CHART}" --from "${DIRECTORY}/cut.csv" --out "${DIRECTORY}/again")
expect_chart("${DIRECTORY}/again")

# Interrupted after its first row.
find_program(SHELL sh)
if(SHELL)
  # Lines, not semicolons: those would be lists.
  set(script "\"$0\" \"$@\" &\nchart=$!\nuntil grep -q accuracy \"$CSV\" 2>/dev/null\ndo sleep 0.1\ndone\nkill -INT $chart\nwait $chart")
  expect_success("${CMAKE_COMMAND}" -E env "CSV=${DIRECTORY}/interrupted/chart.csv" "${SHELL}" -c "${script}" "${CHART}"
                 --quick --scenes tree,forest --size 200 --repetitions 1000 --out "${DIRECTORY}/interrupted")
  expect_files(1 "^chart,scene,.*\naccuracy,tree,52470," "${DIRECTORY}/interrupted/chart.csv")
  expect_files(1 "</html>" "${DIRECTORY}/interrupted/index.html")
  if(GNUPLOT)
    expect_files(1 "</svg>" "${DIRECTORY}/interrupted/charts/*.svg")
  endif()
endif()
