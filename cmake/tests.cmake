# tests/<room>/test_*.c are programs of their own; *_f64.c among them see the double build of the rooms.
if(CMOCKA_FOUND)
  foreach(room base image patterns tensor capture denoise gaussians match network render loss synth train bench rig calibrate align refine field apply export api eval cli cuda)
    if(NOT room STREQUAL "cli" AND NOT TARGET ffp_${room})
      continue()
    endif()
    file(GLOB tests CONFIGURE_DEPENDS tests/${room}/test_*.c)
    foreach(source ${tests})
      get_filename_component(test ${source} NAME_WE)
      add_executable(${test} ${source})
      if(test MATCHES "_f64$")
        target_link_libraries(${test} PRIVATE ffp_${room}_f64 PkgConfig::CMOCKA)
      elseif(room STREQUAL "cli")
        target_link_libraries(${test} PRIVATE ffp_eval PkgConfig::CMOCKA)
        target_compile_definitions(${test} PRIVATE FFP_PROGRAM="$<TARGET_FILE:ffprocams>" FFP_HAS_MPI=$<BOOL:${FFPROCAMS_MPI}>)
        add_dependencies(${test} ffprocams)
      elseif(room STREQUAL "cuda")
        target_link_libraries(${test} PRIVATE ffp_cuda ffp_eval PkgConfig::CMOCKA)
      elseif(room STREQUAL "api") # evaluation is a call of the public header too
        target_link_libraries(${test} PRIVATE ffp_eval PkgConfig::CMOCKA)
      else()
        target_link_libraries(${test} PRIVATE ffp_${room} PkgConfig::CMOCKA)
      endif()
      target_compile_definitions(${test} PRIVATE FFP_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
      target_include_directories(${test} PRIVATE tests)
      add_test(NAME ${test} COMMAND ${test} WORKING_DIRECTORY ${PROJECT_BINARY_DIR})
    endforeach()
  endforeach()
endif()

# Tests of what the library looks like from outside: its headers, its examples, and what is installed.
add_test(NAME headers COMMAND ${PROJECT_SOURCE_DIR}/script/test-headers ${CMAKE_C_COMPILER} ${CMAKE_CXX_COMPILER})

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

# README.md's examples, in a minute; sanitized they take too long.
if(NOT FFPROCAMS_SANITIZE)
  add_test(NAME readme COMMAND ${PROJECT_SOURCE_DIR}/tests/cli/readme.sh $<TARGET_FILE:ffprocams> $<TARGET_FILE:ffprocams_shared>)
endif()

# The page of `ffprocams view` in a headless Chromium; without one (or without Python) it is skipped.
find_program(FFP_PYTHON python3)
if(FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME view_page COMMAND ${FFP_PYTHON} ${PROJECT_SOURCE_DIR}/tests/view/test_view.py $<TARGET_FILE:ffprocams>
           ${PROJECT_SOURCE_DIR}/data/sample ${PROJECT_BINARY_DIR}/view-page)
  set_tests_properties(view_page PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 600)
elseif(NOT FFP_PYTHON)
  message(STATUS "The page of `ffprocams view` is not tested: there is no python3")
endif()

# From bare devices to new poses, on a simulated rig: calibrate's OpenCV is needed, and Python for a line of JSON.
if(TARGET ffprocams_opencv AND FFP_PYTHON AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME simulated_rig COMMAND ${PROJECT_SOURCE_DIR}/script/simulated-rig ${PROJECT_BINARY_DIR})
  set_tests_properties(simulated_rig PROPERTIES ENVIRONMENT "HEIGHT=180;WIDTH=96;ATTITUDES=6") # in a minute
endif()

# A sanitized library asks all that link it for the sanitizers.
if(FFPROCAMS_INSTALL AND NOT FFPROCAMS_SANITIZE)
  add_test(NAME install COMMAND ${PROJECT_SOURCE_DIR}/script/test-install ${PROJECT_BINARY_DIR})
endif()

# Tests that run threads side by side: ctest -L threads. Under ThreadSanitizer (FFPROCAMS_SANITIZE=thread) the target thread_tests
# builds them alone, and LLVM's archer tells it what OpenMP's barriers order.
set(FFP_THREAD_TESTS test_queue test_stream test_training test_render test_pass test_start test_denoise test_refine test_pyramid
                     test_thin test_capture test_generate test_products test_scan test_attention test_contexts test_call)
if(FFPROCAMS_SANITIZE STREQUAL "thread")
  execute_process(COMMAND ${CMAKE_C_COMPILER} -print-resource-dir OUTPUT_VARIABLE clang OUTPUT_STRIP_TRAILING_WHITESPACE)
  find_library(FFP_ARCHER archer PATHS ${clang}/../.. REQUIRED)
endif()

add_custom_target(thread_tests)
foreach(test ${FFP_THREAD_TESTS})
  if(TARGET ${test})
    add_dependencies(thread_tests ${test})
    set_property(TEST ${test} APPEND PROPERTY LABELS threads)
    if(FFP_ARCHER)
      set_property(TEST ${test} APPEND PROPERTY ENVIRONMENT "OMP_TOOL_LIBRARIES=${FFP_ARCHER}"
                   "TSAN_OPTIONS=ignore_noninstrumented_modules=1") # OpenBLAS, Embree
    endif()
  endif()
endforeach()

# The longest begin first, so that none is left alone at the end.
set(FFP_LONG_TESTS view_page simulated_rig test_no_memory install test_cuda_training test_align test_axis test_cli_results test_cli_sizes
                   test_cli_import readme test_calibrate test_ranks test_meshes test_response test_predictors test_checks test_codes
                   test_mixture test_bundle test_start test_generate)
list(LENGTH FFP_LONG_TESTS cost)
get_property(tests DIRECTORY PROPERTY TESTS)
foreach(test ${FFP_LONG_TESTS})
  if(test IN_LIST tests)
    set_property(TEST ${test} PROPERTY COST ${cost})
  endif()
  math(EXPR cost "${cost} - 1")
endforeach()

# libomp (clang's OpenMP) gives some of its own threads' tables back to nobody when their number changes.
if(FFPROCAMS_SANITIZE STREQUAL "address")
  get_property(tests DIRECTORY PROPERTY TESTS)
  set_property(TEST ${tests} APPEND PROPERTY ENVIRONMENT "LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/cmake/leaks.txt:print_suppressions=0")
endif()
