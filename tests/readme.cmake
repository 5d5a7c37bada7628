# The quick start in README.md is examples/quickstart.cpp, word for word, and what README shows below it is what the
# program prints, where examples are built.
file(READ "${SOURCE_DIRECTORY}/README.md" readme)
file(READ "${SOURCE_DIRECTORY}/examples/quickstart.cpp" quickstart)
string(FIND "${readme}" "${quickstart}" at)
if(at EQUAL -1)
  message(FATAL_ERROR "README.md does not show examples/quickstart.cpp as it is")
endif()

if(QUICKSTART)
  execute_process(COMMAND "${QUICKSTART}" OUTPUT_VARIABLE output RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "the quick start ended with ${status}")
  endif()
  string(FIND "${readme}" "${output}" at)
  if(output STREQUAL "" OR at EQUAL -1)
    message(FATAL_ERROR "README.md does not show what the quick start prints: ${output}")
  endif()
endif()
