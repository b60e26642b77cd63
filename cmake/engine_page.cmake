# The engine as a page: BUILD FOLDER/ffprocams.html is view/engine.html with the engine as WebAssembly and the weights in it (script/test-wasm).
include(cmake/page.cmake)
target_compile_options(ffp_native INTERFACE -msimd128)

# The command line too, inside the engine, but for the commands that a page does not have.
file(GLOB cli_sources CONFIGURE_DEPENDS src/product/cli/*.c)
list(FILTER cli_sources EXCLUDE REGEX "/(bench|child|commands|generate|refine|stack|studio|train|waiting)\\.c$")
file(GLOB cli_own CONFIGURE_DEPENDS wasm/product/cli/*.c)
# The studio's rules, and the page as their platform.
file(GLOB studio_rules CONFIGURE_DEPENDS src/product/studio/*.c wasm/product/studio/*.c)
enable_language(CXX) # OpenCV's
add_executable(engine wasm/engine.c ${cli_sources} ${cli_own} ${studio_rules} src/rig/chessboard/opencv_module.cc)
set_source_files_properties(src/product/cli/main.c PROPERTIES COMPILE_OPTIONS "-Dmain=command_line;-Wno-missing-prototypes")
set_source_files_properties(src/rig/chessboard/opencv_module.cc PROPERTIES COMPILE_OPTIONS -fexceptions)
set_target_properties(engine PROPERTIES OUTPUT_NAME module C_EXTENSIONS ON) # MAIN_THREAD_EM_ASM
target_link_libraries(engine PRIVATE ffp_api ffp_compile PkgConfig::OPENCV)
target_include_directories(engine PRIVATE ${FFP_INCLUDE})
# -O1: the objects are optimised already, and more takes minutes here. Memory as it is needed, up to what 32-bit addresses reach.
target_link_options(engine PRIVATE -O1 -sMODULARIZE=1 -sEXPORT_NAME=makeEngine -sENVIRONMENT=worker -sALLOW_MEMORY_GROWTH=1 -sINITIAL_MEMORY=268435456 -sMAXIMUM_MEMORY=4294967296
                    -sTOTAL_STACK=8388608 -sFORCE_FILESYSTEM=1 -fexceptions -sEXPORTED_RUNTIME_METHODS=FS,ENV,ccall,UTF8ToString
                    -sEXPORTED_FUNCTIONS=_engine_command,_engine_open,_engine_run,_engine_save,_engine_peak,_studio_open,_studio_state,_studio_post,_studio_work,_studio_hear,_malloc,_free --no-entry)

if(FFP_WASM_THREADS) # a worker for each processor beside the engine's own, made before it begins
  target_sources(engine PRIVATE wasm/openmp.c)
  set_target_properties(engine PROPERTIES OUTPUT_NAME threads)
  target_link_options(engine PRIVATE -pthread -Wno-pthreads-mem-growth "-sPTHREAD_POOL_SIZE=Math.min(navigator.hardwareConcurrency, 16) - 1")
  return()
endif()

set(FFP_WASM_WITH_THREADS "" CACHE PATH "Build folder of the module with threads, which the page gets too")
set(payload ${PROJECT_SOURCE_DIR}/models/small.safetensors ${PROJECT_SOURCE_DIR}/models/README.md ${PROJECT_SOURCE_DIR}/LICENSE ${FFP_WASM_LIBS}/THIRD-PARTY)
if(FFP_WASM_WITH_THREADS)
  list(APPEND payload threads.js threads.worker.js threads.wasm)
  list(TRANSFORM payload PREPEND ${FFP_WASM_WITH_THREADS}/ REGEX "^threads")
endif()
set(FFP_WASM_RIG "" CACHE FILEPATH "A simulated rig for the page's studio (wasm/rig)")
list(APPEND payload ${FFP_WASM_RIG})
ffp_page(engine ffp_page_engine ${PROJECT_BINARY_DIR}/page_engine.c)
set(inner ${PROJECT_BINARY_DIR}/inner) # pages inside it, by their elements' names
ffp_page(studio ffp_page_studio ${inner}/studio studio_server.js=studio_page.js)
ffp_page(studio_projector ffp_page_projector ${inner}/projector)
add_custom_command(OUTPUT ${PROJECT_BINARY_DIR}/ffprocams.html
                   COMMAND sh ${PROJECT_SOURCE_DIR}/wasm/join ${PROJECT_BINARY_DIR}/page_engine.c.html ${PROJECT_BINARY_DIR}/module.js
                           ${PROJECT_BINARY_DIR}/module.wasm ${inner}/studio.html ${inner}/projector.html ${payload}
                           > ${PROJECT_BINARY_DIR}/ffprocams.html
                   DEPENDS ${PROJECT_BINARY_DIR}/page_engine.c ${inner}/studio ${inner}/projector engine wasm/join ${payload})
add_custom_target(engine_page DEPENDS ${PROJECT_BINARY_DIR}/ffprocams.html)
