# SPDX-License-Identifier: Apache-2.0
# Install rules: headers, library, CMake package `bn` with target bn::bn, and pkg-config `bn`.
include(CMakePackageConfigHelpers)
set(bn_package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/bn")

install(TARGETS bn EXPORT bn_targets
    ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
    LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
    RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
set(bn_unwanted_headers "")
if(NOT BN_NEURAL)
    set(bn_unwanted_headers PATTERN neural.h EXCLUDE)
endif()
install(DIRECTORY include/bn DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${bn_unwanted_headers})
install(EXPORT bn_targets NAMESPACE bn:: FILE bnTargets.cmake DESTINATION ${bn_package_dir})

configure_package_config_file(cmake/bnConfig.cmake.in "${CMAKE_CURRENT_BINARY_DIR}/bnConfig.cmake"
    INSTALL_DESTINATION ${bn_package_dir})
write_basic_package_version_file("${CMAKE_CURRENT_BINARY_DIR}/bnConfigVersion.cmake"
    VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/bnConfig.cmake"
              "${CMAKE_CURRENT_BINARY_DIR}/bnConfigVersion.cmake" DESTINATION ${bn_package_dir})

# Paths are relative to the .pc file, so that an installed tree can be moved, except for absolute folders.
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}")
    set(bn_pc_prefix "${CMAKE_INSTALL_PREFIX}")
else()
    file(RELATIVE_PATH bn_pc_prefix "/prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/prefix")
    string(PREPEND bn_pc_prefix "\${pcfiledir}/")
endif()
foreach(dir IN ITEMS LIBDIR INCLUDEDIR)
    set(bn_pc_${dir} "${CMAKE_INSTALL_${dir}}")
    if(NOT IS_ABSOLUTE "${bn_pc_${dir}}")
        string(PREPEND bn_pc_${dir} "\${prefix}/")
    endif()
endforeach()
set(bn_pc_cflags "")
if(BN_BUILD_SHARED)
    set(bn_pc_cflags " -DBN_SHARED")
endif()
# Programs link a static library's dependencies themselves. Not all of them call pkg-config with --static.
set(bn_pc_libs "")
if(UNIX AND NOT BN_BUILD_SHARED)
    set(bn_pc_libs " -pthread -lm")
    if(BN_NEURAL AND CMAKE_DL_LIBS)
        string(APPEND bn_pc_libs " -l${CMAKE_DL_LIBS}")
    endif()
endif()
configure_file(cmake/bn.pc.in "${CMAKE_CURRENT_BINARY_DIR}/bn.pc" @ONLY)
install(FILES "${CMAKE_CURRENT_BINARY_DIR}/bn.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
install(FILES "${PROJECT_SOURCE_DIR}/LICENSE" DESTINATION "${CMAKE_INSTALL_DOCDIR}")
install(FILES data/LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}" RENAME LICENSE-data)
