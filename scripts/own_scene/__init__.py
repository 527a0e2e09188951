# SPDX-License-Identifier: Apache-2.0
"""The samplers on a scene of the user: scripts/demo, and meshes as glTF: scripts/to-gltf."""
