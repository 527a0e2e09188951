# SPDX-License-Identifier: Apache-2.0
# An overlay port of the checkout that contains it: vcpkg install libbn --overlay-ports=scripts/packaging/vcpkg
# vcpkg's binary cache ignores changes to a checkout's sources: after changing them, add --no-binarycaching. For a registry,
# replace this line with the release's archive.
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../../../.." ABSOLUTE)

string(COMPARE EQUAL "${VCPKG_LIBRARY_LINKAGE}" "dynamic" shared)
vcpkg_check_features(OUT_FEATURE_OPTIONS feature_options FEATURES neural BN_NEURAL)

vcpkg_cmake_configure(
    SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS
        ${feature_options}
        -DBN_BUILD_SHARED=${shared}
        -DBN_BUILD_TESTS=OFF
        -DBN_BUILD_TOOLS=OFF
        -DBN_INSTALL=ON
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME bn CONFIG_PATH lib/cmake/bn)
vcpkg_fixup_pkgconfig()
vcpkg_copy_pdbs()

# Licences go to a separate folder, and debug builds install no headers.
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share"
                    "${CURRENT_PACKAGES_DIR}/share/doc")
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE" "${SOURCE_PATH}/libbn/data/LICENSE"
    COMMENT "The code is Apache-2.0; the tables, masks and network weights in it are CC0-1.0.")
