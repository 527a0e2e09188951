# SPDX-License-Identifier: Apache-2.0
# bn_embed(<sources-variable> NAME <array> TYPE <uint8_t|uint16_t|uint32_t> FILE <little-endian file>
#         [HEADER <header that declares the array>])
# Converts a binary file to a C source that defines `const TYPE NAME[]` and `const size_t NAME_count`, and
# appends the source to the variable. The conversion runs at build time and needs only CMake.
function(bn_embed sources_variable)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "NAME;TYPE;FILE;HEADER" "")
    set(input "${CMAKE_CURRENT_SOURCE_DIR}/${arg_FILE}")
    set(output "${CMAKE_CURRENT_BINARY_DIR}/embedded/${arg_NAME}.c")
    set(script "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/embed.cmake")
    add_custom_command(OUTPUT "${output}"
        COMMAND "${CMAKE_COMMAND}" "-DINPUT=${input}" "-DOUTPUT=${output}" "-DNAME=${arg_NAME}"
                "-DTYPE=${arg_TYPE}" "-DHEADER=${arg_HEADER}" -P "${script}"
        DEPENDS "${input}" "${script}"
        COMMENT "Embedding ${arg_FILE}" VERBATIM)
    set(${sources_variable} ${${sources_variable}} "${output}" PARENT_SCOPE)
endfunction()
