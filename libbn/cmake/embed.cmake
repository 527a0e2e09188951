# SPDX-License-Identifier: Apache-2.0
# The build step behind bn_embed(). INPUT, OUTPUT, NAME, TYPE and HEADER are passed with -D.
file(READ "${INPUT}" hex HEX)
if(TYPE STREQUAL "uint8_t")
    string(REGEX REPLACE "(..)" "0x\\1," values "${hex}")
    set(count_divisor 2)
elseif(TYPE STREQUAL "uint16_t")
    string(REGEX REPLACE "(..)(..)" "0x\\2\\1," values "${hex}")
    set(count_divisor 4)
elseif(TYPE STREQUAL "uint32_t")
    string(REGEX REPLACE "(..)(..)(..)(..)" "0x\\4\\3\\2\\1," values "${hex}")
    set(count_divisor 8)
else()
    message(FATAL_ERROR "embed: unknown type ${TYPE}")
endif()
string(LENGTH "${hex}" length)
math(EXPR remainder "${length} % ${count_divisor}")
if(length EQUAL 0 OR NOT remainder EQUAL 0)
    message(FATAL_ERROR "embed: ${INPUT} does not hold a whole number of ${TYPE}")
endif()
math(EXPR count "${length} / ${count_divisor}")
# Break the array into short lines, because some compilers limit line lengths.
string(REGEX REPLACE "(0x[0-9a-f]+,0x[0-9a-f]+,0x[0-9a-f]+,0x[0-9a-f]+,0x[0-9a-f]+,0x[0-9a-f]+,0x[0-9a-f]+,0x[0-9a-f]+,)"
       "\\1\n" values "${values}")
set(declaration "extern const ${TYPE} ${NAME}[];")
if(HEADER)
    set(declaration "#include <${HEADER}>")
endif()
file(WRITE "${OUTPUT}.tmp" "#include <stddef.h>\n#include <stdint.h>\n${declaration}\n\
extern const size_t ${NAME}_count;\n\
const ${TYPE} ${NAME}[] = {\n${values}};\nconst size_t ${NAME}_count = ${count};\n")
file(RENAME "${OUTPUT}.tmp" "${OUTPUT}")
