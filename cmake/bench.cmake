# Programs that measure (bench/), each built when it is asked for, none installed.

# Milliseconds of the GPU's functions, a program a room.
if(TARGET ffp_cuda)
  file(GLOB gpu_benches CONFIGURE_DEPENDS bench/gpu_*.c)
  foreach(source ${gpu_benches})
    get_filename_component(name ${source} NAME_WE)
    add_executable(${name} EXCLUDE_FROM_ALL ${source})
    target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
    target_link_libraries(${name} PRIVATE ffp_cuda ffp_train)
  endforeach()
endif()

# Pictures and figures of the training world, for docs/.
if(TARGET ffp_synth)
  add_executable(contact_sheets EXCLUDE_FROM_ALL bench/contact_sheets.c bench/diversity.c)
  target_include_directories(contact_sheets PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(contact_sheets PRIVATE ffp_synth)
endif()

# The limits of a reconstruction, found by putting the truth in.
if(TARGET ffp_train)
  add_executable(limits EXCLUDE_FROM_ALL bench/limits.c)
  target_link_libraries(limits PRIVATE ffp_train)
endif()

# The encoder alone, for comparison with other libraries' form of it (bench/peers).
if(TARGET ffp_network)
  add_executable(encoder_times EXCLUDE_FROM_ALL bench/encoder_times.c)
  target_link_libraries(encoder_times PRIVATE ffp_network)
endif()

# The rasteriser alone, for the same. And the instructions of all kernels (script/test-arm --count).
if(TARGET ffp_bench)
  add_executable(splat_times EXCLUDE_FROM_ALL bench/splat_times.c)
  target_link_libraries(splat_times PRIVATE ffp_bench)
  add_executable(kernel_counts EXCLUDE_FROM_ALL bench/kernel_counts.c)
  target_link_libraries(kernel_counts PRIVATE ffp_bench)
endif()

# The gain of a compensated projection on captures with true depth.
if(TARGET ffp_apply)
  add_executable(compensate_report EXCLUDE_FROM_ALL bench/compensate_report.c)
  target_link_libraries(compensate_report PRIVATE ffp_api ffp_apply)
endif()

# The cost of a rig's faults, from photographs through import to the pictures predicted.
if(TARGET ffp_api AND TARGET ffp_synth)
  add_executable(degraded_rig EXCLUDE_FROM_ALL bench/degraded_rig.c)
  target_link_libraries(degraded_rig PRIVATE ffp_api ffp_synth)
endif()

# A slow wire between two network namespaces (Linux), to measure ranks with.
if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
  add_executable(slow_link EXCLUDE_FROM_ALL bench/slow_link.c)
  target_link_libraries(slow_link PRIVATE ffp_compile)
endif()

# Faults of rigs and captures: what the checks before the work say of them.
if(TARGET ffp_api AND TARGET ffp_synth)
  add_executable(rig_faults EXCLUDE_FROM_ALL bench/rig_faults.c)
  target_include_directories(rig_faults PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(rig_faults PRIVATE ffp_api ffp_checks ffp_synth)
endif()
