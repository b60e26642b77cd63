# tests/WING/ROOM/test_*.c are programs of their own; *_f64.c among them see the double build of the rooms.
# Labels (ctest -L): unit, cli (the program, run as its users run it), gpu (runs on one if there is one, otherwise emulated), browser,
# install. A test program names its others itself, in a line of its own: "// Labels: slow threads".
#   slow     ten seconds of a processor or more; begins first
#   threads  threads side by side: what ThreadSanitizer runs (FFPROCAMS_SANITIZE=thread), and the target thread_tests builds
add_custom_target(thread_tests)
get_property(rooms DIRECTORY PROPERTY FFP_ROOMS)
list(APPEND rooms product/cli)
if(TARGET ffp_cuda)
  list(APPEND rooms engine/cuda)
endif()
if(CMOCKA_FOUND)
  foreach(place ${rooms})
    get_filename_component(room ${place} NAME)
    file(GLOB tests CONFIGURE_DEPENDS tests/${place}/test_*.c)
    foreach(source ${tests})
      get_filename_component(test ${source} NAME_WE)
      add_executable(${test} ${source})
      if(test MATCHES "_f64$")
        target_link_libraries(${test} PRIVATE ffp_${room}_f64 PkgConfig::CMOCKA)
      elseif(room STREQUAL "cli")
        target_link_libraries(${test} PRIVATE ffp_api PkgConfig::CMOCKA)
        target_compile_definitions(${test} PRIVATE FFP_PROGRAM="$<TARGET_FILE:ffprocams>" FFP_HAS_MPI=$<BOOL:${FFPROCAMS_MPI}>)
        add_dependencies(${test} ffprocams)
      elseif(room STREQUAL "cuda")
        target_link_libraries(${test} PRIVATE ffp_cuda ffp_api PkgConfig::CMOCKA)
      else()
        target_link_libraries(${test} PRIVATE ffp_${room} PkgConfig::CMOCKA)
      endif()
      if(room STREQUAL "image") # they write files too
        target_link_libraries(${test} PRIVATE PkgConfig::TIFF PkgConfig::LCMS)
      endif()
      target_compile_definitions(${test} PRIVATE FFP_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
      target_include_directories(${test} PRIVATE tests)
      add_test(NAME ${test} COMMAND ${test} WORKING_DIRECTORY ${PROJECT_BINARY_DIR})
      set(labels unit)
      if(room STREQUAL "cli")
        set(labels cli)
      elseif(room STREQUAL "cuda")
        list(APPEND labels gpu)
      endif()
      file(STRINGS ${source} named REGEX "^// Labels: " LIMIT_COUNT 1)
      string(REPLACE "// Labels: " "" named "${named}")
      separate_arguments(named)
      list(APPEND labels ${named})
      if("threads" IN_LIST labels)
        add_dependencies(thread_tests ${test})
      endif()
      set_tests_properties(${test} PROPERTIES LABELS "${labels}")
      if(test MATCHES "_f64$") # thousands of tiny problems: a second thread costs more than it does
        set_tests_properties(${test} PROPERTIES ENVIRONMENT OMP_NUM_THREADS=1)
      endif()
    endforeach()
  endforeach()
endif()

# Tests of what the library looks like from outside: its headers, its examples, and what is installed.
add_test(NAME headers COMMAND ${PROJECT_SOURCE_DIR}/script/test-headers ${PROJECT_BINARY_DIR} ${CMAKE_C_COMPILER} ${CMAKE_CXX_COMPILER})

add_subdirectory(examples)
add_test(NAME example_reconstruct
         COMMAND example_reconstruct ${PROJECT_SOURCE_DIR}/data/sample ${PROJECT_BINARY_DIR}/example.ply)
add_test(NAME example_roles
         COMMAND ${PROJECT_SOURCE_DIR}/tests/examples/roles.sh $<TARGET_FILE:example_reconstruct> ${PROJECT_SOURCE_DIR}/data/sample)
add_test(NAME example_relight
         COMMAND example_relight ${PROJECT_BINARY_DIR}/example.ply ${PROJECT_SOURCE_DIR}/data/sample ${PROJECT_BINARY_DIR}/example.ppm)
add_test(NAME example_progress COMMAND example_progress ${PROJECT_SOURCE_DIR}/data/sample 100)
add_test(NAME example_cancel COMMAND example_progress ${PROJECT_SOURCE_DIR}/data/sample 0.2)
set_tests_properties(example_relight PROPERTIES DEPENDS example_reconstruct)
set_tests_properties(example_progress PROPERTIES PASS_REGULAR_EXPRESSION "done: [0-9]+ Gaussians")
set_tests_properties(example_cancel PROPERTIES PASS_REGULAR_EXPRESSION "stopped after")

# The documents' examples, in a minute; sanitized they take too long.
if(NOT FFPROCAMS_SANITIZE)
  add_test(NAME readme COMMAND ${PROJECT_SOURCE_DIR}/tests/product/cli/readme.sh $<TARGET_FILE:ffprocams> $<TARGET_FILE:ffprocams_shared>)
endif()

# A release carries the notices of the libraries in it.
add_test(NAME third_party COMMAND ${PROJECT_SOURCE_DIR}/tests/script/third_party.sh)

# The documents: links that exist, plain English, figures as measured.
find_program(FFP_PYTHON python3)
if(FFP_PYTHON)
  add_test(NAME links COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/script/test-links)
  add_test(NAME words COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/script/test-words)
  add_test(NAME measured COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/script/test_measure.py)
endif()

# script/gpu-run on the emulation: the program whose --device cuda it is, and the script's slices, tiny.
if(TARGET ffp_cuda AND NOT FFPROCAMS_CUDA AND CMOCKA_FOUND AND TARGET ffprocams_embree AND FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_executable(ffprocams_emulated ${cli_sources} src/product/api/context.c) # context.c in the place of the archive's
  target_compile_definitions(ffprocams_emulated PRIVATE FFP_WITH_CUDA)
  target_link_libraries(ffprocams_emulated PRIVATE ffp_api ffp_cuda PkgConfig::JANSSON)
  add_test(NAME gpu_run COMMAND ${PROJECT_SOURCE_DIR}/script/gpu-run rehearse ${PROJECT_BINARY_DIR})
endif()

# The page of `ffprocams view` in a headless Chromium, and its lit pixels in Firefox and WebKit; what is not installed is skipped.
if(FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME view_page COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/view/test_view.py $<TARGET_FILE:ffprocams>
           ${PROJECT_SOURCE_DIR}/data/sample ${PROJECT_BINARY_DIR}/view-page)
  add_test(NAME view_scatter COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/view/test_scatter.py $<TARGET_FILE:ffprocams>
           ${PROJECT_SOURCE_DIR}/data/sample)
  add_test(NAME view_engines COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/view/test_engines.py $<TARGET_FILE:ffprocams>
           ${PROJECT_SOURCE_DIR}/data/sample ${PROJECT_BINARY_DIR}/view-engines)
  add_test(NAME view_guard COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/view/test_guard.py $<TARGET_FILE:ffprocams>
           ${PROJECT_SOURCE_DIR}/data/sample ${PROJECT_BINARY_DIR}/view-guard)
  set_tests_properties(view_page view_engines view_guard view_scatter PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 1500)
elseif(NOT FFP_PYTHON)
  message(STATUS "The page of `ffprocams view` is not tested: there is no python3")
endif()

# The page's logic without a browser; the test before has it in one.
find_program(FFP_NODE node)
if(FFP_NODE)
  add_test(NAME view_place COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/view/test_place.js)
  add_test(NAME studio_watch COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/studio/test_watch.js)
  add_test(NAME studio_link COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/studio/test_link.js)
  add_test(NAME studio_kept COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/studio/test_kept.js)
  add_test(NAME view_zip COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/view/test_zip.js)
  add_test(NAME view_contents COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/view/test_contents.js)
  add_test(NAME view_nudge COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/view/test_nudge.js)
  add_test(NAME view_control COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/view/test_control.js)
  add_test(NAME view_surfaces COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/view/test_surfaces.js)
  add_test(NAME view_show COMMAND ${FFP_NODE} ${PROJECT_SOURCE_DIR}/tests/product/view/test_show.js)
endif()

# All pages' scripts by TypeScript's compiler; without it (or without Python) that is skipped.
if(FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME view_scripts COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/view/test_scripts.py)
  set_tests_properties(view_scripts PROPERTIES SKIP_RETURN_CODE 77)
endif()

# The studio in a headless Chromium, from a bare simulated rig to the relit object.
if(TARGET PkgConfig::MICROHTTPD AND TARGET ffprocams_opencv AND TARGET ffprocams_embree AND FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME studio_page COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/studio/test_studio.py $<TARGET_FILE:ffprocams>
           ${PROJECT_BINARY_DIR}/studio-page)
  set_tests_properties(studio_page PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 1500)
endif()
# A second projector in it, with a browser or without.
if(TARGET PkgConfig::MICROHTTPD AND TARGET ffprocams_opencv AND TARGET ffprocams_embree AND FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME studio_second COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/studio/test_second.py $<TARGET_FILE:ffprocams>
           ${PROJECT_BINARY_DIR}/studio-second)
  set_tests_properties(studio_second PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 600)
endif()
if(TARGET PkgConfig::MICROHTTPD AND FFP_PYTHON)
  add_test(NAME studio_server COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/studio/test_server.py $<TARGET_FILE:ffprocams>
           ${PROJECT_BINARY_DIR}/studio-server)
endif()

# Files of each part, read by the others; of the page that reconstructs where script/test-wasm has built it.
if(TARGET ffprocams_embree AND FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME matrix COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/product/test_matrix.py $<TARGET_FILE:ffprocams>
           ${PROJECT_BINARY_DIR}/matrix ${PROJECT_SOURCE_DIR}/build-wasm/ffprocams.html)
  set_tests_properties(matrix PROPERTIES TIMEOUT 1500)
endif()

# Includes and symbols against the plan of the rooms.
if(FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME house COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/script/test-house ${PROJECT_BINARY_DIR})
endif()

# From bare devices to new poses, on a simulated rig: calibrate's OpenCV is needed, and Python for the figures.
if(TARGET ffprocams_opencv AND FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME simulated_rig COMMAND ${PROJECT_SOURCE_DIR}/script/simulated-rig ${PROJECT_BINARY_DIR})
  set_tests_properties(simulated_rig PROPERTIES ENVIRONMENT "HEIGHT=180;WIDTH=96;ATTITUDES=6") # in a minute
endif()

# A room to learn from, the smallest.
if(TARGET ffprocams_embree AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME training_rooms COMMAND ${PROJECT_SOURCE_DIR}/tests/lab/train/training_rooms.sh ${PROJECT_BINARY_DIR})
endif()

# A sanitized library asks all that link it for the sanitizers.
if(FFPROCAMS_INSTALL AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME install COMMAND ${PROJECT_SOURCE_DIR}/script/test-install ${PROJECT_BINARY_DIR})
endif()

# A script or another program, by its labels.
function(ffp_label labels)
  foreach(test ${ARGN})
    if(TEST ${test})
      set_property(TEST ${test} PROPERTY LABELS ${labels})
    endif()
  endforeach()
endfunction()
ffp_label(unit headers house links words)
ffp_label(cli example_reconstruct example_roles example_relight example_progress example_cancel)
ffp_label("cli;slow" readme simulated_rig studio_server training_rooms)
ffp_label("browser;slow" view_page view_engines view_guard view_scatter studio_page matrix)
ffp_label("gpu;slow" gpu_run)
ffp_label("install;slow" install)
if(TEST test_bench)
  set_property(TEST test_bench PROPERTY RUN_SERIAL ON) # it holds kernels to a peak that it has measured
endif()

get_property(tests DIRECTORY PROPERTY TESTS)
foreach(test ${tests})
  get_property(labels TEST ${test} PROPERTY LABELS)
  # The longest begin first, so that none is left alone at the end; scripts are longer than programs, browsers than scripts.
  if("slow" IN_LIST labels)
    set_property(TEST ${test} PROPERTY COST 100)
    if(NOT TARGET ${test})
      set_property(TEST ${test} PROPERTY COST 1000)
    endif()
    if("browser" IN_LIST labels)
      set_property(TEST ${test} PROPERTY COST 2000)
    endif()
  endif()
endforeach()

# LLVM's archer informs ThreadSanitizer of the order that OpenMP's barriers impose.
if(FFPROCAMS_SANITIZE STREQUAL "thread")
  execute_process(COMMAND ${CMAKE_C_COMPILER} -print-resource-dir OUTPUT_VARIABLE clang OUTPUT_STRIP_TRAILING_WHITESPACE)
  find_library(FFP_ARCHER archer PATHS ${clang}/../.. REQUIRED)
  set_property(TEST ${tests} APPEND PROPERTY ENVIRONMENT "OMP_TOOL_LIBRARIES=${FFP_ARCHER}"
               "TSAN_OPTIONS=ignore_noninstrumented_modules=1") # OpenBLAS, Embree
endif()

# libomp (clang's OpenMP) gives some of its own threads' tables back to nobody when their number changes. LeakSanitizer of clang 14
# crashes now and then ("Tracer caught signal 11") over thread-local memory of libraries loaded later (Embree), where it keeps track of it.
if(FFPROCAMS_SANITIZE STREQUAL "address")
  set_property(TEST ${tests} APPEND PROPERTY ENVIRONMENT "LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/cmake/leaks.txt:print_suppressions=0:intercept_tls_get_addr=0")
endif()
