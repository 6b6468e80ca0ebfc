# kinemesh_precompile(TARGET [ALWAYS] [FROM OTHER] [HEADERS <header>...]): with KINEMESH_PRECOMPILE or
# ALWAYS, parses the headers that nearly every file includes once for the target, or takes what OTHER
# parsed (its compile flags must be the same). The presets release and sanitizers precompile, which keeps
# CI within half an hour; the preset debug does not, and shows an include that is missing.
option(KINEMESH_PRECOMPILE "Precompile the common headers" OFF)

function(kinemesh_precompile TARGET)
  cmake_parse_arguments(ARG "ALWAYS" "FROM" "HEADERS" ${ARGN})
  if(NOT KINEMESH_PRECOMPILE AND NOT ARG_ALWAYS)
    return()
  endif()
  if(ARG_FROM)
    target_precompile_headers(${TARGET} REUSE_FROM ${ARG_FROM})
    return()
  endif()
  target_precompile_headers(${TARGET} PRIVATE
    <algorithm> <array> <charconv> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory>
    <numeric> <optional> <set> <span> <sstream> <string> <string_view> <vector>
    <Eigen/Core> <Eigen/Geometry> ${ARG_HEADERS})
endfunction()
