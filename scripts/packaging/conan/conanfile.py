# SPDX-License-Identifier: Apache-2.0
"""Conan 2 recipe for the checkout that contains it: conan create scripts/packaging/conan"""

import re
from pathlib import Path

from conan import ConanFile
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy, rmdir

required_conan_version = ">=2.0"


class LibbnConan(ConanFile):
    name = "libbn"
    description = "Blue-noise samples and masks for path tracers"
    license = "Apache-2.0 AND CC0-1.0"
    author = "The authors of libbn"
    topics = ("blue-noise", "sampling", "path-tracing", "dithering")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {"shared": [True, False], "fPIC": [True, False], "neural": [True, False], "small_data": [True, False]}
    default_options = {"shared": False, "fPIC": True, "neural": True, "small_data": False}
    implements = ["auto_shared_fpic"]
    languages = "C"

    def set_version(self):
        header = Path(self._checkout, "libbn", "include", "bn", "bn.h").read_text(encoding="utf-8")
        self.version = ".".join(re.findall(r"^#define BN_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", header, re.MULTILINE))

    @property
    def _checkout(self):
        return str(Path(self.recipe_folder).parents[2])

    def export_sources(self):
        for pattern in ("CMakeLists.txt", "LICENSE", "libbn/*"):
            copy(self, pattern, src=self._checkout, dst=self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["BN_BUILD_SHARED"] = bool(self.options.shared)
        toolchain.cache_variables["BN_BUILD_TESTS"] = False
        toolchain.cache_variables["BN_BUILD_TOOLS"] = False
        toolchain.cache_variables["BN_NEURAL"] = bool(self.options.neural)
        toolchain.cache_variables["BN_SMALL_DATA"] = bool(self.options.small_data)
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", src=self.source_folder, dst=str(Path(self.package_folder, "licenses")))
        copy(self, "LICENSE", src=str(Path(self.source_folder, "libbn", "data")),
             dst=str(Path(self.package_folder, "licenses", "data")))
        CMake(self).install()
        # Conan writes the CMake and pkg-config package files for each consumer's settings.
        for folder in ("lib/cmake", "lib/pkgconfig", "share"):
            rmdir(self, str(Path(self.package_folder, folder)))

    def package_info(self):
        self.cpp_info.libs = ["bn"]
        self.cpp_info.set_property("cmake_file_name", "bn")
        self.cpp_info.set_property("cmake_target_name", "bn::bn")
        self.cpp_info.set_property("pkg_config_name", "bn")
        if self.options.shared:
            self.cpp_info.defines.append("BN_SHARED")
        if not self.options.neural:
            self.cpp_info.defines.append("BN_NO_NEURAL")
        if self.settings.os in ("Linux", "FreeBSD") and not self.options.shared:
            self.cpp_info.system_libs = ["m", "pthread"] + (["dl"] if self.options.neural else [])
