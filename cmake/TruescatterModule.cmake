# One library per folder of src/. A module sees another module's headers only if it names it under
# UPSTREAM: each module exports an include folder that holds a link to itself and nothing else, so
# an include against the data flow (README, The code) does not compile.

add_library(truescatter_options INTERFACE)
target_compile_options(truescatter_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow
                       -Wnon-virtual-dtor -Wold-style-cast -Wcast-qual -Woverloaded-virtual)
# GCC 12 sees overlapping copies in concatenated std::strings that are not there (GCC bug 105329).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(truescatter_options INTERFACE -Wno-restrict)
endif()
if(TRUESCATTER_WERROR)
  target_compile_options(truescatter_options INTERFACE -Werror)
endif()
if(TRUESCATTER_ARCH AND CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(truescatter_options INTERFACE -march=${TRUESCATTER_ARCH})
endif()
# Packaged libraries (Ceres) were compiled for 16-byte alignment of Eigen's types; ours must agree
# even where wider vectors are enabled.
target_compile_definitions(truescatter_options INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
if(TRUESCATTER_SANITIZE)
  target_compile_options(truescatter_options INTERFACE -fsanitize=${TRUESCATTER_SANITIZE}
                         -fno-omit-frame-pointer -fno-sanitize-recover=all)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Instrumented, OpenMesh's and Eigen's unset temporaries look to GCC as if they were read.
    target_compile_options(truescatter_options INTERFACE -Wno-maybe-uninitialized)
  endif()
  target_link_options(truescatter_options INTERFACE -fsanitize=${TRUESCATTER_SANITIZE})
endif()

# For code in which a run spends no time: compiling it takes 40 % less.
set(truescatter_unhurried $<$<CONFIG:Release>:-O1>)

# truescatter_headers(<name> <options> <headers>) makes headers that targets of the same options share, by
# truescatter_precompiled(<target> <name>): reading Eigen, {fmt}, JSON and GoogleTest takes as long as compiling what is
# ours. Only where TRUESCATTER_PRECOMPILE asks for it: other presets show a missing include.
function(truescatter_headers name options)
  if(NOT TRUESCATTER_PRECOMPILE)
    return()
  endif()
  set(empty ${CMAKE_CURRENT_BINARY_DIR}/headers_${name}.cpp)
  file(CONFIGURE OUTPUT ${empty} CONTENT "" @ONLY)
  add_library(truescatter_headers_${name} OBJECT ${empty})
  set_target_properties(truescatter_headers_${name} PROPERTIES UNITY_BUILD OFF)
  target_compile_options(truescatter_headers_${name} PRIVATE ${options})
  target_link_libraries(truescatter_headers_${name} PRIVATE truescatter_options Eigen3::Eigen fmt::fmt
                        nlohmann_json::nlohmann_json $<$<STREQUAL:${name},tests>:GTest::gtest>
                        $<$<STREQUAL:${name},numeric_tests>:GTest::gtest>)
  target_precompile_headers(truescatter_headers_${name} PRIVATE ${ARGN})
endfunction()

function(truescatter_precompiled target name)
  if(TRUESCATTER_PRECOMPILE)
    target_precompile_headers(${target} REUSE_FROM truescatter_headers_${name})
  endif()
endfunction()

set(truescatter_large_headers <Eigen/Dense> <algorithm> <array> <cmath> <filesystem> <fmt/format.h> <functional> <map>
    <memory> <nlohmann/json.hpp> <optional> <string> <vector>)

# truescatter_module(<name> [UNHURRIED] SOURCES <files> [APART <files>] [UPSTREAM <modules>] [LIBRARIES <targets>]
#                    [PRIVATE_LIBRARIES <targets>])
# SOURCES are compiled several at a time where the preset asks for it (CMAKE_UNITY_BUILD), which takes a quarter of the
# time: most of it goes into headers. APART: files that are always compiled alone, because they name things as
# another file does. UNHURRIED: see truescatter_unhurried.
function(truescatter_module name)
  cmake_parse_arguments(ARG "UNHURRIED" "" "SOURCES;APART;UPSTREAM;LIBRARIES;PRIVATE_LIBRARIES" ${ARGN})
  set_source_files_properties(${ARG_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  set(include_root ${CMAKE_BINARY_DIR}/include/${name})
  file(MAKE_DIRECTORY ${include_root})
  file(CREATE_LINK ${CMAKE_SOURCE_DIR}/src/${name} ${include_root}/${name} SYMBOLIC)
  add_library(truescatter_${name} STATIC ${ARG_SOURCES} ${ARG_APART})
  target_include_directories(truescatter_${name} PUBLIC ${include_root})
  if(ARG_UNHURRIED)
    target_compile_options(truescatter_${name} PRIVATE ${truescatter_unhurried})
    truescatter_precompiled(truescatter_${name} unhurried)
  else()
    truescatter_precompiled(truescatter_${name} modules)
  endif()
  list(TRANSFORM ARG_UPSTREAM PREPEND truescatter_)
  target_link_libraries(truescatter_${name} PUBLIC ${ARG_UPSTREAM} ${ARG_LIBRARIES}
                        PRIVATE truescatter_options ${ARG_PRIVATE_LIBRARIES})
endfunction()

# truescatter_embed(<target> <namespace> <files>): makes each text file a std::string_view constant,
# looked up by its path relative to src/ through the generated function `<namespace>::embedded(path)`. A file
# from elsewhere is given by its absolute path, and looked up by its name.
function(truescatter_embed target namespace)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${target}_embedded.cpp)
  set(paths ${ARGN})
  list(TRANSFORM paths PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ REGEX "^[^/]")
  string(REPLACE ";" "," joined "${paths}")
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} -DOUTPUT=${output} -DNAMESPACE=${namespace} -DFILES=${joined}
            -DROOT=${CMAKE_SOURCE_DIR}/src -P ${CMAKE_SOURCE_DIR}/cmake/Embed.cmake
    DEPENDS ${paths} ${CMAKE_SOURCE_DIR}/cmake/Embed.cmake
    COMMENT "Embedding text files into ${target}")
  target_sources(${target} PRIVATE ${output})
endfunction()
