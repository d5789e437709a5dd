# Installs dragcore from the build folder BUILD into WORK, then configures, builds and runs its examples against that copy, as a stranger would.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result)
  if(result)
    message(FATAL_ERROR "failed: ${ARGN}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD}/dragcore --prefix ${WORK}/prefix)
# The library alone must not ask for what the file readers and the rays need. The sources are the installed ones, too.
set(settings -DCMAKE_BUILD_TYPE=Release -DCMAKE_DISABLE_FIND_PACKAGE_HDF5=ON -DCMAKE_DISABLE_FIND_PACKAGE_embree=ON
  -DCMAKE_PREFIX_PATH=${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${WORK}/prefix/share/dragcore/examples -B ${WORK}/build ${settings} "-DCMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${WORK}/build)
foreach(program first_force minimal_loop falling_paper falling_paper_c left_handed_engine waving_cloth)
  run(${WORK}/build/${program})
endforeach()

# Meshes are read without HDF5; a component whose package is missing is named.
file(WRITE ${WORK}/reader/CMakeLists.txt "cmake_minimum_required(VERSION 3.22)\nproject(reader LANGUAGES CXX)\n"
  "set(component mesh_files CACHE STRING \"\")\nfind_package(dragcore REQUIRED COMPONENTS \${component})\n"
  "add_executable(reader reader.cpp)\ntarget_link_libraries(reader PRIVATE dragcore::\${component})\n")
file(WRITE ${WORK}/reader/reader.cpp "#include <dragcore/mesh_file.hpp>\nint main(int count, char** words) {\n"
  "  return count == 2 && dragcore::read_mesh(words[1]).triangles.size() == 1 ? 0 : 1;\n}\n")
file(WRITE ${WORK}/reader/triangle.obj "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
run(${CMAKE_COMMAND} -S ${WORK}/reader -B ${WORK}/reader/build ${settings} "-DCMAKE_CXX_FLAGS=${FLAGS}")
run(${CMAKE_COMMAND} --build ${WORK}/reader/build)
run(${WORK}/reader/build/reader ${WORK}/reader/triangle.obj)
execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK}/reader -B ${WORK}/reader/build_without_hdf5 ${settings} -Dcomponent=field_files
  RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE message)
if(NOT result OR NOT message MATCHES "HDF5|field_files")
  message(FATAL_ERROR "a project that lacks what field files need is not told so: ${message}")
endif()
file(GLOB_RECURSE all_readers ${WORK}/prefix/*/dragcore-io-targets.cmake)
if(all_readers)
  run(${CMAKE_COMMAND} -S ${WORK}/reader -B ${WORK}/reader/build_io -DCMAKE_PREFIX_PATH=${WORK}/prefix -Dcomponent=io "-DCMAKE_CXX_FLAGS=${FLAGS}")
  run(${CMAKE_COMMAND} --build ${WORK}/reader/build_io)
  run(${WORK}/reader/build_io/reader ${WORK}/reader/triangle.obj)
endif()

# A project without C++ is told what it lacks.
file(WRITE ${WORK}/c_alone/CMakeLists.txt "cmake_minimum_required(VERSION 3.22)\nproject(c_alone LANGUAGES C)\nfind_package(dragcore REQUIRED)\n")
execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK}/c_alone -B ${WORK}/c_alone/build ${settings} RESULT_VARIABLE result OUTPUT_QUIET ERROR_VARIABLE message)
if(NOT result OR NOT message MATCHES "LANGUAGES C CXX")
  message(FATAL_ERROR "a project in C alone is not told to enable CXX: ${message}")
endif()
