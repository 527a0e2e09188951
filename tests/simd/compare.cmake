# SPDX-License-Identifier: Apache-2.0
# Runs PROGRAM (with EMULATOR, if any) and compares what it prints with the file EXPECTED.
execute_process(COMMAND ${EMULATOR} "${PROGRAM}" OUTPUT_VARIABLE printed RESULT_VARIABLE status)
file(READ "${EXPECTED}" expected)
string(REPLACE "\r" "" printed "${printed}")
if(NOT status EQUAL 0)
    message(FATAL_ERROR "${PROGRAM} failed: ${status}\n${printed}")
elseif(NOT printed STREQUAL expected)
    message(FATAL_ERROR "the masks differ from ${EXPECTED}; now:\n${printed}")
endif()
