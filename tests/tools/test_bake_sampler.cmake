# SPDX-License-Identifier: Apache-2.0
# bn_bake_sampler: it makes a table, another quadtree for the same vectors, and says in one line what it
# cannot do.
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")

# Runs the tool; its exit status must be `expected`. Sets `said` to what it wrote to standard error.
function(run expected)
    execute_process(COMMAND "${TOOL}" ${ARGN} WORKING_DIRECTORY "${FOLDER}"
                    RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE said)
    if(NOT status EQUAL expected)
        message(FATAL_ERROR "bn_bake_sampler ${ARGN} ended with ${status}, not ${expected}: ${said}")
    endif()
    set(said "${said}" PARENT_SCOPE)
endfunction()

set(effort --effort 0.001)
run(0 ${effort} -o whole.u32)
if(NOT said STREQUAL "")
    message(FATAL_ERROR "progress in a pipe: ${said}")
endif()

# Another quadtree for the same vectors.
run(0 ${effort} --seed 2 --vectors whole.u32 -o tree.u32)
file(SHA256 "${FOLDER}/whole.u32" whole)
file(SHA256 "${FOLDER}/tree.u32" tree)
if(tree STREQUAL whole)
    message(FATAL_ERROR "--vectors made the same quadtree with another seed")
endif()
file(WRITE "${FOLDER}/short.u32" "no table")
run(1 ${effort} --vectors short.u32 -o x.u32)
if(NOT said MATCHES "^bn_bake_sampler: short.u32 is not a table of 47616 bytes\n$")
    message(FATAL_ERROR "not one line: ${said}")
endif()

run(2)
run(2 --seed)
run(2 --effort nonsense -o x.u32)
run(2 --effort 101 -o x.u32)
run(2 --sweeps 3 -o x.u32)
run(1 ${effort} -o missing/x.u32)
if(NOT said MATCHES "^bn_bake_sampler: cannot write [^\n]*\n$")
    message(FATAL_ERROR "not one line: ${said}")
endif()
file(GLOB found RELATIVE "${FOLDER}" "${FOLDER}/*")
if(NOT found STREQUAL "short.u32;tree.u32;whole.u32")
    message(FATAL_ERROR "not the files of the runs that worked: ${found}")
endif()
