# SPDX-License-Identifier: Apache-2.0
# Turns the plain comments in the public headers into Doxygen comments. A comment before a blank line describes its section and goes to
# the file's page; a function without a comment refers to the one above.
function declare(line) {
    if (line ~ /^} [a-z_]+;/) { above = line; gsub(/[} ;]/, "", above) }
    if (line ~ /^BN_(API|CONSTEXPR|INLINE|UNREAD|DEVICE_INLINE|HOST_INLINE) .*\(/) {
        name = line; sub(/\(.*/, "", name); sub(/.*[ *]/, "", name)
        if (commented) above = name "()"; else print "/** See " above ". */"
    }
    if (line != "" && line !~ /^#if/) commented = 0
    sub(/ \/\* /, " /**< ", line)
    if (line ~ /[;,{)] *\/\/ /) sub(/ \/\/ /, " ///< ", line)
    else if (line ~ /^ *\/\/( |$)/) sub(/\/\//, "///", line)
    print line
}
NR == 1 && /^\/\/ / { print "/// @file"; next }
NR == 1 { comment = "/** @file"; next }
comment == "" && /^ *\/\* ---- / { title = $0; gsub(/^ *\/\* ---- | *\*\/ *$/, "", title); next }
comment == "" && /^ *\/\* / { comment = $0; sub(/\/\* /, "/** ", comment); if (/\*\//) finished = 1; next }
comment != "" && !finished { comment = comment "\n" $0; if (/\*\//) finished = 1; next }
comment != "" {
    if ($0 == "" && comment !~ /@file/) sub(/\/\*\* /, "/** @file\n * @details\n * **" title "**\n *\n * ", comment)
    print comment; comment = ""; finished = 0; commented = $0 != ""
}
{ declare($0) }
