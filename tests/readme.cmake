# The quick start in README.md is examples/quickstart.cpp, word for word, and that is compiled.
file(READ "${SOURCE_DIRECTORY}/README.md" readme)
file(READ "${SOURCE_DIRECTORY}/examples/quickstart.cpp" quickstart)
string(FIND "${readme}" "${quickstart}" at)
if(at EQUAL -1)
  message(FATAL_ERROR "README.md does not show examples/quickstart.cpp as it is")
endif()
