# SPDX-License-Identifier: Apache-2.0
# Tests that bn_bake_sampler writes a table and reports an error in one line.
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")

# Runs the tool. Its exit status must be `expected`, and its standard error must match the regular expression `words`.
function(run expected words)
    execute_process(COMMAND "${TOOL}" ${ARGN} WORKING_DIRECTORY "${FOLDER}"
                    RESULT_VARIABLE status OUTPUT_QUIET ERROR_VARIABLE said)
    if(NOT status EQUAL expected OR NOT said MATCHES "${words}")
        message(FATAL_ERROR "bn_bake_sampler ${ARGN} exited with ${status} instead of ${expected} and printed: ${said}")
    endif()
endfunction()

run(0 "^$" 0.001 whole.u32)
file(SIZE "${FOLDER}/whole.u32" size)
if(NOT size EQUAL 47616)
    message(FATAL_ERROR "whole.u32 has ${size} bytes")
endif()
run(2 "^Usage: ")
run(2 "^Usage: " nonsense x.u32)
run(2 "^Usage: " 101 x.u32)
run(1 "^bn_bake_sampler: cannot write [^\n]*\n$" 0.001 missing/x.u32)
file(GLOB found RELATIVE "${FOLDER}" "${FOLDER}/*")
if(NOT found STREQUAL "whole.u32")
    message(FATAL_ERROR "expected whole.u32 only, but found: ${found}")
endif()
