# SPDX-License-Identifier: Apache-2.0
"""Samplers on the user's own scene (scripts/demo), and conversion of meshes to glTF (scripts/to-gltf)."""
