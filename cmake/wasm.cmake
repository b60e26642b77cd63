# WebAssembly by emscripten: the engine of a page (cmake/engine_page.cmake). Its stand-ins for the libraries that a page
# does not have, and its rooms.
set(FFP_WASM_LIBS "" CACHE PATH "Where zlib, libpng and Jansson lie, built by emscripten (script/test-wasm)")
set(FFPROCAMS_TESTS OFF)
set(FFPROCAMS_INSTALL OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE OFF) # a page is one piece

# Others' libraries by the names that rooms.cmake has for them. Those that are empty are not there.
foreach(entry PNG:libpng16.a,libz.a ZLIB:libz.a JANSSON:libjansson.a JPEG: OPENBLAS: OPENEXR: YAML: EXPAT:)
  string(REGEX MATCH "^(.+):(.*)$" entry ${entry})
  string(REPLACE "," ";" files "${CMAKE_MATCH_2}")
  list(TRANSFORM files PREPEND ${FFP_WASM_LIBS}/lib/)
  add_library(PkgConfig::${CMAKE_MATCH_1} INTERFACE IMPORTED)
  target_include_directories(PkgConfig::${CMAKE_MATCH_1} SYSTEM INTERFACE ${FFP_WASM_LIBS}/include)
  target_link_libraries(PkgConfig::${CMAKE_MATCH_1} INTERFACE ${files})
endforeach()

# One thread. Of OpenMP's pragmas the compiler knows `simd`, which takes no library.
add_library(OpenMP::OpenMP_C INTERFACE IMPORTED)
target_include_directories(OpenMP::OpenMP_C INTERFACE ${PROJECT_SOURCE_DIR}/wasm)
target_compile_options(OpenMP::OpenMP_C INTERFACE -fopenmp-simd)
target_compile_definitions(OpenMP::OpenMP_C INTERFACE FFP_NO_BLAS)

# Whole rooms, and of others what the page calls.
set(FFP_WASM_ROOMS base numerics image tensor gaussians capture denoise match network render loss refine view)
set(FFP_WASM_pipeline fit margins need normalised reconstruct refine relight)
set(FFP_WASM_import checks chord explain silhouettes suspect suspect_alias suspect_light suspect_pattern)
set(FFP_WASM_api arguments context gaussian_arrays handles memory page reconstruct)

# The room's sources in a page: those under src, or the files of the same name under wasm, and what wasm adds. None: the page has no such room.
function(ffp_wasm_sources out name)
  set(folder ${FFP_WING}/${name})
  if(DEFINED FFP_WASM_${name})
    list(TRANSFORM FFP_WASM_${name} REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/src/${folder}/\\1.c" OUTPUT_VARIABLE sources)
  elseif(name IN_LIST FFP_WASM_ROOMS)
    set(sources "${${out}}")
  else()
    set(sources "")
  endif()
  file(GLOB others CONFIGURE_DEPENDS wasm/${folder}/*.c)
  foreach(other ${others})
    get_filename_component(file ${other} NAME)
    list(FILTER sources EXCLUDE REGEX "/src/${folder}/${file}$")
    list(APPEND sources ${other})
  endforeach()
  set(${out} "${sources}" PARENT_SCOPE)
endfunction()
