# WebAssembly by emscripten: the engine of a page (cmake/engine_page.cmake). Its stand-ins for the libraries that a page
# does not have, and its rooms.
set(FFP_WASM_LIBS "" CACHE PATH "Where the libraries of others lie, built by emscripten (script/test-wasm)")
set(FFPROCAMS_TESTS OFF)
set(FFPROCAMS_INSTALL OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE OFF) # a page is one piece

# Others' libraries by the names that rooms.cmake has for them. Those that are empty are not there.
foreach(entry PNG:libpng16.a,libz.a ZLIB:libz.a JANSSON:libjansson.a JPEG:libjpeg.a YAML:libyaml.a EXPAT:libexpat.a OPENBLAS: OPENEXR:
              OPENCV:libopencv_calib3d.a,libopencv_features2d.a,libopencv_flann.a,libopencv_imgproc.a,libopencv_core.a)
  string(REGEX MATCH "^(.+):(.*)$" entry ${entry})
  string(REPLACE "," ";" files "${CMAKE_MATCH_2}")
  list(TRANSFORM files PREPEND ${FFP_WASM_LIBS}/lib/)
  add_library(PkgConfig::${CMAKE_MATCH_1} INTERFACE IMPORTED)
  target_include_directories(PkgConfig::${CMAKE_MATCH_1} SYSTEM INTERFACE ${FFP_WASM_LIBS}/include ${FFP_WASM_LIBS}/include/opencv4)
  target_link_libraries(PkgConfig::${CMAKE_MATCH_1} INTERFACE ${files})
endforeach()

# One thread: of OpenMP's pragmas the compiler knows `simd`, which takes no library. Or several, for pages that
# may share memory among threads: wasm/openmp.c is the library.
option(FFP_WASM_THREADS "The module of pages that are isolated from others (crossOriginIsolated)" OFF)
add_library(OpenMP::OpenMP_C INTERFACE IMPORTED)
target_include_directories(OpenMP::OpenMP_C INTERFACE ${PROJECT_SOURCE_DIR}/wasm)
target_compile_options(OpenMP::OpenMP_C INTERFACE $<IF:$<BOOL:${FFP_WASM_THREADS}>,-fopenmp;-pthread,-fopenmp-simd>)
target_compile_definitions(OpenMP::OpenMP_C INTERFACE FFP_NO_BLAS)

# The rooms that a page has: whole, but for the calls (api), of which it has those that take no other room.
set(FFP_WASM_ROOMS base numerics image tensor gaussians capture patterns denoise match network render loss refine align apply
                   pipeline findings optics graycode shots chessboard turntable masks checks response import calibrate selfcal
                   baselines eval view export describe api)
function(ffp_wasm_calls out)
  set(kept "")
  foreach(source ${${out}})
    file(STRINGS ${source} includes REGEX "^#include \"[a-z]+/[a-z]+/")
    list(TRANSFORM includes REPLACE "^#include \"[a-z]+/([a-z]+)/.*" "\\1")
    list(REMOVE_ITEM includes ${FFP_WASM_ROOMS} cuda) # a header alone: there is no GPU
    if(NOT includes)
      list(APPEND kept ${source})
    endif()
  endforeach()
  set(${out} "${kept}" PARENT_SCOPE)
endfunction()

# The room's sources in a page: those under src, or the files of the same name under wasm, and what wasm adds. None: the page has no such room.
function(ffp_wasm_sources out name)
  set(folder ${FFP_WING}/${name})
  set(sources "${${out}}")
  if(NOT name IN_LIST FFP_WASM_ROOMS)
    set(sources "")
  endif()
  if(name STREQUAL "api")
    ffp_wasm_calls(sources)
  endif()
  file(GLOB others CONFIGURE_DEPENDS wasm/${folder}/*.c)
  foreach(other ${others})
    get_filename_component(file ${other} NAME)
    list(FILTER sources EXCLUDE REGEX "/src/${folder}/${file}$")
    list(APPEND sources ${other})
  endforeach()
  set(${out} "${sources}" PARENT_SCOPE)
endfunction()
