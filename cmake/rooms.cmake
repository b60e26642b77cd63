# The plan of the house, and the only one: six wings in the order in which data walks through them, and the rooms of each. A room
# is a folder, src/WING/ROOM. It includes only the rooms among its DEPS, which lie in its own wing or in one above it, and links them
# alone (script/test-house). ffp_room is in room.cmake.

ffp_wing(core) # what everything else speaks
# errors, the call at work, log, arenas, random numbers, files, other programs, small vectors, reflectance; the device seam
ffp_room(base CALLS LIBS ${CMAKE_DL_LIBS} READERS base64 file kind text)
# least squares, ranks, surface nets
ffp_room(numerics DEPS base LIBS PkgConfig::OPENBLAS)
# float images, PNG, JPEG, TIFF, EXR, raw photographs and films (by other programs), sRGB, resizing, pattern lookup
ffp_room(image NUMERIC DEPS base LIBS PkgConfig::PNG PkgConfig::JPEG PkgConfig::OPENEXR PkgConfig::ZLIB
         READERS exr foreign jpeg orientation photograph png profile profile_find raw read stream tiff webp)
# kernels on plain arrays: products, norms, attention, state-space scan, Adam; safetensors
ffp_room(tensor NUMERIC PRODUCTS DEPS base LIBS PkgConfig::OPENBLAS PkgConfig::JANSSON READERS safetensors)
# the Gaussian set and its PLY; splats of other programs
ffp_room(gaussians NUMERIC DEPS base LIBS PkgConfig::JANSSON PkgConfig::ZLIB
         READERS affine elsewhere foreign_splats gaussians gltf ply ply_header ply_read ply_rows row splat spz)
# cameras, projectors, captures: reading, checking, writing, bounds, reducing
ffp_room(capture NUMERIC DEPS image numerics base LIBS PkgConfig::JANSSON
         READERS bounds capture load manifest names node pad pose read render_poses scene_read whole)
# what a projector shows while a rig is photographed; the lollipop
ffp_room(patterns DEPS image base)

ffp_wing(engine) # from a capture to Gaussians, and from Gaussians to pictures
# noise of photographs: estimating and filtering it
ffp_room(denoise DEPS capture base LIBS PkgConfig::OPENBLAS)
# projector matching and the classical initialisation
ffp_room(match NUMERIC DEPS capture image numerics base)
# rasterise, map to the projector, shade, resolve; and back: the view pass
ffp_room(render NUMERIC DEPS gaussians capture image base)
# the hybrid encoder and its heads; configurations and weights
ffp_room(network NUMERIC DEPS render match gaussians capture image tensor base LIBS PkgConfig::JANSSON READERS config parameters weights)
# loss terms and metrics
ffp_room(loss NUMERIC DEPS tensor image base)
# fits to one object's photographs
ffp_room(refine NUMERIC DEPS loss render gaussians tensor capture image base)
# poses corrected from the photographs
ffp_room(align DEPS network match render capture image numerics base)
# compensated projections and correspondence maps
ffp_room(apply DEPS loss render gaussians tensor capture image numerics base)
# what the calls of the public headers do, from end to end: reconstruct, draw pictures, and what it takes
ffp_room(pipeline CALLS DEPS align apply refine render network match denoise gaussians capture image numerics base)
# the GPU: kernels of the numeric rooms, and their emulation for tests
ffp_room(cuda IN cuda.cmake DEPS refine loss network render match tensor image base)

ffp_wing(rig) # from a bare projector and a camera to a capture
# what can be wrong, in words: the rules, and how a finding is told
ffp_room(findings DEPS base)
# calibrations as other tools write them; lenses, and pictures without their distortion
ffp_room(optics DEPS capture base LIBS PkgConfig::YAML PkgConfig::EXPAT PkgConfig::JANSSON
         READERS calibration calibration_parts colmap document document_parts lens matrix nepmap opencv procams xml yaml)
# photographs of Gray codes into positions on the projector's panel
ffp_room(graycode DEPS findings optics match patterns image numerics base)
# which file shows what: names, folders, and the photographs of everything that was shown
ffp_room(shots DEPS findings graycode optics patterns capture image base READERS file_names)
# a chessboard in several attitudes into the optics of camera and projector
ffp_room(chessboard CALLS DEPS findings graycode shots optics capture image numerics base)
# what is wrong with a capture
ffp_room(checks DEPS findings match capture image numerics base READERS explain)
# separates the object from its background
ffp_room(masks DEPS checks findings graycode match capture image numerics base)
# a turntable: its file, and its axis from what is seen at its stops, the object or a chessboard
ffp_room(turntable DEPS checks findings chessboard shots optics match capture image numerics base READERS turntable)
# what a projector makes of its pictures: their light, and how soft they are
ffp_room(response DEPS match capture image numerics base)
# photographs into captures: the order of the steps
ffp_room(import DEPS response checks findings masks turntable shots graycode optics patterns pipeline capture image numerics base)
# the rig's own calibration: the order of its steps, its files and report
ffp_room(calibrate CALLS DEPS turntable chessboard optics capture base)
# a calibration without a board: projector, and a walking camera or a turntable, from the codes on anything
ffp_room(selfcal CALLS DEPS calibrate turntable chessboard shots graycode optics findings capture image numerics base)

ffp_wing(world) # objects and rigs that do not exist
# shapes, generated or read, as meshes; solid noise
ffp_room(shapes DEPS numerics base READERS mesh_file)
# materials, rig and light simulator; scenes and data sets
ffp_room(synth DEPS optics shapes patterns capture image base LIBS PkgConfig::JANSSON)

ffp_wing(lab) # training, measuring, comparing
# steps, optimiser, checkpoints, validation
ffp_room(train DEPS denoise refine synth shapes loss render network match capture tensor numerics base LIBS PkgConfig::JANSSON
         READERS config)
# the machine's peaks; kernels and steps as shares of them
ffp_room(bench PRODUCTS DEPS train refine render network gaussians tensor base LIBS PkgConfig::JANSSON)
# other methods, for comparison: Gaussians from scratch, a neural reflectance field
ffp_room(baselines NUMERIC DEPS refine loss render tensor capture image base)
# protocols, scores and reports
ffp_room(eval CALLS DEPS checks baselines pipeline loss render match capture numerics base LIBS PkgConfig::JANSSON)

ffp_wing(product) # what people hold in their hands
# the page for browsers: splats and scene as it reads them
ffp_room(view CALLS DEPS pipeline render gaussians capture base)
# splats and meshes for other programs
ffp_room(export CALLS DEPS pipeline apply render gaussians capture image numerics base LIBS PkgConfig::JANSSON PkgConfig::ZLIB)
# what a file holds, as text for people
ffp_room(describe CALLS DEPS checks findings masks baselines network gaussians capture numerics base)
# the calls of the public headers, one file per call: arguments checked, the call entered, structs translated, one function called
ffp_room(api CALLS DEPS describe eval pipeline bench view export selfcal calibrate import optics checks findings baselines train synth patterns loss render
         network gaussians capture image base cuda LIBS PkgConfig::JANSSON PkgConfig::ZLIB)
# the ranks of an MPI job: part of the program where it is built with MPI
ffp_room(cluster IN library.cmake)
# the studio's rules, from a bare rig to the relit object by the program's other commands
ffp_room(studio IN library.cmake)
# the platform on which they work here: a server and its page, processes
ffp_room(server IN library.cmake DEPS studio)
# the program, a file per command; like anybody's, it sees the public headers alone
ffp_room(cli IN library.cmake DEPS cluster studio server)
