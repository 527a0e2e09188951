# SPDX-License-Identifier: Apache-2.0
# bn_bake_sampler: the same table twice, another one for another seed, and what cannot be done is said and leaves no file.
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
run(0 ${effort} -o first.u32)
run(0 ${effort} -o again.u32)
run(0 ${effort} --seed 2 -o other.u32)
foreach(name first again other)
    file(SHA256 "${FOLDER}/${name}.u32" ${name})
endforeach()
if(NOT first STREQUAL again OR first STREQUAL other)
    message(FATAL_ERROR "a table does not depend on its seed alone")
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
file(GLOB left "${FOLDER}/x*" "${FOLDER}/*.part")
if(left)
    message(FATAL_ERROR "left behind: ${left}")
endif()
