# kinemesh_module(NAME [USES module...] [PUBLIC target...] [PRIVATE target...])
# One static library from all sources below the current folder. USES names the Kinemesh modules
# that it may include.
function(kinemesh_module NAME)
  cmake_parse_arguments(ARG "" "" "USES;PUBLIC;PRIVATE" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.h")
  add_library(kinemesh_${NAME} STATIC ${sources} ${headers})
  add_library(kinemesh::${NAME} ALIAS kinemesh_${NAME})
  set_target_properties(kinemesh_${NAME} PROPERTIES EXPORT_NAME ${NAME})
  list(TRANSFORM ARG_USES PREPEND kinemesh_)
  target_link_libraries(kinemesh_${NAME}
    PUBLIC ${ARG_USES} ${ARG_PUBLIC}
    PRIVATE $<BUILD_INTERFACE:kinemesh_compiler> ${ARG_PRIVATE})
  target_include_directories(kinemesh_${NAME} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/kinemesh>)
  install(TARGETS kinemesh_${NAME} EXPORT kinemeshTargets ARCHIVE COMPONENT development)
  install(DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}/" COMPONENT development
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/kinemesh/${NAME} FILES_MATCHING PATTERN "*.h")
endfunction()
