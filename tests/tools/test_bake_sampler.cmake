# SPDX-License-Identifier: Apache-2.0
# bn_bake_sampler: interruptions do not change the table, another seed does, and what cannot be done is
# said in one line that leaves no file.
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

function(expect_there name there)
    if(EXISTS "${FOLDER}/${name}" AND NOT there)
        message(FATAL_ERROR "${name} should not be there")
    elseif(NOT EXISTS "${FOLDER}/${name}" AND there)
        message(FATAL_ERROR "${name} should be there")
    endif()
endfunction()

set(effort --effort 0.001)
run(0 ${effort} -o whole.u32)
if(NOT said STREQUAL "")
    message(FATAL_ERROR "progress in a pipe: ${said}")
endif()
expect_there(whole.u32.progress FALSE)
# In the vectors and in the quadtree of a later member.
foreach(parts 1 13 40)
    run(0 ${effort} --stop-after ${parts} -o resumed.u32)
    expect_there(resumed.u32 FALSE)
    expect_there(resumed.u32.progress TRUE)
endforeach()
run(0 ${effort} -o resumed.u32)
expect_there(resumed.u32.progress FALSE)
file(SHA256 "${FOLDER}/whole.u32" whole)
file(SHA256 "${FOLDER}/resumed.u32" resumed)
if(NOT whole STREQUAL resumed)
    message(FATAL_ERROR "an interrupted run made another table")
endif()

# Progress of other options is not taken up.
run(0 ${effort} --stop-after 1 -o other.u32)
file(SHA256 "${FOLDER}/other.u32.progress" first)
run(0 ${effort} --seed 2 --stop-after 1 -o other.u32)
file(SHA256 "${FOLDER}/other.u32.progress" second)
if(first STREQUAL second)
    message(FATAL_ERROR "another seed took up the progress of the first")
endif()

run(2)
run(2 --seed)
run(2 --effort nonsense -o x.u32)
run(2 --effort 101 -o x.u32)
run(2 --sweeps 3 -o x.u32)
run(1 ${effort} --stop-after 1 -o missing/x.u32)
if(NOT said MATCHES "^bn_bake_sampler: cannot write [^\n]*\n$")
    message(FATAL_ERROR "not one line: ${said}")
endif()
expect_there(x.u32 FALSE)
