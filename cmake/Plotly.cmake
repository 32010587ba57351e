# plotly.js for the report's charts: the one part that comes from npm's registry, when configuring. Where npm is
# missing or the registry does not answer, the charts are plain SVG.
option(TRUESCATTER_PLOTLY "Draw the report's charts with plotly.js, fetched by npm when configuring" ON)
set(TRUESCATTER_PLOTLY_VERSION 3.7.0)
set(TRUESCATTER_PLOTLY_SHA256 671aa70a322bd6222a233be824d0f148c08f08c3cc64c85d1a409bd89d17a39d)

# truescatter_fetch_plotly(<variable>): the files to embed, the script and its licence; empty without them.
# Fetched once into the build tree, and taken only if it is the very package named above.
function(truescatter_fetch_plotly variable)
  set(${variable} "" PARENT_SCOPE)
  if(NOT TRUESCATTER_PLOTLY)
    message(STATUS "Report: charts are plain SVG (TRUESCATTER_PLOTLY is off)")
    return()
  endif()
  set(folder ${CMAKE_BINARY_DIR}/plotly)
  set(package ${folder}/plotly.js-basic-dist-min-${TRUESCATTER_PLOTLY_VERSION}.tgz)
  if(NOT EXISTS ${package})
    find_program(NPM_PROGRAM npm)
    if(NOT NPM_PROGRAM)
      message(STATUS "Report: charts are plain SVG (npm, which fetches plotly.js, was not found)")
      return()
    endif()
    file(MAKE_DIRECTORY ${folder})
    execute_process(
      COMMAND ${NPM_PROGRAM} pack plotly.js-basic-dist-min@${TRUESCATTER_PLOTLY_VERSION}
              --silent --fetch-retries=1 --fetch-timeout=20000
      WORKING_DIRECTORY ${folder} TIMEOUT 60 RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
    if(failed OR NOT EXISTS ${package})
      message(STATUS "Report: charts are plain SVG (npm could not fetch plotly.js ${TRUESCATTER_PLOTLY_VERSION}: ${failed})")
      return()
    endif()
  endif()
  file(SHA256 ${package} found)
  if(NOT found STREQUAL TRUESCATTER_PLOTLY_SHA256)
    file(REMOVE ${package})
    message(STATUS "Report: charts are plain SVG (plotly.js was fetched with the SHA-256 ${found}, "
                   "which is not that of ${TRUESCATTER_PLOTLY_VERSION})")
    return()
  endif()
  file(ARCHIVE_EXTRACT INPUT ${package} DESTINATION ${folder})
  message(STATUS "Report: charts by plotly.js ${TRUESCATTER_PLOTLY_VERSION}")
  set(${variable} ${folder}/package/plotly-basic.min.js ${folder}/package/LICENSE PARENT_SCOPE)
endfunction()
