# SPDX-License-Identifier: Apache-2.0
"""Samplers on the user's own scene (scripts/demo), and conversion of other files to glTF (scripts/to-gltf)."""
